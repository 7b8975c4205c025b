"""The folder that a wheel is made of: the package, and the program, tasks and planners as its data."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from . import _licences

ROOT = Path(__file__).parents[4]
PYTHON = Path("harness/python")
# Where a source distribution has its planners, since a user's Rust may lack the target that they are built for.
PREBUILT = PYTHON / "prebuilt"
# Planners that are there to fail, or to misuse the vehicle.
_FOR_TESTS = {"faulty", "wild"}
_SUFFIX = ".exe" if sys.platform == "win32" else ""


def package(into: Path) -> None:
    """Puts together what the wheel is made of."""
    # What takes longest may fail first.
    built, planners, gpu_kernels = program(), plugins(), kernels()
    description(into)
    for path in tracked(str(PYTHON / "vertibench")):
        _copy(ROOT / path, into / path.relative_to(PYTHON))
    data = into / "vertibench/_data"
    harness = data / f"bin/vb-harness{_SUFFIX}"
    harness.parent.mkdir(parents=True)
    harness.write_bytes(stripped(built))
    harness.chmod(0o755)
    for path in tracked("tasks"):
        _copy(ROOT / path, data / path)
    for path in planners:
        _copy(path, data / "plugins" / path.name)
    for path in gpu_kernels:
        _copy(path, data / "kernels" / path.name)
    (into / "LICENSE-THIRD-PARTY.txt").write_text(_licences.text(ROOT), encoding="utf-8")


def description(into: Path) -> None:
    """Puts there what says how the package is built, as if it lay beside the workspace."""
    text = pyproject(manifest=(ROOT / PYTHON / "Cargo.toml").as_posix())
    (into / "pyproject.toml").write_text(text, encoding="utf-8")
    # maturin looks for it even where it only writes the metadata.
    (into / "vertibench").mkdir()
    _copy(ROOT / PYTHON / "README.md", into / "README.md")
    for licence in sorted(ROOT.glob("LICENSE-*")):
        _copy(licence, into / licence.name)


def pyproject(manifest: str, folder: str = "") -> str:
    """The package's pyproject.toml for another folder: that of its manifest's path, with its files in `folder`."""
    text = (ROOT / PYTHON / "pyproject.toml").read_text(encoding="utf-8")
    changes = {
        'manifest-path = "Cargo.toml"': f'manifest-path = "{manifest}"',
        'python-source = "."': f'python-source = "{folder or "."}"',
        'readme = "README.md"': f'readme = "{folder + "/" if folder else ""}README.md"',
        'backend-path = ["build_backend"]': f'backend-path = ["{folder + "/" if folder else ""}build_backend"]',
    }
    for old, new in changes.items():
        if text.count(f"{old}\n") != 1:
            raise SystemExit(
                f"error: {PYTHON}/pyproject.toml: wants one line `{old}` (the build puts another in its place)"
            )
        text = text.replace(f"{old}\n", f"{new}\n")
    return text


def program() -> Path:
    """The program: the one that is named, or built now."""
    named = os.environ.get("VB_WHEEL_HARNESS")
    if named:
        return _existing(Path(named), "VB_WHEEL_HARNESS")
    # Without the tasks within it, which lie beside it.
    _cargo("build", "--release", "--locked", "--package", "vb-harness", "--no-default-features")
    return target() / "release" / f"vb-harness{_SUFFIX}"


def plugins() -> list[Path]:
    """The planners: those in the folder that is named, those that came with the sources, or built now."""
    named = os.environ.get("VB_WHEEL_PLUGINS")
    if named:
        folder = _existing(Path(named), "VB_WHEEL_PLUGINS")
    elif (ROOT / PREBUILT).is_dir():
        folder = ROOT / PREBUILT
    else:
        folder = target() / "plugins"
        _cargo("xtask", "plugins", "--wasm", "--out", str(folder))
    files = [folder / f"{name}.wasm" for name in planners()]
    for file in files:
        if not file.is_file():
            raise SystemExit(f"error: {file}: the planner isn't there (build it with `cargo xtask plugins`)")
    return files


def kernels() -> list[Path]:
    """The kernels for GPUs: those in the folder that is named, else none, since few can build them."""
    named = os.environ.get("VB_WHEEL_KERNELS")
    if not named:
        return []
    folder = _existing(Path(named), "VB_WHEEL_KERNELS")
    files = sorted(folder.glob("vb-kernel-*.cubin.xz"))
    if not files:
        raise SystemExit(f"error: {folder}: has no kernels (make them with `cargo xtask kernel`)")
    return files


def planners() -> list[str]:
    """The names of the planners that come with the package: all in Rust that aren't for tests."""
    manifests = [*ROOT.glob("plugins/*/Cargo.toml"), *ROOT.glob("examples/*/Cargo.toml")]
    names = {path.parent.name for path in manifests if '"cdylib"' in path.read_text(encoding="utf-8")}
    return sorted(names - _FOR_TESTS)


