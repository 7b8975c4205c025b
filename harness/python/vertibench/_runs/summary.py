"""Summary of a run."""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from .errors import RunError
from .store import RunDirectory, json_object, read

#: Labels of worlds by which figures are split.
SPLITS = ("elevation", "terrain", "density", "world")


@dataclass(frozen=True)
class Estimate:
    """Mean with its 95 % interval, from the bootstrap over worlds (docs/reports.md).

    Attributes:
        mean: The mean.
        low: Lower end of the interval; None if all tasks are in one world.
        high: Upper end of the interval; None if all tasks are in one world.
    """

    mean: float
    low: float | None
    high: float | None

    def __format__(self, spec: str) -> str:
        """Formats mean and interval with one specification.

        Args:
            spec: Format specification of each number.

        Returns:
            Text such as `37.7% (30.2%–45.9%)` or `-2.0% (-9.1% to 5.0%)` for `f"{estimate:.1%}"`; the mean only if
            there is no interval.
        """
        text = format(self.mean, spec)
        if self.low is None or self.high is None:
            return text
        # A dash next to a minus sign is unreadable.
        to = "–" if self.low >= 0 and self.high >= 0 else " to "
        return f"{text} ({self.low:{spec}}{to}{self.high:{spec}})"

    def __str__(self) -> str:
        return format(self, ".4g")


class Summary(Mapping[str, Any]):
    """Summary of a run: `summary.json` as a mapping (docs/scoring.md), with the most used figures as properties.

    Args:
        content: Content of `summary.json`.
    """

    def __init__(self, content: dict[str, Any]):
        self._content = content

    def __getitem__(self, name: str) -> Any:
        return self._content[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._content)

    def __len__(self) -> int:
        return len(self._content)

    @property
    def tasks(self) -> int:
        """Number of tasks in the figures."""
        return self["all"]["tasks"]

    @property
    def success_rate(self) -> Estimate | None:
        """Success rate in [0, 1] with its interval; None if no task is in the figures."""
        return _success(self["all"])

    @property
    def outcomes(self) -> dict[str, int]:
        """Number of tasks by outcome."""
        return dict(self["all"]["outcomes"])

    def frame(self, frame: str = "pandas") -> Any:
        """Returns the figures as a data frame: one row for all tasks, and one per level and world.

        Columns: `split` (`all`, `elevation`, `terrain`, `density` or `world`), `level`, and one per figure. Prefixes
        mark the number of tasks by outcome (`outcome_`), by the paper's class (`three_way_`) and by true flag
        (`flag_`), means of shock and ride (`ride_`), and the planner's fuel (`fuel_`).

        Args:
            frame: Type of the result, as in `vertibench.results`: `"pandas"` (default), `"polars"`, `"arrow"` or
                `"dict"`.

        Returns:
            The data frame. The other fields of `summary.json` are its attribute or metadata `summary` where the type
            has one.

        Raises:
            VertibenchError: If there is no such type.
            MissingPackageError: If the package for this type is not installed.
        """
        import pyarrow as pa

        from .frames import as_frame

        rows = [{"split": split, "level": level, **_flat(figures)} for split, level, figures in self._groups()]
        names = list(dict.fromkeys(name for row in rows for name in row))
        table = pa.table({name: [row.get(name) for row in rows] for name in names})
        return as_frame(table, frame, {"summary": {k: v for k, v in self.items() if k not in ("all", *SPLITS)}})

    def _groups(self) -> Iterator[tuple[str, str, dict[str, Any]]]:
        yield "all", "all", self["all"]
        for split in SPLITS:
            for level, figures in (self.get(split) or {}).items():
                yield split, level, figures

    def __repr__(self) -> str:
        rate = self.success_rate
        told = "no task" if rate is None else f"success {rate:.1%}"
        return f"<Summary {self['planner']} on {self['suite']}: {self.tasks} tasks, {told}>"

    def _repr_html_(self) -> str:
        rows = [
            [level if split == "all" else f"{split} {level}", str(f["tasks"]), _percent(_success(f)), _number(f["time_mean_s"]),
             _number(f["roll_mean_deg"]), _number(f["pitch_mean_deg"]), str(f["outcomes"]["rollover"]),
             _count(f, "tilted"), str(f["outcomes"]["stuck"]), _count(f, "strict")]
            for split, level, f in self._groups() if split != "world"
        ]  # fmt: skip
        head = [
            "",
            "tasks",
            "success % (95 % interval)",
            "time s",
            "mean |roll| °",
            "mean |pitch| °",
            "rollover",
            "tilt > 30°",
            "stuck",
            "strict",
        ]
        return table_html(f"{self['planner']} on {self['suite']}", head, rows)


def summary(run: RunDirectory) -> Summary:
    """Reads the summary of a finished run; see `vertibench.summary`."""
    file = run.path / "summary.json"
    if not file.is_file():
        raise RunError(file, "there is no summary yet", "wait for the end of the run, or finish it with resume=True")
    content = json_object(file, read(file))
    figures = content.get("all")
    if not isinstance(figures, dict) or not {"tasks", "success_rate", "outcomes"} <= figures.keys():
        raise RunError(file, "not a summary of this version", "create it again: vb-harness score --help")
    return Summary(content)


def table_html(title: str, head: list[str], rows: list[list[str]]) -> str:
    """Returns an HTML table; texts are escaped. The first column is left-aligned, all others are right-aligned."""
    align = ["left"] + ["right"] * (len(head) - 1)

    def line(tag: str, cells: list[str]) -> str:
        return "".join(
            f'<{tag} style="text-align:{a};white-space:nowrap">{html.escape(c)}</{tag}>' for a, c in zip(align, cells)
        )

    body = "".join(f"<tr>{line('td', row)}</tr>" for row in rows)
    caption = f'<caption style="text-align:left;caption-side:top">{html.escape(title)}</caption>'
    return f"<table>{caption}<thead><tr>{line('th', head)}</tr></thead><tbody>{body}</tbody></table>"


def _flat(figures: dict[str, Any]) -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for name, value in figures.items():
        if name in ("outcomes", "three_way", "flags", "ride", "fuel"):
            before = name.removesuffix("s") if name in ("outcomes", "flags") else name
            flat |= {f"{before}_{k}": v for k, v in (value or {}).items()}
        else:
            flat[name] = value
    return flat


def _success(figures: dict[str, Any]) -> Estimate | None:
    rate = figures["success_rate"]
    return None if rate is None else Estimate(rate, figures.get("success_low"), figures.get("success_high"))


def _percent(e: Estimate | None) -> str:
    if e is None:
        return "–"
    of = Estimate(*(None if v is None else 100 * v for v in (e.mean, e.low, e.high)))  # type: ignore[arg-type]
    return format(of, ".1f")


def _count(figures: dict[str, Any], flag: str) -> str:
    """Returns the number of tasks with this flag."""
    return str(figures.get("flags", {}).get(flag, "–"))


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.1f}"
