"""Execution of a shard as a `vb-harness` process, and the meaning of its exit code."""

from __future__ import annotations

import ctypes
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

from .._program import environment, harness_path
from ._work import ScaleError, Work

#: Exit codes of a complete shard; 5 means that some simulations failed, which is a result.
DONE = (0, 5)
#: Exit codes after which a retry can succeed: results not written, tasks failed because of the machine, stopped.
AGAIN = (4, 7, 130)
#: Number of last stderr lines that a message contains.
_LAST = 3


@dataclass(frozen=True)
class ShardEnd:
    """Result of a shard's process.

    Attributes:
        index: Number of the shard, from 1.
        code: Exit code of `vb-harness`; negative if a signal ended it.
        said: Last lines that the process wrote to stderr, joined with ` | `.
        tasks: Number of tasks with a result so far.
        successes: Number of successful tasks among them.
    """

    index: int
    code: int
    said: str
    tasks: int = 0
    successes: int = 0

    @property
    def is_done(self) -> bool:
        """Whether all tasks of the shard have a result (exit code 0 or 5)."""
        return self.code in DONE

    @property
    def is_worth_another_try(self) -> bool:
        """Whether a retry of the same command can succeed: the machine, file system or scheduler failed."""
        return self.code in AGAIN or self.code < 0 or self.code > 128


def run_shard(work: Work, index: int, jobs: int | None = None, scratch: Path | None = None) -> ShardEnd:
    """Runs a shard in a child process, which ends with this process, and waits for its end.

    A shard that was interrupted continues.

    Args:
        work: The run or sweep.
        index: Number of the shard, from 1 to `work.shards`.
        jobs: Number of parallel tasks. None (default): the number of cores.
        scratch: Existing folder on this machine's own disk. The shard works there, and its results are copied to
            `work.out` at its end, which avoids a sync of every task on the shared file system. None (default): the
            shard works in `work.out`.

    Returns:
        Exit code, messages and counts of the shard.

    Raises:
        MissingError: If the program is missing.
    """
    if scratch is None:
        return _drive(work, index, jobs)
    with tempfile.TemporaryDirectory(dir=scratch, prefix="vertibench-") as folder:
        there = replace(work, out=Path(folder))
        for done in work.folders(index):
            # From an earlier attempt, which continues.
            shutil.copytree(done, there.out / done.relative_to(work.out))
        end = _drive(there, index, jobs)
        for done in there.folders(index):
            _put(done, work.out / done.relative_to(there.out))
    return end


def progress(ended: list[ShardEnd], shards: int) -> str:
    """Returns the progress of all shards as one line."""
    return f"{len(ended)} of {shards} shards, {sum(e.tasks for e in ended)} tasks, {sum(e.successes for e in ended)} successes"


def _put(folder: Path, where: Path) -> None:
    """Copies a folder atomically; an existing one is replaced."""
    half = where.with_name(f".{where.name}.half")
    shutil.rmtree(half, ignore_errors=True)
    # Times and permissions of files are not needed there.
    shutil.copytree(folder, half, copy_function=shutil.copyfile)
    if where.exists():
        shutil.rmtree(where)
    half.rename(where)


def _drive(work: Work, index: int, jobs: int | None) -> ShardEnd:
    # The results contain the progress on stdout.
    done = subprocess.run(
        [str(harness_path()), *work.shard(index, jobs)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
        env=environment(),
        preexec_fn=_end_with_parent if sys.platform == "linux" else None,
        check=False,
    )
    said = " | ".join(done.stderr.splitlines()[-_LAST:])
    return ShardEnd(index, done.returncode, said, *_counted(work.folders(index)))


def join(work: Work) -> int:
    """Joins all shards and returns the exit code. A joined run that exists already is kept."""
    if not work.is_sweep and (work.result() / "summary.json").is_file():
        return 0
    return subprocess.run([str(harness_path()), *work.joined()], env=environment(), check=False).returncode


def failed(end: ShardEnd) -> ScaleError:
    """Returns the error for a shard that has failed permanently."""
    to_do = "the same command continues" if end.is_worth_another_try else "correct the cause, then give the same command again"
    return ScaleError(f"shard {end.index}", f"it ended with code {end.code}: {end.said}", to_do)


def _counted(folders: list[Path]) -> tuple[int, int]:
    files = [folder / "tasks.jsonl" for folder in folders]
    lines = [line for file in files if file.is_file() for line in file.read_text(encoding="utf-8").splitlines()]
    return len(lines), sum('"outcome":"success"' in line for line in lines)


def _end_with_parent() -> None:
    # Otherwise a shard whose worker was killed would continue and keep its folder locked.
    parent = os.getppid()
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG, linux/prctl.h
    if os.getppid() != parent:
        os.kill(os.getpid(), signal.SIGTERM)
