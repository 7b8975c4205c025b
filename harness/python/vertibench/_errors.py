"""The kinds of error that all of this package raises."""

from __future__ import annotations


def one_line(text: object) -> str:
    """A text on one line."""
    return " ".join(str(text).split())


class VertibenchError(Exception):
    """Any error of `vertibench` that its user can mend. The message is one line: where, what, what to do."""

    def __init__(self, where: object, what: str, to_do: str):
        super().__init__(one_line(f"{where}: {what} ({to_do})"))


class MissingError(VertibenchError):
    """The program, the tasks or a planner isn't where it is looked for."""


class MissingPackageError(VertibenchError, ImportError):
    """A package that is needed for this alone is not installed."""

    def __init__(self, package: str, what_for: str):
        super().__init__(
            package, f"it is not installed, but needed for {what_for}", f"pip install 'vertibench[{package}]'"
        )
