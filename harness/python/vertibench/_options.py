"""Validates arguments before they are passed to Rust; errors name the argument."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any

from ._errors import OptionError


def whole(name: str, value: Any, least: int = 1, most: int | None = None) -> int:
    """Returns the value as an int within the bounds; raises `OptionError` otherwise."""
    try:
        count = int(value)
        if count != value or count < least or (most is not None and count > most):
            raise ValueError
    except (TypeError, ValueError, OverflowError):
        within = f", at least {least}" if most is None else f" from {least} to {most}"
        raise OptionError(f"{name}: {value!r} must be a whole number{within}") from None
    return count


def number(name: str, value: Any) -> float:
    """Returns the value as a float; raises `OptionError` otherwise."""
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise OptionError(f"{name}: {value!r} is not a number") from None


def seed(name: str, value: Any) -> int | None:
    """Returns a seed: None, or an int from 0 to 2**63 - 1; raises `OptionError` otherwise."""
    if value is None:
        return None
    try:
        own = int(value)
        if own != value:
            raise ValueError
    except (TypeError, ValueError, OverflowError):
        raise OptionError(f"{name}: {value!r} is not a whole number") from None
    if not 0 <= own < 2**63:
        raise OptionError(f"{name}: {own} must lie in 0 to 2**63 - 1")
    return own


def path(name: str, value: Any) -> str:
    """Returns a name or path as text; raises `OptionError` for other types."""
    if not isinstance(value, (str, os.PathLike)):
        raise OptionError(f"{name}: {value!r} must be a name or a path")
    return os.fsdecode(value)


def selector(tasks: Any) -> str | None:
    """Returns a task selector: None, a text, or a list of conditions joined with commas; raises `OptionError` otherwise."""
    if tasks is None or isinstance(tasks, str):
        return tasks
    names = list(tasks) if isinstance(tasks, Iterable) else [tasks]
    if not all(isinstance(name, str) for name in names):
        raise OptionError(f"tasks: {tasks!r} must be a selector such as 'w001/t03', or a list of names")
    return ",".join(names)
