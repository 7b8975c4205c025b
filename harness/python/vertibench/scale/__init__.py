"""Many machines for one run or one sweep: by Ray, Slurm or Kubernetes (docs/scale.md).

Machines share a file system, on which shards write their results; between machines go command lines and exit codes alone.
"""

from __future__ import annotations

from ._shard import ShardEnd, run_shard
from ._work import ScaleError, Work

__all__ = ["ScaleError", "ShardEnd", "Work", "run_shard"]
