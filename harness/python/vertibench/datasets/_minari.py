"""Conversion to Minari datasets, for offline reinforcement learning (minari.farama.org)."""

from __future__ import annotations

import copy
import inspect
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np

from ._dataset import Dataset, Episode
from ._errors import DatasetError

#: Bounds of the entries of `action`: steering, throttle, brake, gear.
_LOW, _HIGH = np.array([-1, 0, 0, -1], np.float32), np.array([1, 1, 1, 1], np.float32)
#: Outcomes that terminate an episode; all others truncate it.
_ENDS = ("success", "rollover", "stuck", "out_of_bounds")
#: Valid names in Minari's storage.
_NAME = re.compile(r"([-_a-zA-Z0-9]+/)*[-_a-zA-Z0-9]+-v[0-9]+")


def to_minari(
    dataset: Dataset, dataset_id: str, *, author: str | None = None, author_email: str | None = None, **more: Any
) -> Any:
    """Writes a dataset into Minari's local storage, from which `minari.load_dataset(dataset_id)` loads it.

    - Observation: dictionary of the columns `observation.*`, without this prefix.
    - Steps: a step goes from one frame to the next, so an episode of n frames has n observations and n − 1 steps.
      Episodes with one frame are skipped.
    - Action: the command within its range, which is what the vehicle receives.
    - Reward: 1 for the step that ends at the goal, otherwise 0.
    - End: `success`, `rollover`, `stuck` and `out_of_bounds` terminate an episode; all other outcomes truncate it.
    - Infos: the columns `truth.*` and `action.applied` of the frame at the start of a step; the last entry is of the
      last frame.

    Licence and origin are in the description.

    Args:
        dataset: Dataset to convert.
        dataset_id: Name in the storage, with a version, e.g. `"vertibench/explore-v0"`.
        author: Name of the author. None (default): `"Verti-Bench"`.
        author_email: Address of the author. None (default): no address.
        **more: Further arguments of `minari.create_dataset_from_buffers`.

    Returns:
        The `minari.MinariDataset`.

    Raises:
        DatasetError: If the name is invalid or exists already, a package is missing, a file is damaged, or the dataset
            must not be used for training. An incomplete result is removed.
    """
    if not isinstance(dataset_id, str) or not _NAME.fullmatch(dataset_id):
        raise DatasetError("to_minari", f"{dataset_id!r} is not a valid dataset name", "give one such as vertibench/explore-v0")
    try:
        import gymnasium
        import minari
        from minari.data_collector import EpisodeBuffer
        from minari.storage.datasets_root_dir import get_dataset_path
    except ImportError as e:
        raise _missing(e) from None
    if dataset.info.of_a_suite:
        raise DatasetError(
            dataset.folder, "its worlds belong to a benchmark suite, which must not be used for training", "use another dataset"
        )
    parts = [c for c in dataset.columns.values() if c.name.startswith("observation.")]
    spaces = {}
    for c in parts:
        low, high = (0, 255) if c.dtype == np.uint8 else (-np.inf, np.inf)
        spaces[c.name.removeprefix("observation.")] = gymnasium.spaces.Box(low, high, c.shape, c.dtype)
    told = [name for name in dataset.columns if name.startswith("truth.") or name == "action.applied"]
    names = [c.name for c in parts] + ["action"] + told
    info = dataset.info
    # Created one by one, so that only one data file is in memory.
    buffers = (
        _buffer(EpisodeBuffer, episode, dataset.frames(k, names), [c.name for c in parts], told)
        for k, episode in enumerate(dataset.episodes)
        if episode.length > 1
    )
    drivers = sorted({e.driver for e in dataset.episodes})
    settings = {
        "algorithm_name": ", ".join(drivers),
        "author": author or "Verti-Bench",
        "author_email": author_email,
        "description": f"{info.name}: driving over rough ground in simulation by {', '.join(drivers)}; vehicle "
        f"{info.vehicle}, {info.hz} Hz. Licence: {info.licence}. Made by vb-harness {info.harness_version}; hash {info.hash}.",
        # Lossless: images would become JPEG.
        "jpeg_encoding": False,
        **more,
    }
    make = minari.create_dataset_from_buffers
    if "jpeg_encoding" not in inspect.signature(make).parameters:
        settings.pop("jpeg_encoding")
    settings.setdefault("env", _environment(dataset))
    observations = gymnasium.spaces.Dict(spaces)
    actions = gymnasium.spaces.Box(_LOW, _HIGH, dtype=np.float32)
    path = Path(get_dataset_path(dataset_id))
    if path.exists():
        raise DatasetError(path, "a dataset with this name exists already", "give another name or version, or delete it")
    # The outermost folder that the call creates.
    begun = path
    while not begun.parent.exists():
        begun = begun.parent
    try:
        return make(dataset_id, buffers, observation_space=observations, action_space=actions, **settings)
    except BaseException as e:
        shutil.rmtree(begun, ignore_errors=True)
        if isinstance(e, ImportError):
            raise _missing(e) from None
        raise


def _environment(dataset: Dataset) -> Any:
    """Returns a stand-in for the environment over the dataset's worlds, from which Minari's `recover_environment` creates
    it.

    It has the specification only and loads nothing. The worlds are those in the dataset's present folder.
    """
    import gymnasium

    from ..registration import NAME, register

    register()
    info = dataset.info
    options = {
        "suite": str((dataset.folder / "suite").resolve()),
        "vehicle": info.vehicle,
        "soils": info.soils,
        "perception": info.perception,
        "scale": info.scale,
        "time_step": info.header["time_step"],
        "control_hz": float(info.hz),
        "action": "pedals",
    }
    named = gymnasium.Env()
    named.spec = copy.deepcopy(gymnasium.spec(NAME))
    named.spec.kwargs = options
    return named


def _missing(e: ImportError) -> DatasetError:
    # If h5py is missing, Minari raises errors without a name.
    what = e.name or str(e)
    return DatasetError("to_minari", f"a package is not installed: {what}", "pip install 'verti-bench[minari]'")


def _buffer(kind: Any, episode: Episode, frames: dict[str, np.ndarray], seen: list[str], told: list[str]) -> Any:
    steps = episode.length - 1
    last = np.arange(steps) == steps - 1
    ends = episode.outcome in _ENDS
    return kind(
        id=episode.index,
        observations={name.removeprefix("observation."): frames[name] for name in seen},
        actions=np.clip(frames["action"][:-1], _LOW, _HIGH),
        rewards=np.where(last & (episode.outcome == "success"), 1.0, 0.0),
        terminations=last & ends,
        truncations=last & (not ends),
        infos={name: frames[name] for name in told},
    )
