"""Reader for datasets: provenance, episodes and frames."""

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
    # `open` reports it; environments don't need pyarrow.
    pa = pq = None

from ._errors import DatasetError
from ._world import World, read_world

#: Supported version of `dataset.json`.
SCHEMA = 1
#: Units by suffix of a name.
_UNITS = {"_m_per_s": "m/s", "_rad_per_s": "rad/s", "_rad": "rad", "_m": "m", "_N": "N"}
#: Units of columns without names of entries.
_COLUMN_UNITS = {"observation.height_crop": "m", "timestamp": "s"}


@dataclass(frozen=True)
class Info:
    """Provenance of a dataset, from `dataset.json`.

    Attributes:
        name: Dataset name.
        kind: `explore`, `drive`, `teleop`, `failures`, `merged` or `split`.
        licence: SPDX identifier of the licence.
        harness_version: Version of the harness.
        seed: Random seed.
        hz: Frames per second.
        vehicle: Vehicle name.
        perception: Name of the perception profile.
        rules: Name of the rules.
        soils: Name of the soil set.
        scale: Factor on all lengths of the worlds.
        of_a_suite: Whether its worlds belong to a benchmark suite. Such a dataset must not be used for training.
        hash: SHA-256 of the file `SHA256SUMS`; equal hashes mean equal files.
        header: Whole content of `dataset.json`.
    """

    name: str
    kind: str
    licence: str
    harness_version: str
    seed: int
    hz: int
    vehicle: str
    perception: str
    rules: str
    soils: str
    scale: float
    of_a_suite: bool
    hash: str
    header: dict[str, Any]


@dataclass(frozen=True)
class Episode:
    """Description of an episode, from `meta/episodes`.

    Attributes:
        index: Number of the episode in the dataset on disk, from 0.
        length: Number of frames.
        instruction: The task as text.
        drive: Index among all drives of the command; drives that were not kept are skipped.
        driver: Planner, person or exploration that drove.
        world: World id, for `Dataset.world`.
        world_hash: Content hash of the world.
        task: Task name, e.g. `w003/t07`; empty for exploration.
        elevation: Elevation level of the world.
        terrain: Terrain type of the world.
        density: Obstacle density of the world.
        ground: Terrain class under the vehicle at the end.
        outcome: `success`, `rollover`, `stuck`, `timeout`, `out_of_bounds`, ...
        reason: Reason of the end, as text.
        cause: Cause of a rollover or stuck end; empty except in datasets of failures.
        time_s: Duration, s.
        distance_m: Length of the trajectory, m.
        start: Start: x and y, m; heading, rad.
        goal: Goal: x and y, m; those of the start if there is no goal.
        state_hash: Hash of the simulation states; empty for a part of an episode.
        origin: Source of a partial or merged episode.
    """

    index: int
    length: int
    instruction: str
    drive: int
    driver: str
    world: str
    world_hash: str
    task: str
    elevation: str
    terrain: str
    density: str
    ground: str
    outcome: str
    reason: str
    cause: str
    time_s: float
    distance_m: float
    start: tuple[float, ...]
    goal: tuple[float, ...]
    state_hash: str
    origin: str


@dataclass(frozen=True)
class Column:
    """Column of the frames.

    Attributes:
        name: Column name, e.g. `observation.state`.
        dtype: NumPy data type.
        shape: Shape of one frame's value; `()` for a number.
        names: Names of the entries of a vector; empty for numbers and grids.
        units: Units of the entries, or one unit of the whole value if they have no names; an empty text means
            dimensionless.
    """

    name: str
    dtype: np.dtype
    shape: tuple[int, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]


@dataclass(frozen=True)
class _Place:
    """Location of an episode's frames: data file and rows."""

    file: Path
    start: int
    stop: int


