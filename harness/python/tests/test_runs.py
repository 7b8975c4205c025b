"""A run started from Python is the run that the program makes, and what goes wrong has a type and the program's words."""

import importlib.util
import json
import os
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path

import pytest

import vertibench
from vertibench._program import plugin_path


def test_it_is_the_run_of_the_command_line(driven, harness, tmp_path):
    for name, more in (("slow", ["--param", "speed=3"]), ("fast", ["--param", "speed=5"])):
        run = vertibench.Run(driven / name)
        plugin = plugin_path("pid.wasm")
        out = tmp_path / name
        harness(
            "--plugin",
            plugin,
            "--suite",
            "smoke",
            "--tasks",
            "w001/t00,w003/t00-t01,w008/t04",
            "--out",
            str(out),
            *more,
        )
        by_hand = vertibench.Run(out)
        assert run.records() == by_hand.records() and len(run.tasks) == 4
        for field in ("suite", "plugin", "params", "vehicle", "seed", "selector"):
            assert run.header[field] == by_hand.header[field], field
    hashes = [[r["state_hash"] for r in vertibench.Run(driven / n).records()] for n in ("slow", "fast")]
    assert hashes[0] != hashes[1], "parameters reach the planner"


def test_options_reach_the_program(program, tmp_path):
    run = vertibench.run(
        "pid.wasm", suite="smoke", tasks="w001/t00", vehicle="verti4wheeler", perception="onboard", rules="dev",
        soils="wong", scale="1/6", seed=7, trace="none", logs="all", jobs=1, out=tmp_path / "r", progress=False,
    )  # fmt: skip
    header = run.header
    names = {k: header[k]["name"] for k in ("vehicle", "perception", "rules", "soils")}
    assert names == {"vehicle": "verti4wheeler", "perception": "onboard", "rules": "dev", "soils": "wong"}
    assert (header["seed"], header["trace"], header["logs"]) == (7, "none", "all")
    assert header["scale"] == pytest.approx(1 / 6)


def test_progress_is_told_task_by_task(program, tmp_path, capsys):
    seen = []
    run = vertibench.run("pid.wasm", suite="smoke", tasks="w001/t00-t02", out=tmp_path / "r", progress=seen.append)
    assert [(p.done, p.total) for p in seen] == [(0, 3), (1, 3), (2, 3), (3, 3)] and seen[0].record is None
    assert sorted((p.record for p in seen[1:]), key=lambda r: r["task"]) == run.records()
    assert seen[-1].outcomes == {name: n for name, n in run.summary().outcomes.items() if n}
    assert capsys.readouterr() == ("", "")
    vertibench.run("pid.wasm", suite="smoke", tasks="w001/t00", out=tmp_path / "s", progress=True)
    told = capsys.readouterr()
    assert told.err.split("\r")[-1].rstrip() == "1 of 1 tasks: 1 success" and told.out == ""


def test_errors_have_the_programs_words_and_code(program, tmp_path):
    (tmp_path / "full").mkdir()
    (tmp_path / "full/file").touch()
    cases = [
        (vertibench.UsageError, 2, {"params": {"sped": 5}}, "--param sped: the planner `pid` has no such parameter"),
        (vertibench.UsageError, 2, {"tasks": "w099"}, "w099"),
        (vertibench.UsageError, 2, {"trace": "20hz"}, "20hz"),
        (vertibench.UsageError, 2, {"tasks": 5}, "tasks: 5 must be a selector"),
        (vertibench.UsageError, 2, {"tasks": [1]}, "tasks: [1] must be a selector"),
        (vertibench.UsageError, 2, {"params": 5}, "params=5: not a dictionary"),
        (vertibench.InputError, 3, {"suite": "none"}, "there is no suite none"),
        (vertibench.InputError, 3, {"vehicle": "none"}, "there is no vehicle none"),
        (vertibench.OutputError, 4, {"out": tmp_path / "full"}, "is not empty"),
    ]
    for kind, code, options, told in cases:
        with pytest.raises(kind) as caught:
            vertibench.run("pid.wasm", **{"suite": "smoke", "tasks": "w001/t00", "out": tmp_path / "r"} | options)
        message = str(caught.value)
        assert caught.value.code == code and told in message and "\n" not in message, message
        assert not message.startswith("error") and isinstance(caught.value, vertibench.VertibenchError)
    with pytest.raises(vertibench.UsageError, match="plugin=5: not a planner"):
        vertibench.run(5)
    with pytest.raises(vertibench.InputError, match="none.wasm"):
        vertibench.run("none.wasm", suite="smoke")


