"""What goes wrong with runs. Each message is one line: where, what, what to do."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from .._errors import MissingPackageError as MissingPackageError
from .._errors import VertibenchError as VertibenchError
from .._errors import one_line

if TYPE_CHECKING:
    from .store import Run


class RunError(VertibenchError):
    """A run directory, a file in it, or a suite can't be used."""


class ProgramError(VertibenchError):
    """The program `vb-harness` ended with an error. The message is its own."""

    def __init__(self, message: str, code: int, command: Sequence[str] = (), run: Run | None = None):
        Exception.__init__(self, one_line(message))
        #: Its exit code, as `vb-harness --help` lists them; negative if a signal ended it.
        self.code = code
        #: The command that was started.
        self.command = tuple(command)
        #: The run as far as it got, where there is one.
        self.run = run


class InternalError(ProgramError):
    """Exit code 1: a fault of the harness."""


class UsageError(ProgramError):
    """Exit code 2: an argument makes no sense, or names an unknown task, world or parameter."""


class InputError(ProgramError):
    """Exit code 3: a suite, plugin, rule file, vehicle file, recorded run or dataset can't be used."""


class OutputError(ProgramError):
    """Exit code 4: results can't be written: disk full, no permission, directory not empty, in use or of another run."""


class HostError(ProgramError):
    """Exit code 7: the harness or the machine failed some tasks; `resume=True` runs them again. `run` has the others."""


class FailedStartError(ProgramError):
    """Exit code 10: in all of the first tasks the planner failed alike, or the simulation failed. `run` has them."""


class StoppedError(ProgramError):
    """Exit code 130: somebody else stopped the program; `resume=True` goes on. `run` has the finished tasks."""


_OF_CODE: dict[int, type[ProgramError]] = {
    1: InternalError,
    2: UsageError,
    3: InputError,
    4: OutputError,
    7: HostError,
    10: FailedStartError,
    130: StoppedError,
}


def of_program(message: str, code: int, command: Sequence[str], run: Run | None = None) -> ProgramError:
    """The error for an exit code."""
    if not message:
        how = f"was ended by signal {-code}" if code < 0 else f"ended with exit code {code}"
        message = f"{command[0]}: it {how} and said nothing (run it in a terminal: {' '.join(command)})"
    return _OF_CODE.get(code, ProgramError)(message, code, command, run)
