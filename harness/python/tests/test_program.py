"""Where program, tasks and planners are found."""

import copy
import os
import pickle
import re
import subprocess
import sys
from pathlib import Path

import pytest
import vertibench
from vertibench import MissingError, __main__, _program, datasets, harness_path, plugin_path, plugins_path, tasks_path
from vertibench.training import TrainingError

ROOT = Path(__file__).parents[3]


@pytest.fixture(autouse=True)
def nothing_set(monkeypatch):
    for name in ("VB_HARNESS", "VB_TASKS", "VB_PLUGINS", "CARGO_TARGET_DIR"):
        monkeypatch.delenv(name, raising=False)


@pytest.fixture
def packaged(monkeypatch, tmp_path):
    """An installed package: its data are there, and no checkout is above it."""
    for name in ("bin/vb-harness", "tasks/smoke/suite.yaml", "plugins/pid.wasm", "plugins/ibex.wasm"):
        file = tmp_path / "_data" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("#!/bin/sh\necho $VB_TASKS $VB_PLUGINS $*\nexit 7\n")
        file.chmod(0o755)
    monkeypatch.setattr(_program, "_DATA", tmp_path / "_data")
    monkeypatch.setattr(_program, "_CHECKOUT", tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path / "_data"


def test_an_installed_package_has_everything(packaged):
    assert harness_path() == packaged / "bin/vb-harness"
    assert tasks_path() == packaged / "tasks"
    assert plugins_path() == packaged / "plugins"
    assert plugin_path("pid.wasm") == packaged / "plugins/pid.wasm"


def test_what_the_user_names_comes_first(packaged, monkeypatch, tmp_path):
    for variable, find in (("VB_HARNESS", harness_path), ("VB_TASKS", tasks_path), ("VB_PLUGINS", plugins_path)):
        monkeypatch.setenv(variable, str(tmp_path))
        assert find() == tmp_path
        monkeypatch.setenv(variable, str(tmp_path / "gone"))
        with pytest.raises(MissingError, match=f"gone: .* is missing \\({variable} names it"):
            find()
        monkeypatch.delenv(variable)


def test_a_checkout_has_what_is_built_in_it(monkeypatch, tmp_path):
    # Also where the tested package is an installed one.
    monkeypatch.setattr(_program, "_DATA", tmp_path / "_data")
    monkeypatch.setattr(_program, "_CHECKOUT", ROOT)
    monkeypatch.setenv("CARGO_TARGET_DIR", str(tmp_path))
    assert tasks_path() == ROOT / "tasks"
    with pytest.raises(MissingError, match="run `cargo build --release -p vb-harness`"):
        harness_path()
    with pytest.raises(MissingError, match="run `cargo xtask plugins`"):
        plugins_path()
    (tmp_path / "plugins").mkdir()
    assert plugins_path() == tmp_path / "plugins"


def test_nothing_of_a_checkout_is_taken_for_a_package_that_lacks_something(packaged, monkeypatch, tmp_path):
    monkeypatch.setenv("CARGO_TARGET_DIR", str(tmp_path))
    (packaged / "bin/vb-harness").unlink()
    (tmp_path / "release").mkdir()
    (tmp_path / "release/vb-harness").touch()
    with pytest.raises(MissingError, match="install a wheel of `cargo xtask wheel`, or set VB_HARNESS"):
        harness_path()


def test_a_planner_is_a_file_or_the_name_of_one_in_the_folder_of_planners(packaged):
    Path("mine.wasm").touch()
    assert plugin_path("mine.wasm") == Path("mine.wasm")
    assert plugin_path(packaged / "plugins/ibex.wasm") == packaged / "plugins/ibex.wasm"
    with pytest.raises(MissingError, match="its planners: ibex.wasm, pid.wasm"):
        plugin_path("gone.wasm")
    with pytest.raises(MissingError, match="planners/pid.wasm: no such planner"):
        plugin_path("planners/pid.wasm")


def test_every_error_is_one_line_and_of_one_kind():
    assert issubclass(MissingError, vertibench.VertibenchError)
    assert issubclass(datasets.DatasetError, vertibench.VertibenchError)
    assert str(vertibench.VertibenchError("a", "is\nbroken", "mend it")) == "a: is broken (mend it)"


def test_an_error_comes_whole_out_of_another_process():
    made = [
        vertibench.VertibenchError("a", "is broken", "mend it"),
        MissingError("a", "isn't there", "fetch it"),
        vertibench.MissingPackageError("polars", "frames"),
        vertibench.UnknownError("there is no task"),
        datasets.DatasetError("a", "is no dataset", "make one"),
        TrainingError("a", "is no run", "make one"),
        vertibench.UsageError("what, where (what to do)", 2, ["vb-harness", "run"]),
    ]
    for error in made:
        for again in (pickle.loads(pickle.dumps(error)), copy.copy(error)):
            assert type(again) is type(error) and str(again) == str(error) and vars(again) == vars(error)


def test_the_command_becomes_the_program_with_its_tasks_and_planners(packaged):
    code = (
        "import pathlib, sys; from vertibench import _program, __main__;"
        f"_program._DATA = pathlib.Path({str(packaged)!r});"
        "sys.argv[1:] = ['suite', 'list']; sys.exit(__main__.main())"
    )
    clean = {name: value for name, value in os.environ.items() if not name.startswith("VB_")}
    environment = {**clean, "PYTHONPATH": str(ROOT / "harness/python"), "VB_TASKS": "/mine"}
    command = [sys.executable, "-B", "-c", code]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 7, done.stderr
    assert done.stdout == f"/mine {packaged}/plugins suite list\n"


def test_a_program_that_is_missing_or_broken_is_told_in_one_line(packaged, monkeypatch, capsys):
    (packaged / "bin/vb-harness").chmod(0o644)
    monkeypatch.setattr(sys, "argv", ["vertibench"])
    assert __main__.main() == 3
    (packaged / "bin/vb-harness").unlink()
    assert __main__.main() == 3
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 2 and all(re.match("error: .*vb-harness: .*(.*VB_HARNESS.*)$", line) for line in lines), lines
