"""Where the program `vb-harness` and the planners for it are."""

from __future__ import annotations

import os
import shutil
from os import PathLike
from pathlib import Path

from ._runs.errors import VertibenchError


def harness_path() -> Path:
    """The program `vb-harness`: what the environment variable `VB_HARNESS` names, else the one on the search path.

    Raises `VertibenchError` if there is none.
    """
    named = os.environ.get("VB_HARNESS")
    if named:
        if not Path(named).is_file():
            raise VertibenchError(
                named, "no program is here", "let VB_HARNESS name the program vb-harness, or unset it"
            )
        return Path(named)
    found = shutil.which("vb-harness")
    if found is None:
        raise VertibenchError(
            "vb-harness", "the program is not on the search path", "put it there, or let VB_HARNESS name it"
        )
    return Path(found)


def plugin_path(name: str | PathLike[str]) -> str:
    """The planner that a name means: a file of this name, else one in the folder that the environment variable
    `VB_PLUGINS` names, else the name as it is, which may be a command."""
    text = os.fspath(name)
    folder = os.environ.get("VB_PLUGINS")
    if folder and not Path(text).exists():
        there = Path(folder) / text
        if there.is_file():
            return str(there)
    return text
