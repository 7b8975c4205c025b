"""Base classes of the package's errors."""

from __future__ import annotations

from typing import Any


def one_line(text: object) -> str:
    """Returns the text with all whitespace replaced with single spaces."""
    return " ".join(str(text).split())


class VertibenchError(Exception):
    """Base of all errors of `vertibench`. The message is one line: `where: what (to_do)`.

    Args:
        where: Object of the error: a file, field or argument.
        what: What failed.
        to_do: Next step for the user.
    """

    def __init__(self, where: object, what: str, to_do: str):
        super().__init__(one_line(f"{where}: {what} ({to_do})"))

    def __reduce__(self) -> tuple[Any, ...]:
        # The constructor's arguments differ from `args`, so pickle can't call it.
        return _again, (type(self), self.args), self.__dict__


def _again(kind: type[VertibenchError], args: tuple[Any, ...]) -> VertibenchError:
    """Returns an unpickled error."""
    error = kind.__new__(kind, *args)
    super(VertibenchError, error).__init__(*args)
    return error


class MissingError(VertibenchError):
    """The program, the tasks, a planner, the GPU kernels or the package's compiled module can't be found."""


def missing_module(where: str, reason: ImportError) -> MissingError:
    """Returns the error for a part of the package whose compiled module can't be loaded."""
    return MissingError(where, f"the compiled module can't be loaded: {reason}", "install the wheel (docs/python.md)")


class MissingPackageError(VertibenchError, ImportError):
    """A Python package that a feature needs is not installed.

    Args:
        package: Name of the missing package.
        what_for: Feature that needs it.
        extra: Extra of `vertibench` that installs it. None (default): there is none.
    """

    def __init__(self, package: str, what_for: str, extra: str | None = None):
        to_do = f"pip install 'verti-bench[{extra}]'" if extra else f"pip install {package}"
        super().__init__(package, f"not installed, but required for {what_for}", to_do)


class EnvError(VertibenchError):
    """Base of the errors of environments and fleets. The message is one line.

    Args:
        message: The message.
    """

    def __init__(self, message: str):
        Exception.__init__(self, one_line(message))


class OptionError(EnvError, ValueError):
    """An argument is invalid, or names something that doesn't exist."""


class UnknownError(EnvError, KeyError):
    """There is no such task, environment or attribute."""

    __str__ = Exception.__str__  # A KeyError would put its message in quotes.


class ActionError(EnvError, ValueError):
    """An action has the wrong shape, or a number in it is not real and finite."""


class EpisodeError(EnvError, RuntimeError):
    """The call is impossible now: no episode, an ended one, or an environment that is busy, closed or of another process."""


class GpuError(EnvError, RuntimeError):
    """There is no suitable GPU, its memory is insufficient, it fails, or its states differ from those of the CPU."""


class PanicError(EnvError, RuntimeError):
    """A defect of the package. The interpreter continues; create the environment again."""