def tracked(folder: str = ".") -> list[Path]:
    """The files of the sources in a folder, relative to their root: those that git tracks, with what lies in folders that links
    name; all where there is no git."""
    git = ["git", "-C", str(ROOT), "ls-files", "-z", "--", folder]
    if (ROOT / ".git").exists():
        done = subprocess.run(git, capture_output=True, check=False)
        if done.returncode != 0:
            reason = done.stderr.decode(errors="replace").strip()
            raise SystemExit(
                f"error: {ROOT}: git can't list the sources: {reason} (see that `git ls-files` works there)"
            )
        paths = [Path(os.fsdecode(name)) for name in done.stdout.split(b"\0") if name]
        return sorted(file for path in paths for file in _files_of(path))
    files = [path.relative_to(ROOT) for path in sorted((ROOT / folder).rglob("*")) if path.is_file()]
    return [path for path in files if path.parts[0] != "target" and "__pycache__" not in path.parts]


def _files_of(path: Path) -> list[Path]:
    """A file that git tracks, or those in the folder that a link of it names."""
    whole = ROOT / path
    if whole.is_dir():
        return [path / file.relative_to(whole) for file in whole.rglob("*") if file.is_file()]
    return [path] if whole.is_file() else []


def _existing(path: Path, variable: str) -> Path:
    if not path.exists():
        raise SystemExit(f"error: {path}: isn't there ({variable} names it: correct or unset it)")
    return path


def target() -> Path:
    """The folder of what cargo builds."""
    # Relative to the current folder where the user sets it, as cargo takes it.
    return Path(os.environ.get("CARGO_TARGET_DIR") or ROOT / "target").absolute()


def _cargo(*arguments: str) -> None:
    if not shutil.which("cargo"):
        raise SystemExit(
            "error: cargo isn't there, and the package is built from Rust (install it from https://rustup.rs)"
        )
    print("Running `cargo {}`".format(" ".join(arguments)), flush=True)
    done = subprocess.run(
        ["cargo", *arguments], cwd=ROOT, env={**os.environ, "CARGO_TARGET_DIR": str(target())}, check=False
    )
    if done.returncode != 0:
        raise SystemExit(f"error: `cargo {' '.join(arguments)}` failed in {ROOT} (what it says above is the reason)")


def stripped(program: Path) -> bytes:
    """A program without the names of its functions, which are a fifth of it."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, program.name)
        _copy(program, file)
        # Where there is no strip, or none for that processor, they stay.
        strip = shutil.which("strip")
        if not strip or subprocess.run([strip, str(file)], stderr=subprocess.DEVNULL, check=False).returncode != 0:
            if re.search(rb"\x00\.symtab\x00", file.read_bytes()):
                print(f"note: {file.name} keeps its symbols: there is no `strip` for it", file=sys.stderr)
        return file.read_bytes()


def _copy(source: Path, to: Path) -> None:
    to.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(source, to)
    shutil.copymode(source, to)