@pytest.mark.parametrize(
    ("code", "kind"),
    [(1, "InternalError"), (2, "UsageError"), (3, "InputError"), (4, "OutputError"), (7, "HostError"), (10, "FailedStartError"),
     (130, "StoppedError"), (9, "ProgramError")],
)  # fmt: skip
def test_every_code_has_its_error(code, kind, stand_in, driven):
    finished = {"event": "finished", "out": str(driven / "slow")}
    stand_in(finished, code=code, said="a hint\nerror: what, where (what to do)\n")
    with pytest.raises(vertibench.ProgramError) as caught:
        vertibench.run("pid.wasm")
    error = caught.value
    assert type(error).__name__ == kind and (error.code, str(error)) == (code, "what, where (what to do)")
    assert (error.run is not None) == (code in (7, 10, 130)), "the tasks that were done"
    stand_in(code=code)
    with pytest.raises(vertibench.ProgramError, match=f"ended with exit code {code} without a message"):
        vertibench.run("pid.wasm")


def test_what_is_completed_with_a_warning_is_a_run(stand_in, driven):
    finished = {"event": "finished", "out": str(driven / "slow")}
    stand_in(finished, code=5, said="warning: not confined\nerror: the simulation of 2 tasks failed\n")
    with pytest.warns(UserWarning) as told:
        run = vertibench.run("pid.wasm")
    assert len(run.tasks) == 4 and [str(w.message) for w in told] == [
        "warning: not confined",
        "the simulation of 2 tasks failed",
    ]
    assert all(w.filename == __file__ for w in told), "the line of the caller is named"


def test_what_is_no_harness_is_refused(stand_in, tmp_path, monkeypatch):
    for told, what in (
        ("hello", "`hello` is not an event"),
        ([1], "is not an event"),
        ({"event": "x"}, "without the directory of the results"),
    ):
        stand_in(told)
        with pytest.raises(vertibench.ProgramError, match=what):
            vertibench.run("pid.wasm")
    monkeypatch.setenv("VB_HARNESS", str(tmp_path / "none"))
    with pytest.raises(vertibench.VertibenchError, match="the program is missing"):
        vertibench.run("pid.wasm")
    (tmp_path / "none").touch()
    with pytest.raises(vertibench.ProgramError, match="cannot be started"):
        vertibench.run("pid.wasm")


