"""Results and trajectories of a run as tables."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from os import PathLike
from typing import Any

import numpy as np
from .errors import MissingPackageError, RunError, VertibenchError
from .store import Run, opened

try:
    import pyarrow as pa
    import pyarrow.parquet as pq
except ImportError:
    raise MissingPackageError("pyarrow", "results and trajectories as frames") from None

_TEXTS = "task world elevation terrain density outcome three_way reason cause evidence fault".split()
_COUNTS = ("sim_steps", "planner_steps", "clamped")
_FLAGS = ("tilted", "strict", "over_2_5_g", "over_6_w")
_METRICS = (
    "samples roll_mean_deg roll_variance_deg2 roll_max_deg roll_end_deg pitch_mean_deg pitch_variance_deg2 pitch_max_deg "
    "distance_m speed_mean_m_per_s speed_max_m_per_s throttle_effort_s brake_effort_s steering_effort_s steering_rate_per_s "
    "reverse_s goal_distance_min_m goal_distance_end_m end_x_m end_y_m"
).split()
_RIDE = (
    "seat_peak_g seat_peak_z_g seat_rms_m_per_s2 seat_rms_z_m_per_s2 absorbed_power_w airborne_fraction landed energy_surplus_j "
    "held_fraction"
).split()
_FUEL = "total init p50_step p99_step max_step init_share p99_share max_share memory_bytes".split()
#: Measures with whole numbers.
_WHOLE = {"samples", "total", "init", "p50_step", "p99_step", "max_step", "memory_bytes"}
#: Boolean measures.
_TRUTHS = {"landed", *_FLAGS}
#: Columns with conditions of the run, and their fields in run.json.
_OF_THE_RUN = {
    "planner": ("plugin", "name"),
    "planner_version": ("plugin", "version"),
    "suite": ("suite", "name"),
    "vehicle": ("vehicle", "name"),
    "perception": ("perception", "name"),
    "rules": ("rules", "name"),
}
#: Types of data frames.
FRAMES = ("pandas", "polars", "arrow", "dict")


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
            `run.json` in the metadata entry `vertibench:run`. `"dict"`: a list per column, with None for missing
            values.

    Returns:
        The data frame.

    Raises:
        RunError: If the run can't be read.
        VertibenchError: If there is no such type.
        MissingPackageError: If the package for this type is not installed.
    """
    run = opened(run)
    return as_frame(_results(run), frame, {"run": run.header})


def _results(run: Run) -> pa.Table:
    records = run.records()

    def column(of: str | None, name: str, kind: pa.DataType) -> pa.Array:
        parts = records if of is None else [r.get(of) or {} for r in records]
        try:
            return pa.array([part.get(name) for part in parts], kind)
        except (pa.ArrowInvalid, pa.ArrowTypeError, AttributeError):
            raise RunError(
                run.path / "tasks.jsonl", f"{name} is of a wrong type in some record", "restore the file"
            ) from None

    columns = {name: column(None, name, pa.string()) for name in _TEXTS}
    columns["time_s"] = column(None, "time_s", pa.float64())
    columns["state_hash"] = column(None, "state_hash", pa.string())
    columns |= {name: column(None, name, pa.int64()) for name in _COUNTS}
    for of, names in (("flags", _FLAGS), ("metrics", _METRICS), ("ride", _RIDE), ("fuel", _FUEL)):
        for name in names:
            shown = f"fuel_{name}" if of == "fuel" and name != "memory_bytes" else name
            kind = pa.bool_() if name in _TRUTHS else pa.int64() if name in _WHOLE else pa.float64()
            columns[shown] = column(of, name, kind)
    n = len(records)
    for name, way in _OF_THE_RUN.items():
        columns[name] = pa.array([run.of(*way)] * n, pa.string())
    columns["scale"] = pa.array([run.of("scale")] * n, pa.float64())
    columns["seed"] = pa.array([run.of("seed")] * n, pa.uint64())
    return pa.table(columns)


