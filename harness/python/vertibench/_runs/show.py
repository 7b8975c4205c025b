"""A task to look at, in a notebook or as a page of its own."""

from __future__ import annotations

import html
import math
import tempfile
from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from .errors import RunError, VertibenchError
from .frames import Trace
from .launch import events
from .picture import Driven, svg
from .places import Task, read_task, suite_folder, suite_of
from .store import Run, opened

#: Height of the replay in a notebook, pixels.
_HEIGHT = 520
#: How far a start or goal of a trace may be from the suite's, m.
_SAME = 1e-6


class Shown:
    """A picture of a task, with its replay below it if there is one. A notebook shows it at the end of a cell."""

    def __init__(self, task: str, told: str, svg: str, replay: str | None, height: int = _HEIGHT):
        #: Name of the task.
        self.task = task
        #: The picture as SVG.
        self.svg = svg
        #: The replay as a page of HTML; None if it is only the picture.
        self.replay = replay
        self._told = told
        self._height = height

    def __repr__(self) -> str:
        return f"<{self.task}: {self._told}; a notebook shows it, and save('page.html') writes it>"

    def _repr_html_(self) -> str:
        shown = f'<div style="max-width:820px">{self.svg}</div>'
        if self.replay is not None:
            # A frame of its own: neither its script nor its style reaches the notebook.
            shown += (
                f'<iframe srcdoc="{html.escape(self.replay)}" sandbox="allow-scripts" title="replay of {html.escape(self.task)}" '
                f'style="width:100%;max-width:1100px;height:{self._height}px;border:0;border-radius:6px;margin-top:6px"></iframe>'
            )
        return f'<div class="vertibench">{shown}</div>'

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, str]:
        return {"text/html": self._repr_html_(), "text/plain": repr(self)}

    def save(self, path: str | PathLike[str]) -> Path:
        """Writes it, and returns the file: the picture alone if its name ends in `.svg`, else a page of HTML that needs no
        other file and no network."""
        file = Path(path)
        title = html.escape(self.task)
        page = (
            f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title></head>'
            f'<body style="margin:16px;background:#fff">{self._repr_html_()}</body></html>\n'
        )
        try:
            file.write_text(self.svg if file.suffix == ".svg" else page, encoding="utf-8")
        except OSError as e:
            raise VertibenchError(file, f"cannot be written: {e.strerror}", "choose another place") from None
        return file


def show(
    run: Run | str | PathLike[str] | Sequence[Run | str | PathLike[str]],
    task: str | None = None,
    *,
    replay: bool = True,
    suite: str | PathLike[str] | None = None,
    height: int = _HEIGHT,
) -> Shown:
    """Shows a task of a run, e.g. `show(run, "w012/t03")`: the map with global path, start, goal and what was driven,
    coloured by speed, and below it the replay in three dimensions. Of several runs of the same suite each trajectory has a
    colour, and the replay follows the first. The task may be left out if the first run has one alone.

    `replay=False` leaves the replay out, which is about a megabyte; `height` is its height in pixels. `suite` is the folder
    of the suite, if it is neither where it was nor the one of its name that comes with the harness.

    Raises `RunError` if a run hasn't done the task, kept no trajectories, or is of another suite; `ProgramError` if
    `vb-harness replay` can't make the replay.
    """
    given: Sequence[Any] = run if isinstance(run, (list, tuple)) else [run]
    if not given:
        raise VertibenchError("show", "no run is given", "give one, or a list of some")
    runs = [opened(r) for r in given]
    for other in runs[1:]:
        if other.of("suite", "hash") != runs[0].of("suite", "hash"):
            names = " and ".join(str(r.of("suite", "name")) for r in (runs[0], other))
            raise RunError(other.path, f"it is of another suite than {runs[0].path}: {names}", "show them one by one")
        if other.of("scale") != runs[0].of("scale"):
            raise RunError(
                other.path, f"its world has another scale than that of {runs[0].path}", "show them one by one"
            )
    task = _only_task(runs[0]) if task is None else task
    traces = [r.trace(task) for r in runs]
    folder = suite_of(runs[0], suite)
    scene = read_task(folder, task, float(runs[0].of("scale") or 1))
    for trace in traces:
        _same_task(trace, scene, folder)
    labels = _labels(runs)
    driven = [_driven(r, t, label) for r, t, label in zip(runs, traces, labels)]
    picture = svg(scene, driven, _goal_radius(runs[0]))
    page = _replay(runs, task, folder) if replay else None
    told = ", ".join(f"{label} {d.outcome} after {d.time_s:.2f} s" for label, d in zip(labels, driven))
    return Shown(task, told, picture, page, height)


