"""The same files in the hands of others: pandas, Hugging Face's datasets, Minari."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from vertibench import datasets


def test_pandas_reads_the_files_as_they_are(explored):
    pandas = pytest.importorskip("pandas", reason="pandas is not installed")
    dataset = datasets.open(explored)
    frames = pandas.concat(pandas.read_parquet(f) for f in sorted(explored.glob("data/*/*.parquet")))
    own = np.concatenate([f["observation.state"] for f in dataset])
    assert np.array_equal(np.stack(frames["observation.state"]), own)
    episodes = pandas.read_parquet(explored / "meta/episodes")
    assert episodes["outcome"].tolist() == [e.outcome for e in dataset.episodes]
    tasks = pandas.read_parquet(explored / "meta/tasks.parquet")
    assert tasks.index.name == "task" and tasks["task_index"].tolist() == list(range(len(tasks)))


def test_hugging_face_reads_the_folder_as_it_is(explored, tmp_path, monkeypatch):
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    hub = pytest.importorskip("datasets", reason="Hugging Face's datasets is not installed")
    loaded = hub.load_dataset(str(explored), split="train", cache_dir=str(tmp_path)).with_format("numpy")
    dataset = datasets.open(explored)
    assert len(loaded) == sum(e.length for e in dataset.episodes)
    first, last = dataset[0], dataset[-1]
    for name in dataset.columns:
        assert np.array_equal(loaded[0][name], first[name][0]) and np.array_equal(loaded[-1][name], last[name][-1]), name


@pytest.fixture
def minari(tmp_path, monkeypatch):
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    pytest.importorskip("h5py", reason="h5py is not installed")
    return pytest.importorskip("minari", reason="Minari is not installed")


def test_a_package_that_minari_lacks_is_named():
    from vertibench.datasets._minari import _missing

    # As Minari raises it: an error of its own without the name of a module.
    told = str(_missing(ImportError("h5py is not installed. Please install it using `pip install minari[hdf5]`")))
    assert "h5py is not installed" in told and "None" not in told
    assert "a package is not installed: minari (" in str(_missing(ModuleNotFoundError("No module named 'minari'", name="minari")))


def test_minari_gets_every_step(explored, minari):
    dataset = datasets.open(explored)
    datasets.to_minari(dataset, "vertibench/explored-v0", author="A. Driver", author_email="a@example.org")
    made = minari.load_dataset("vertibench/explored-v0")
    assert made.total_episodes == len(dataset) and made.total_steps == sum(e.length - 1 for e in dataset.episodes)
    metadata = made.storage.metadata
    assert metadata["author"] == {"A. Driver"} or metadata["author"] == "A. Driver"
    assert "CC-BY-4.0" in metadata["description"] and dataset.info.hash in metadata["description"]
    for own, frames, episode in zip(dataset.episodes, dataset, made.iterate_episodes()):
        steps = own.length - 1
        assert set(episode.observations) == {"state", "wheels", "height_crop", "class_crop", "friction_crop"}
        for name, values in episode.observations.items():
            assert np.array_equal(values, frames[f"observation.{name}"]) and values.dtype == frames[f"observation.{name}"].dtype
            assert made.observation_space[name].shape == values.shape[1:]
        assert episode.actions.shape == (steps, 4) and np.array_equal(episode.actions, frames["action"][:-1])
        assert made.action_space.contains(episode.actions[0])
        assert (episode.rewards == 0).all(), "exploration has no goal"
        assert not episode.terminations[:-1].any() and not episode.truncations[:-1].any()
        assert episode.terminations[-1] == (own.outcome != "timeout") and episode.truncations[-1] == (own.outcome == "timeout")
        assert np.array_equal(episode.infos["truth.wheels"], frames["truth.wheels"])
    assert len({e.outcome == "timeout" for e in dataset.episodes}) == 2, "both kinds of end are the point"
    spec = made.env_spec
    assert spec.id == "VertiBench/Navigation-v0" and spec.kwargs["vehicle"] == "hmmwv" and spec.kwargs["action"] == "pedals"


def test_minari_rewards_the_goal(explored, minari, monkeypatch):
    import dataclasses

    dataset = datasets.open(explored)
    outcomes = ["success", "timeout", "planner_error", "rollover"]
    dataset.episodes = tuple(dataclasses.replace(e, outcome=o) for e, o in zip(dataset.episodes, outcomes))
    ends = []
    for episode in datasets.to_minari(dataset, "ends-v0").iterate_episodes():
        assert (episode.rewards[:-1] == 0).all()
        ends.append((episode.rewards[-1], episode.terminations[-1], episode.truncations[-1]))
    assert ends == [(1, True, False), (0, False, True), (0, False, True), (0, True, False)]
    monkeypatch.setattr(dataset, "info", dataclasses.replace(dataset.info, of_a_suite=True))
    with pytest.raises(datasets.DatasetError, match="must not be used for training"):
        datasets.to_minari(dataset, "suite-v0")


def test_the_command_converts(explored, minari, tmp_path):
    def run(*arguments):
        path = os.pathsep.join([str(Path(datasets.__file__).parents[2]), os.environ.get("PYTHONPATH", "")])
        command = [sys.executable, "-B", "-m", "vertibench.datasets", *arguments]
        return subprocess.run(
            command, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, check=False
        )

    done = run("to-minari", str(explored), "explored-v1")
    steps = sum(e.length - 1 for e in datasets.open(explored).episodes)
    assert (done.returncode, done.stdout) == (0, f"explored-v1: 18 episodes, {steps} steps\n"), done.stderr
    assert minari.load_dataset("explored-v1").total_episodes == 18
    for arguments, told in [
        (("to-minari", str(tmp_path / "none"), "x-v0"), "no such folder"),
        (("to-minari", str(explored), "explored-v1"), "explored-v1"),
        (("to-minari", str(explored), "no version"), "no version"),
        (("to-minari", str(explored), "badid"), "'badid' is not a valid dataset name"),
    ]:
        before = sorted(tmp_path.rglob("*"))
        failed = run(*arguments)
        assert failed.returncode == 3 and failed.stderr.startswith("error: ") and told in failed.stderr, failed.stderr
        assert failed.stderr.count("\n") == 1, failed.stderr
        assert sorted(tmp_path.rglob("*")) == before, "nothing is left half made"


def test_what_minari_can_not_finish_is_removed(explored, minari, tmp_path, monkeypatch):
    dataset = datasets.open(explored)
    monkeypatch.setattr(dataset, "_places", dataset._places[:3])
    with pytest.raises(IndexError):
        datasets.to_minari(dataset, "own/half-v0")
    assert not list(tmp_path.iterdir())
    with pytest.raises(datasets.DatasetError, match="is not a valid dataset name"):
        datasets.to_minari(dataset, 5)
