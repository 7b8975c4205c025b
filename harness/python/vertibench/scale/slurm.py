"""`vertibench-slurm`: the shards of a run or sweep as a Slurm job array, submitted with submitit."""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

from .._errors import MissingPackageError, VertibenchError
from . import _shard
from ._command import ended, parser, work_of
from ._shard import ShardEnd, failed, progress, run_shard
from ._work import ScaleError, Work

#: File in the directory of results that describes the submitted array.
SUBMITTED = "slurm.json"
#: Interval between queries of the jobs' state, s.
_LOOK = 5.0


class Shard:
    """Job of a shard, which submitit pickles and calls on a machine of the cluster."""

    def __init__(self, work: Work, index: int, cpus: int, scratch: Path | None) -> None:
        self.work, self.index, self.cpus, self.scratch = work, index, cpus, scratch

    def __call__(self) -> ShardEnd:
        """Runs the shard, with up to two retries on the same machine if a retry can succeed."""
        end = run_shard(self.work, self.index, self.cpus, self.scratch)
        for _ in range(2):
            if not end.is_worth_another_try:
                break
            end = run_shard(self.work, self.index, self.cpus, self.scratch)
        return end

    def checkpoint(self) -> Any:
        """Returns the job to submit after a time-out or preemption: the same shard, which then resumes."""
        return _submitit().helpers.DelayedSubmission(self)


def submit(
    work: Work, cpus: int, minutes: int, parameters: dict[str, str], at_a_time: int, scratch: Path | None = None
) -> list[str]:
    """Submits the shards as a job array.

    Args:
        work: The run or sweep.
        cpus: Processors per job, also its number of parallel tasks.
        minutes: Time limit per job, min; a shard that needs more is continued in another job.
        parameters: Further parameters of sbatch by name, such as `{"partition": "cpu"}`.
        at_a_time: Maximum number of parallel jobs.
        scratch: Folder on each machine's own disk to work in, see `run_shard`. None (default): `work.out`.

    Returns:
        Ids of the jobs, in the order of the shards.

    Raises:
        ScaleError: If an array was already submitted for `work.out`.
        MissingPackageError: If submitit is not installed.
    """
    submitit = _submitit()
    if (work.out / SUBMITTED).exists():
        raise ScaleError(work.out, "an array has been submitted for it", "collect it, or give another --out")
    folder = work.out / "slurm"
    folder.mkdir(parents=True, exist_ok=True)
    executor = submitit.AutoExecutor(folder=folder, cluster="slurm")
    executor.update_parameters(name="vertibench", cpus_per_task=cpus, timeout_min=minutes)
    executor.update_parameters(slurm_array_parallelism=at_a_time, **{f"slurm_{k}": v for k, v in parameters.items()})
    shards = [Shard(work, k, cpus, scratch) for k in range(1, work.shards + 1)]
    jobs = executor.submit_array(shards)
    names = [job.job_id for job in jobs]
    (work.out / SUBMITTED).write_text(json.dumps({"work": work.to_json(), "jobs": names}, indent=1) + "\n", encoding="utf-8")
    return names


def collect(out: Path) -> int:
    """Waits for the jobs of an array and joins their results.

    Args:
        out: Directory for the results, as given to `submit`.

    Returns:
        Exit code of the step that joins the shards.

    Raises:
        ScaleError: If no array was submitted for this directory, or a shard has failed permanently.
        MissingPackageError: If submitit is not installed.
    """
    submitit = _submitit()
    try:
        submitted = json.loads((out / SUBMITTED).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ScaleError(out, "no array has been submitted for it", "give the --out of submit") from None
    work = Work.from_json(submitted["work"])
    waiting = {k: submitit.SlurmJob(folder=out.absolute() / "slurm", job_id=name) for k, name in enumerate(submitted["jobs"], 1)}
    ends: list[ShardEnd] = []
    while waiting:
        for index, job in list(waiting.items()):
            if job.done():
                del waiting[index]
                ends.append(_end_of(index, job))
                print(progress(ends, work.shards), file=sys.stderr)
        if waiting:
            time.sleep(_LOOK)
    return _shard.join(work)


def _end_of(index: int, job: Any) -> ShardEnd:
    try:
        end: ShardEnd = job.result()
    except VertibenchError:
        raise
    except Exception as e:  # Any error of submitit or of the job.
        said = [line.strip() for line in str(e).splitlines() if line.strip()] or [type(e).__name__]
        what = f"job {job.job_id} ended as {job.state}: {said[-1]}"
        to_do = f"see {job.paths.stderr}; remove {SUBMITTED} and submit again, which continues the work"
        raise ScaleError(f"shard {index}", what, to_do) from None
    if not end.is_done:
        raise failed(end)
    return end


def _submitit() -> Any:
    try:
        import submitit
    except ImportError:
        raise MissingPackageError("submitit", "vertibench-slurm") from None
    return submitit


def main(arguments: list[str] | None = None) -> int:
    """Runs the command line.

    Args:
        arguments: Arguments after the program's name. None (default): those of the process.

    Returns:
        Exit code.
    """
    program = "vertibench-slurm"
    options = argparse.ArgumentParser(prog=program, description="Runs the shards of a run or a sweep as a Slurm job array.")
    commands = options.add_subparsers(required=True, metavar="COMMAND")
    about = "Submits the array."
    begin = commands.add_parser("submit", help=about, description=about, parents=[parser(program, about)], add_help=False)
    begin.add_argument("--minutes", type=int, default=60, help="time limit of a job; longer work continues in another job (default: 60)")
    begin.add_argument("--at-a-time", type=int, default=256, metavar="N", help="maximum number of simultaneous jobs (default: 256)")
    begin.add_argument("--sbatch", action="append", default=[], metavar="NAME=VALUE", help="option of sbatch, e.g. partition=cpu")
    begin.add_argument("--wait", action="store_true", help="wait for the jobs and join their results")
    begin.set_defaults(run=_submit)
    about = "Waits for the jobs of an array, and joins their results."
    end = commands.add_parser("collect", help=about, description=about)
    end.add_argument("out", type=Path, metavar="DIR", help="the --out of submit")
    end.set_defaults(run=lambda own: collect(own.out))
    own = options.parse_args(arguments)
    return ended(lambda: int(own.run(own)))


def _submit(own: argparse.Namespace) -> int:
    parameters = {}
    for pair in own.sbatch:
        name, equals, value = pair.partition("=")
        if not name or not equals:
            raise ScaleError("--sbatch", f"{pair!r} is not an option", "give NAME=VALUE, e.g. partition=cpu")
        parameters[name.replace("-", "_")] = value
    work = work_of(own)
    names = submit(work, own.cpus, own.minutes, parameters, own.at_a_time, own.scratch)
    print(f"submitted {names[0]} to {names[-1]}")
    if own.wait:
        return collect(work.out)
    print(f"after their end: vertibench-slurm collect {work.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
