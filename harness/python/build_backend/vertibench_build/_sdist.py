"""The source distribution: the workspace, with the planners built."""

from __future__ import annotations

import gzip
import io
import os
import re
import subprocess
import tarfile
from pathlib import Path

from . import _stage

# What is there for tests alone, and large, or of no use without the repository.
_LEFT_OUT = ("tests/golden/abi-", "tests/fuzz/seeds/", "tests/fuzz/libfuzzer/", ".ci/", ".gitignore")
# The file that tells the program which commit it is built from, where there is no git.
_COMMIT = ".commit"


def make(out: Path, metadata: bytes) -> str:
    """Writes the archive; returns its name."""
    version = re.search(rb"^Version: (.+)$", metadata, re.MULTILINE)
    if not version:
        raise SystemExit("error: the metadata of the package has no version (see harness/python/pyproject.toml)")
    folder = f"vertibench-{version[1].decode()}"
    files: dict[str, tuple[bytes, int]] = {}
    for path in _stage.tracked():
        if not path.as_posix().startswith(_LEFT_OUT):
            mode = (_stage.ROOT / path).stat().st_mode & 0o111
            files[path.as_posix()] = ((_stage.ROOT / path).read_bytes(), 0o755 if mode else 0o644)
    for file in _stage.plugins():
        files[(_stage.PREBUILT / file.name).as_posix()] = (file.read_bytes(), 0o644)
    project = _stage.pyproject(f"{_stage.PYTHON.as_posix()}/Cargo.toml", _stage.PYTHON.as_posix())
    files["pyproject.toml"] = (project.encode(), 0o644)
    files["PKG-INFO"] = (metadata, 0o644)
    if commit := _git("describe", "--always", "--dirty=, modified", "--abbrev=40", "--exclude=*"):
        files[_COMMIT] = (f"{commit}\n".encode(), 0o644)
    write(out / f"{folder}.tar.gz", folder, files)
    return f"{folder}.tar.gz"


def _git(*arguments: str) -> str | None:
    if not (_stage.ROOT / ".git").exists():
        return None
    done = subprocess.run(["git", "-C", _stage.ROOT, *arguments], capture_output=True, text=True, check=False)
    return done.stdout.strip() or None


def write(file: Path, folder: str, files: dict[str, tuple[bytes, int]]) -> None:
    """Writes an archive with these files, each with its content and mode, in a folder: the same bytes each time."""
    seconds = int(os.environ.get("SOURCE_DATE_EPOCH") or _git("log", "-1", "--format=%ct") or 315532800)
    with (
        gzip.GzipFile(file, "wb", 9, mtime=seconds) as packed,
        tarfile.open(fileobj=packed, mode="w|", format=tarfile.PAX_FORMAT) as archive,
    ):
        for path in sorted(files):
            content, mode = files[path]
            entry = tarfile.TarInfo(f"{folder}/{path}")
            entry.size, entry.mode, entry.mtime = len(content), mode, seconds
            archive.addfile(entry, io.BytesIO(content))
