"""The parts of YAML and PNG that worlds are in."""

import struct
import zlib

import numpy as np
import pytest

from vertibench import _yaml
from vertibench.datasets import _png


def test_yaml_of_all_forms_that_suites_have():
    text = """
# A comment.
schema: 1
name: "quoted: \\"#1\\""   # another
words: two of them, with: colons-no
empty:
range: [0.0, -1.5e-3, .5]
grid: {rows: 129, "key": [1, {a: b}], on: true}
worlds:
  - id: w001
    tasks: [t00,
      t01]   # over two lines

  - {id: w002, none: null}
  -
    id: w003
same:
- 'it''s'
- -3
"""
    # A word with ": " in it is no text of YAML's, so it is left out here.
    value = _yaml.parse(text.replace("words: two of them, with: colons-no\n", "words: two of them\n"))
    assert value == {
        "schema": 1,
        "name": 'quoted: "#1"',
        "words": "two of them",
        "empty": None,
        "range": [0.0, -0.0015, 0.5],
        "grid": {"rows": 129, "key": [1, {"a": "b"}], "on": True},
        "worlds": [{"id": "w001", "tasks": ["t00", "t01"]}, {"id": "w002", "none": None}, {"id": "w003"}],
        "same": ["it's", -3],
    }


@pytest.mark.parametrize(
    ("text", "line"),
    [("a: &x 1", 1), ("a: 1\nb: [1, 2", 2), ("a: 1\na: 2", 2), ("a: 1\n   b: 2", 2), ("a: |\n  text", 1), ("a: {b}", 1)],
)
def test_other_yaml_is_refused_with_its_line(text, line):
    with pytest.raises(ValueError, match=f"^line {line}: "):
        _yaml.parse(text)


def test_suites_read_as_any_reader_of_yaml_reads_them(explored):
    yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")
    files = list((explored / "suite").rglob("*.yaml"))
    assert len(files) > 10
    for file in files:
        assert _yaml.parse(file.read_text()) == yaml.safe_load(file.read_text()), file


def _chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def _encode(levels, kinds, depth=16):
    """A PNG whose rows have these filters (PNG specification, section 9)."""
    height, width = levels.shape
    bytes_ = levels.astype(">u2").view(np.uint8).reshape(height, 2 * width).astype(int)
    lines = []
    for k, kind in enumerate(kinds):
        row, above = bytes_[k], bytes_[k - 1] if k else np.zeros(2 * width, int)
        left, corner = np.r_[0, 0, row[:-2]], np.r_[0, 0, above[:-2]]
        guess = left + above - corner
        near = np.stack([abs(guess - left), abs(guess - above), abs(guess - corner)])
        paeth = np.choose(near.argmin(axis=0), [left, above, corner])
        predicted = [0 * row, left, above, (left + above) // 2, paeth][kind]
        lines.append(bytes([kind]) + ((row - predicted) & 255).astype(np.uint8).tobytes())
    packed = zlib.compress(b"".join(lines))
    parts = [(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, 0, 0, 0, 0)), (b"IDAT", packed[:50])]
    parts += [(b"IDAT", packed[50:]), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(*part) for part in parts)


@pytest.mark.parametrize("kinds", [[0] * 9, [1] * 9, [2] * 9, [3] * 9, [4] * 9, [4, 3, 2, 1, 0, 1, 2, 3, 4]])
def test_images_with_any_filter(kinds):
    levels = np.random.default_rng(3).integers(0, 65536, (9, 13))
    assert np.array_equal(_png.read_grey16(_encode(levels, kinds)), levels)


def test_damaged_and_other_images_are_refused():
    whole = _encode(np.arange(12).reshape(3, 4), [0, 0, 0])
    changed = bytearray(whole)
    changed[60] ^= 1
    cases = {"no PNG": b"GIF89a", "cut short": whole[:-12], "changed": bytes(changed)}
    cases["16-bit"] = _encode(np.arange(12).reshape(3, 4), [0, 0, 0], depth=8)
    for told, data in cases.items():
        with pytest.raises(ValueError, match=told):
            _png.read_grey16(data)