def open(directory: str | PathLike[str]) -> Dataset:  # noqa: A001 - used as `datasets.open`
    """Opens a complete dataset.

    Only the descriptions of the episodes are read; frames are read on access.

    Args:
        directory: Output directory of `vb-harness dataset`.

    Returns:
        The dataset.

    Raises:
        DatasetError: If there is no dataset, it is incomplete, of another version or damaged, or pyarrow is not
            installed.

    Example:
        >>> dataset = datasets.open("explore")
        >>> frames = dataset[0]
    """
    folder = Path(directory)
    if pq is None:
        raise DatasetError(folder, "pyarrow, which reads datasets, is not installed", "pip install pyarrow")
    if not folder.is_dir():
        raise DatasetError(folder, "there is no such folder", "give the output directory of `vb-harness dataset`")
    file = folder / "dataset.json"
    if not file.is_file():
        raise DatasetError(
            folder, "not a dataset: dataset.json is missing", "give the output directory of `vb-harness dataset`"
        )
    header = _json(file)
    schema = header.get("schema")
    if schema != SCHEMA:
        raise DatasetError(
            file, f"unsupported version {schema} of the dataset format, supported: {SCHEMA}", "use a newer vertibench"
        )
    sums = folder / "SHA256SUMS"
    if not sums.is_file():
        raise DatasetError(
            folder,
            "the dataset is incomplete: SHA256SUMS is missing",
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
        raise DatasetError(file, "a field is missing or has the wrong type", _AGAIN) from None
    meta = _json(folder / "meta/info.json")
    episodes, places = _episodes(folder, meta["data_path"])
    return Dataset(folder, info, _columns(meta), episodes, places)


_AGAIN = "the file is truncated or damaged: make or fetch the dataset again"


class Dataset(Sequence):
    """Sequence of episodes. `datasets.open` returns it.

    `dataset[i]` reads the frames of `dataset.episodes[i]` (see `frames`), and `dataset[i:j]` is a dataset with these
    episodes. Iteration reads the frames of all episodes, with one data file in memory at a time. `in`, `index` and
    `count` compare with `Episode`s.

    Attributes:
        folder: Directory of the dataset.
        info: Provenance (`Info`).
        columns: Columns of the frames (`Column`), by name.
        episodes: Descriptions (`Episode`) of the episodes, a tuple.
    """

    def __init__(
        self, folder: Path, info: Info, columns: dict[str, Column], episodes: Sequence[Episode], places: Sequence[_Place]
    ):
        self.folder = folder
        self.info = info
        self.columns = columns
        self.episodes = tuple(episodes)
        self._places = tuple(places)
        self._worlds: dict[str, World] = {}
        # The last data file, and its columns that are in memory.
        self._file: Path | None = None
        self._loaded: dict[str, np.ndarray] = {}

    def __len__(self) -> int:
        """Returns the number of episodes."""
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
        """Returns the position of an episode.

        Args:
            episode: The episode.
            start: First position to search; default 0.
            stop: Position after the last one to search. None (default): the end.

        Returns:
            The position, from 0.

        Raises:
            ValueError: If the episode is not found.
        """
        return self.episodes.index(episode, start, len(self) if stop is None else stop)

    def count(self, episode: Any) -> int:
        """Returns how often an episode occurs.

        Args:
            episode: The episode.

        Returns:
            1 or 0.
        """
        return self.episodes.count(episode)

    def __iter__(self) -> Iterator[dict[str, np.ndarray]]:
        return (self.frames(k) for k in range(len(self)))

    def __repr__(self) -> str:
        frames = sum(e.length for e in self.episodes)
        return f"<Dataset {self.info.name}: {len(self)} episodes, {frames} frames at {self.info.hz} Hz>"

    def frames(self, episode: int | Episode, columns: str | Sequence[str] | None = None) -> dict[str, np.ndarray]:
        """Reads the frames of an episode.

        Args:
            episode: One of `episodes`, or its position among them; negative positions count from the end.
            columns: Name or names of the columns to read. None (default): all.

        Returns:
            An array per column name, with the frames along the first axis: shape (frames, *column.shape).

        Raises:
            IndexError: If there is no such position.
            DatasetError: If the episode is not in this dataset, a column doesn't exist, or a file is damaged.
        """
        if isinstance(episode, Episode):
            if episode not in self.episodes:
                raise DatasetError(self.folder, f"episode {episode.index} is not in this dataset", "give one of `episodes`")
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
        """Reads all pairs of frames of the same episode with a fixed distance in time.

        All pairs are in memory at once; choose `columns` to save memory.

        Args:
            seconds: Distance in time, s, a positive multiple of 1 / `info.hz`.
            columns: Name or names of the columns to read. None (default): all.

        Returns:
            The earlier and the later frames, each with an array per column name. Row k of both belongs to the same
            pair.

        Raises:
            DatasetError: If the distance is no positive multiple, a column doesn't exist, or a file is damaged.

        Example:
            >>> now, later = dataset.pairs(seconds=0.5, columns=["observation.state", "action"])
        """
        try:
            steps = round(seconds * self.info.hz)
            is_whole = abs(steps - seconds * self.info.hz) <= 1e-6
        except (TypeError, ValueError, OverflowError):
            steps, is_whole = 0, False
        if steps < 1 or not is_whole:
            raise DatasetError(
                self.folder,
                f"{seconds} s is not a whole number of frames at {self.info.hz} Hz",
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
        """Reads a world, in the scaled lengths of the frames. Later calls return the same object.

        Args:
            id: World id, as in `Episode.world`.

        Returns:
            The world.

        Raises:
            DatasetError: If there is no such world, or a file is damaged.
        """
        if id not in self._worlds:
            folder = self.folder / "suite" / "worlds" / id
            known = sorted({e.world for e in self.episodes})
            if id not in known and not folder.is_dir():
                raise DatasetError(self.folder, f"no world {id}", f"give one of {', '.join(known)}")
            self._worlds[id] = read_world(folder, self.info.scale)
        return self._worlds[id]

    def split(self, train: float = 0.8, seed: int = 0) -> tuple[Dataset, Dataset]:
        """Splits the episodes by world into two parts.

        Frames of one world are similar, so a model must be tested on worlds that it hasn't been trained on. The
        assignment depends only on the seed and the contents of the worlds.

        Args:
            train: Fraction of the worlds in the first part, between 0 and 1, rounded so that each part has at least one
                world; default 0.8.
            seed: Random seed; default 0.

        Returns:
            The first part, and the part with all other worlds.

        Raises:
            DatasetError: If the fraction is out of range, or all episodes are in one world.
        """
        hashes = sorted(
            {e.world_hash for e in self.episodes}, key=lambda h: hashlib.sha256(f"{seed} {h}".encode()).digest()
        )
        if not 0 < train < 1:
            raise DatasetError(self.folder, f"train is {train}", "give a fraction of the worlds between 0 and 1")
        if len(hashes) < 2:
            raise DatasetError(
                self.folder, "all episodes are in one world, which can't be split", "make a dataset with more --worlds"
            )
        chosen = set(hashes[: min(max(round(train * len(hashes)), 1), len(hashes) - 1)])
        return self.where(lambda e: e.world_hash in chosen), self.where(lambda e: e.world_hash not in chosen)

    def where(self, chosen: Any) -> Dataset:
        """Selects episodes.

        Args:
            chosen: Function that returns whether an `Episode` is selected.

        Returns:
            A dataset with the selected episodes.

        Example:
            >>> failures = dataset.where(lambda episode: episode.outcome == "stuck")
        """
        kept = [k for k, e in enumerate(self.episodes) if chosen(e)]
        episodes, places = [self.episodes[k] for k in kept], [self._places[k] for k in kept]
        return Dataset(self.folder, self.info, self.columns, episodes, places)

    def _names(self, columns: str | Sequence[str] | None) -> list[str]:
        """Returns the names of the requested columns."""
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
        raise DatasetError(file, "not an object", _AGAIN)
    return value


def _parquet(file: Path, columns: Sequence[str] | None) -> pa.Table:
    if not file.is_file():
        raise DatasetError(file, "the file is missing", "make or fetch the dataset again")
    try:
        # As a single file, not as a data set, so that folders named a=b don't become columns.
        with pq.ParquetFile(file) as opened:
            return opened.read(columns=columns)
    except (pa.ArrowException, OSError) as e:
        raise DatasetError(file, f"not a complete Parquet file: {e}", _AGAIN) from None


def _array(file: Path, values: pa.ChunkedArray, column: Column) -> np.ndarray:
    """Converts a column to an array, with nested lists as further axes."""
    count = len(values)
    flat = values.combine_chunks()
    while pa.types.is_list(flat.type) or pa.types.is_large_list(flat.type) or pa.types.is_fixed_size_list(flat.type):
        flat = flat.flatten()
    array = flat.to_numpy(zero_copy_only=False)
    width = int(np.prod(column.shape, dtype=int))
    if array.size != count * width or array.dtype != column.dtype:
        raise DatasetError(
            file, f"column {column.name} must have {width} values of {column.dtype} per frame", _AGAIN
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
    #: Index of the first frame of each data file.
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
        raise DatasetError(folder, "the descriptions of the episodes are missing: meta/episodes", "make or fetch the dataset again")
    return episodes, places
