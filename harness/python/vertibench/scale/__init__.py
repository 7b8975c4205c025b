"""Runs and sweeps on many machines, with Ray, Slurm or Kubernetes (docs/scale.md).

A run or sweep is split into shards. Machines need a shared file system for the results; only command lines and exit
codes pass between them.

>>> from pathlib import Path
>>> from vertibench.scale import Work, run_shard
>>> work = Work.of(["--plugin", "pid.wasm", "--suite", "smoke"], Path("/shared/big"), shards=8)
>>> run_shard(work, 1)               # the first shard, on this machine

The commands `vertibench-ray`, `vertibench-slurm` and `vertibench-kubernetes` run all shards and join them.
"""

from __future__ import annotations

from ._shard import ShardEnd, run_shard
from ._work import ScaleError, Work

__all__ = ["ScaleError", "ShardEnd", "Work", "run_shard"]
