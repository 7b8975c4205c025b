"""Starts the program `vb-harness` as a child process and reads its events."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import threading
import warnings
from collections.abc import Callable, Sequence
from typing import Any

from .._program import environment, harness_path
from .errors import ProgramError, of_program

#: Maximum time in which a stopped program may write its results, s.
_PATIENCE = 30.0
#: Exit code: completed, but the simulation of some tasks failed. The results are valid.
_SIM_ERRORS = 5


def events(*arguments: str) -> list[dict[str, Any]]:
    """Runs a command of the program and returns its JSON events. Raises the `ProgramError` of its exit code."""
    told: list[dict[str, Any]] = []
    listen([str(harness_path()), *arguments], told.append)
    return told


def listen(command: Sequence[str], handle: Callable[[dict[str, Any]], None]) -> None:
    """Starts the program, passes each event to `handle`, and stops the program if `handle` raises an error or after
    Ctrl-C.

    The program's warnings become Python warnings.
    """
    # In a separate process group, so that Ctrl-C reaches it once, from this process.
    apart: dict[str, Any] = {"start_new_session": True}
    if sys.platform == "win32":
        apart = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    pipe = subprocess.PIPE
    try:
        child = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=pipe, stderr=pipe, encoding="utf-8", errors="replace", env=environment(), **apart
        )
    except OSError as e:
        raise ProgramError(
            f"{command[0]}: cannot be started: {e.strerror} (set VB_HARNESS to the program)", 126, command
        ) from None
    said: list[str] = []
    # Both pipes must be read, otherwise program and parent wait for each other.
    listener = threading.Thread(target=lambda: said.extend(line.rstrip() for line in child.stderr or ()), daemon=True)
    listener.start()
    # The end of this block closes the pipes.
    with child:
        try:
            for line in child.stdout or ():
                handle(_message(line, command))
            code = child.wait()
            listener.join()
        except BaseException as e:
            _stop(child)
            listener.join(1)
            if isinstance(e, KeyboardInterrupt):
                raise KeyboardInterrupt(_error(said) or "stopped") from None
            raise
    for line in said:
        if line.startswith(("warning: ", "note: ")):
            warnings.warn(line, stacklevel=3)
    if code == _SIM_ERRORS:
        warnings.warn(_error(said), stacklevel=3)
    elif code:
        raise of_program(_error(said), code, command)


def _message(line: str, command: Sequence[str]) -> dict[str, Any]:
    try:
        event = json.loads(line)
    except ValueError:
        event = None
    if not isinstance(event, dict):
        raise ProgramError(f"{command[0]}: `{line[:80].strip()}` is not an event (VB_HARNESS must name vb-harness)", 0, command)
    return event


def _error(said: Sequence[str]) -> str:
    """Returns the text of the last error line and of the lines after it, which may refer to the help."""
    told = [k for k, line in enumerate(said) if line.startswith("error: ")]
    return " ".join(said[told[-1] :]).removeprefix("error: ") if told else ""


def _stop(child: subprocess.Popen[str]) -> None:
    """Stops the program as Ctrl-C does, so that it writes its results.

    Kills it if that takes too long, or after another interrupt.
    """
    try:
        if child.poll() is None:
            if sys.platform == "win32":
                child.send_signal(signal.CTRL_BREAK_EVENT)
            else:
                child.send_signal(signal.SIGINT)
            # A full pipe would block the program.
            reader = threading.Thread(target=lambda: all(True for _ in child.stdout or ()), daemon=True)
            reader.start()
            child.wait(_PATIENCE)
            reader.join(1)
    except (subprocess.TimeoutExpired, KeyboardInterrupt):
        pass
    finally:
        if child.poll() is None:
            child.kill()
            child.wait()
