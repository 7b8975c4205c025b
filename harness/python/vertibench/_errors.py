"""The kinds of error that all of this package raises."""

from __future__ import annotations

from typing import Any


def one_line(text: object) -> str:
    """A text on one line."""
    return " ".join(str(text).split())


class VertibenchError(Exception):
    """Any error of `vertibench` that its user can mend. The message is one line: where, what, what to do."""

    def __init__(self, where: object, what: str, to_do: str):
        super().__init__(one_line(f"{where}: {what} ({to_do})"))

    def __reduce__(self) -> tuple[Any, ...]:
        # An error has other arguments than its message, so that a process which is sent one can't make it of these.
        return _again, (type(self), self.args), self.__dict__


def _again(kind: type[VertibenchError], args: tuple[Any, ...]) -> VertibenchError:
    """An error as it was in another process."""
    error = kind.__new__(kind, *args)
    super(VertibenchError, error).__init__(*args)
    return error


class MissingError(VertibenchError):
    """The program, the tasks or a planner isn't where it is looked for."""


def missing_module(where: str, reason: ImportError) -> MissingError:
    """The error for a part of the package whose module in Rust can't be loaded."""
    return MissingError(where, f"the package's module in Rust can't be loaded: {reason}", "install the wheel (docs/python.md)")


class MissingPackageError(VertibenchError, ImportError):
    """A package that is needed for this alone is not installed. `extra` is the one of this package that brings it, if one does."""

    def __init__(self, package: str, what_for: str, extra: str | None = None):
        to_do = f"pip install 'vertibench[{extra}]'" if extra else f"pip install {package}"
        super().__init__(package, f"it is not installed, but needed for {what_for}", to_do)


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
    """An action has the wrong shape, or isn't made of finite, real numbers."""


class EpisodeError(EnvError, RuntimeError):
    """There is no episode, it has ended, the environment is at work, in another process, or closed."""


class GpuError(EnvError, RuntimeError):
    """There is no GPU that a fleet could be on, too little memory on it, or it fails."""


class PanicError(EnvError, RuntimeError):
    """A fault of the package itself. The interpreter goes on; the environment should be made anew."""
