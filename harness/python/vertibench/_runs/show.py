"""Display of a task, in a notebook or as an HTML page."""

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
from .frames import Trace, trace
from .picture import Driven, svg
from .places import Task, read_task, suite_folder, suite_of
from .program import events
from .store import RunDirectory

#: Default height of the replay in a notebook, pixels.
_HEIGHT = 520
#: Maximum distance between start or goal of a trace and of the suite, m.
_SAME = 1e-6


class Shown:
    """Picture of a task, with its replay if there is one. A notebook displays it at the end of a cell.

    `vertibench.show` and `vertibench.show_task` return it.

    Attributes:
        task: Task name.
        svg: The picture as SVG.
        replay: The replay as HTML page; None without one.
    """

    def __init__(self, task: str, told: str, svg: str, replay: str | None, height: int | None = None):
        self.task = task
        self.svg = svg
        self.replay = replay
        self._told = told
        self._height = _HEIGHT if height is None else height

    def __repr__(self) -> str:
        return f"<{self.task}: {self._told}; a notebook shows it, and save('page.html') writes it>"

    def _repr_html_(self) -> str:
        shown = f'<div style="max-width:820px">{self.svg}</div>'
        if self.replay is not None:
            # In a separate frame, so that its script and style don't affect the notebook.
            shown += (
                f'<iframe srcdoc="{html.escape(self.replay)}" sandbox="allow-scripts" title="replay of {html.escape(self.task)}" '
                f'style="width:100%;max-width:1100px;height:{self._height}px;border:0;border-radius:6px;margin-top:6px"></iframe>'
            )
        return f'<div class="vertibench">{shown}</div>'

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, str]:
        return {"text/html": self._repr_html_(), "text/plain": repr(self)}

    def save(self, path: str | PathLike[str]) -> Path:
        """Writes the picture to a file.

        Args:
            path: File to write. With the suffix `.svg` it contains only the picture; otherwise it is an HTML page with
                picture and replay that needs no other file and no network.

        Returns:
            The file.

        Raises:
            VertibenchError: If the file can't be written.
        """
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


def show_runs(
    runs: Sequence[RunDirectory], task: str | None, replay: bool, suite: str | PathLike[str] | None, height: int | None
) -> Shown:
    """Displays a task of one or more runs; see `vertibench.show`."""
    for other in runs[1:]:
        if other.of("suite", "hash") != runs[0].of("suite", "hash"):
            names = " and ".join(str(r.of("suite", "name")) for r in (runs[0], other))
            raise RunError(other.path, f"its suite differs from that of {runs[0].path}: {names}", "show the runs separately")
        if other.of("scale") != runs[0].of("scale"):
            raise RunError(
                other.path, f"its scale differs from that of {runs[0].path}", "show the runs separately"
            )
    task = _only_task(runs[0]) if task is None else task
    traces = [trace(r, task, "numpy") for r in runs]
    folder = suite_of(runs[0], suite)
    scene = read_task(folder, task, float(runs[0].of("scale") or 1))
    for own in traces:
        _same_task(own, scene, folder)
    labels = _labels(runs)
    driven = [_driven(r, t, label) for r, t, label in zip(runs, traces, labels)]
    picture = svg(scene, driven, _goal_radius(runs[0]))
    page = _replay(runs, task, folder) if replay else None
    told = ", ".join(f"{label} {d.outcome} after {d.time_s:.2f} s" for label, d in zip(labels, driven))
    return Shown(task, told, picture, page, height)


def show_task(suite: str | PathLike[str], task: str, *, scale: float = 1.0) -> Shown:
    """Displays a task without a run: a map with global path, start and goal.

    Args:
        suite: Suite folder, or name of a shipped suite.
        task: Task name, e.g. `"w003/t00"`.
        scale: Factor on all lengths of the world, above 0; default 1.

    Returns:
        The picture, which a notebook displays.

    Raises:
        RunError: If there is no such suite or task, or a file is damaged.
        VertibenchError: If the scale is no number above 0.
    """
    if not isinstance(scale, (int, float)) or not 0.0 < scale < math.inf:
        raise VertibenchError("show_task", f"scale is {scale!r}", "give a number above 0")
    scene = read_task(suite_folder(suite), task, scale)
    return Shown(task, f"of {scene.suite}", svg(scene), None)


def _only_task(run: RunDirectory) -> str:
    tasks = run.tasks
    if len(tasks) != 1:
        example = f"e.g. show(run, {tasks[0]!r})" if tasks else "once it has finished one"
        raise RunError(run.path, f"the run has {len(tasks)} finished tasks", f"name the task, {example}")
    return tasks[0]


def _replay(runs: Sequence[RunDirectory], task: str, folder: Path) -> str:
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


def _driven(run: RunDirectory, trace: Trace, label: str) -> Driven:
    record = run.record(trace.task)
    speed = np.sqrt(trace["vx"] ** 2 + trace["vy"] ** 2 + trace["vz"] ** 2)
    return Driven(label, record["outcome"], record.get("reason") or "", record["time_s"], trace["x"], trace["y"], speed)


def _labels(runs: Sequence[RunDirectory]) -> list[str]:
    """Returns planner names, with the parameters in which runs of one planner differ, and the folder if these are equal."""
    names = [r.planner for r in runs]
    params = [r.of("params") or {} for r in runs]
    labels = []
    for name, own in zip(names, params):
        others = [p for p, n in zip(params, names) if n == name]
        differ = sorted(key for key in set().union(*others) if any(p.get(key) != own.get(key) for p in others))
        told = ", ".join(f"{key} {own.get(key, 'default')}" for key in differ)
        labels.append(f"{name} ({told})" if told else name)
    return [label if labels.count(label) == 1 else f"{label} [{r.path.name}]" for label, r in zip(labels, runs)]


def _goal_radius(run: RunDirectory) -> float | None:
    """Returns the distance from the goal that counts as success, m; None if the rules have none."""
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
            f"its task {scene.name} differs from that of {trace.run.path}",
            "give the folder of the run's suite as suite=",
        )
