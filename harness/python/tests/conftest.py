"""Datasets and runs that the built harness makes for the tests."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import vertibench

ROOT = Path(__file__).parents[3]


def _found(find) -> Path:
    """What the package finds: in itself where it is installed, else what was built in the checkout."""
    try:
        return find()
    except vertibench.MissingError as e:
        pytest.skip(f"not installed, and not built: {e}")


def _harness() -> Path:
    return _found(vertibench.harness_path)


@pytest.fixture(scope="session")
def harness(tmp_path_factory):
    """Runs the harness in a folder of its own."""
    folder = tmp_path_factory.mktemp("harness")
    environment = {"VB_TASKS": str(ROOT / "tasks"), **os.environ}

    def run(*arguments: str) -> Path:
        command = [str(_harness()), *arguments]
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return folder

    return run


@pytest.fixture(scope="session")
def explored(harness):
    """Eighteen episodes in three worlds, with crops so large that a data file has two episodes."""
    arguments = ["--worlds", "3", "--episodes", "18", "--seed", "2", "--crops", "64", "--out", "explored"]
    return harness("dataset", "explore", *arguments) / "explored"


@pytest.fixture(scope="session")
def small(harness):
    """A sixth of the size, without the truth being told to the driver."""
    arguments = ["--worlds", "1", "--episodes", "2", "--scale", "1/6", "--crops", "8", "--out", "small"]
    return harness("dataset", "explore", "--perception", "degraded", *arguments) / "small"


@pytest.fixture(scope="session")
def program():
    """The harness and its planners where `vertibench` looks for them."""
    plugins = _found(lambda: vertibench.plugin_path("pid.wasm")).parent
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("VB_HARNESS", str(_harness()))
        patch.setenv("VB_TASKS", os.environ.get("VB_TASKS", str(ROOT / "tasks")))
        patch.setenv("VB_PLUGINS", str(plugins))
        yield


TASKS = ["w001/t00", "w003/t00-t01", "w008/t04"]


@pytest.fixture(scope="session")
def driven(program, tmp_path_factory):
    """A run of PID at 3 m/s over four tasks in three worlds, and the same at 5 m/s."""
    folder = tmp_path_factory.mktemp("runs")
    for name, params in (("slow", {"speed": 3}), ("fast", {"speed": 5})):
        vertibench.run("pid.wasm", suite="smoke", tasks=TASKS, out=folder / name, params=params, progress=False)
    return folder


@pytest.fixture
def stand_in(tmp_path, monkeypatch):
    """Makes a program that stands in for the harness: it tells these lines, and ends with this code."""

    def make(*told: object, code: int = 0, said: str = "") -> Path:
        lines = "".join((t if isinstance(t, str) else json.dumps(t)) + "\n" for t in told)
        file = tmp_path / "stand-in"
        text = f"#!{sys.executable}\nimport sys\nsys.stdout.write({lines!r})\nsys.stderr.write({said!r})\nsys.exit({code})\n"
        file.write_text(text)
        file.chmod(0o755)
        monkeypatch.setenv("VB_HARNESS", str(file))
        return file

    return make


@pytest.fixture(scope="session")
def native():
    """The compiled module; skipped without it."""
    try:
        import vertibench._native
    except ImportError:
        pytest.skip("the native module is not installed (pip install the wheel)")
    return vertibench._native


@pytest.fixture(scope="session")
def envs(native):
    """The package's environments; skipped without the native module, or gymnasium."""
    pytest.importorskip("gymnasium", reason="gymnasium is not installed")
    import vertibench.envs

    return vertibench.envs


def pursue(path, speed=0.0):
    """The policy of examples/policy: steers to the third point of the path."""
    forward, left = float(path[2, 0]), float(path[2, 1])
    return [min(max(1.5 * left / max(abs(forward), 1.0), -1.0), 1.0), speed]
