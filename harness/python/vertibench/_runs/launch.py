"""Runs a planner over tasks, with `vb-harness run` as a child process."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

from .._errors import OptionError
from .._options import selector
from .._program import harness_path
from .errors import ProgramError, UsageError
from .program import listen
from .run import Run


@dataclass(frozen=True)
class Progress:
    """State of a run in progress; `str()` returns it as one line.

    Attributes:
        done: Number of ended tasks, including those of an earlier part of the run.
        total: Number of tasks of the run.
        record: Record of the task that has just ended, as in `tasks.jsonl`; None at the start.
        outcomes: Number of tasks that this call has ended, by outcome.
    """

    done: int
    total: int
    record: dict[str, Any] | None
    outcomes: dict[str, int]

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
    """Runs a planner over tasks and returns the run when it has ended.

    Only `plugin` may be given by position. Arguments that are None use the default of `vb-harness run`. Ctrl-C,
    interrupting the notebook cell, and an exception in `progress` stop the program; finished tasks are kept, and
    `resume=True` continues the run.

    Args:
        plugin: Planner: a WASM file, a native library, or a command such as `"python3 my_planner.py"`. A file name such
            as `"pid.wasm"` that doesn't exist in the working directory names a shipped planner.
        suite: Suite directory, or name of a shipped suite; default `"vb-100"`.
        tasks: Selector, e.g. `"w001/t03"` or `"elevation=high,terrain=rigid"` (docs/worlds.md), or a list of its
            conditions, such as names of tasks; default all tasks.
        vehicle: Vehicle name or file; default `"hmmwv"`.
        perception: Name or file of the perception profile; default `"oracle"`.
        rules: Name or file of the rules; default `"paper"`.
        soils: Name or file of the soil set; default `"default"`.
        params: Parameters of the planner by name, e.g. `{"speed": 5}`; default: the planner's own values.
        limits: File with limits of the planner (docs/abi.md); default: the documented limits.
        scale: Factor on all lengths of the worlds, 0.01 to 10, as a number or as text such as `"1/6"`; default: the
            scale that the vehicle is made for.
        seed: Seed of the planner's randomness and of the sensor noise, at least 0; default 0.
        trace: Stored trajectory samples: `"none"`, `"10hz"` (default), or `"full"`, every 10 ms.
        logs: Tasks whose results contain the planner's last log lines: `"all"`, `"failed"` (default) or `"none"`.
        jobs: Number of parallel tasks, at least 1; default: the number of cores.
        out: Directory for the results, new or empty; default: a new `runs/PLANNER-N`.
        resume: Whether to continue the run in `out`, or without `out` the last `runs/PLANNER-N`. All other arguments
            except `jobs` and `progress` must be those of its start. Default False.
        keep_going: Whether to run all tasks even if the first ones all fail in the same way. Default False.
        require_sandbox: Whether to refuse commands, and native planners that the system can't confine completely.
            Default False.
        progress: Function that is called with a `Progress` at the start and after each task. True prints one line of
            text, False prints nothing. None (default): prints in notebooks and terminals.

    Returns:
        The run. A warning is issued if the simulation of some tasks failed.

    Raises:
        UsageError: If an argument is invalid, or a task, world or parameter is unknown.
        InputError: If the suite, planner, or another file can't be used.
        OutputError: If the results can't be written.
        HostError: If some tasks failed because of the harness or the machine; `run` of the error has the others.
        FailedStartError: If all of the first tasks failed in the same way; `run` of the error has them.
        StoppedError: If the program was stopped from outside; `run` of the error has the finished tasks.
        ProgramError: If the program ended with another error, or can't be started.
        MissingError: If the program is missing.
        KeyboardInterrupt: After Ctrl-C or an interrupt of the notebook cell.

    Example:
        >>> run = vertibench.run("pid.wasm", suite="smoke", tasks="w*/t00", params={"speed": 5})
    """
    if not isinstance(plugin, (str, PathLike)):
        raise UsageError(f"plugin={plugin!r}: not a planner (give a file, a command, or pid.wasm)", 2)
    if params is not None and not isinstance(params, Mapping):
        raise UsageError(f"params={params!r}: not a dictionary (give the parameters by name)", 2)
    try:
        tasks = selector(tasks)
    except OptionError as e:
        raise UsageError(str(e), 2) from None
    command = [str(harness_path()), "run", "--message-format", "json", "--plugin", os.fspath(plugin)]
    named = {
        "suite": suite, "tasks": tasks, "vehicle": vehicle, "perception": perception, "rules": rules, "soils": soils,
        "limits": limits, "scale": scale, "seed": seed, "trace": trace, "logs": logs, "jobs": jobs, "out": out,
    }  # fmt: skip
    # After an equals sign a value may begin with a dash.
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
        listen(command, handle)
    except ProgramError as e:
        if e.code in (7, 10, 130) and where is not None:
            e.run = Run(where)
        raise
    finally:
        finish()
    if where is None:
        raise ProgramError("vb-harness ended without the directory of the results (use a newer vb-harness)", 0, command)
    return Run(where)


def _text(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return os.fspath(value) if isinstance(value, PathLike) else str(value)


def _teller(
    progress: bool | Callable[[Progress], object] | None,
) -> tuple[Callable[[Progress], object], Callable[[], object]]:
    """Returns a function that reports each progress, and one to call at the end."""
    if callable(progress):
        return progress, lambda: None
    # In a notebook IPython is imported.
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    notebook = hasattr(shell, "kernel")
    if progress is None:
        progress = notebook or sys.stderr.isatty()
    elif not isinstance(progress, bool):
        raise UsageError(f"progress={progress!r}: not callable (give True, False or a function)", 2)
    if not progress:
        return lambda _: None, lambda: None
    return _in_a_notebook() if notebook else _on_a_terminal()


def _on_a_terminal() -> tuple[Callable[[Progress], object], Callable[[], object]]:
    """Reports on one line of stderr that is overwritten."""
    width = 0

    def tell(state: Progress) -> None:
        nonlocal width
        text = str(state)
        print(f"\r{text:<{width}}", end="", file=sys.stderr, flush=True)
        width = len(text)

    return tell, lambda: print(file=sys.stderr, flush=True) if width else None


def _in_a_notebook() -> tuple[Callable[[Progress], object], Callable[[], object]]:
    """Reports in one notebook output that is replaced."""
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
