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


def missing_module(where: str, reason: ImportError) -> MissingError:
    """The error for a part of the package whose module in Rust can't be loaded."""
    return MissingError(where, f"the package's module in Rust can't be loaded: {reason}", "install the wheel (docs/python.md)")


class MissingPackageError(VertibenchError, ImportError):
    """A package that is needed for this alone is not installed."""

    def __init__(self, package: str, what_for: str):
        super().__init__(package, f"it is not installed, but needed for {what_for}", f"pip install {package}")


class EnvError(VertibenchError):
    """Something is wrong with an environment, or with what is asked of it. The message is one line."""

    def __init__(self, message: str):
        Exception.__init__(self, one_line(message))


class OptionError(EnvError, ValueError):
    """An option of an environment makes no sense, or names what isn't there."""


class UnknownError(EnvError, KeyError):
    """There is no such task, or no such environment."""

    __str__ = Exception.__str__  # A KeyError would put its message in quotes.


class ActionError(EnvError, ValueError):
    """An action has the wrong shape, or is no number."""


class EpisodeError(EnvError, RuntimeError):
    """There is no episode, it has ended, the environment is at work, in another process, or closed."""


class GpuError(EnvError, RuntimeError):
    """There is no GPU that a fleet could be on, too little memory on it, or it fails."""


class PanicError(EnvError, RuntimeError):
    """A fault of the package itself. The interpreter goes on; the environment should be made anew."""
