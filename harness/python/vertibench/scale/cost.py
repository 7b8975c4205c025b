"""`python -m vertibench.scale.cost`: what a sweep costs on so many cores, and what limits it (docs/scale.md has the model)."""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import dataclass

from .._command import above_zero, whole_number

# What docs/scale.md has measured.

#: Beginning a run, or a shard's part of one: loading the planner's compiled code, checking the worlds by their hash; s.
START = 0.2
#: What a file system has to do for it: files opened, renamed, synced; operations.
BEGUN = 50.0
#: What it has to do for each task, with and without a trace.
OPERATIONS = {True: 14.0, False: 7.0}
#: The same where results are copied when they are whole (`--scratch`): for each folder, and for each task.
BEGUN_COPIED, COPIED = 30.0, {True: 3.0, False: 0.0}
#: Bytes of a task's results, with and without a trace of 10 samples a second.
BYTES = {True: 57_600.0, False: 1_300.0}
#: Tasks that one process joins in a second.
JOINED = {True: 1_800.0, False: 15_000.0}


@dataclass(frozen=True)
class Cost:
    """What a sweep costs; times in seconds."""

    #: Of all cores together.
    core_seconds: float
    #: Until the last shard ends, if nothing but the cores limits it.
    driving: float
    #: Until the last file is written, if nothing but the file system limits it.
    writing: float
    #: Putting the shards together, by one process.
    joining: float
    #: Results, bytes.
    size: float

    @property
    def wall(self) -> float:
        """From the first shard to the joined result."""
        return max(self.driving, self.writing) + self.joining

    @property
    def limit(self) -> str:
        """What takes the most time."""
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
    """The cost of so many runs of so many tasks in so many worlds, where a task takes so many seconds of a core.

    Shards get whole worlds, dealt out over all runs one after the other, and the largest shard decides when all are done. A shard has a
    folder for each run that it has a part of. `operations` are those that the file system does in a second; with `scratch`, it sees
    results once, when they are whole.
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
    """Does what the command line says; gives the exit code."""
    options = argparse.ArgumentParser(prog="python -m vertibench.scale.cost", description="What a sweep costs on so many cores.")
    options.add_argument("--runs", type=above_zero, required=True, help="planners × parameters × vehicles × profiles × seeds")
    options.add_argument("--tasks", type=above_zero, default=1000, help="tasks of each run (default: 1000)")
    options.add_argument("--worlds", type=above_zero, default=100, help="worlds of each run (default: 100)")
    tells = "what a task takes of one core, s: `vb-harness run --jobs 1` tells"
    options.add_argument("--seconds", type=above_zero, required=True, help=tells)
    options.add_argument("--cores", type=whole_number, required=True)
    options.add_argument("--shards", type=whole_number, help="default: as many as cores")
    options.add_argument("--no-traces", action="store_true", help="with `trace: none`")
    options.add_argument("--scratch", action="store_true", help="shards write to a disk of their machine first")
    options.add_argument("--operations", type=above_zero, default=5000, help="operations a second of the file system (default: 5000)")
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
