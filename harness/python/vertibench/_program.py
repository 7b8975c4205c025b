"""Where the program, its tasks and its planners are: in the installed package, or in the checkout around it."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from ._errors import MissingError

# What the build puts into the package; a checkout has none of it.
_DATA = Path(__file__).parent / "_data"
_CHECKOUT = Path(__file__).parent.parent.parent.parent
_SUFFIX = ".exe" if sys.platform == "win32" else ""
# The variable that names the kernels for GPUs.
KERNEL = "VB_KERNEL"


def harness_path() -> Path:
    """The program `vb-harness`: what VB_HARNESS names, else the packaged one, else the one built in the checkout."""
    built = _target() / f"release/vb-harness{_SUFFIX}"
    return _find("VB_HARNESS", f"bin/vb-harness{_SUFFIX}", built, "the program", "cargo build --release -p vb-harness")


def tasks_path() -> Path:
    """The folder of suites and vehicles: what VB_TASKS names, else the packaged one, else that of the checkout."""
    return _find("VB_TASKS", "tasks", _CHECKOUT / "tasks", "the folder of tasks", "git checkout tasks")


def plugins_path() -> Path:
    """The folder of planners: what VB_PLUGINS names, else the packaged one, else the one built in the checkout."""
    return _find("VB_PLUGINS", "plugins", _target() / "plugins", "the folder of planners", "cargo xtask plugins")


def kernels_path() -> Path:
    """The kernels for GPUs: what VB_KERNEL names, else the folder of the packaged ones, else those made in the checkout."""
    build = "cargo xtask kernel"
    # A package that was built from its sources has none.
    lacking = f"run `{build}` in a checkout of this version"
    return _find(KERNEL, "kernels", _target() / "kernel", "the folder of kernels for GPUs", build, lacking)


def plugin_path(name: str | os.PathLike[str]) -> Path:
    """A planner's file: as it is named, or a bare file name such as `pid.wasm` in the folder of planners."""
    wanted = Path(name)
    if wanted.exists():
        return wanted
    if wanted.name != os.fspath(name):
        raise MissingError(wanted, "no such planner", "give the file of a planner, or pid.wasm")
    folder = plugins_path()
    if (folder / wanted).is_file():
        return folder / wanted
    there = ", ".join(sorted(file.name for file in folder.glob("*.wasm"))) or "none"
    raise MissingError(wanted, f"no such planner, here or in {folder}", f"the planners there: {there}")


def environment() -> dict[str, str]:
    """The environment in which the program finds its tasks and planners. What the user has set stays."""
    found = dict(os.environ)
    for variable, path in (("VB_TASKS", tasks_path), ("VB_PLUGINS", plugins_path)):
        if not found.get(variable):
            try:
                found[variable] = str(path())
            except MissingError:
                # The program says it where it needs them: a checkout may have no planners yet.
                pass
    return found


def _find(
    variable: str,
    packaged: str,
    built: Path,
    what: str,
    build: str,
    lacking: str = "install vertibench again",
) -> Path:
    named = os.environ.get(variable)
    if named:
        path = Path(named)
        if path.exists():
            return path
        raise MissingError(path, f"{what} isn't there", f"{variable} names it: correct or unset it")
    if (_DATA / packaged).exists():
        return _DATA / packaged
    if _in_checkout():
        if built.exists():
            return built
        raise MissingError(built, f"{what} isn't there", f"run `{build}` in the checkout, or set {variable}")
    raise MissingError(_DATA / packaged, f"{what} isn't there", f"{lacking}, or set {variable}")


def _in_checkout() -> bool:
    return (_CHECKOUT / "harness/cli/Cargo.toml").is_file()


def _target() -> Path:
    # Relative to the current folder where the user sets it, as cargo takes it.
    return Path(os.environ.get("CARGO_TARGET_DIR") or _CHECKOUT / "target")
