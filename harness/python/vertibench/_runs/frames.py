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
#: Measures that are whole numbers.
_WHOLE = {"samples", "total", "init", "p50_step", "p99_step", "max_step", "memory_bytes"}
#: Measures that are true or false.
_TRUTHS = {"landed", *_FLAGS}
#: What every row says of the run, and where run.json has it.
_OF_THE_RUN = {
    "planner": ("plugin", "name"),
    "planner_version": ("plugin", "version"),
    "suite": ("suite", "name"),
    "vehicle": ("vehicle", "name"),
    "perception": ("perception", "name"),
    "rules": ("rules", "name"),
}
#: The kinds of frames.
FRAMES = ("pandas", "polars", "arrow", "dict")


def results(run: Run | str | PathLike[str], frame: str = "pandas") -> Any:
    """The results of a run, a row for each finished task, in the order of the tasks' names.

    The columns are the fields of tasks.jsonl (docs/results.md, docs/scoring.md) under the names that
    `vb-harness report --csv` gives them, and then what was run:

    * `task`, `world`, `elevation`, `terrain`, `density`, `outcome`, `three_way`, `reason`, `cause` and `evidence` (what the
      vehicle was up against; missing where it neither rolled over nor got stuck), `fault` (missing without an error),
      `time_s` (simulated time at the end, s), `state_hash`, `sim_steps`, `planner_steps`, `clamped`;
    * the flags, which are true or false whatever the outcome: `tilted` (|roll| or |pitch| above 30° at any time, the rollover
      rule of the authors' scripts), `strict` (a success that ends upright on loaded wheels, without a shock above 2.5 g),
      `over_2_5_g`, `over_6_w`; missing where they aren't known;
    * the metrics, with units in their names: `roll_mean_deg`, `distance_m`, `speed_mean_m_per_s`, …; missing where a task
      ended before its first sample;
    * shock and ride at the driver's seat: `seat_peak_g`, `seat_rms_m_per_s2`, `absorbed_power_w`, `airborne_fraction`, …; missing
      where a task ended before its first step, or was scored again with another end;
    * the planner's fuel, `fuel_total`, `fuel_p99_step`, …, and `memory_bytes`; missing for native planners and commands;
    * `planner`, `planner_version`, `suite`, `vehicle`, `perception`, `rules`, `scale`, `seed`.

    `frame` says what is returned:

    * `pandas`: a `pandas.DataFrame`, whose `attrs["run"]` is run.json;
    * `polars`: a `polars.DataFrame`, which has no place for run.json (`vertibench.Run(run).header`);
    * `arrow`: a `pyarrow.Table`, whose metadata has run.json under `vertibench:run`;
    * `dict`: a list for each column by its name, with None for what is missing.

    Raises `RunError` if the run can't be read, `MissingPackageError` if the package isn't installed.
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
    """The table as a frame of a kind, with attributes where it has a place for them."""
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
    # Whole numbers stay whole where some are missing.
    made = table.to_pandas(integer_object_nulls=True)
    whole = [f.name for f in table.schema if pa.types.is_integer(f.type) and table[f.name].null_count]
    made = made.astype({name: "Int64" for name in whole})
    made.attrs.update(attrs)
    return made


class Trace(Mapping[str, np.ndarray]):
    """The trajectory of a task: an array of float64 for each column, shape (samples,).

    `time` (s); `x`, `y`, `z` (m, x east, y north, z up); `roll`, `pitch`, `yaw` (rad); `vx`, `vy`, `vz` (m/s) and `wx`,
    `wy`, `wz` (rad/s) in the vehicle's axes, x forward and y left; `steering`, `throttle`, `brake`, `gear`: the command up
    to this time; `speed_N` (rad/s) and `deflection_N` (m) of wheel N, front to back and left before right.
    """

    def __init__(self, run: Run, table: pa.Table, meta: dict[str, Any]):
        self._table = table
        self._columns = {name: table[name].to_numpy() for name in table.column_names}
        #: The run that it is of.
        self.run = run
        #: What the file says of its task: `start`, `goal`, `goal_z`, `half_extent` of the world, `scale`, `mode`, …
        self.meta = meta
        #: Name of the task.
        self.task: str = meta["task"]
        #: Where it starts: x and y, m; heading, rad.
        self.start: tuple[float, ...] = tuple(meta["start"])
        #: Where it should go: x and y, m.
        self.goal: tuple[float, ...] = tuple(meta["goal"])

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._columns:
            raise KeyError(f"no column {name} (there are {', '.join(self._columns)})")
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        """The number of columns."""
        return len(self._columns)

    def __repr__(self) -> str:
        times = self["time"]
        return f"<Trace {self.task} of {self.run.path}: {len(times)} samples, {times[-1] if len(times) else 0:.2f} s>"

    def frame(self, frame: str = "pandas") -> Any:
        """The same as a frame of a kind (see `vertibench.results`), a row for each sample, with `meta` as the attribute or
        metadata `trace`."""
        return as_frame(self._table, frame, {"trace": self.meta})


def trace(run: Run | str | PathLike[str], task: str, frame: str = "numpy") -> Trace | Any:
    """The recorded trajectory of a task such as `w001/t03`: ten samples a second, or all if the run has full traces.

    With `frame="numpy"` it is a `Trace`, arrays by the name of their column; `pandas`, `polars`, `arrow` and `dict` make
    frames with a row for each sample (see `vertibench.results`).

    Raises `RunError` if the run hasn't finished the task or kept no trajectories, or a file is damaged.
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
        # What everything else here counts on.
        for name in ("time", "x", "y", "z", "vx", "vy", "vz"):
            read[name]
    except (KeyError, ValueError, TypeError) as e:
        raise RunError(file, f"no trajectory: {e}", again) from None
    return read if frame == "numpy" else read.frame(frame)
