"""Driving a planner over tasks: `vb-harness run` as a child."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

from .._errors import OptionError
from .._options import selector
from .._program import environment, harness_path
from .errors import ProgramError, UsageError, of_program
from .store import Run

#: How long the program may take to put its results away when it is stopped, s.
_PATIENCE = 30.0
#: Completed, but the simulation of some tasks failed: the results stand.
_SIM_ERRORS = 5


@dataclass(frozen=True)
class Progress:
    """How far a run is."""

    done: int  #: tasks that have ended, those of an earlier part of the run included
    total: int  #: tasks of the run
    record: dict[str, Any] | None  #: of the task that has just ended, as in tasks.jsonl; None at the start
    outcomes: dict[str, int]  #: tasks that this call has ended, by outcome

    def __str__(self) -> str:
        counts = ", ".join(f"{n} {name}" for name, n in sorted(self.outcomes.items()))
        return f"{self.done} of {self.total} tasks" + (f": {counts}" if counts else "")


def run(
    plugin: str | PathLike[str],
    *,
    suite: str | PathLike[str] | None = None,
    tasks: str | Sequence[str] | None = None,
    vehicle: str | PathLike[str] | None = None,
    perception: str | PathLike[str] | None = None,
    rules: str | PathLike[str] | None = None,
    soils: str | PathLike[str] | None = None,
    params: Mapping[str, object] | None = None,
    limits: str | PathLike[str] | None = None,
    scale: float | str | None = None,
    seed: int | None = None,
    trace: str | None = None,
    logs: str | None = None,
    jobs: int | None = None,
    out: str | PathLike[str] | None = None,
    resume: bool = False,
    keep_going: bool = False,
    require_sandbox: bool = False,
    progress: bool | Callable[[Progress], object] | None = None,
) -> Run:
    """Drives a planner over tasks, and returns the run when it has ended.

    `plugin` is a WASM file, a native library, or a command such as `"python3 my_planner.py"`; a bare file
    name such as `pid.wasm` that isn't in the working directory is one of the planners that come with the package. `suite` is a directory or the name of a suite
    that comes with the harness (vb-100 if it is left out), `tasks` a selector such as `"w001/t03"` or
    `"w001-w004,elevation=high"`, or a list of them. `params` are the planner's parameters by name. All other arguments are
    the options of `vb-harness` of the same names; what is left out has the value that `vb-harness --help` tells. `jobs` is
    the number of tasks that run at a time. `out` is the directory for the results, by default a new `runs/PLANNER-N`; with
    `resume=True` the run in it goes on.

    `progress` is called with a `Progress` at the start and after each task. True writes a line of text, False writes
    nothing, and by default the line is written in notebooks and on terminals. Ctrl-C, the interruption of a notebook's
    cell, and an error in `progress` stop the program; the finished tasks are safe.

    Raises the `ProgramError` of its exit code, with the program's own message, if the run doesn't come about; `HostError`
    and `FailedStartError` have the tasks that were done as `run`. Tasks whose simulation failed are a warning.
    """
    if not isinstance(plugin, (str, PathLike)):
        raise UsageError(f"plugin={plugin!r}: it is no planner (give a file, a command, or pid.wasm)", 2)
    if params is not None and not isinstance(params, Mapping):
        raise UsageError(f"params={params!r}: they are no parameters (give a dictionary by their names)", 2)
    try:
        tasks = selector(tasks)
    except OptionError as e:
        raise UsageError(str(e), 2) from None
    command = [str(harness_path()), "run", "--message-format", "json", "--plugin", os.fspath(plugin)]
    named = {
        "suite": suite, "tasks": tasks, "vehicle": vehicle, "perception": perception, "rules": rules, "soils": soils,
        "limits": limits, "scale": scale, "seed": seed, "trace": trace, "logs": logs, "jobs": jobs, "out": out,
    }  # fmt: skip
    # With the sign of equality a value may begin with a dash.
    command += [f"--{name}={_text(value)}" for name, value in named.items() if value is not None]
    command += [f"--param={name}={_text(value)}" for name, value in (params or {}).items()]
    flags = {"resume": resume, "keep-going": keep_going, "require-sandbox": require_sandbox}
    command += [f"--{name}" for name, given in flags.items() if given]
    tell, finish = _teller(progress)
    where: Path | None = Path(out).absolute() if out is not None else None
    outcomes: dict[str, int] = {}

    def handle(event: dict[str, Any]) -> None:
        nonlocal where
        kind = event.get("event")
        if kind == "started":
            tell(Progress(event["resumed"], event["total"], None, {}))
        elif kind == "task":
            name = event["record"]["outcome"]
            outcomes[name] = outcomes.get(name, 0) + 1
            tell(Progress(event["done"], event["total"], event["record"], dict(outcomes)))
        elif kind == "finished":
            where = Path(event["out"]).absolute()

    try:
        _listen(command, handle)
    except ProgramError as e:
        if e.code in (7, 10, 130) and where is not None:
            e.run = Run(where)
        raise
    finally:
        finish()
    if where is None:
        raise ProgramError("vb-harness ended without telling where the results are (use a newer one)", 0, command)
    return Run(where)


def events(*arguments: str) -> list[dict[str, Any]]:
    """What a command of the program tells, as dictionaries. Raises the `ProgramError` of its exit code."""
    told: list[dict[str, Any]] = []
    _listen([str(harness_path()), *arguments], told.append)
    return told


def _text(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return os.fspath(value) if isinstance(value, PathLike) else str(value)


def _listen(command: Sequence[str], handle: Callable[[dict[str, Any]], None]) -> None:
    """Starts the program, hands over what it tells on stdout while it goes on, and stops it if `handle` fails or we are
    interrupted. What it warns of is warned of here."""
    # In a group of its own, so that Ctrl-C reaches it once, through us.
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
            f"{command[0]}: cannot be started: {e.strerror} (let VB_HARNESS name it)", 126, command
        ) from None
    said: list[str] = []
    # Both pipes must be emptied, or the program waits for us while we wait for it.
    listener = threading.Thread(target=lambda: said.extend(line.rstrip() for line in child.stderr or ()), daemon=True)
    listener.start()
    # Leaving this closes the pipes.
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
        raise ProgramError(f"{command[0]}: `{line[:80].strip()}` is no message (is it vb-harness?)", 0, command)
    return event


def _error(said: Sequence[str]) -> str:
    """The message of the line that tells the error; it may be followed by a hint to the help."""
    told = [k for k, line in enumerate(said) if line.startswith("error: ")]
    return " ".join(said[told[-1] :]).removeprefix("error: ") if told else ""


def _stop(child: subprocess.Popen[str]) -> None:
    """Stops the program as Ctrl-C does, so that it puts its results away; at once if that takes too long, or we are
    interrupted again."""
    try:
        if child.poll() is None:
            if sys.platform == "win32":
                child.send_signal(signal.CTRL_BREAK_EVENT)
            else:
                child.send_signal(signal.SIGINT)
            # Nobody else reads on, and a full pipe must not hold it up.
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


def _teller(
    progress: bool | Callable[[Progress], object] | None,
) -> tuple[Callable[[Progress], object], Callable[[], object]]:
    """What is called with each progress, and at the end."""
    if callable(progress):
        return progress, lambda: None
    # Whoever runs in a notebook has imported IPython.
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    notebook = hasattr(shell, "kernel")
    if progress is None:
        progress = notebook or sys.stderr.isatty()
    elif not isinstance(progress, bool):
        raise UsageError(f"progress={progress!r}: it can't be called (give True, False or a function)", 2)
    if not progress:
        return lambda _: None, lambda: None
    return _in_a_notebook() if notebook else _on_a_terminal()


def _on_a_terminal() -> tuple[Callable[[Progress], object], Callable[[], object]]:
    """One line on stderr that is written over."""
    width = 0

    def tell(state: Progress) -> None:
        nonlocal width
        text = str(state)
        print(f"\r{text:<{width}}", end="", file=sys.stderr, flush=True)
        width = len(text)

    return tell, lambda: print(file=sys.stderr, flush=True) if width else None


def _in_a_notebook() -> tuple[Callable[[Progress], object], Callable[[], object]]:
    """One output that is replaced."""
    from IPython.display import display

    shown = None

    def tell(state: Progress) -> None:
        nonlocal shown
        text = {"text/plain": str(state)}
        if shown is None:
            shown = display(text, raw=True, display_id=True)
        else:
            shown.update(text, raw=True)

    return tell, lambda: None
