"""`python -m vertibench.scale.cost`: estimated cost of a sweep, and its bottleneck (docs/scale.md describes the model)."""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import dataclass

from .._command import above_zero, whole_number

# Measurements of docs/performance.md.

#: Start of a run or of a shard's part of one: loading the compiled planner, verifying the hashes of the worlds; s.
START = 0.2
#: File operations (open, rename, sync) per start.
BEGUN = 50.0
#: File operations per task, with and without a trace.
OPERATIONS = {True: 14.0, False: 7.0}
#: File operations to copy complete results (`--scratch`): per folder, and per task with and without a trace.
BEGUN_COPIED, COPIED = 30.0, {True: 3.0, False: 0.0}
#: Size of a task's results, bytes, with and without a trace of 10 samples per second.
BYTES = {True: 57_600.0, False: 1_300.0}
#: Tasks that one process joins per second, with and without traces.
JOINED = {True: 1_800.0, False: 15_000.0}


@dataclass(frozen=True)
class Cost:
    """Estimated cost of a sweep.

    Attributes:
        core_seconds: Computing time summed over all cores, s.
        driving: Time until the last shard ends, s, if only the cores limit it.
        writing: Time to write all files, s, if only the file system limits it.
        joining: Time to join the shards with one process, s.
        size: Size of the results, bytes.
    """

    core_seconds: float
    driving: float
    writing: float
    joining: float
    size: float

    @property
    def wall(self) -> float:
        """Time from the start of the first shard to the joined result, s."""
        return max(self.driving, self.writing) + self.joining

    @property
    def limit(self) -> str:
        """Bottleneck with the longest time: `the cores`, `the file system` or `joining`."""
        times = {"the cores": self.driving, "the file system": self.writing, "joining": self.joining}
        return max(times, key=lambda name: times[name])


def cost(
    runs: float,
    tasks: float,
    worlds: float,
    seconds: float,
    cores: int,
    shards: int,
    traces: bool = True,
    operations: float = 5000.0,
    scratch: bool = False,
) -> Cost:
    """Estimates the cost of a sweep.

    Whole worlds are distributed over the shards, consecutively over all runs; the largest shard determines the end. A
    shard has a folder per run of which it has a part.

    Args:
        runs: Number of runs, above 0.
        tasks: Tasks per run, above 0.
        worlds: Worlds per run, above 0.
        seconds: Computing time of a task on one core, s, above 0.
        cores: Number of cores, at least 1.
        shards: Number of shards, at least 1.
        traces: Whether trajectories are stored (10 Hz); default True.
        operations: Operations per second of the file system, above 0; default 5000.
        scratch: Whether shards write to a local disk first, so that the file system only receives complete results;
            default False.

    Returns:
        The estimate.

    Raises:
        ValueError: If a number is not finite or not above 0.
    """
    if not all(0 < number < math.inf for number in (runs, tasks, worlds, seconds, cores, shards, operations)):
        raise ValueError("all numbers must be above 0")
    folders = min(runs * worlds, runs * shards)
    largest = -(-runs * worlds // shards)
    driving = -(-shards // cores) * (min(largest, runs) * START + largest * tasks / worlds * seconds)
    begun, each = (BEGUN_COPIED, COPIED[traces]) if scratch else (BEGUN, OPERATIONS[traces])
    return Cost(
        core_seconds=runs * tasks * seconds + folders * START,
        driving=driving,
        writing=(folders * begun + runs * tasks * each) / operations,
        joining=runs * tasks / JOINED[traces],
        size=runs * tasks * BYTES[traces],
    )


def main(arguments: list[str] | None = None) -> int:
    """Runs the command line.

    Args:
        arguments: Arguments after the program's name. None (default): those of the process.

    Returns:
        Exit code.
    """
    options = argparse.ArgumentParser(prog="python -m vertibench.scale.cost", description="Estimates the cost of a sweep.")
    options.add_argument("--runs", type=above_zero, required=True, help="planners × parameters × vehicles × profiles × seeds")
    options.add_argument("--tasks", type=above_zero, default=1000, help="tasks of each run (default: 1000)")
    options.add_argument("--worlds", type=above_zero, default=100, help="worlds of each run (default: 100)")
    tells = "what a task takes of one core, s: `vb-harness run --jobs 1` tells"
    options.add_argument("--seconds", type=above_zero, required=True, help=tells)
    options.add_argument("--cores", type=whole_number, required=True)
    options.add_argument("--shards", type=whole_number, help="default: as many as cores")
    options.add_argument("--no-traces", action="store_true", help="with `trace: none`")
    options.add_argument("--scratch", action="store_true", help="shards write to a local disk first")
    options.add_argument("--operations", type=above_zero, default=5000, help="file system operations per second (default: 5000)")
    own = options.parse_args(arguments)
    shards, traces = own.shards or own.cores, not own.no_traces
    found = cost(own.runs, own.tasks, own.worlds, own.seconds, own.cores, shards, traces, own.operations, own.scratch)
    rows = [
        ("tasks", f"{own.runs * own.tasks:,.0f}"),
        ("hours of cores", f"{found.core_seconds / 3600:,.1f}"),
        ("driving", _time(found.driving)),
        ("writing", _time(found.writing)),
        ("joining", _time(found.joining)),
        ("in all", _time(found.wall)),
        ("most of it is", found.limit),
        ("results", f"{found.size / 1e9:,.1f} GB"),
    ]
    for name, value in rows:
        print(f"{name:>15}  {value}")
    return 0


def _time(seconds: float) -> str:
    minutes = seconds / 60.0
    return f"{minutes / 60.0:,.1f} h" if minutes > 120 else f"{minutes:,.1f} min"


if __name__ == "__main__":
    sys.exit(main())
