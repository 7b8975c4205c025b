"""The archive of a release: the program with its tasks and planners beside it, for those who don't use Python."""

from __future__ import annotations

import hashlib
import os
import re
from pathlib import Path

from . import _licences, _sdist, _stage

# What a user reads first, as it lies in the repository.
_TEXTS = ("README.md", "CHANGELOG.md", "LICENSE-APACHE", "LICENSE-MIT")


def make(out: Path) -> str:
    """Writes the archive for the platform that VB_RELEASE_TARGET names; returns its name.

    The program and the planners are those of VB_WHEEL_HARNESS and VB_WHEEL_PLUGINS, or built now. VB_RELEASE_SHELL
    names a folder with what shells and `man` know of the program.
    """
    name = f"vertibench-{_version()}-{_named('VB_RELEASE_TARGET')}"
    program = _stage.program()
    files: dict[str, tuple[bytes, int]] = {program.name: (_stage.stripped(program), 0o755)}
    for path in _stage.tracked("tasks"):
        files[path.as_posix()] = ((_stage.ROOT / path).read_bytes(), 0o644)
    for path in _stage.plugins():
        files[f"plugins/{path.name}"] = (path.read_bytes(), 0o644)
    shell = Path(_named("VB_RELEASE_SHELL"))
    for path in sorted(shell.rglob("*")):
        if path.is_file():
            files[path.relative_to(shell).as_posix()] = (path.read_bytes(), 0o644)
    for text in _TEXTS:
        files[text] = ((_stage.ROOT / text).read_bytes(), 0o644)
    files["LICENSE-THIRD-PARTY.txt"] = (_licences.text(_stage.ROOT).encode(), 0o644)
    _sdist.write(out / f"{name}.tar.gz", name, files)
    sums(out)
    return f"{name}.tar.gz"


def sums(out: Path) -> None:
    """Writes the checksums of all archives and wheels in a folder, as `sha256sum --check` reads them."""
    made = sorted([*out.glob("*.tar.gz"), *out.glob("*.whl")], key=lambda path: path.name)
    lines = [f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in made]
    (out / "SHA256SUMS").write_bytes("".join(lines).encode())


def _version() -> str:
    text = (_stage.ROOT / "Cargo.toml").read_text(encoding="utf-8")
    found = re.search(r'^\[workspace\.package\]\nversion = "([^"]+)"$', text, re.MULTILINE)
    if not found:
        raise SystemExit("error: Cargo.toml: the workspace has no version (it is the name of a release)")
    return found[1]


def _named(variable: str) -> str:
    value = os.environ.get(variable)
    if not value:
        raise SystemExit(f"error: {variable} is not set (releases are made by `cargo xtask release`)")
    return value
