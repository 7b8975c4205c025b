"""`vertibench-ray`: the shards of a run or sweep as Ray tasks."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from .._errors import MissingPackageError
from . import _shard
from ._command import ended, parser, work_of
from ._shard import ShardEnd, failed, progress, run_shard
from ._work import ScaleError, Work


class _Again(Exception):
    """A shard has failed in a way that a retry can fix."""


def _drive(work: dict[str, object], index: int, jobs: int, scratch: Path | None) -> ShardEnd:
    end = run_shard(Work.from_json(work), index, jobs, scratch)
    if end.is_worth_another_try:
        raise _Again(f"shard {index} ended with code {end.code}: {end.said}")
    return end


def run(work: Work, cpus: int = 1, retries: int = 3, address: str | None = None, scratch: Path | None = None) -> int:
    """Runs all shards on a Ray cluster and joins them.

    A shard is retried if its worker is lost or its machine fails. Any other failure ends all shards, because it would
    occur in each.

    Args:
        work: The run or sweep.
        cpus: Processors per shard, also its number of parallel tasks; default 1.
        retries: Maximum number of retries per shard; default 3.
        address: Address of the cluster. None (default): `RAY_ADDRESS`, otherwise this machine.
        scratch: Folder on each machine's own disk to work in, see `run_shard`. None (default): `work.out`.

    Returns:
        Exit code of the step that joins the shards.

    Raises:
        ScaleError: If a shard has failed permanently.
        MissingPackageError: If Ray is not installed.
    """
    try:
        import ray
    except ImportError:
        raise MissingPackageError("ray", "vertibench-ray") from None
    own = not ray.is_initialized()
    if own:
        ray.init(address=address, log_to_driver=False)
    try:
        task = ray.remote(num_cpus=cpus, max_retries=retries, retry_exceptions=[_Again])(_drive)
        # Only a command line and an exit code pass over the network.
        waiting: dict[Any, int] = {
            task.remote(work.to_json(), k, cpus, scratch): k for k in range(1, work.shards + 1)
        }
        ends: list[ShardEnd] = []
        while waiting:
            [ref], _ = ray.wait(list(waiting), num_returns=1)
            end = _end_of(ray, ref, waiting.pop(ref))
            if not end.is_done:
                for other in waiting:
                    ray.cancel(other, force=True)
                raise failed(end)
            ends.append(end)
            print(progress(ends, work.shards), file=sys.stderr)
    finally:
        if own:
            ray.shutdown()
    return _shard.join(work)


def _end_of(ray: Any, ref: Any, index: int) -> ShardEnd:
    try:
        end: ShardEnd = ray.get(ref)
        return end
    except ray.exceptions.RayTaskError as e:
        if isinstance(e.cause, _Again):
            raise ScaleError(f"shard {index}", f"all attempts failed: {e.cause}", "the same command continues") from None
        raise
    except ray.exceptions.RayError as e:
        what = f"its worker was lost in all attempts: {str(e).splitlines()[0]}"
        raise ScaleError(f"shard {index}", what, "see the logs of Ray; the same command continues") from None


def main(arguments: list[str] | None = None) -> int:
    """Runs the command line.

    Args:
        arguments: Arguments after the program's name. None (default): those of the process.

    Returns:
        Exit code.
    """
    options = parser("vertibench-ray", "Drives the shards of a run or a sweep on a Ray cluster, and joins them.")
    options.add_argument("--address", help="address of the cluster (default: RAY_ADDRESS, otherwise this machine)")
    options.add_argument("--retries", type=int, default=3, help="maximum number of retries of a shard (default: 3)")
    own = options.parse_args(arguments)
    return ended(lambda: run(work_of(own), own.cpus, own.retries, own.address, own.scratch))


if __name__ == "__main__":
    sys.exit(main())