def as_frame(table: pa.Table, frame: str, attrs: dict[str, Any]) -> Any:
    """Converts a table to a type of data frame, with attributes where the type has a place for them."""
    if frame == "arrow":
        return table.replace_schema_metadata({f"vertibench:{k}": json.dumps(v) for k, v in attrs.items()})
    if frame == "dict":
        return table.to_pydict()
    if frame == "polars":
        try:
            import polars
        except ImportError:
            raise MissingPackageError("polars", "frame='polars'") from None
        return polars.from_arrow(table)
    if frame != "pandas":
        raise VertibenchError(f"frame={frame!r}", "there is no such kind of frame", f"give one of {', '.join(FRAMES)}")
    try:
        import pandas  # noqa: F401 - pyarrow needs it, and says less clearly that it isn't there
    except ImportError:
        raise MissingPackageError(
            "pandas", "frame='pandas', the default; frame='arrow' and frame='dict' need nothing more"
        ) from None
    # Columns of whole numbers keep their type if values are missing.
    made = table.to_pandas(integer_object_nulls=True)
    whole = [f.name for f in table.schema if pa.types.is_integer(f.type) and table[f.name].null_count]
    made = made.astype({name: "Int64" for name in whole})
    made.attrs.update(attrs)
    return made


class Trace(Mapping[str, np.ndarray]):
    """Trajectory of a task: a mapping from column name to a float64 array of shape (samples,).

    World axes are x east, y north, z up; body axes are x forward, y left, z up. Columns:

    - `time`: simulated time, s
    - `x`, `y`, `z`: position of the vehicle's reference point, m
    - `roll`, `pitch`, `yaw`: attitude, rad; roll is positive with the right side down, pitch with the nose down
    - `vx`, `vy`, `vz`: velocity in body axes, m/s
    - `wx`, `wy`, `wz`: angular velocity in body axes, rad/s
    - `steering`, `throttle`, `brake`: command up to this time, after clamping
    - `gear`: gear of this command: 0 forward, 1 neutral, 2 reverse; missing in older traces
    - `speed_N`, `deflection_N`: spin, rad/s, and suspension travel, m, positive in compression, of wheel N; front to
      back, left before right

    `vertibench.trace` and `Run.trace` return traces.

    Attributes:
        run: Run of the trajectory.
        meta: Metadata of the file: `start`, `goal`, `goal_z`, `half_extent` of the world, `scale`, `mode`, ...
        task: Task name.
        start: Start of the task: x and y, m; heading, rad.
        goal: Goal of the task: x and y, m.
    """

    def __init__(self, run: Run, table: pa.Table, meta: dict[str, Any]):
        self._table = table
        self._columns = {name: table[name].to_numpy() for name in table.column_names}
        self.run = run
        self.meta = meta
        self.task: str = meta["task"]
        self.start: tuple[float, ...] = tuple(meta["start"])
        self.goal: tuple[float, ...] = tuple(meta["goal"])

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._columns:
            raise KeyError(f"no column {name} (there are {', '.join(self._columns)})")
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        """Returns the number of columns."""
        return len(self._columns)

    def __repr__(self) -> str:
        times = self["time"]
        return f"<Trace {self.task} of {self.run.path}: {len(times)} samples, {times[-1] if len(times) else 0:.2f} s>"

    def frame(self, frame: str = "pandas") -> Any:
        """Returns the trajectory as a data frame with one row per sample.

        Args:
            frame: Type of the result, as in `vertibench.results`: `"pandas"` (default), `"polars"`, `"arrow"` or
                `"dict"`.

        Returns:
            The data frame. `meta` is its attribute or metadata `trace` where the type has one.

        Raises:
            VertibenchError: If there is no such type.
            MissingPackageError: If the package for this type is not installed.
        """
        return as_frame(self._table, frame, {"trace": self.meta})


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
    run = opened(run)
    file = run.trace_file(task)
    again = "restore it, or run the task again"
    try:
        table = pq.read_table(file)
    except (pa.ArrowException, OSError) as e:
        raise RunError(file, f"no Parquet file: {e}", again) from None
    try:
        meta = json.loads((table.schema.metadata or {})[b"vertibench:trace"])
        read = Trace(run, table.replace_schema_metadata(None), meta)
        # Columns that other functions of the package need.
        for name in ("time", "x", "y", "z", "vx", "vy", "vz"):
            read[name]
    except (KeyError, ValueError, TypeError) as e:
        raise RunError(file, f"no trajectory: {e}", again) from None
    return read if frame == "numpy" else read.frame(frame)
