"""Reading a dataset: what is said of it, its episodes, its frames."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, overload

import numpy as np

try:
    import pyarrow as pa
    import pyarrow.parquet as pq
except ImportError:
    # `open` says so: who wants environments only needs none.
    pa = pq = None

from ._errors import DatasetError
from ._world import World, read_world

#: The version of `dataset.json` that this package reads.
SCHEMA = 1
#: Endings of names, and their units.
_UNITS = {"_m_per_s": "m/s", "_rad_per_s": "rad/s", "_rad": "rad", "_m": "m", "_N": "N"}
#: Units of columns whose entries have no names.
_COLUMN_UNITS = {"observation.height_crop": "m", "timestamp": "s"}


@dataclass(frozen=True)
class Info:
    """What a dataset says of itself, in `dataset.json`."""

    name: str
    kind: str  #: `explore`, `drive`, `teleop`, `failures`, `merged` or `split`
    licence: str  #: as SPDX names it
    harness_version: str
    seed: int
    hz: int  #: frames a second
    vehicle: str
    perception: str  #: the perception profile
    rules: str
    soils: str
    scale: float  #: the factor on every length of the worlds
    of_a_suite: bool  #: whether planners are judged on its worlds: then nothing may be trained on it
    hash: str  #: SHA-256 of the file `SHA256SUMS`: the same for the same bytes
    header: dict[str, Any]  #: all of `dataset.json`


@dataclass(frozen=True)
class Episode:
    """What is said of an episode: a row of `meta/episodes`."""

    index: int  #: its number in the dataset on disk
    length: int  #: frames
    instruction: str  #: the task in words
    drive: int  #: the place among all drives of the command; those that weren't kept are missing
    driver: str
    world: str  #: name of its world, for `Dataset.world`
    world_hash: str
    task: str  #: e.g. `w003/t07`; empty for exploration
    elevation: str
    terrain: str
    density: str
    ground: str  #: kind of ground under the vehicle at the end
    outcome: str  #: `success`, `rollover`, `stuck`, `timeout`, `out_of_bounds`, …
    reason: str  #: why it ended, in words
    cause: str  #: of a rollover or of getting stuck, in datasets of failures
    time_s: float
    distance_m: float
    start: tuple[float, ...]  #: x and y, m; heading, rad
    goal: tuple[float, ...]  #: x and y, m; where it started if there is none
    state_hash: str
    origin: str  #: where a part of an episode comes from


@dataclass(frozen=True)
class Column:
    """A column of the frames."""

    name: str
    dtype: np.dtype
    shape: tuple[int, ...]  #: of one frame's value: `()` for a number
    names: tuple[str, ...]  #: of a vector's entries; none for grids
    units: tuple[str, ...]  #: of these entries, or of the whole where they have no names; empty text: a bare number


@dataclass(frozen=True)
class _Place:
    """Where an episode's frames are: the data file, and the rows in it."""

    file: Path
    start: int
    stop: int


