"""Work for many machines: command lines of the shards, and the command line that joins them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from .._errors import VertibenchError

#: Options that this package sets per shard.
_OWN = ("--shard", "--out", "-o", "--resume", "--jobs", "-j", "--json", "--message-format")


class ScaleError(VertibenchError):
    """A work is invalid, or a shard has failed permanently. The message is one line."""


@dataclass(frozen=True)
class Work:
    """Run or sweep that is split into shards.

    Create it with `Work.of`, which validates the arguments.

    Attributes:
        arguments: Arguments of `vb-harness run`, e.g. `("pid.wasm", "--seed", "7")`, or `("sweep", FILE)`.
        out: Directory that all machines see, absolute. The joined run is in `out/run`, the report of a sweep in
            `out/report`.
        shards: Number of shards, at least 1.
    """

    arguments: tuple[str, ...]
    out: Path
    shards: int

    @classmethod
    def of(cls, arguments: list[str], out: Path, shards: int) -> Work:
        """Creates a work from a command line.

        Args:
            arguments: Arguments of `vb-harness run`, the planner first or with `--plugin`, or `["sweep", FILE]`. A leading
                `"run"` is ignored.
            out: Directory for the results, which all machines see.
            shards: Number of shards, at least 1.

        Returns:
            The work.

        Raises:
            ScaleError: If there is no planner, an option is set per shard (`--shard`, `--out`, `--resume`, `--jobs`,
                `--json`, `--message-format`), a sweep has further arguments, or `shards` is below 1.
        """
        own = [a for a in arguments if a.split("=")[0] in _OWN]
        if own:
            raise ScaleError(own[0], "the option is set per shard automatically", "leave it out")
        if shards < 1:
            raise ScaleError("--shards", f"{shards} is not a number of shards", "give at least 1")
        if arguments[:1] == ["run"]:
            arguments = arguments[1:]
        if arguments[:1] == ["sweep"]:
            if len(arguments) != 2 or arguments[1].startswith("-"):
                raise ScaleError("sweep", "one file and no options are allowed", "give: sweep FILE")
            arguments = ["sweep", str(Path(arguments[1]).absolute())]
        elif not arguments or (arguments[0].startswith("-") and not any(a.split("=")[0] == "--plugin" for a in arguments)):
            raise ScaleError("the command line", "no planner", "give `-- pid.wasm …`, or `-- sweep FILE`")
        # Machines start in different working directories.
        return cls(tuple(arguments), out.absolute(), shards)

    @property
    def is_sweep(self) -> bool:
        """Whether the work is a sweep."""
        return self.arguments[:1] == ("sweep",)

    def shard(self, index: int | None, jobs: int | None = None) -> list[str]:
        """Returns the command line of a shard; the same command line resumes an interrupted shard.

        Args:
            index: Number of the shard, from 1 to `shards`. None: the number from the scheduler's environment variables
                (`--shard auto`).
            jobs: Number of parallel tasks. None (default): the number of cores.

        Returns:
            Arguments of `vb-harness`.
        """
        place = "auto" if index is None else f"{index}/{self.shards}"
        part = ["--resume", "--shard", place, *([] if jobs is None else ["--jobs", str(jobs)])]
        if self.is_sweep:
            return ["sweep", "run", self.arguments[1], "--out", str(self.out), *part]
        return ["run", *self.arguments, "--out", str(self.out / "shards"), *part]

    def folders(self, index: int) -> list[Path]:
        """Finds the folders that a shard has written so far.

        Args:
            index: Number of the shard, from 1.

        Returns:
            One folder for a run; for a sweep one per run of which the shard has a part. Folders that don't exist yet
            are absent.
        """
        own = f"shard-{index:04}-of-{self.shards:04}"
        return sorted(self.out.glob(f"shards/*/{own}" if self.is_sweep else f"shards/{own}"))

    def joined(self) -> list[str]:
        """Returns the command line that joins all shards.

        Returns:
            Arguments of `vb-harness`.
        """
        if self.is_sweep:
            return ["sweep", "report", self.arguments[1], "--out", str(self.out)]
        return ["merge", str(self.out / "shards"), "--out", str(self.out / "run")]

    def result(self) -> Path:
        """Returns the directory of the joined result.

        Returns:
            `out/run`, or `out/report` for a sweep.
        """
        return self.out / ("report" if self.is_sweep else "run")

    def to_json(self) -> dict[str, object]:
        """Converts the work to a JSON-compatible dictionary.

        Returns:
            The dictionary, for `from_json`.
        """
        return {"arguments": list(self.arguments), "out": str(self.out), "shards": self.shards}

    @classmethod
    def from_json(cls, value: dict[str, object]) -> Work:
        """Creates a work from the dictionary of `to_json`.

        Args:
            value: The dictionary.

        Returns:
            The work.
        """
        arguments, shards = value["arguments"], value["shards"]
        assert isinstance(arguments, list) and isinstance(shards, int)
        return cls(tuple(str(a) for a in arguments), Path(str(value["out"])), shards)
