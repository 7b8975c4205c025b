"""Datasets that the built harness makes for the tests."""

import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]


def _harness() -> Path:
    path = Path(os.environ.get("VB_HARNESS", ROOT / "target/release/vb-harness"))
    if not path.is_file():
        pytest.skip(f"{path} is not built (cargo build --release -p vb-harness, or set VB_HARNESS)")
    return path


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
    arguments = ["--worlds", "3", "--episodes", "18", "--seed", "5", "--crops", "64", "--out", "explored"]
    return harness("dataset", "explore", *arguments) / "explored"


@pytest.fixture(scope="session")
def small(harness):
    """A sixth of the size, without the truth being told to the driver."""
    arguments = ["--worlds", "1", "--episodes", "2", "--scale", "1/6", "--crops", "8", "--out", "small"]
    return harness("dataset", "explore", "--perception", "degraded", *arguments) / "small"