INTERRUPTED = """
import os, signal, sys, vertibench
# A shell starts what runs in its background with Ctrl-C ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
def watch(p):
    if p.done == 2:
        print("two", flush=True)
try:
    vertibench.run("pid.wasm", suite="vb-100", tasks="elevation=low", jobs=1, out=sys.argv[1], progress=watch)
except KeyboardInterrupt as e:
    print("interrupted:", e, flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_ctrl_c_stops_the_program_and_the_run_can_go_on(program, tmp_path):
    path = os.pathsep.join([str(Path(vertibench.__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    command = [sys.executable, "-B", "-c", INTERRUPTED, str(tmp_path / "r")]
    environment = {**os.environ, "PYTHONPATH": path}
    python = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True, start_new_session=True)
    assert python.stdout.readline() == "two\n"
    # A terminal sends it to the whole group.
    os.killpg(python.pid, signal.SIGINT)
    told, _ = python.communicate(timeout=600)
    assert told.startswith("interrupted: stopped, ") and "--resume" in told, told
    # The program is gone: nobody holds the run, which goes on where it was.
    done = vertibench.Run(tmp_path / "r").tasks
    assert 2 <= len(done) < 340
    seen = []

    def stop(progress):
        seen.append(progress.done)
        if progress.done == len(done) + 2:
            raise RuntimeError("enough")

    for again in range(2):
        with pytest.raises(RuntimeError, match="enough"):
            vertibench.run(
                "pid.wasm",
                suite="vb-100",
                tasks="elevation=low",
                jobs=1,
                out=tmp_path / "r",
                resume=True,
                progress=stop,
            )
        assert seen[0] >= len(done), "no task is run again"
        done = vertibench.Run(tmp_path / "r").tasks
        seen.clear()


def test_a_program_that_does_not_stop_is_ended(tmp_path, monkeypatch):
    file = tmp_path / "stubborn"
    file.write_text(
        f"#!{sys.executable}\nimport signal, time, os\nsignal.signal(signal.SIGINT, signal.SIG_IGN)\n"
        f'print(\'{{"event": "started", "total": 1, "resumed": 0}}\', flush=True)\nopen({str(tmp_path / "pid")!r}, "w").write(str(os.getpid()))\n'
        "time.sleep(60)\n"
    )
    file.chmod(0o755)
    monkeypatch.setenv("VB_HARNESS", str(file))
    monkeypatch.setattr("vertibench._runs.program._PATIENCE", 0.5)

    def fail(progress):
        while not (tmp_path / "pid").is_file():
            time.sleep(0.01)
        raise KeyboardInterrupt

    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        vertibench.run("pid.wasm", progress=fail)
    assert time.monotonic() - begin < 30
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text()), 0)


IMPORTED = """
import sys, vertibench
heavy = {"numpy", "pyarrow", "pandas", "polars", "IPython", "vertibench._runs"} & set(sys.modules)
assert not heavy, heavy
vertibench.Run
heavy = {"numpy", "pyarrow", "pandas", "polars", "IPython"} & set(sys.modules)
assert not heavy, heavy
"""


def test_import_is_light_and_names_are_found():
    path = os.pathsep.join([str(Path(vertibench.__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    subprocess.run([sys.executable, "-B", "-c", IMPORTED], env={**os.environ, "PYTHONPATH": path}, check=True)
    source = Path(vertibench.__file__).read_text()
    for name in vertibench.__all__:
        if name in ("envs", "gpu") and importlib.util.find_spec("vertibench._native") is None:
            with pytest.raises(vertibench.MissingError, match="compiled module can't be loaded: .*install the wheel"):
                getattr(vertibench, name)
            continue
        assert getattr(vertibench, name).__doc__, name
        assert name in dir(vertibench)
        assert f"import {name} as {name}\n" in source, f"type checkers don't see {name}"
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        vertibench.nothing


def test_hurt_runs_are_told_in_one_line(driven, native, tmp_path):
    import shutil

    def edit(name, old, new):
        def change(folder):
            content = (folder / name).read_bytes()
            assert old in content
            (folder / name).write_bytes(content.replace(old, new, 1))

        return change

    def cut(name, most):
        return lambda d: (d / name).write_bytes((d / name).read_bytes()[:most])

    trace = "traces/w001/t00.parquet"
    no_sums = lambda d: (d / "checksums.txt").unlink()  # noqa: E731
    cases = [
        ([lambda d: shutil.rmtree(d)], "there is no such folder"),
        ([lambda d: (d / "run.json").unlink()], "run.json is missing (give the directory of a run)"),
        ([edit("run.json", b'"schema": 3', b'"schema": 4')], "unsupported version 4 of the run format"),
        ([cut("run.json", 50)], "run.json: not JSON"),
        ([edit("run.json", b'"seed": 0', b'"seed": 1')], "run.json differs from its checksum"),
        ([edit("tasks.jsonl", b'"stuck"', b'"success"')], "differs from its checksum"),
        ([edit("tasks.jsonl", b"{", b"(")], "tasks.jsonl line 1: not JSON"),
        ([no_sums, edit("tasks.jsonl", b'"task"', b'"tusk"')], "not a record of a task"),
        ([no_sums, edit("tasks.jsonl", b'"time_s":', b'"time_s":"x","t":')], "time_s has the wrong type"),
        ([cut("checksums.txt", 20), lambda d: (d / "checksums.txt").open("a").write("\n")], "not a checksum"),
        ([lambda d: (d / trace).unlink()], "the trajectory is missing"),
        ([cut(trace, 5000)], f"{trace} differs from its checksum"),
        ([no_sums, cut(trace, 5000)], f"{trace}: not a Parquet file"),
        ([no_sums, edit(trace, b"vertibench:trace", b"vertibench:other")], f"{trace}: not a "),
        ([lambda d: (d / "summary.json").unlink()], "there is no summary yet (wait for the end of the run"),
        ([lambda d: (d / "summary.json").write_text("{}")], "not a summary of this version"),
    ]
    for k, (changes, told) in enumerate(cases):
        folder = tmp_path / str(k)
        shutil.copytree(driven / "slow", folder)
        for change in changes:
            change(folder)
        with pytest.raises(vertibench.RunError) as caught:
            run = vertibench.Run(folder)
            run.results("dict")
            run.trace("w001/t00")
            run.summary()
        message = str(caught.value)
        assert told in message and message.startswith(str(folder)) and message.endswith(")") and "\n" not in message, (
            message
        )


def test_a_run_that_goes_on_is_read_as_far_as_it_got(driven, native, tmp_path):
    import shutil

    shutil.copytree(driven / "slow", tmp_path / "r")
    file = tmp_path / "r/tasks.jsonl"
    content = file.read_bytes()
    first = content.index(b"\n") + 1
    file.write_bytes(content[: first + 30])
    assert vertibench.Run(tmp_path / "r").tasks == (json.loads(content[:first])["task"],)
    file.unlink()
    run = vertibench.Run(tmp_path / "r")
    assert run.tasks == () and run.results("dict")["task"] == []
    assert run.results("arrow").column_names == vertibench.results(driven / "slow", "arrow").column_names
    with pytest.raises(vertibench.RunError, match="no task w001/t00 among its 0 finished tasks"):
        run.record("w001/t00")


def test_no_warning_is_given_where_all_is_well(program, tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        vertibench.run("pid.wasm", suite="smoke", tasks="w001/t00", out=tmp_path / "r").show("w001/t00")