def open(directory: str | PathLike[str]) -> Dataset:  # noqa: A001 - used as `datasets.open`
    """Opens a finished dataset. Only what tells of the episodes is read; frames are read when they are asked for.

    Raises `DatasetError` if there is none, it isn't finished, it is of a newer version, or it is damaged.
    """
    folder = Path(directory)
    if pq is None:
        raise DatasetError(folder, "datasets are read by pyarrow, which is missing", "pip install pyarrow")
    if not folder.is_dir():
        raise DatasetError(folder, "there is no such folder", "give the folder that `vb-harness dataset` wrote")
    file = folder / "dataset.json"
    if not file.is_file():
        raise DatasetError(
            folder, "no dataset is here: dataset.json is missing", "give the folder that `vb-harness dataset` wrote"
        )
    header = _json(file)
    schema = header.get("schema")
    if schema != SCHEMA:
        raise DatasetError(
            file, f"version {schema} of datasets, this package reads version {SCHEMA}", "use a newer vertibench"
        )
    sums = folder / "SHA256SUMS"
    if not sums.is_file():
        raise DatasetError(
            folder,
            "the dataset is not finished: SHA256SUMS is missing",
            "finish it with the command in its dataset.json and --resume",
        )
    try:
        info = Info(
            **{name: header[name] for name in ("name", "kind", "licence", "harness_version", "seed", "hz", "scale")},
            **{name: header[name]["name"] for name in ("vehicle", "perception", "rules", "soils")},
            of_a_suite=header.get("of_a_suite", False),
            hash=hashlib.sha256(sums.read_bytes()).hexdigest(),
            header=header,
        )
    except (KeyError, TypeError):
        raise DatasetError(file, "a field is missing or of a wrong type", _AGAIN) from None
    meta = _json(folder / "meta/info.json")
    episodes, places = _episodes(folder, meta["data_path"])
    return Dataset(folder, info, _columns(meta), episodes, places)


_AGAIN = "the file is truncated or damaged: make or fetch the dataset again"


