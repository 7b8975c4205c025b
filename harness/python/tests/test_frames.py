"""Results, summaries and trajectories are what is in the files, in every kind of frame."""

import csv
import json
import sys

import numpy as np
import pyarrow.parquet as pq
import pytest

import vertibench

OF_THE_RUN = ["planner", "planner_version", "suite", "vehicle", "perception", "rules", "scale", "seed"]


def test_results_are_the_table_that_the_report_writes(native, driven, harness, tmp_path):
    harness("report", str(driven / "slow"), "--csv", str(tmp_path / "t.csv"))
    with (tmp_path / "t.csv").open(newline="") as file:
        rows = sorted(csv.DictReader(file), key=lambda r: r["task"])
    table = vertibench.results(driven / "slow", "dict")
    names = [name for name in rows[0] if name != "run"]
    assert list(table) == names + OF_THE_RUN
    for name in names:
        for own, row in zip(table[name], rows, strict=True):
            if own is None:
                assert row[name] == "", name
            else:
                assert (own == row[name]) if isinstance(own, str) else (own == float(row[name])), name
    assert table["planner"] == ["pid"] * 4 and table["seed"] == [0] * 4 and table["scale"] == [1.0] * 4
    assert table["fault"] == [None] * 4 and "success" in table["outcome"] and len(set(table["outcome"])) > 1


def test_every_kind_of_frame_has_the_same(native, driven):
    pandas, polars = pytest.importorskip("pandas", reason="pandas is not installed"), pytest.importorskip("polars", reason="polars is not installed")
    run = vertibench.Run(driven / "slow")
    table = run.results("dict")
    frame, arrow, of_polars = run.results(), run.results("arrow"), run.results("polars")
    assert isinstance(frame, pandas.DataFrame) and isinstance(of_polars, polars.DataFrame)
    assert arrow.to_pydict() == of_polars.to_dict(as_series=False) == table
    assert list(frame.columns) == list(table)
    for name, values in table.items():
        assert [None if pandas.isna(v) else v for v in frame[name]] == values, name
    assert frame.attrs["run"] == run.header == json.loads(arrow.schema.metadata[b"vertibench:run"])
    assert (frame.time_s.dtype, frame.sim_steps.dtype) == (np.float64, np.int64)
    assert arrow.schema.field("roll_mean_deg").metadata[b"description"].startswith(b"Mean of |roll|")


def test_what_is_missing_is_missing_and_whole_numbers_stay_whole(native, driven, tmp_path):
    pandas = pytest.importorskip("pandas", reason="pandas is not installed")
    import shutil

    shutil.copytree(driven / "slow", tmp_path / "r")
    (tmp_path / "r/checksums.txt").unlink()
    records = vertibench.Run(tmp_path / "r").records()
    records[0] |= {"metrics": None, "fuel": None, "fault": "planner/trap"}
    records[1]["fuel"]["total"] = 2**60 + 1
    (tmp_path / "r/tasks.jsonl").write_text("".join(json.dumps(r) + "\n" for r in records))
    frame = vertibench.results(tmp_path / "r")
    assert frame.fault.tolist()[0] == "planner/trap" and frame.fault.isna().tolist() == [False, True, True, True]
    assert frame.roll_mean_deg.isna().tolist() == frame.fuel_total.isna().tolist() == [True, False, False, False]
    assert frame.fuel_total[1] == 2**60 + 1 and isinstance(frame.fuel_total.dtype, pandas.Int64Dtype)


def test_packages_that_are_missing_are_named(native, driven, monkeypatch):
    for package in ("pandas", "polars"):
        monkeypatch.setitem(sys.modules, package, None)
        with pytest.raises(vertibench.MissingPackageError) as caught:
            vertibench.results(driven / "slow", package)
        message = str(caught.value)
        assert (
            f"pip install {package})" in message
            and "\n" not in message
            and isinstance(caught.value, ImportError)
        )
    with pytest.raises(vertibench.VertibenchError, match="give one of pandas, polars, arrow, dict"):
        vertibench.results(driven / "slow", "excel")
    assert len(vertibench.results(driven / "slow", "arrow")) == 4, "nothing more is needed"


