"""The finished wheel: its tag by all that it holds, and bytes that depend on its content alone."""

from __future__ import annotations

import base64
import hashlib
import os
import re
import time
import zipfile
from pathlib import Path

# The version of a symbol of glibc, as a name in an ELF file.
_GLIBC = re.compile(rb"(?<=\x00)GLIBC_2\.(\d+)(?:\.\d+)?(?=\x00)")
# The oldest that the Rust toolchain supports.
_OLDEST = 17


def finish(wheel: Path, out: Path) -> str:
    """Writes the wheel into `out`, for the oldest glibc on which its programs and modules run; returns its name.

    maturin looks at the module alone, but the program needs a newer glibc as a rule.
    """
    with zipfile.ZipFile(wheel) as archive:
        files = {info.filename: (archive.read(info), info.external_attr >> 16) for info in archive.infolist()}
    name, platform = _tagged(wheel.name, glibc(content for content, _ in files.values()))
    info = next(path.split("/")[0] for path in files if path.endswith(".dist-info/WHEEL"))
    content, mode = files[f"{info}/WHEEL"]
    lines = [line for line in content.decode().splitlines() if line.strip()]
    tag = "-".join([*name[: -len(".whl")].split("-")[-3:-1], platform])
    lines = [line for line in lines if not line.startswith("Tag:")] + [f"Tag: {tag}"]
    files[f"{info}/WHEEL"] = (("\n".join(lines) + "\n").encode(), mode)
    files.pop(f"{info}/RECORD")
    # Readers expect the metadata at the end.
    paths = sorted(files, key=lambda path: (path.startswith(f"{info}/"), path))
    record = "".join(f"{_quoted(path)},sha256={_hash(files[path][0])},{len(files[path][0])}\n" for path in paths)
    files[f"{info}/RECORD"] = (f"{record}{info}/RECORD,,\n".encode(), mode)
    _write(out / name, [(path, *files[path]) for path in [*paths, f"{info}/RECORD"]])
    return name


def glibc(files) -> int | None:
    """The minor version of glibc 2 that is needed by the ELF files among these; none where none needs any."""
    needed = [int(found) for content in files if content[:4] == b"\x7fELF" for found in _GLIBC.findall(content)]
    return max(needed, default=None)


def _tagged(name: str, version: int | None) -> tuple[str, str]:
    """The wheel's name for that glibc, and the tag of its platform."""
    start, platform = name[: -len(".whl")].rsplit("-", 1)
    processor = re.fullmatch(r"(?:linux|manylinux(?:2014|_2_\d+))_([a-z0-9_]+?)(?:\.manylinux.*)?", platform)
    if version is not None and processor:
        platform = f"manylinux_2_{max(version, _OLDEST)}_{processor[1]}"
    return f"{start}-{platform}.whl", platform


def _hash(content: bytes) -> str:
    return base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()


def _quoted(path: str) -> str:
    return f'"{path}"' if "," in path else path


def _write(file: Path, entries: list[tuple[str, bytes, int]]) -> None:
    # Zip archives know no time before 1980.
    seconds = max(int(os.environ.get("SOURCE_DATE_EPOCH") or 0), 315532800)
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for path, content, mode in entries:
            entry = zipfile.ZipInfo(path, time.gmtime(seconds)[:6])
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # Unix, so that the mode is one.
            entry.external_attr = mode << 16
            archive.writestr(entry, content)
