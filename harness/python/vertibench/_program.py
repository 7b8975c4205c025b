"""Finds program, tasks, planners and GPU kernels: in the installed package, or in the checkout around it."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from ._errors import MissingError

# Files that `cargo xtask wheel` adds to the package; a checkout has none.
_DATA = Path(__file__).parent / "_data"
_CHECKOUT = Path(__file__).parent.parent.parent.parent
_SUFFIX = ".exe" if sys.platform == "win32" else ""
# Environment variable that names the GPU kernels.
KERNEL = "VB_KERNEL"


def harness_path() -> Path:
    """Finds the program `vb-harness`.

    Returns:
        The file that the variable `VB_HARNESS` names, otherwise the package's own, otherwise the checkout's
        (`target/release`).

    Raises:
        MissingError: If the file doesn't exist.
    """
    built = _target() / f"release/vb-harness{_SUFFIX}"
    return _find("VB_HARNESS", f"bin/vb-harness{_SUFFIX}", built, "the program", "cargo build --release -p vb-harness")


def tasks_path() -> Path:
    """Finds the folder of suites and vehicles.

    Returns:
        The folder that the variable `VB_TASKS` names, otherwise the package's own, otherwise the checkout's (`tasks`).

    Raises:
        MissingError: If the folder doesn't exist.

    Example:
        >>> suite = tasks_path() / "smoke"
    """
    return _find("VB_TASKS", "tasks", _CHECKOUT / "tasks", "the folder of tasks", "git checkout tasks")


def plugins_path() -> Path:
    """Finds the folder of the shipped planners.

    Returns:
        The folder that the variable `VB_PLUGINS` names, otherwise the package's own, otherwise the checkout's
        (`target/plugins`).

    Raises:
        MissingError: If the folder doesn't exist.
    """
    return _find("VB_PLUGINS", "plugins", _target() / "plugins", "the folder of planners", "cargo xtask plugins")


def kernels_path() -> Path:
    """Finds the folder of GPU kernels.

    Returns:
        The folder or file that the variable `VB_KERNEL` names, otherwise the package's own folder, otherwise the
        checkout's (`target/kernel`).

    Raises:
        MissingError: If the folder or file doesn't exist.
    """
    build = "cargo xtask kernel"
    # A wheel without the option --kernels has no kernels.
    lacking = f"run `{build}` in a checkout of this version"
    return _find(KERNEL, "kernels", _target() / "kernel", "the folder of GPU kernels", build, lacking)


def plugin_path(name: str | os.PathLike[str]) -> Path:
    """Finds the file of a planner.

    Args:
        name: File of a planner. A file name without a folder that doesn't exist, such as `"pid.wasm"`, is searched in
            the folder of the shipped planners.

    Returns:
        The file.

    Raises:
        MissingError: If there is no such file.
    """
    wanted = Path(name)
    if wanted.exists():
        return wanted
    if wanted.name != os.fspath(name):
        raise MissingError(wanted, "no such planner", "give the file of a planner, or pid.wasm")
    folder = plugins_path()
    if (folder / wanted).is_file():
        return folder / wanted
    there = ", ".join(sorted(file.name for file in folder.glob("*.wasm"))) or "none"
    raise MissingError(wanted, f"no such file here or in {folder}", f"its planners: {there}")


def environment() -> dict[str, str]:
    """Returns environment variables with which the program finds tasks and planners. User settings are kept."""
    found = dict(os.environ)
    for variable, path in (("VB_TASKS", tasks_path), ("VB_PLUGINS", plugins_path)):
        if not found.get(variable):
            try:
                found[variable] = str(path())
            except MissingError:
                # The program reports the error if it needs them: a checkout may have no planners yet.
                pass
    return found


def _find(
    variable: str,
    packaged: str,
    built: Path,
    what: str,
    build: str,
    lacking: str = "install a wheel of `cargo xtask wheel`",
) -> Path:
    named = os.environ.get(variable)
    if named:
        path = Path(named)
        if path.exists():
            return path
        raise MissingError(path, f"{what} is missing", f"{variable} names it: correct or unset {variable}")
    if (_DATA / packaged).exists():
        return _DATA / packaged
    if _in_checkout():
        if built.exists():
            return built
        raise MissingError(built, f"{what} is missing", f"run `{build}` in the checkout, or set {variable}")
    raise MissingError(_DATA / packaged, f"{what} is missing", f"{lacking}, or set {variable}")


def _in_checkout() -> bool:
    return (_CHECKOUT / "harness/cli/Cargo.toml").is_file()


def _target() -> Path:
    # As in cargo, the variable is relative to the current folder.
    return Path(os.environ.get("CARGO_TARGET_DIR") or _CHECKOUT / "target")
