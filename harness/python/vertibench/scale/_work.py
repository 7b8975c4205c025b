"""What is to be done by many machines: the command lines of its parts, and the one that puts them together."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from .._errors import VertibenchError

#: Options that this package sets itself.
_OWN = ("--shard", "--out", "--resume", "--jobs", "--json", "--message-format")


class ScaleError(VertibenchError):
    """What is to be done makes no sense, or a shard has failed for good. The message is one line: where, what, what to do."""


@dataclass(frozen=True)
class Work:
    """A run or a sweep, in so many shards.

    `arguments` are those of `vb-harness run` (`--plugin pid.wasm --suite vb-100`), or `sweep FILE`. The shards write below `out`; the
    whole run will be in `out/run`, and of a sweep the comparison in `out/report`.
    """

    arguments: tuple[str, ...]
    out: Path
    shards: int

    @classmethod
    def of(cls, arguments: list[str], out: Path, shards: int) -> Work:
        """The work that a command line says."""
        own = [a for a in arguments if a.split("=")[0] in _OWN]
        if own:
            raise ScaleError(own[0], "the option is set for each shard by itself", "leave it out")
        if shards < 1:
            raise ScaleError("--shards", f"{shards} is no number of shards", "give at least 1")
        if arguments[:1] == ["run"]:
            arguments = arguments[1:]
        if arguments[:1] == ["sweep"]:
            if len(arguments) != 2 or arguments[1].startswith("-"):
                raise ScaleError("sweep", "it takes one file and no options", "give: sweep FILE")
            arguments = ["sweep", str(Path(arguments[1]).absolute())]
        elif not any(a.split("=")[0] == "--plugin" for a in arguments):
            raise ScaleError("the command line", "it names no planner", "give `-- --plugin pid.wasm …`, or `-- sweep FILE`")
        # Machines begin in folders of their own.
        return cls(tuple(arguments), out.absolute(), shards)

    @property
    def is_sweep(self) -> bool:
        """Whether it is a sweep."""
        return self.arguments[:1] == ("sweep",)

    def shard(self, index: int | None, jobs: int | None = None) -> list[str]:
        """The command line of a shard, from 1; without an index, of the one that the environment says (`--shard auto`). Given again, it
        goes on where it was stopped."""
        place = "auto" if index is None else f"{index}/{self.shards}"
        part = ["--shard", place, *([] if jobs is None else ["--jobs", str(jobs)])]
        if self.is_sweep:
            return ["sweep", "run", self.arguments[1], "--out", str(self.out), *part]
        return ["run", *self.arguments, "--out", str(self.out / "shards"), *part]

    def folders(self, index: int) -> list[Path]:
        """Where a shard has written until now: one folder, or of a sweep one for each run that it has a part of."""
        own = f"shard-{index:04}-of-{self.shards:04}"
        return sorted(self.out.glob(f"shards/*/{own}" if self.is_sweep else f"shards/{own}"))

    def joined(self) -> list[str]:
        """The command line that puts all shards together."""
        if self.is_sweep:
            return ["sweep", "report", self.arguments[1], "--out", str(self.out)]
        return ["merge", str(self.out / "shards"), "--out", str(self.out / "run")]

    def result(self) -> Path:
        """Where the whole result is in the end."""
        return self.out / ("report" if self.is_sweep else "run")

    def to_json(self) -> dict[str, object]:
        """The work as JSON keeps it."""
        return {"arguments": list(self.arguments), "out": str(self.out), "shards": self.shards}

    @classmethod
    def from_json(cls, value: dict[str, object]) -> Work:
        """The work that JSON has kept."""
        arguments, shards = value["arguments"], value["shards"]
        assert isinstance(arguments, list) and isinstance(shards, int)
        return cls(tuple(str(a) for a in arguments), Path(str(value["out"])), shards)
