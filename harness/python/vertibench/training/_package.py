"""Makes planners from weights without Rust: the shipped planner `learned.wasm` has space for them in its file."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable
from os import PathLike
from pathlib import Path

from .._program import plugin_path
from ._config import TrainingError
from ._weights import read_weights

#: Bytes that mark the space for weights, and its size in bytes (plugins/learned/src/lib.rs).
MARK = b"vertibench: room for weights ->\n"
CAPACITY = 1 << 20
#: Name of the section with a planner's metadata (sdk/src/export.rs).
METADATA = b"vb:planner"
#: Kinds of sections that can contain it, or a module with it.
_CUSTOM, _CORE_MODULE, _COMPONENT = 0, 1, 4
_NAME = re.compile(r"[a-z0-9_-]+")


def package(weights: str | PathLike[str], planner: str | PathLike[str], name: str, about: str) -> None:
    """Makes a planner that runs a policy.

    Args:
        weights: Weight file that `export` has written, up to 1 MiB.
        planner: File to write, e.g. `my-policy.wasm`; an existing file is overwritten.
        name: Name of the planner: `a-z`, `0-9`, `-` and `_`.
        about: Description, which `vertibench inspect` prints.

    Raises:
        TrainingError: If the weights can't be read or are too large, or the name is invalid.
        MissingError: If the package's planner `learned.wasm` is missing.
    """
    notes, content = read_weights(weights)
    if not _NAME.fullmatch(name):
        raise TrainingError(f"--name {name}", "the name of a planner must consist of a-z, 0-9, - and _", "give another name")
    if len(content) > CAPACITY:
        what = f"{len(content)} bytes exceed the {CAPACITY} bytes that a planner has for weights"
        raise TrainingError(weights, what, "train a smaller network (network.planes, network.widths)")
    template = plugin_path("learned.wasm").read_bytes()
    model = f"{Path(weights).name} sha256 {hashlib.sha256(content).hexdigest()}"
    fields = {"name": name, "about": about, "model": model}
    needs = _needs(notes.get("parts", "").split())
    made = rewrite(_filled(template, content), lambda text: metadata(text, fields, needs))
    Path(planner).write_bytes(made)


def _needs(parts: list[str]) -> list[str]:
    from .. import _native

    sensors = [sensor for name, _, sensor in _native.parts() if sensor and name in parts]
    return ["pose", *dict.fromkeys(sensors)] if sensors else []


def _filled(template: bytes, content: bytes) -> bytes:
    at = template.find(MARK)
    if at < 0 or template.find(MARK, at + 1) >= 0:
        raise TrainingError("learned.wasm", "it has no space for weights", "install vertibench again")
    at += len(MARK)
    filled = len(content).to_bytes(4, "little") + content
    return template[:at] + filled + template[at + len(filled) :]


def metadata(text: str, fields: dict[str, str], needs: list[str]) -> str:
    """Returns the metadata of a planner (lines `key: value` with escaped line breaks) with these fields and needs
    replaced.
    """
    lines = [line for line in text.splitlines() if line.partition(": ")[0] not in ("name", "about", "need", "model")]
    own = [f"{key}: {_escaped(value)}" for key, value in fields.items()] + [f"need: {sensor}" for sensor in needs]
    return "\n".join([*lines, *own, ""])


def _escaped(value: str) -> str:
    return value.replace("\\", "\\\\").replace("\n", "\\n").replace("\r", "\\r")


def rewrite(wasm: bytes, change: Callable[[str], str]) -> bytes:
    """Returns a WASM module or component in which the planner's metadata section, at any nesting, is replaced."""
    sections = [wasm[:8]]
    at = 8
    while at < len(wasm):
        kind = wasm[at]
        size, start = _number(wasm, at + 1)
        body = wasm[start : start + size]
        if kind == _CUSTOM:
            length, begin = _number(body, 0)
            if body[begin : begin + length] == METADATA:
                text = body[begin + length :].decode("utf-8")
                body = body[: begin + length] + change(text).encode()
        elif wasm[4:8] != b"\x01\x00\x00\x00" and kind in (_CORE_MODULE, _COMPONENT):
            body = rewrite(body, change)
        sections += [bytes([kind]), _bytes(len(body)), body]
        at = start + size
    return b"".join(sections)


def _number(data: bytes, at: int) -> tuple[int, int]:
    """Decodes a number of WASM (LEB128); returns it and the position after it."""
    value = shift = 0
    while True:
        byte = data[at]
        at += 1
        value |= (byte & 0x7F) << shift
        shift += 7
        if byte < 0x80:
            return value, at


def _bytes(value: int) -> bytes:
    out = bytearray()
    while True:
        value, low = value >> 7, value & 0x7F
        out.append(low | (0x80 if value else 0))
        if not value:
            return bytes(out)
