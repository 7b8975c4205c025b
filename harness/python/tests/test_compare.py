"""Comparisons are what the program's statistics say."""

import pytest

import vertibench
from vertibench._runs.compare import Place


def _estimate(mean, low=None, high=None):
    return {"mean": mean, "low": low, "high": high}


def _figures(**means):
    none = dict.fromkeys(("success_rate", "time_s", "roll_deg", "pitch_deg"))
    return {"tasks": 10, "worlds": 2, "outcomes": {"success": 4, "stuck": 6}, "causes": {"high_centred": 6}} | none | means


def _run(label, path, rate):
    all_ = _figures(success_rate=_estimate(rate, 0.1, 0.9), time_s=_estimate(38.2), roll_deg=_estimate(4.0, 3.0, 5.0))
    splits = {"elevation": {"low": _figures(success_rate=_estimate(1.0))}, "terrain": {}, "density": {}}
    return {"label": label, "path": path, "missing": 1, "host_errors": 0, "all": all_, **splits}


def _difference(tasks, mean, low, high, p, p_adjusted, verdict, worlds=2, needed=None, **secondary):
    own = {"tasks": tasks, "mean": mean, "low": low, "high": high, "p": p, "p_adjusted": p_adjusted}
    return own | {"verdict": verdict, "worlds": worlds, "worlds_needed": needed} | secondary


DIFFERENCES = {
    "success_rate": _difference(9, 0.25, -0.1, 0.5, 0.0004, 0.0004, "better", p_mcnemar=0.375),
    "time_s": _difference(3, -2.5, None, None, 0.5, 0.5, "too_few_worlds", needed=6, p_wilcoxon=0.5),
    "roll_deg": _difference(9, 0.0, -1.0, 1.0, None, None, None, p_wilcoxon=None),
    "pitch_deg": None,
}
PAIR = {"first": 0, "second": 1, "common": 9, "both": 3, "only_first": 1, "only_second": 4, "differences": DIFFERENCES}
TOLD = {
    "event": "statistics",
    "level": 0.95,
    "runs": [_run("a <b>", "runs/a", 0.4), _run("c", "runs/c", 0.65)],
    "pairs": [PAIR],
    "ranking": [
        {"run": 1, "rank": 1, "rank_last": 2, "ties": [0]},
        {"run": 0, "rank": 1, "rank_last": 2, "ties": [1]},
    ],
    "headline": "c does <most>.",
}


def test_what_the_program_tells_is_in_the_comparison(stand_in):
    stand_in(TOLD, {"event": "report", "runs": ["a <b>", "c"], "files": []})
    comparison = vertibench.compare("runs/a", "runs/c")
    first, second = comparison.runs
    assert (first.label, second.path, first.missing, first.all.tasks) == ("a <b>", "runs/c", 1, 10)
    assert first.all.success_rate == vertibench.Estimate(0.4, 0.1, 0.9) and first.all.pitch_deg is None
    assert (
        first.all.outcomes == {"success": 4, "stuck": 6} and first.all.causes == {"high_centred": 6} and first.splits["elevation"]["low"].success_rate.mean == 1.0
    )
    (pair,) = comparison.pairs
    assert (pair.first, pair.second, pair.common, pair.both, pair.only_first, pair.only_second) == (
        "a <b>",
        "c",
        9,
        3,
        1,
        4,
    )
    d = pair.success_rate
    assert (d.mean, d.low, d.high, d.tasks, d.p, d.p_adjusted) == (0.25, -0.1, 0.5, 9, 0.0004, 0.0004)
    assert (d.verdict, d.worlds, d.worlds_needed, d.p_secondary) == ("better", 2, None, 0.375)
    assert (pair.time_s.verdict, pair.time_s.worlds_needed, pair.time_s.p_secondary) == ("too_few_worlds", 6, 0.5)
    assert comparison.ranking[0] == Place("c", 1, 2, ("a <b>",)) and comparison.headline == "c does <most>."
    assert f"{d:.0%}" == "25% (-10% to 50%)" and pair.pitch_deg is None and pair.time_s.low is None
    assert "success a <b> 40.0% (10.0%–90.0%); c 65.0%" in repr(comparison)


