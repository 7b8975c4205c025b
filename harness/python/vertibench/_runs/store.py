"""The run directory that `vb-harness` writes (docs/results.md)."""

from __future__ import annotations

import hashlib
import json
from os import PathLike
from pathlib import Path
from typing import Any

from .errors import RunError

#: Supported versions of run.json.
SCHEMAS = (1, 2, 3)

_DAMAGED = "the file was changed or damaged: restore the run from a copy, or run it again"


class RunDirectory:
    """Reader for the files of a run directory; base of `vertibench.Run`, which documents it."""

    def __init__(self, directory: str | PathLike[str]):
        self.path = Path(directory)
        file = self.path / "run.json"
        if not self.path.is_dir():
            raise RunError(self.path, "there is no such folder", "give the directory of a run")
        if not file.is_file():
            raise RunError(self.path, "not a run: run.json is missing", "give the directory of a run")
        content = read(file)
        self.header: dict[str, Any] = json_object(file, content)
        schema = self.header.get("schema")
        if schema not in SCHEMAS:
            raise RunError(
                file,
                f"unsupported version {schema} of the run format, supported: {SCHEMAS[0]} to {SCHEMAS[-1]}",
                "use a newer vertibench",
            )
        _check(self._sums(), "run.json", file, content)

    def __fspath__(self) -> str:
        return str(self.path)

    def __repr__(self) -> str:
        count = self.header.get("tasks")
        tasks = "1 task" if count == 1 else f"{count} tasks"
        return f"<Run {self.path}: {self.planner} on {self.of('suite', 'name')}, {tasks}>"

    @property
    def planner(self) -> str:
        """Name of the planner."""
        return str(self.of("plugin", "name"))

    @property
    def tasks(self) -> tuple[str, ...]:
        """Names of the finished tasks, sorted, e.g. `w001/t03`."""
        return tuple(record["task"] for record in self.records())

    def of(self, *names: str) -> Any:
        """Returns a field of `run.json`.

        Args:
            *names: Names of the nested fields, e.g. `"suite", "name"`.

        Returns:
            Value of the field; None if it doesn't exist.
        """
        value: Any = self.header
        for name in names:
            value = value.get(name) if isinstance(value, dict) else None
        return value

    def records(self) -> list[dict[str, Any]]:
        """Reads the records of all finished tasks from `tasks.jsonl`.

        An incomplete last line, of a run in progress or one that was killed, is ignored.

        Returns:
            One dictionary per task, in the order of the task names (docs/results.md lists the fields).

        Raises:
            RunError: If the file is damaged.
        """
        file = self.path / "tasks.jsonl"
        if not file.is_file():
            return []
        sums = self._sums()
        records = {}
        *lines, _torn = read(file).split(b"\n")
        for number, line in enumerate(lines, 1):
            record = json_object(f"{file} line {number}", line)
            task = record.get("task")
            if not isinstance(task, str) or "outcome" not in record:
                raise RunError(f"{file} line {number}", "not a record of a task", _DAMAGED)
            _check(sums, f"tasks.jsonl {task}", f"{file} line {number}", line)
            records[task] = record
        return [records[task] for task in sorted(records)]

    def record(self, task: str) -> dict[str, Any]:
        """Reads the record of a task from `tasks.jsonl`.

        Args:
            task: Task name, e.g. `"w001/t03"`.

        Returns:
            The record.

        Raises:
            RunError: If the run hasn't finished the task, or the file is damaged.
        """
        records = {record["task"]: record for record in self.records()}
        if task not in records:
            example = f"give one of them, e.g. {next(iter(records))}" if records else "wait for one, or run it"
            raise RunError(self.path, f"no task {task} among its {len(records)} finished tasks", example)
        return records[task]

    def trace_file(self, task: str) -> Path:
        """Finds and verifies the Parquet file of a task's trajectory.

        Args:
            task: Task name.

        Returns:
            The file.

        Raises:
            RunError: If the run hasn't finished the task or stored no trajectories, or the file is missing or damaged.
        """
        self.record(task)
        if self.header.get("trace") == "none":
            raise RunError(self.path, "the run stored no trajectories", "run it again with trace='10hz'")
        name = f"traces/{task}.parquet"
        file = self.path / name
        if not file.is_file():
            raise RunError(file, "the trajectory is missing", "restore the file, or run the task again")
        _check(self._sums(), name, file, read(file))
        return file

    def _sums(self) -> dict[str, str] | None:
        """Returns SHA-256 by name from `checksums.txt`; None for runs without this file."""
        file = self.path / "checksums.txt"
        if not file.is_file():
            return None
        sums = {}
        *lines, _torn = read(file).decode("utf-8", "replace").split("\n")
        for number, line in enumerate(lines, 1):
            digest, gap, name = line.partition("  ")
            if len(digest) != 64 or not gap or not name:
                raise RunError(f"{file} line {number}", "not a checksum", _DAMAGED)
            sums[name] = digest
        return sums


def _check(sums: dict[str, str] | None, name: str, where: object, content: bytes) -> None:
    """Raises `RunError` if the content differs from its checksum; does nothing without checksums."""
    if sums is None:
        return
    if name not in sums:
        raise RunError(where, f"{name} has no checksum in checksums.txt", _DAMAGED)
    if hashlib.sha256(content).hexdigest() != sums[name]:
        raise RunError(where, f"{name} differs from its checksum", _DAMAGED)


def read(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as e:
        raise RunError(file, f"cannot be read: {e.strerror}", "check its permissions, or restore it") from None


def json_object(where: object, content: bytes) -> dict[str, Any]:
    try:
        value = json.loads(content)
    except ValueError as e:
        raise RunError(where, f"not JSON: {e}", _DAMAGED) from None
    if not isinstance(value, dict):
        raise RunError(where, "not a JSON object", _DAMAGED)
    return value
