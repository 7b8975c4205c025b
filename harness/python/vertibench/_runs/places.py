"""Suites and their tasks."""

from __future__ import annotations

import os
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from .. import _yaml
from .._errors import MissingError
from .._program import tasks_path
from ..datasets._world import World, read_world
from .errors import RunError
from .store import RunDirectory

_AGAIN = "restore the suite's folder"


@dataclass(frozen=True)
class Task:
    """Task in its world, in lengths of the scaled world."""

    name: str  #: e.g. `w001/t03`
    suite: str  #: name of the suite
    world: World
    start: tuple[float, float, float]  #: x, m; y, m; heading, rad
    goal: tuple[float, float]  #: x and y, m
    path: tuple[tuple[float, float], ...]  #: the global path: x and y of its points, m


def suite_folder(suite: str | PathLike[str]) -> Path:
    """Returns the folder of a suite, given as directory or shipped name. Raises `RunError` if there is none."""
    if Path(suite).is_dir():
        return Path(suite)
    try:
        tasks = tasks_path()
    except MissingError:
        tasks = None
    found = sorted(f.parent.name for f in tasks.glob("*/suite.yaml")) if tasks else []
    if tasks and str(suite) in found:
        return tasks / str(suite)
    known = f", or one of {', '.join(found)}" if found else ", or set VB_TASKS to the folder with the shipped suites"
    raise RunError(
        f"suite {os.fspath(suite)}", "not a folder or a shipped suite", f"give a folder{known}"
    )


def suite_of(run: RunDirectory, suite: str | PathLike[str] | None) -> Path:
    """Returns the folder of a run's suite: the given one, otherwise the recorded one, otherwise the shipped suite with its
    name.
    """
    if suite is not None:
        return suite_folder(suite)
    there = run.of("suite", "path")
    if there and (Path(there) / "suite.yaml").is_file():
        return Path(there)
    try:
        return suite_folder(str(run.of("suite", "name")))
    except RunError:
        raise RunError(
            f"suite {run.of('suite', 'name')}",
            f"{there}, its folder in {run.path}, is not a suite",
            "give the folder as suite=",
        ) from None


def read_task(folder: Path, task: str, scale: float = 1.0) -> Task:
    """Reads a task of a suite with its world. Raises `RunError` if there is no such task, or a file is damaged."""
    file = folder / "suite.yaml"
    try:
        index = _yaml.read(file)
        tasks = {f"{world['id']}/{name}" for world in index["worlds"] for name in world["tasks"]}
        if task not in tasks:
            raise RunError(folder, f"there is no task {task}", f"give one of its {len(tasks)} tasks, e.g. {min(tasks)}")
        world_id, name = task.split("/")
        place = folder / "worlds" / world_id
        file = place / "tasks.yaml"
        found = {own["id"]: own for own in _yaml.read(file)["tasks"]}[name]
        start = tuple(float(found["start"][k]) for k in ("x", "y", "yaw"))
        return Task(
            name=task,
            suite=str(index["name"]),
            world=read_world(place, scale, RunError, _AGAIN),
            start=(scale * start[0], scale * start[1], start[2]),
            goal=(scale * found["goal"][0], scale * found["goal"][1]),
            path=tuple((scale * x, scale * y) for x, y in found["path"]),
        )
    except OSError as e:
        raise RunError(file, f"cannot be read: {e.strerror}", "give the folder of a suite") from None
    except (KeyError, TypeError, ValueError, IndexError) as e:
        what = f"no field {e}" if isinstance(e, KeyError) else str(e)
        raise RunError(file, what, _AGAIN) from None
