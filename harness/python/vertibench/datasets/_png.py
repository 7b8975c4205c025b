"""Reader for 16-bit greyscale PNG, the format of elevation maps."""

from __future__ import annotations

import struct
import zlib

import numpy as np


def read_grey16(data: bytes) -> np.ndarray:
    """Returns the levels as uint16, row 0 at the top. Raises `ValueError` if the data is no complete image of this type."""
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise ValueError("it is no PNG image")
    at, packed, size, ended = 8, b"", None, False
    while at + 12 <= len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        crc = data[at + 8 + length : at + 12 + length]
        if len(crc) < 4 or zlib.crc32(kind + body) != struct.unpack(">I", crc)[0]:
            raise ValueError("it was cut short or changed")
        if kind == b"IHDR":
            width, height, *rest = struct.unpack(">IIBBBBB", body)
            if rest != [16, 0, 0, 0, 0]:
                raise ValueError("it is not of 16-bit greyscale")
            size = (height, width)
        elif kind == b"IDAT":
            packed += body
        elif kind == b"IEND":
            ended = True
        at += 12 + length
    if size is None or not ended:
        raise ValueError("it was cut short")
    try:
        raw = zlib.decompress(packed)
    except zlib.error as e:
        raise ValueError(f"its pixels can't be unpacked: {e}") from None
    height, width = size
    if len(raw) != height * (2 * width + 1):
        raise ValueError("it has too few or too many pixels")
    lines = np.frombuffer(raw, np.uint8).reshape(height, 2 * width + 1)
    rows, above = np.empty((height, 2 * width), np.uint8), np.zeros(2 * width, np.uint8)
    for k, line in enumerate(lines):
        above = rows[k] = _unfilter(int(line[0]), line[1:], above)
    return rows.reshape(height, width, 2) @ np.array([256, 1], np.uint16)


def _unfilter(kind: int, line: np.ndarray, above: np.ndarray) -> np.ndarray:
    """Reverses the filter of a row of bytes (PNG specification, section 9.2)."""
    if kind == 0:
        return line
    if kind == 2:
        return line + above
    if kind not in (1, 3, 4):
        raise ValueError(f"it has a filter {kind}, which doesn't exist")
    row = [0, 0]
    corner = [0, 0, *above.tolist()]
    for k, (x, b) in enumerate(zip(line.tolist(), above.tolist())):
        a, c = row[k], corner[k]
        if kind == 1:
            guess = a
        elif kind == 3:
            guess = (a + b) // 2
        else:
            pa, pb, pc = abs(b - c), abs(a - c), abs(a + b - 2 * c)
            guess = a if pa <= pb and pa <= pc else b if pb <= pc else c
        row.append((x + guess) & 255)
    return np.array(row[2:], np.uint8)