class Dataset(Sequence):
    """Episodes of driving. `dataset[i]` has the frames of the episode `dataset.episodes[i]`, and iterating goes through
    all of them, with one data file in memory at a time. `dataset[i:j]` is the part with these episodes. `in`, `index` and
    `count` look for an `Episode`."""

    def __init__(
        self, folder: Path, info: Info, columns: dict[str, Column], episodes: Sequence[Episode], places: Sequence[_Place]
    ):
        self.folder = folder
        self.info = info
        #: The columns of the frames, by name.
        self.columns = columns
        #: What is said of each episode.
        self.episodes = tuple(episodes)
        self._places = tuple(places)
        self._worlds: dict[str, World] = {}
        # The data file that was read last, and its columns.
        self._file: Path | None = None
        self._loaded: dict[str, np.ndarray] = {}

    def __len__(self) -> int:
        """The number of episodes."""
        return len(self.episodes)

    @overload
    def __getitem__(self, index: int) -> dict[str, np.ndarray]: ...

    @overload
    def __getitem__(self, index: slice) -> Dataset: ...

    def __getitem__(self, index: int | slice) -> dict[str, np.ndarray] | Dataset:
        if isinstance(index, slice):
            return Dataset(self.folder, self.info, self.columns, self.episodes[index], self._places[index])
        return self.frames(index)

    def __contains__(self, episode: object) -> bool:
        return isinstance(episode, Episode) and episode in self.episodes

    def index(self, episode: Any, start: int = 0, stop: int | None = None) -> int:
        """The place of an episode. Raises `ValueError` if it is none of them."""
        return self.episodes.index(episode, start, len(self) if stop is None else stop)

    def count(self, episode: Any) -> int:
        """1 for one of the episodes, else 0."""
        return self.episodes.count(episode)

    def __iter__(self) -> Iterator[dict[str, np.ndarray]]:
        return (self.frames(k) for k in range(len(self)))

    def __repr__(self) -> str:
        frames = sum(e.length for e in self.episodes)
        return f"<Dataset {self.info.name}: {len(self)} episodes, {frames} frames at {self.info.hz} Hz>"

    def frames(self, episode: int | Episode, columns: str | Sequence[str] | None = None) -> dict[str, np.ndarray]:
        """The frames of an episode – one of `episodes`, or its place among them: an array for each column, or for those
        that `columns` names, with the frames along its first axis. One column may be given by its name alone."""
        if isinstance(episode, Episode):
            if episode not in self.episodes:
                raise DatasetError(self.folder, f"episode {episode.index} is not in this part", "give one of `episodes`")
            episode = self.episodes.index(episode)
        if not -len(self) <= episode < len(self):
            to_do = f"give 0 to {len(self) - 1}" if len(self) else "take another part"
            raise IndexError(f"{self.folder}: no episode {episode}, there are {len(self)} ({to_do})")
        place = self._places[episode]
        names = self._names(columns)
        self._load(place.file, names)
        frames = {name: self._loaded[name][place.start : place.stop].copy() for name in names}
        length = self.episodes[episode].length
        if any(len(values) != length for values in frames.values()):
            raise DatasetError(place.file, f"it ends before the {length} frames of episode {episode}", _AGAIN)
        return frames

    def pairs(
        self, seconds: float, columns: str | Sequence[str] | None = None
    ) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
        """All pairs of frames of the same episode that are so many seconds apart: the earlier and the later ones, each as
        `frames` has them. They are all in memory at once; `columns` says which are needed."""
        try:
            steps = round(seconds * self.info.hz)
            is_whole = abs(steps - seconds * self.info.hz) <= 1e-6
        except (TypeError, ValueError, OverflowError):
            steps, is_whole = 0, False
        if steps < 1 or not is_whole:
            raise DatasetError(
                self.folder,
                f"{seconds} s are not a whole number of frames at {self.info.hz} Hz",
                f"give a multiple of {1 / self.info.hz:g} s",
            )
        names = self._names(columns)
        parts = [self.frames(k, names) for k in range(len(self))]
        if not parts:
            parts = [{name: np.empty((0, *self.columns[name].shape), self.columns[name].dtype) for name in names}]
        earlier = {name: np.concatenate([p[name][:-steps] for p in parts]) for name in names}
        later = {name: np.concatenate([p[name][steps:] for p in parts]) for name in names}
        return earlier, later

    def world(self, id: str) -> World:
        """The world of this name (`episode.world`), at the scale of the dataset, so that places in frames are places in
        it."""
        if id not in self._worlds:
            folder = self.folder / "suite" / "worlds" / id
            known = sorted({e.world for e in self.episodes})
            if id not in known and not folder.is_dir():
                raise DatasetError(self.folder, f"no world {id}", f"give one of {', '.join(known)}")
            self._worlds[id] = read_world(folder, self.info.scale)
        return self._worlds[id]

    def split(self, train: float = 0.8, seed: int = 0) -> tuple[Dataset, Dataset]:
        """Two parts: episodes of about this fraction of the worlds, and those of all other worlds. Frames of one world are
        alike, so a model must be judged on worlds that it has never seen; frames and episodes are never dealt out. Which
        world goes where depends on the seed and on the worlds' contents alone."""
        hashes = sorted(
            {e.world_hash for e in self.episodes}, key=lambda h: hashlib.sha256(f"{seed} {h}".encode()).digest()
        )
        if not 0 < train < 1:
            raise DatasetError(self.folder, f"train is {train}", "give a fraction of the worlds between 0 and 1")
        if len(hashes) < 2:
            raise DatasetError(
                self.folder, "all episodes are of one world, which can't be split", "make a dataset with more --worlds"
            )
        chosen = set(hashes[: min(max(round(train * len(hashes)), 1), len(hashes) - 1)])
        return self.where(lambda e: e.world_hash in chosen), self.where(lambda e: e.world_hash not in chosen)

    def where(self, chosen: Any) -> Dataset:
        """The part with the episodes for which `chosen(episode)` is true."""
        kept = [k for k, e in enumerate(self.episodes) if chosen(e)]
        episodes, places = [self.episodes[k] for k in kept], [self._places[k] for k in kept]
        return Dataset(self.folder, self.info, self.columns, episodes, places)

    def _names(self, columns: str | Sequence[str] | None) -> list[str]:
        """The names of the columns that are asked for."""
        if columns is None:
            return list(self.columns)
        names = [columns] if isinstance(columns, str) else list(columns)
        for name in names:
            if name not in self.columns:
                raise DatasetError(self.folder, f"no column {name}", f"give one of {', '.join(self.columns)}")
        return names

    def _load(self, file: Path, names: Sequence[str]) -> None:
        """Reads columns of a data file, unless they are in memory."""
        if file != self._file:
            self._file, self._loaded = file, {}
        missing = [name for name in names if name not in self._loaded]
        if not missing:
            return
        table = _parquet(file, missing)
        for name in missing:
            if name not in table.column_names:
                raise DatasetError(file, f"no column {name}", _AGAIN)
            self._loaded[name] = _array(file, table.column(name), self.columns[name])


