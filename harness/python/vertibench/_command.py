"""Shared parts of the package's command lines."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable

from ._errors import VertibenchError


def ended(do: Callable[[], int | None], stopped: str = "stopped") -> int:
    """Calls the function and returns its exit code; an error becomes one line and an exit code. `stopped` is printed after
    Ctrl-C.
    """
    try:
        return int(do() or 0)
    except VertibenchError as e:
        print(f"error: {e}", file=sys.stderr)
        return 2
    except OSError as e:
        print(f"error: {e.filename or 'the system'}: {e.strerror or e} (check that the folder is writable)", file=sys.stderr)
        return 3
    except KeyboardInterrupt:
        print(stopped, file=sys.stderr)
        return 130


def whole_number(text: str) -> int:
    """Parses an argument that must be a whole number of at least 1."""
    try:
        number = int(text)
    except ValueError:
        number = 0
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text!r} must be a whole number, at least 1")
    return number


def above_zero(text: str) -> float:
    """Parses an argument that must be a finite number above 0."""
    try:
        number = float(text)
    except ValueError:
        number = 0.0
    if not 0.0 < number < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} must be a number above 0")
    return number
