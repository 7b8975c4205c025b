"""One shard, as a process of `vb-harness`, and what its exit code means for whoever began it."""

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

#: Exit codes of a shard that is done: 5 tells of simulations that failed, which is a result.
DONE = (0, 5)
#: Exit codes after which the same command is worth another try: the machine failed tasks, the results couldn't be written, it was
#: stopped.
AGAIN = (4, 7, 130)
#: How many lines of what a shard said last are kept for a message.
_LAST = 3


@dataclass(frozen=True)
class ShardEnd:
    """How a shard has ended."""

    index: int
    code: int
    #: What it said last.
    said: str
    #: The tasks that it has done until now, and the successes among them.
    tasks: int = 0
    successes: int = 0

    @property
    def is_done(self) -> bool:
        """Whether all of its tasks have a result."""
        return self.code in DONE

    @property
    def is_worth_another_try(self) -> bool:
        """Whether the same command may do better: the machine is to blame, not what was asked for."""
        return self.code in AGAIN or self.code < 0 or self.code > 128


def run_shard(work: Work, index: int, jobs: int | None = None, scratch: Path | None = None) -> ShardEnd:
    """Drives a shard to its end, in a process that ends with this one. With `scratch`, a folder of this machine, it works there, and its
    results are moved to where they belong when it ends, so that a shared file system isn't asked to sync every task."""
    if scratch is None:
        return _drive(work, index, jobs)
    with tempfile.TemporaryDirectory(dir=scratch, prefix="vertibench-") as folder:
        there = replace(work, out=Path(folder))
        for done in work.folders(index):
            # From an earlier try, which goes on.
            shutil.copytree(done, there.out / done.relative_to(work.out))
        end = _drive(there, index, jobs)
        for done in there.folders(index):
            _put(done, work.out / done.relative_to(there.out))
    return end


def progress(ended: list[ShardEnd], shards: int) -> str:
    """How far all is, for those who watch."""
    return f"{len(ended)} of {shards} shards, {sum(e.tasks for e in ended)} tasks, {sum(e.successes for e in ended)} successes"


def _put(folder: Path, where: Path) -> None:
    """Copies a folder so that it is there as a whole or not at all; one that is there goes first."""
    half = where.with_name(f".{where.name}.half")
    shutil.rmtree(half, ignore_errors=True)
    # Times and rights of files are of no use there.
    shutil.copytree(folder, half, copy_function=shutil.copyfile)
    if where.exists():
        shutil.rmtree(where)
    half.rename(where)


def _drive(work: Work, index: int, jobs: int | None) -> ShardEnd:
    # What it tells of each task is in the results.
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
    """Puts all shards together; gives the exit code. A run that is there already stays."""
    if not work.is_sweep and (work.result() / "summary.json").is_file():
        return 0
    return subprocess.run([str(harness_path()), *work.joined()], env=environment(), check=False).returncode


def failed(end: ShardEnd) -> ScaleError:
    """The error of a shard that has failed for good."""
    to_do = "the same command goes on where it was stopped" if end.is_worth_another_try else "mend it, then give the same command again"
    return ScaleError(f"shard {end.index}", f"it ended with code {end.code}: {end.said}", to_do)


def _counted(folders: list[Path]) -> tuple[int, int]:
    files = [folder / "tasks.jsonl" for folder in folders]
    lines = [line for file in files if file.is_file() for line in file.read_text(encoding="utf-8").splitlines()]
    return len(lines), sum('"outcome":"success"' in line for line in lines)


def _end_with_parent() -> None:
    # Else a shard whose worker was killed would go on, and hold its folder against the next one.
    parent = os.getppid()
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG, linux/prctl.h
    if os.getppid() != parent:
        os.kill(os.getpid(), signal.SIGTERM)
