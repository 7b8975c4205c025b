"""A run and the operations on it."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

from .errors import VertibenchError
from .store import RunDirectory

if TYPE_CHECKING:
    from .frames import Trace
    from .show import Shown
    from .summary import Summary


class Run(RunDirectory):
    """Run directory: the results of one planner over tasks of one suite.

    A run in progress is read up to its last finished task. `run.json`, records and trajectories are verified with
    `checksums.txt`, if there is one, when they are read.

    Example:
        >>> run = Run("runs/pid-1")
        >>> run.record("w001/t03")["outcome"]

    Args:
        directory: The run directory.

    Attributes:
        path: The run directory.
        header: Content of `run.json`: all that determines the results.

    Raises:
        RunError: If there is no run, its version is unsupported, or `run.json` is damaged.
    """

    def results(self, frame: str = "pandas") -> Any:
        """Returns `vertibench.results(self, frame)`: the results as a data frame."""
        from .frames import results

        return results(self, frame)

    def summary(self) -> Summary:
        """Returns `vertibench.summary(self)`: the figures over all tasks."""
        from .summary import summary

        return summary(self)

    def trace(self, task: str, frame: str = "numpy") -> Trace | Any:
        """Returns `vertibench.trace(self, task, frame)`: the trajectory of a task."""
        from .frames import trace

        return trace(self, task, frame)

    def show(self, task: str | None = None, **options: Any) -> Shown:
        """Returns `vertibench.show(self, task, **options)`: map, trajectory and replay of a task."""
        return show(self, task, **options)


def results(run: Run | str | PathLike[str], frame: str = "pandas") -> Any:
    """Returns the results of a run as a data frame with one row per finished task, in the order of the task names.

    The columns are the fields of `tasks.jsonl` (docs/results.md, docs/scoring.md), with the names of `vb-harness report
    --csv`, and the conditions of the run:

    - Task and outcome: `task`, `world`, `elevation`, `terrain`, `density`, `outcome`, `three_way`, `reason`; `cause`
      and `evidence` of a rollover or stuck end; `fault`, the code of an error; `time_s`, simulated time at the end, s;
      `state_hash`, `sim_steps`, `planner_steps`, `clamped`.
    - Flags, independent of the outcome: `tilted` (|roll| or |pitch| above 30° at any time, the rollover rule of the
      authors' scripts), `strict` (a success that ends upright on loaded wheels, without a shock above 2.5 g),
      `over_2_5_g`, `over_6_w`.
    - Metrics, with units in their names: `roll_mean_deg`, `distance_m`, `speed_mean_m_per_s`, ... Missing if the task
      ended before its first sample.
    - Shock and ride at the driver's seat: `seat_peak_g`, `seat_rms_m_per_s2`, `absorbed_power_w`, `airborne_fraction`,
      ... Missing if the task ended before its first step, or re-scoring changed its end.
    - Computation of the planner: `fuel_total`, `fuel_p99_step`, ..., `memory_bytes`. Missing for native planners and
      commands.
    - Conditions: `planner`, `planner_version`, `suite`, `vehicle`, `perception`, `rules`, `scale`, `seed`.

    Args:
        run: Run, or its directory.
        frame: Type of the result. `"pandas"` (default): `pandas.DataFrame` with `run.json` in `attrs["run"]`.
            `"polars"`: `polars.DataFrame`, without `run.json` (use `Run.header`). `"arrow"`: `pyarrow.Table` with
            `run.json` in the metadata entry `vertibench:run`, and a `description` in the metadata of each measure.
            `"dict"`: a list per column, with None for missing values.

    Returns:
        The data frame.

    Raises:
        RunError: If the run can't be read.
        VertibenchError: If there is no such type.
        MissingPackageError: If the package for this type is not installed.
    """
    return _opened(run).results(frame)


def summary(run: Run | str | PathLike[str]) -> Summary:
    """Reads the summary of a finished run: figures over all tasks, and by elevation, terrain, obstacle density and world.

    Args:
        run: Run, or its directory.

    Returns:
        The summary.

    Raises:
        RunError: If the run can't be read or has no summary, because it is in progress or was killed.
    """
    return _opened(run).summary()


def trace(run: Run | str | PathLike[str], task: str, frame: str = "numpy") -> Trace | Any:
    """Reads the recorded trajectory of a task.

    It has ten samples per second, or one every 10 ms if the run was made with `trace="full"`.

    Args:
        run: Run, or its directory.
        task: Task name, e.g. `"w001/t03"`.
        frame: Type of the result: `"numpy"` (default) for a `Trace`, or a type of data frame as in
            `vertibench.results`, with one row per sample.

    Returns:
        The trajectory.

    Raises:
        RunError: If the run hasn't finished the task or stored no trajectories, or a file is damaged.
        VertibenchError: If there is no such type.
        MissingPackageError: If the package for this type is not installed.
    """
    return _opened(run).trace(task, frame)


def show(
    run: Run | str | PathLike[str] | Sequence[Run | str | PathLike[str]],
    task: str | None = None,
    *,
    replay: bool = True,
    suite: str | PathLike[str] | None = None,
    height: int | None = None,
) -> Shown:
    """Displays a task of one or more runs: a map with global path, start, goal and trajectory, and the replay in 3D below
    it.

    The trajectory of a single run is coloured by speed. Several runs have one colour each, and the replay follows the
    first.

    Args:
        run: Run or its directory, or a list of runs of the same suite and scale.
        task: Task name, e.g. `"w012/t03"`. None (default): the only finished task of the first run.
        replay: Whether to include the replay, about 1 MB; default True.
        suite: Folder of the suite. None (default): the folder recorded in the run, otherwise the shipped suite with its
            name.
        height: Height of the replay in a notebook, pixels. None (default): 520.

    Returns:
        The picture, which a notebook displays; `save()` writes it to a file.

    Raises:
        RunError: If a run can't be read, hasn't finished the task or stored no trajectories; if `task` is None and the
            run has several finished tasks; or if the runs differ in suite or scale.
        ProgramError: If `vb-harness replay` can't make the replay.
        VertibenchError: If the list of runs is empty.

    Example:
        >>> vertibench.show([run, "runs/pid-1"], "w003/t00").save("page.html")
    """
    from .show import show_runs

    given: Sequence[Any] = run if isinstance(run, (list, tuple)) else [run]
    if not given:
        raise VertibenchError("show", "no run is given", "give one, or a list of some")
    return show_runs([_opened(r) for r in given], task, replay, suite, height)


def _opened(run: Run | str | PathLike[str]) -> Run:
    """Returns the run, opened if it is a directory."""
    return run if isinstance(run, Run) else Run(run)
