"""`python -m vertibench.scale.cost`: what a sweep costs on so many cores, and what limits it (docs/scale.md has the model)."""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass

#: Starting a shard: loading the planner's compiled code, checking the worlds by their hash; s.
START = 0.3
#: What a file system of a cluster has to do for a task, with and without a trace: opening, creating, renaming, syncing; operations.
OPERATIONS = {True: 14.0, False: 8.0}
#: Bytes of a task's results, with and without a trace of 10 samples a second.
BYTES = {True: 57_500.0, False: 1_300.0}
#: Tasks that one process joins in a second.
JOINED = {True: 2_500.0, False: 13_000.0}


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


def cost(tasks: float, seconds: float, cores: int, shards: int, worlds: float, traces: bool, operations: float, scratch: bool) -> Cost:
    """The cost of so many tasks, each of which takes so many seconds of a core.

    Shards get whole worlds (`worlds` of all runs together), and the largest decides when all are done. `operations` are those that the
    file system does in a second; with `scratch`, it sees a task's files once, not the writing of them.
    """
    if not (tasks > 0 and seconds > 0 and cores > 0 and shards > 0 and worlds > 0 and operations > 0):
        raise ValueError("all numbers must be above 0")
    largest = -(-worlds // shards) / worlds * tasks
    rounds = -(-shards // cores)
    driving = rounds * (START + largest * seconds)
    each = (2.0 if traces else 0.1) if scratch else OPERATIONS[traces]
    return Cost(
        core_seconds=tasks * seconds + shards * START,
        driving=driving,
        writing=tasks * each / operations,
        joining=tasks / JOINED[traces],
        size=tasks * BYTES[traces],
    )


def main(arguments: list[str] | None = None) -> int:
    """Does what the command line says; gives the exit code."""
    options = argparse.ArgumentParser(prog="python -m vertibench.scale.cost", description="What a sweep costs on so many cores.")
    options.add_argument("--runs", type=float, required=True, help="planners × parameters × vehicles × profiles × seeds")
    options.add_argument("--tasks", type=float, default=1000, help="tasks of each run (default: 1000)")
    options.add_argument("--worlds", type=float, default=100, help="worlds of each run (default: 100)")
    options.add_argument("--seconds", type=float, required=True, help="what a task takes of one core, s: `vb-harness run --jobs 1` tells")
    options.add_argument("--cores", type=int, required=True)
    options.add_argument("--shards", type=int, help="default: as many as cores")
    options.add_argument("--no-traces", action="store_true", help="with `trace: none`")
    options.add_argument("--scratch", action="store_true", help="shards write to a disk of their machine first")
    options.add_argument("--operations", type=float, default=5000, help="operations a second of the file system (default: 5000)")
    own = options.parse_args(arguments)
    tasks, worlds, shards = own.runs * own.tasks, own.runs * own.worlds, own.shards or own.cores
    try:
        found = cost(tasks, own.seconds, own.cores, shards, worlds, not own.no_traces, own.operations, own.scratch)
    except ValueError as e:
        print(f"error: the options: {e} (give others)", file=sys.stderr)
        return 2
    rows = [
        ("tasks", f"{tasks:,.0f}"),
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
