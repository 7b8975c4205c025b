"""Results and trajectories of a run as tables."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from .._errors import missing_module
from .errors import MissingPackageError, RunError, VertibenchError
from .store import RunDirectory

try:
    import pyarrow as pa
    import pyarrow.parquet as pq
except ImportError:
    raise MissingPackageError("pyarrow", "results and trajectories as frames") from None

_TEXTS = "task world elevation terrain density outcome three_way reason cause evidence fault".split()
_COUNTS = ("sim_steps", "planner_steps", "clamped")
#: Arrow types of measures.
_KINDS = {"count": pa.int64(), "number": pa.float64(), "flag": pa.bool_()}
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


def results(run: RunDirectory, frame: str) -> Any:
    """Returns the results of a run; see `vertibench.results`."""
    return as_frame(_results(run), frame, {"run": run.header})


def _results(run: RunDirectory) -> pa.Table:
    records = run.records()

    def column(of: str | None, name: str, kind: pa.DataType) -> pa.Array:
        parts = records if of is None else [r.get(of) or {} for r in records]
        try:
            return pa.array([part.get(name) for part in parts], kind)
        except (pa.ArrowInvalid, pa.ArrowTypeError, AttributeError):
            raise RunError(
                run.path / "tasks.jsonl", f"{name} has the wrong type in a record", "restore the file"
            ) from None

    columns = {name: column(None, name, pa.string()) for name in _TEXTS}
    columns["time_s"] = column(None, "time_s", pa.float64())
    columns["state_hash"] = column(None, "state_hash", pa.string())
    columns |= {name: column(None, name, pa.int64()) for name in _COUNTS}
    descriptions = {}
    for group, name, kind, description in _measures():
        shown = f"fuel_{name}" if group == "fuel" and name != "memory_bytes" else name
        columns[shown] = column(group, name, _KINDS[kind])
        descriptions[shown] = {"description": description}
    n = len(records)
    for name, field in _OF_THE_RUN.items():
        columns[name] = pa.array([run.of(*field)] * n, pa.string())
    columns["scale"] = pa.array([run.of("scale")] * n, pa.float64())
    columns["seed"] = pa.array([run.of("seed")] * n, pa.uint64())
    fields = [pa.field(name, values.type, metadata=descriptions.get(name)) for name, values in columns.items()]
    return pa.table(list(columns.values()), schema=pa.schema(fields))


def _measures() -> list[tuple[str, str, str, str]]:
    """Returns the measures of records, as (group, name, type, description); the harness defines them."""
    try:
        from .._native import measures
    except ImportError as e:
        raise missing_module("vertibench.results", e) from None
    return measures()


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
        raise VertibenchError(f"frame={frame!r}", "unknown type of frame", f"give one of {', '.join(FRAMES)}")
    try:
        import pandas  # noqa: F401 - pyarrow needs it, and says less clearly that it isn't there
    except ImportError:
        raise MissingPackageError(
            "pandas", "frame='pandas', the default; frame='arrow' and frame='dict' need no other package"
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

    def __init__(self, run: RunDirectory, table: pa.Table, meta: dict[str, Any]):
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


def trace(run: RunDirectory, task: str, frame: str) -> Trace | Any:
    """Reads the recorded trajectory of a task; see `vertibench.trace`."""
    file = run.trace_file(task)
    again = "restore it, or run the task again"
    try:
        table = pq.read_table(file)
    except (pa.ArrowException, OSError) as e:
        raise RunError(file, f"not a Parquet file: {e}", again) from None
    try:
        meta = json.loads((table.schema.metadata or {})[b"vertibench:trace"])
        read = Trace(run, table.replace_schema_metadata(None), meta)
        # Columns that other functions of the package need.
        for name in ("time", "x", "y", "z", "vx", "vy", "vz"):
            read[name]
    except (KeyError, ValueError, TypeError) as e:
        raise RunError(file, f"not a trajectory: {e}", again) from None
    return read if frame == "numpy" else read.frame(frame)