def show_task(suite: str | PathLike[str], task: str, *, scale: float = 1.0) -> Shown:
    """Shows a task that nobody has driven: the map with global path, start and goal. `suite` is a folder, or the name of a
    suite that comes with the harness; `scale` is the factor on every length of the world.

    Raises `RunError` if there is no such suite or task, or a file is damaged.
    """
    if not isinstance(scale, (int, float)) or not 0.0 < scale < math.inf:
        raise VertibenchError("show_task", f"scale is {scale!r}", "give a number above 0")
    scene = read_task(suite_folder(suite), task, scale)
    return Shown(task, f"of {scene.suite}", svg(scene), None)


def _only_task(run: Run) -> str:
    tasks = run.tasks
    if len(tasks) != 1:
        example = f"e.g. show(run, {tasks[0]!r})" if tasks else "once it has finished one"
        raise RunError(run.path, f"the run has {len(tasks)} finished tasks", f"name the task, {example}")
    return tasks[0]


def _replay(runs: Sequence[Run], task: str, folder: Path) -> str:
    with tempfile.TemporaryDirectory(prefix="vertibench-") as place:
        page = Path(place) / "replay.html"
        events(
            "replay",
            *(str(r.path) for r in runs),
            f"--task={task}",
            f"--suite={folder}",
            f"--out={page}",
            "--message-format=json",
        )
        return page.read_text(encoding="utf-8")


def _driven(run: Run, trace: Trace, label: str) -> Driven:
    record = run.record(trace.task)
    speed = np.sqrt(trace["vx"] ** 2 + trace["vy"] ** 2 + trace["vz"] ** 2)
    return Driven(label, record["outcome"], record.get("reason") or "", record["time_s"], trace["x"], trace["y"], speed)


def _labels(runs: Sequence[Run]) -> list[str]:
    """The planners' names, with the parameters in which namesakes differ, and the folder where that doesn't tell them
    apart."""
    names = [r.planner for r in runs]
    params = [r.of("params") or {} for r in runs]
    labels = []
    for name, own in zip(names, params):
        others = [p for p, n in zip(params, names) if n == name]
        differ = sorted(key for key in set().union(*others) if any(p.get(key) != own.get(key) for p in others))
        told = ", ".join(f"{key} {own.get(key, 'default')}" for key in differ)
        labels.append(f"{name} ({told})" if told else name)
    return [label if labels.count(label) == 1 else f"{label} [{r.path.name}]" for label, r in zip(labels, runs)]


def _goal_radius(run: Run) -> float | None:
    """How near to the goal is a success, m; None where the rules know no such distance."""
    success = run.of("rules", "profile", "success")
    for kind in success.values() if isinstance(success, dict) else ():
        if isinstance(kind, dict) and "radius_m" in kind:
            return float(kind["radius_m"]) * float(run.of("scale") or 1)
    return None


def _same_task(trace: Trace, scene: Task, folder: Path) -> None:
    apart = np.abs(np.subtract([*trace.start[:2], *trace.goal], [*scene.start[:2], *scene.goal])).max()
    if apart > _SAME:
        raise RunError(
            folder,
            f"its task {scene.name} is another than that of {trace.run.path}",
            "give the folder of the run's suite as suite=",
        )
