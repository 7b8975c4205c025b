"""Errors of runs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .._errors import MissingPackageError as MissingPackageError
from .._errors import VertibenchError as VertibenchError
from .._errors import one_line


class RunError(VertibenchError):
    """A run directory, a file in it, or a suite is missing, damaged or unsuitable."""


class ProgramError(VertibenchError):
    """The program `vb-harness` ended with an error; the message is the program's own.

    Args:
        message: The message.
        code: Exit code.
        command: Command line.
        run: The partial run.

    Attributes:
        code: Exit code of the program, as listed by `vb-harness --help`; negative if a signal ended it.
        command: Command line of the program, a tuple of texts.
        run: The `Run` with the finished tasks; None if there is none.
    """

    def __init__(self, message: str, code: int, command: Sequence[str] = (), run: Any = None):
        Exception.__init__(self, one_line(message))
        self.code = code
        self.command = tuple(command)
        self.run = run


class InternalError(ProgramError):
    """Exit code 1: internal error of the harness."""


class UsageError(ProgramError):
    """Exit code 2: invalid argument, or unknown task, world or parameter."""


class InputError(ProgramError):
    """Exit code 3: unusable suite, planner, rule file, vehicle file, recorded run or dataset."""


class OutputError(ProgramError):
    """Exit code 4: results can't be written: disk full, no permission, directory not empty, in use, or of another run."""


class HostError(ProgramError):
    """Exit code 7: some tasks failed because of the harness or the machine.

    `run` contains the other tasks; `resume=True` re-runs the failed ones.
    """


class FailedStartError(ProgramError):
    """Exit code 10: early end, because the planner failed in the same way in all first tasks, or the simulation failed.

    `run` contains these tasks.
    """


class StoppedError(ProgramError):
    """Exit code 130: the program was stopped from outside.

    `run` contains the finished tasks; `resume=True` continues.
    """


_OF_CODE: dict[int, type[ProgramError]] = {
    1: InternalError,
    2: UsageError,
    3: InputError,
    4: OutputError,
    7: HostError,
    10: FailedStartError,
    130: StoppedError,
}


def of_program(message: str, code: int, command: Sequence[str]) -> ProgramError:
    """Returns the error for an exit code."""
    if not message:
        how = f"was ended by signal {-code}" if code < 0 else f"ended with exit code {code}"
        message = f"{command[0]}: it {how} without a message (run it in a terminal: {' '.join(command)})"
    return _OF_CODE.get(code, ProgramError)(message, code, command)
