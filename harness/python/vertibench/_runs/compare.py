"""Comparison of runs with the harness's statistics."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from html import escape
from os import PathLike
from typing import Any

from .errors import ProgramError, VertibenchError
from .program import events
from .run import Run
from .summary import Estimate, table_html

#: Compared measures: success rate in [0, 1], time of successful tasks (s), means of |roll| and |pitch| (degrees).
MEASURES = ("success_rate", "time_s", "roll_deg", "pitch_deg")
#: Fields of a `Difference`, in order.
DIFFERENCE = (
    "mean",
    "low",
    "high",
    "tasks",
    "p",
    "p_adjusted",
    "verdict",
    "worlds",
    "worlds_needed",
    "p_secondary",
)
#: Labels of worlds by which figures are split.
SPLITS = ("elevation", "terrain", "density")


@dataclass(frozen=True)
class Figures:
    """Figures over some tasks of a run. An estimate is None if no task has the value.

    Attributes:
        tasks: Number of tasks in the figures.
        worlds: Number of their worlds.
        outcomes: Number of tasks by outcome.
        causes: Number of rollovers and stuck ends by failure cause (docs/scoring.md).
        success_rate: Success rate in [0, 1].
        time_s: Traversal time of successful tasks, s.
        roll_deg: Mean of |roll|, degrees.
        pitch_deg: Mean of |pitch|, degrees.
    """

    tasks: int
    worlds: int
    outcomes: dict[str, int]
    causes: dict[str, int]
    success_rate: Estimate | None
    time_s: Estimate | None
    roll_deg: Estimate | None
    pitch_deg: Estimate | None


@dataclass(frozen=True)
class RunFigures:
    """Figures of one run of a comparison.

    Attributes:
        label: Planner name, with the parameters or directory that distinguish the run from the others.
        path: Run directory.
        missing: Number of tasks that are not finished.
        host_errors: Number of tasks that failed because of the harness or the machine; no figure contains them.
        all: Figures over all tasks.
        splits: Figures by `elevation`, `terrain` and `density`, then by level.
    """

    label: str
    path: str
    missing: int
    host_errors: int
    all: Figures
    splits: dict[str, dict[str, Figures]]


@dataclass(frozen=True)
class Difference(Estimate):
    """Paired difference of two runs: mean over tasks of the second run's value minus the first's.

    Whether a positive difference is better depends on the measure; see `verdict`.

    Attributes:
        mean: The difference.
        low: Lower end of its 95 % interval (bootstrap over worlds, uncorrected); None for a single world.
        high: Upper end of this interval.
        tasks: Number of tasks with the value in both runs.
        p: Two-sided p-value of the sign-flip test over worlds, which decides; None without one.
        p_adjusted: This p-value after Holm's correction over this measure of all pairs.
        verdict: Result for the second run. `better`, `worse`: significant after the correction. `equal`: equal in every
            world. `too_few_worlds`: no outcome could be significant. `uncorrected`: significant before the correction
            only. `undecided`: not significant.
        worlds: Number of worlds in which the runs differ.
        worlds_needed: Number of differing worlds that significance needs, if there are too few.
        p_secondary: p-value for information, uncorrected: McNemar's exact test for success, otherwise Wilcoxon's
            signed-rank test.
    """

    tasks: int
    p: float | None
    p_adjusted: float | None
    verdict: str | None
    worlds: int
    worlds_needed: int | None
    p_secondary: float | None

    __str__ = Estimate.__str__


@dataclass(frozen=True)
class Pair:
    """Two runs on their common tasks. A difference is None without a common task.

    Attributes:
        first: Label of the first run.
        second: Label of the second run.
        common: Number of tasks that both runs have finished.
        both: Number of tasks that both complete successfully.
        only_first: Number of tasks that only the first completes successfully.
        only_second: Number of tasks that only the second completes successfully.
        success_rate: Difference of the success rates, in [-1, 1].
        time_s: Difference of the traversal times over tasks in which both succeed, s.
        roll_deg: Difference of the mean |roll|, degrees.
        pitch_deg: Difference of the mean |pitch|, degrees.
    """

    first: str
    second: str
    common: int
    both: int
    only_first: int
    only_second: int
    success_rate: Difference | None
    time_s: Difference | None
    roll_deg: Difference | None
    pitch_deg: Difference | None


@dataclass(frozen=True)
class Place:
    """Rank of a run, with ties.

    Attributes:
        label: Label of the run.
        rank: One plus the number of runs with significantly more success.
        rank_last: Last possible rank: the number of all runs minus those with significantly less success.
        ties: Labels of the runs from which it doesn't differ significantly.
    """

    label: str
    rank: int
    rank_last: int
    ties: tuple[str, ...]


@dataclass(frozen=True)
class Comparison:
    """Comparison of runs of one suite. A notebook displays it as tables.

    The methods `..._frame` return data frames. Their argument `frame` is the type of the result: `"pandas"` (default),
    `"polars"`, `"arrow"` or `"dict"`, as in `vertibench.results`. They raise `VertibenchError` for other types, and
    `MissingPackageError` if the package for a type is not installed.

    Attributes:
        runs: Figures of each run, in the order of the arguments.
        pairs: All pairs of runs on their common tasks.
        ranking: Runs by rank, then by success rate; empty for a single run and for runs that can't be ranked.
        headline: The winner in one sentence; None for a single run.
        unranked: Settings in which runs that can't be ranked differ, e.g. the time step; otherwise None.
    """

    runs: tuple[RunFigures, ...]
    pairs: tuple[Pair, ...]
    ranking: tuple[Place, ...]
    headline: str | None
    unranked: str | None = None

    def runs_frame(self, frame: str = "pandas") -> Any:
        """Returns the figures as a data frame with one row per run.

        Columns: `label`, `path`, `tasks`, `worlds`, each measure of `MEASURES` with its interval (`_low`, `_high`), and
        the number of tasks per outcome (`outcome_...`).
        """
        return _frame([{"label": r.label, "path": r.path, **_row(r.all)} for r in self.runs], frame)

    def splits_frame(self, frame: str = "pandas") -> Any:
        """Returns the figures by level as a data frame: one row per run, split and level.

        Columns: `label`, `split` (`elevation`, `terrain` or `density`), `level`, and the figures as in `runs_frame`.
        """
        rows = [
            {"label": r.label, "split": split, "level": level, **_row(figures)}
            for r in self.runs
            for split, levels in r.splits.items()
            for level, figures in levels.items()
        ]
        return _frame(rows, frame)

    def ranking_frame(self, frame: str = "pandas") -> Any:
        """Returns the ranking as a data frame with one row per run, best first.

        Columns: `label`, `rank`, `rank_last`, and `ties`, a text of labels (see `Place`).
        """
        return _frame([asdict(p) | {"ties": ", ".join(p.ties)} for p in self.ranking], frame)

    def pairs_frame(self, frame: str = "pandas") -> Any:
        """Returns the paired differences as a data frame: one row per pair and measure.

        Columns: the labels and task counts of `Pair`, `measure`, and the fields of `Difference`.
        """
        rows = []
        for p in self.pairs:
            counts = {k: getattr(p, k) for k in ("first", "second", "common", "both", "only_first", "only_second")}
            for name in MEASURES:
                d: Difference | None = getattr(p, name)
                own = asdict(d) if d else dict.fromkeys(DIFFERENCE)
                rows.append({**counts, "measure": name, **own})
        return _frame(rows, frame)

    def __repr__(self) -> str:
        told = [
            f"{r.label} {'–' if r.all.success_rate is None else format(r.all.success_rate, '.1%')}" for r in self.runs
        ]
        return f"<Comparison of {len(self.runs)} runs: success {'; '.join(told)}>"

    def _repr_html_(self) -> str:
        units = ["success % (95 % interval)", "time s", "|roll| °", "|pitch| °"]
        head = ["planner", "tasks", *units]
        rows = [[r.label, str(r.all.tasks), *(_shown(getattr(r.all, m), m) for m in MEASURES)] for r in self.runs]
        shown = f"<p>{escape(self.headline)}</p>" if self.headline else ""
        shown += table_html("runs", head, rows)
        if self.pairs:
            head = ["second − first", "tasks", "success, points", "only first / second", "p", *units[1:]]
            rows = [
                [f"{p.second} − {p.first}", str(p.common), _shown(p.success_rate, "success_rate"), f"{p.only_first} / {p.only_second}",
                 _p(p.success_rate), *(_shown(getattr(p, m), m) for m in MEASURES[1:])]
                for p in self.pairs
            ]  # fmt: skip
            shown += table_html(
                "paired differences, with 95 % intervals; p of the sign-flip test over worlds after Holm's correction",
                head,
                rows,
            )
        return shown


def compare(*runs: Run | str | PathLike[str]) -> Comparison:
    """Compares runs of one suite task by task, with the statistics of `vb-harness report`.

    The success rates, times, roll and pitch have 95 % intervals from the bootstrap over worlds. Paired differences have
    sign-flip tests over worlds with Holm's correction (docs/reports.md).

    Args:
        *runs: Runs, or their directories, at least one. A single run has figures but no pairs.

    Returns:
        The comparison.

    Raises:
        VertibenchError: If no run is given, or an argument is no run.
        InputError: If a run can't be read, or the runs are of different suites.
        UsageError: If a run is given twice.
        ProgramError: If the program ends with another error.

    Example:
        >>> vertibench.compare(run, "runs/pid-1").pairs[0].success_rate
    """
    if not runs:
        raise VertibenchError("compare", "no run is given", "give two or more")
    for run in runs:
        if not isinstance(run, (Run, str, PathLike)):
            hint = "give each run as a separate argument: compare(a, b)"
            raise VertibenchError("compare", f"{type(run).__name__} is no run", hint)
    paths = [str(run.path if isinstance(run, Run) else run) for run in runs]
    # Without an output file the program writes no HTML report.
    told = events("report", *paths, "--markdown=-", "--message-format=json")
    found = next((event for event in told if event.get("event") == "statistics"), None)
    if found is None:
        raise ProgramError("vb-harness report prints no statistics (use a newer vb-harness)", 0)
    try:
        return _read(found)
    except (KeyError, TypeError, IndexError) as e:
        raise ProgramError(
            f"vb-harness report prints statistics in an unknown format: {e!r} (use the vb-harness of this version)", 0
        ) from None


def _read(told: dict[str, Any]) -> Comparison:
    runs = tuple(
        RunFigures(
            r["label"],
            r["path"],
            r["missing"],
            r["host_errors"],
            _figures(r["all"]),
            {split: {level: _figures(f) for level, f in r[split].items()} for split in SPLITS},
        )
        for r in told["runs"]
    )
    pairs = tuple(
        Pair(
            runs[p["first"]].label,
            runs[p["second"]].label,
            *(p[k] for k in ("common", "both", "only_first", "only_second")),
            *(_difference(p["differences"][m], m) for m in MEASURES),
        )
        for p in told["pairs"]
    )
    ranking = tuple(
        Place(runs[p["run"]].label, p["rank"], p["rank_last"], tuple(runs[k].label for k in p["ties"]))
        for p in told["ranking"]
    )
    return Comparison(runs, pairs, ranking, told["headline"], told.get("unranked"))


def _figures(f: dict[str, Any]) -> Figures:
    means = [f[m] and Estimate(f[m]["mean"], f[m]["low"], f[m]["high"]) for m in MEASURES]
    return Figures(f["tasks"], f["worlds"], dict(f["outcomes"]), dict(f["causes"]), *means)


def _difference(d: dict[str, Any] | None, measure: str) -> Difference | None:
    if d is None:
        return None
    secondary = d["p_mcnemar" if measure == "success_rate" else "p_wilcoxon"]
    return Difference(*(d[k] for k in DIFFERENCE if k != "p_secondary"), p_secondary=secondary)


def _row(f: Figures) -> dict[str, Any]:
    row: dict[str, Any] = {"tasks": f.tasks, "worlds": f.worlds}
    for name in MEASURES:
        e: Estimate | None = getattr(f, name)
        row |= {name: e and e.mean, f"{name}_low": e and e.low, f"{name}_high": e and e.high}
    return row | {f"outcome_{k}": v for k, v in f.outcomes.items()}


def _frame(rows: list[dict[str, Any]], frame: str) -> Any:
    import pyarrow as pa

    from .frames import as_frame

    names = list(dict.fromkeys(name for row in rows for name in row))
    # A column without any value counts as numeric.
    columns = {name: pa.array([row.get(name) for row in rows]) for name in names}
    columns = {name: c.cast(pa.float64()) if pa.types.is_null(c.type) else c for name, c in columns.items()}
    return as_frame(pa.table(columns), frame, {})


def _shown(e: Estimate | None, measure: str) -> str:
    if e is None:
        return "–"
    factor = 100 if measure == "success_rate" else 1
    low, high = (None if v is None else factor * v for v in (e.low, e.high))
    return format(Estimate(factor * e.mean, low, high), ".1f")


def _p(d: Difference | None) -> str:
    if d is None or d.p_adjusted is None:
        return "–"
    if d.verdict == "too_few_worlds":
        return f"too few worlds ({d.worlds} of {d.worlds_needed})"
    return "< 0.001" if d.p_adjusted < 0.001 else f"{d.p_adjusted:.3f}"