def test_comparisons_are_frames_and_tables(stand_in):
    stand_in(TOLD)
    comparison = vertibench.compare("runs/a", "runs/c")
    runs = comparison.runs_frame("dict")
    assert (
        runs["success_rate"] == [0.4, 0.65]
        and runs["success_rate_high"] == [0.9, 0.9]
        and runs["time_s_low"] == [None, None]
    )
    assert runs["outcome_stuck"] == [6, 6] and runs["label"] == ["a <b>", "c"]
    splits = comparison.splits_frame("dict")
    assert (splits["split"], splits["level"], splits["success_rate"]) == (["elevation"] * 2, ["low"] * 2, [1.0, 1.0])
    pairs = comparison.pairs_frame("dict")
    assert pairs["measure"] == ["success_rate", "time_s", "roll_deg", "pitch_deg"] and pairs["mean"] == [
        0.25,
        -2.5,
        0.0,
        None,
    ]
    assert pairs["p_adjusted"] == [0.0004, 0.5, None, None] and pairs["only_second"] == [4] * 4
    assert pairs["verdict"] == ["better", "too_few_worlds", None, None] and pairs["worlds_needed"][1] == 6
    assert comparison.ranking_frame("dict")["ties"] == ["a <b>", "c"]
    page = comparison._repr_html_()
    assert "<p>c does &lt;most&gt;.</p>" in page
    assert "a &lt;b&gt;" in page and "<b>" not in page, "labels are text"
    for told in ("40.0 (10.0–90.0)", "25.0 (-10.0 to 50.0)", "&lt; 0.001", "1 / 4", "-2.5"):
        assert told in page, told


def test_frames_of_a_comparison_hold_numbers_where_all_is_missing(stand_in):
    pandas = pytest.importorskip("pandas", reason="pandas is not installed")
    stand_in(TOLD)
    frame = vertibench.compare("runs/a").runs_frame()
    assert frame.time_s_low.dtype == float and frame.time_s_low.isna().all() and isinstance(frame, pandas.DataFrame)


def test_a_program_without_statistics_is_told(stand_in):
    stand_in({"event": "report", "runs": ["a"], "files": []})
    with pytest.raises(vertibench.ProgramError, match=r"prints no statistics \(use a newer vb-harness\)"):
        vertibench.compare("runs/a")
    for other in ({"event": "statistics"}, TOLD | {"pairs": [PAIR | {"second": 7}]}, TOLD | {"runs": [1]}):
        stand_in(other)
        with pytest.raises(vertibench.ProgramError, match="statistics in an unknown format"):
            vertibench.compare("runs/a")
    with pytest.raises(vertibench.VertibenchError, match=r"list is no run .*compare\(a, b\)"):
        vertibench.compare(["a", "b"])
    with pytest.raises(vertibench.VertibenchError, match="no run is given"):
        vertibench.compare()


def test_runs_of_different_suites_are_refused(driven, tmp_path):
    other = vertibench.run("pid.wasm", suite="vb-100", tasks="w001/t00", out=tmp_path / "other", progress=False)
    runs = [driven / "slow", other]
    for kind, do in (
        (vertibench.InputError, lambda: vertibench.compare(*runs)),
        (vertibench.RunError, lambda: vertibench.show(runs, "w001/t00", replay=False)),
    ):
        with pytest.raises(kind, match="of different suites|suite differs") as caught:
            do()
        assert "smoke" in str(caught.value) and "vb-100" in str(caught.value) and "\n" not in str(caught.value)
    with pytest.raises(vertibench.InputError, match="run.json is missing"):
        vertibench.compare(tmp_path)
    with pytest.raises(vertibench.UsageError, match="given twice"):
        vertibench.compare(other, other)


def test_the_programs_own_statistics_are_those_of_the_summaries(driven):
    runs = [vertibench.Run(driven / name) for name in ("slow", "fast")]
    try:
        comparison = vertibench.compare(*runs)
    except vertibench.ProgramError as e:
        if "prints no statistics" not in str(e):
            raise
        pytest.skip("this vb-harness prints no statistics")
    for run, of in zip(runs, comparison.runs):
        summary = run.summary()
        assert of.all.success_rate == summary.success_rate and of.all.tasks == summary.tasks
        assert of.all.roll_deg.mean == pytest.approx(summary["all"]["roll_mean_deg"])
        assert {k: n for k, n in of.all.outcomes.items() if n} == {k: n for k, n in summary.outcomes.items() if n}
        for split in ("elevation", "terrain", "density"):
            assert {l: f.tasks for l, f in of.splits[split].items() if f.tasks} == {
                l: f["tasks"] for l, f in summary[split].items()
            }
    assert "speed 5" in comparison.runs[1].label
    (pair,) = comparison.pairs
    rates = [r.all.success_rate.mean for r in comparison.runs]
    assert pair.common == 4 and pair.success_rate.mean == pytest.approx(rates[1] - rates[0])
    assert pair.success_rate.low <= pair.success_rate.mean <= pair.success_rate.high
