"""The tutorial does what it says."""

import json
import re
from pathlib import Path

import pytest

import vertibench

NOTEBOOK = Path(__file__).parents[3] / "examples/notebook/tutorial.ipynb"


@pytest.fixture
def notebook():
    nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed")
    return nbformat.read(NOTEBOOK, as_version=4)


def test_the_tutorial_is_kept_without_outputs(notebook):
    for cell in notebook.cells:
        assert cell.cell_type != "code" or (not cell.outputs and cell.execution_count is None), cell.source


def test_the_tutorial_runs(notebook, envs, driven, tmp_path, monkeypatch):
    nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed")
    pytest.importorskip("ipykernel", reason="ipykernel is not installed")
    pytest.importorskip("pandas", reason="pandas is not installed")
    monkeypatch.setenv("PYTHONPATH", str(Path(vertibench.__file__).parents[1]), prepend=":")
    # No kernel's settings of the user's own.
    for name in ("IPYTHONDIR", "JUPYTER_RUNTIME_DIR"):
        monkeypatch.setenv(name, str(tmp_path / name.lower()))
    # Raises if a cell errs.
    nbclient.NotebookClient(
        notebook, timeout=120, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}
    ).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    pages = [o["data"].get("text/html", "") for o in outputs if "data" in o]
    assert sum("<iframe" in p for p in pages) == 1 and sum("<svg" in p for p in pages) == 2
    texts = "".join(o.get("text", "") for o in outputs) + "".join(
        o["data"].get("text/plain", "") for o in outputs if "data" in o
    )
    records = [json.loads(line) for line in (tmp_path / "runs/pid-1/tasks.jsonl").read_text().splitlines()]
    successes = sum(record["outcome"] == "success" for record in records)
    assert "10 of 10 tasks" in texts and 0 < successes < 10
    assert re.search(rf"success {10 * successes}% \(\d+%–\d+%\) of 10 tasks", texts)
    assert "no task w099/t00 among its 10 finished tasks" in texts
    assert vertibench.Run(tmp_path / "runs/pid-1").of("suite", "name") == "smoke"