def test_without_the_native_module_its_absence_is_reported(driven, monkeypatch):
    monkeypatch.setitem(sys.modules, "vertibench._native", None)
    with pytest.raises(vertibench.MissingError, match=r"^vertibench.results: .*\(install the wheel \(docs/python.md\)\)$"):
        vertibench.results(driven / "slow")


def test_a_trace_is_the_file_of_its_task(driven):
    run = vertibench.Run(driven / "slow")
    table = pq.read_table(driven / "slow/traces/w003/t00.parquet")
    trace = run.trace("w003/t00")
    assert list(trace) == table.column_names and len(trace) == len(table.column_names)
    for name, values in trace.items():
        assert values.dtype == np.float64 and values.shape == (len(table),)
        assert np.array_equal(values, table[name].to_numpy())
    assert trace.meta == json.loads(table.schema.metadata[b"vertibench:trace"])
    assert (trace.task, trace.run, len(trace.start), len(trace.goal)) == ("w003/t00", run, 3, 2)
    assert trace["time"][-1] == run.record("w003/t00")["time_s"]
    assert vertibench.trace(run, "w003/t00", "dict") == table.to_pydict()
    pandas = pytest.importorskip("pandas", reason="pandas is not installed")
    frame = trace.frame()
    assert isinstance(frame, pandas.DataFrame) and frame.attrs["trace"] == trace.meta and len(frame) == len(table)
    with pytest.raises(KeyError, match="no column speed"):
        trace["speed"]


def test_a_run_without_traces_says_so(program, tmp_path):
    run = vertibench.run("pid.wasm", suite="smoke", tasks="w001/t00", trace="none", out=tmp_path / "r", progress=False)
    for look in (run.trace, run.show):
        with pytest.raises(vertibench.RunError, match=r"stored no trajectories \(run it again with trace='10hz'\)"):
            look("w001/t00")
    for look in (run.trace, run.show):
        with pytest.raises(
            vertibench.RunError,
            match=r"no task w001/t01 among its 1 finished tasks \(give one of them, e.g. w001/t00\)",
        ):
            look("w001/t01")


def test_the_summary_is_the_file(driven):
    run = vertibench.Run(driven / "slow")
    content = json.loads((driven / "slow/summary.json").read_text())
    summary = run.summary()
    assert dict(summary) == content and len(summary) == len(content)
    everything = content["all"]
    rate = summary.success_rate
    assert (rate.mean, rate.low, rate.high) == tuple(everything[f"success_{k}"] for k in ("rate", "low", "high"))
    assert rate.low < rate.mean < rate.high and summary.tasks == 4 and summary.outcomes == everything["outcomes"]
    rows = summary.frame("dict")
    by_level = dict(zip(zip(rows["split"], rows["level"]), rows["time_mean_s"]))
    assert by_level["all", "all"] == everything["time_mean_s"]
    for split in ("elevation", "terrain", "density", "world"):
        for level, figures in content[split].items():
            assert by_level[split, level] == figures["time_mean_s"]
    assert rows["outcome_stuck"][0] == everything["outcomes"]["stuck"]
    assert (
        rows["fuel_total"][0] == everything["fuel"]["total"]
        and rows["three_way_success"][0] == everything["three_way"]["success"]
    )
    page = summary._repr_html_()
    assert f"{100 * rate.mean:.1f} ({100 * rate.low:.1f}–{100 * rate.high:.1f})" in page and page.count(
        "<tr>"
    ) == 1 + len([s for s in rows["split"] if s != "world"])


def test_estimates_are_written_with_their_interval():
    rate = vertibench.Estimate(0.377, 0.302, 0.459)
    assert f"{rate:.1%}" == "37.7% (30.2%–45.9%)" and str(rate) == "0.377 (0.302–0.459)"
    assert f"{vertibench.Estimate(-0.02, -0.091, 0.05):.2f}" == "-0.02 (-0.09 to 0.05)", (
        "a minus after a dash can't be read"
    )
    assert f"{vertibench.Estimate(0.5, None, None):.0%}" == "50%", "tasks of one world have no interval"
