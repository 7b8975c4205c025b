"""Options and exit codes that the commands for Ray, Slurm and Kubernetes share."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

from .. import _command
from ._work import Work


def parser(program: str, about: str) -> argparse.ArgumentParser:
    """Returns an argument parser with the shared options."""
    own = argparse.ArgumentParser(prog=program, description=about)
    own.add_argument("--shards", type=int, required=True, metavar="N", help="number of shards")
    own.add_argument("--out", type=Path, required=True, metavar="DIR", help="directory of the results, shared by all machines")
    own.add_argument("--cpus", type=int, default=1, metavar="N", help="processors per shard (default: 1)")
    own.add_argument("--scratch", type=Path, metavar="DIR", help="working directory on the local disk of each machine")
    own.add_argument("arguments", nargs="+", metavar="ARGUMENT", help="after --: arguments of `vb-harness run`, or `sweep FILE`")
    return own


def work_of(own: argparse.Namespace) -> Work:
    """Returns the work that the options describe."""
    return Work.of(own.arguments, own.out, own.shards)


def ended(do: Callable[[], int]) -> int:
    """Calls the function and returns its exit code; an error becomes one line and an exit code."""
    return _command.ended(do, "stopped; the same command continues")
