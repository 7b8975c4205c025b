"""Runs held against each other, by the harness's own statistics."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from html import escape
from os import PathLike
from typing import Any

from .errors import ProgramError, VertibenchError
from .launch import events
from .store import Run
from .summary import Estimate, table_html

#: What is compared, with its unit: the success rate in [0, 1], the time of successes, the means of |roll| and |pitch|.
MEASURES = ("success_rate", "time_s", "roll_deg", "pitch_deg")
#: What a `Difference` has, in its order.
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
#: By what a run's figures are split.
SPLITS = ("elevation", "terrain", "density")


@dataclass(frozen=True)
class Figures:
    """Figures over some tasks of a run. A mean is None where there is nothing to average."""

    tasks: int  #: that count
    worlds: int  #: that they lie in
    outcomes: dict[str, int]  #: tasks by outcome
    causes: dict[str, int]  #: tasks that rolled over or got stuck by what stopped the vehicle (docs/scoring.md)
    success_rate: Estimate | None  #: in [0, 1]
    time_s: Estimate | None  #: traversal time of successes, s
    roll_deg: Estimate | None  #: |roll| over all samples, degrees
    pitch_deg: Estimate | None  #: |pitch| over all samples, degrees


@dataclass(frozen=True)
class RunFigures:
    """A run of a comparison."""

    label: str  #: the planner, with what tells it from the others
    path: str  #: the run's directory
    missing: int  #: tasks that aren't done yet
    host_errors: int  #: tasks that the harness or the machine failed, which count nowhere
    all: Figures  #: over all its tasks
    splits: dict[str, dict[str, Figures]]  #: by `elevation`, `terrain` and `density`, then by level


@dataclass(frozen=True)
class Difference(Estimate):
    """The mean over tasks of the second run's value less the first's, with its 95 % interval. Whether that is good depends on
    the measure: `verdict` says it."""

    tasks: int  #: that have the value in both runs
    p: float | None  #: two-sided, of the test that decides: it flips the signs of whole worlds
    p_adjusted: float | None  #: after Holm's correction over this measure of all pairs
    #: what is known of the second run: `better`, `worse`, `equal` (in every world), `too_few_worlds` (not even the most extreme
    #: outcome would be certain), `uncorrected` (certain if this were the only pair), `undecided`
    verdict: str | None
    worlds: int  #: that differ
    worlds_needed: int | None  #: that would have to differ, if they are too few
    p_secondary: float | None  #: of a test that assumes more and decides nothing: McNemar's for successes, else Wilcoxon's

    __str__ = Estimate.__str__


@dataclass(frozen=True)
class Pair:
    """Two runs on the tasks that both have done. A difference is None without such a task."""

    first: str  #: label of the first run
    second: str  #: label of the second run
    common: int  #: tasks that both have done
    both: int  #: tasks that both succeed in
    only_first: int  #: tasks that the first alone succeeds in
    only_second: int  #: tasks that the second alone succeeds in
    success_rate: Difference | None  #: in [-1, 1]
    time_s: Difference | None  #: over tasks that both succeed in, s
    roll_deg: Difference | None  #: degrees
    pitch_deg: Difference | None  #: degrees


@dataclass(frozen=True)
class Place:
    """A run's place in the ranking, with ties."""

    label: str  #: of the run
    rank: int  #: one more than the number of runs that succeed more for certain
    rank_last: int  #: the last rank that is possible: all runs less those that succeed less for certain
    ties: tuple[str, ...]  #: labels of the runs from which it does not differ significantly


@dataclass(frozen=True)
class Comparison:
    """Runs of one suite with their figures, and each pair of them on its common tasks."""

    runs: tuple[RunFigures, ...]
    pairs: tuple[Pair, ...]  #: all with all
    ranking: tuple[Place, ...]  #: by rank, then by success rate; empty for one run, and for runs that can't be ranked
    headline: str | None  #: who wins, in a sentence; None for one run
    unranked: str | None = None  #: why the runs can't be ranked, e.g. since their time steps differ

    def runs_frame(self, frame: str = "pandas") -> Any:
        """A row for each run (see `vertibench.results` for the kinds of frames): label, path, tasks, and of each measure
        the mean with `_low` and `_high`."""
        return _frame([{"label": r.label, "path": r.path, **_row(r.all)} for r in self.runs], frame)

    def splits_frame(self, frame: str = "pandas") -> Any:
        """A row for each level of elevation, terrain and density of each run, with the same columns."""
        rows = [
            {"label": r.label, "split": split, "level": level, **_row(figures)}
            for r in self.runs
            for split, levels in r.splits.items()
            for level, figures in levels.items()
        ]
        return _frame(rows, frame)

    def ranking_frame(self, frame: str = "pandas") -> Any:
        """A row for each run, the best first: rank, the last rank that is possible, and from which others it does not differ significantly."""
        return _frame([asdict(p) | {"ties": ", ".join(p.ties)} for p in self.ranking], frame)

    def pairs_frame(self, frame: str = "pandas") -> Any:
        """A row for each pair of runs and each measure: the difference (second less first) with its interval, p-values and
        verdict."""
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
    """Compares runs of one suite task by task, by the statistics of `vb-harness report` (docs/reports.md): success rates,
    times, roll and pitch with 95 % intervals by the bootstrap over worlds, and the paired differences of each two runs with
    their tests. One run alone has its figures and no pairs.

    Raises the `ProgramError` of the program's exit code, e.g. `InputError` for runs of different suites.
    """
    if not runs:
        raise VertibenchError("compare", "no run is given", "give two or more")
    for run in runs:
        if not isinstance(run, (Run, str, PathLike)):
            hint = "give each run as an argument of its own: compare(a, b)"
            raise VertibenchError("compare", f"{type(run).__name__} is no run", hint)
    paths = [str(run.path if isinstance(run, Run) else run) for run in runs]
    # Without a file to write the program makes no report.
    told = events("report", *paths, "--markdown=-", "--message-format=json")
    found = next((event for event in told if event.get("event") == "statistics"), None)
    if found is None:
        raise ProgramError("vb-harness report tells no statistics (use a newer vb-harness)", 0)
    try:
        return _read(found)
    except (KeyError, TypeError, IndexError) as e:
        raise ProgramError(
            f"vb-harness report tells statistics of another form: {e!r} (use the vb-harness of this version)", 0
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
    # Missing throughout is still a number.
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