def _json(file: Path) -> dict[str, Any]:
    try:
        value = json.loads(file.read_text(encoding="utf-8"))
    except OSError as e:
        raise DatasetError(file, f"cannot be read: {e.strerror}", "make or fetch the dataset again") from None
    except ValueError as e:
        raise DatasetError(file, f"not JSON: {e}", _AGAIN) from None
    if not isinstance(value, dict):
        raise DatasetError(file, "it has no fields", _AGAIN)
    return value


def _parquet(file: Path, columns: Sequence[str] | None) -> pa.Table:
    if not file.is_file():
        raise DatasetError(file, "the file is missing", "make or fetch the dataset again")
    try:
        # The file itself and not a data set of one file, so that folders named a=b are no columns.
        with pq.ParquetFile(file) as opened:
            return opened.read(columns=columns)
    except (pa.ArrowException, OSError) as e:
        raise DatasetError(file, f"not a whole Parquet file: {e}", _AGAIN) from None


def _array(file: Path, values: pa.ChunkedArray, column: Column) -> np.ndarray:
    """A column as an array, lists of lists as further axes."""
    count = len(values)
    flat = values.combine_chunks()
    while pa.types.is_list(flat.type) or pa.types.is_large_list(flat.type) or pa.types.is_fixed_size_list(flat.type):
        flat = flat.flatten()
    array = flat.to_numpy(zero_copy_only=False)
    width = int(np.prod(column.shape, dtype=int))
    if array.size != count * width or array.dtype != column.dtype:
        raise DatasetError(
            file, f"column {column.name} is not of {column.dtype} with {width} values a frame", _AGAIN
        )
    return array.reshape(count, *column.shape)


def _columns(meta: dict[str, Any]) -> dict[str, Column]:
    columns = {}
    for name, feature in meta["features"].items():
        shape = tuple(feature["shape"])
        names = tuple(feature["names"] or ())
        units = tuple(next((unit for end, unit in _UNITS.items() if n.endswith(end)), "") for n in names)
        columns[name] = Column(
            name=name,
            dtype=np.dtype(feature["dtype"]),
            shape=() if shape == (1,) else shape,
            names=names,
            units=units or (_COLUMN_UNITS.get(name, ""),),
        )
    return columns


def _episodes(folder: Path, data_path: str) -> tuple[list[Episode], list[_Place]]:
    episodes: list[Episode] = []
    places: list[_Place] = []
    fields = [f.name for f in dataclasses.fields(Episode) if f.name != "index"]
    #: The first frame of each data file.
    first: dict[Path, int] = {}
    for file in sorted((folder / "meta/episodes").glob("chunk-*/file-*.parquet")):
        table = _parquet(file, None)
        own = [c for c in table.column_names if not c.startswith("stats/")]
        for row in table.select(own).to_pylist():
            try:
                said = {name: tuple(row[name]) if name in ("start", "goal") else row[name] for name in fields}
                episodes.append(Episode(index=row["episode_index"], **said))
                data = folder / data_path.format(chunk_index=row["data/chunk_index"], file_index=row["data/file_index"])
                start = first.setdefault(data, row["dataset_from_index"])
                places.append(_Place(data, row["dataset_from_index"] - start, row["dataset_to_index"] - start))
            except KeyError as e:
                raise DatasetError(file, f"no column {e}", _AGAIN) from None
    if not episodes:
        raise DatasetError(folder, "what tells of the episodes is missing: meta/episodes", "make or fetch the dataset again")
    return episodes, places
