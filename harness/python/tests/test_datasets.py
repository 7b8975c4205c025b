"""What is read is what was written, and what can't be read is told in one line."""

import dataclasses
import json
import shutil

import numpy as np
import pyarrow.parquet as pq
import pytest

from vertibench import datasets


def test_frames_are_those_of_the_files_episode_by_episode(explored):
    dataset = datasets.open(explored)
    files = sorted(explored.glob("data/*/*.parquet"))
    assert len(files) > 2 and len(dataset) == 18, "several files, of several episodes, are the point"
    rows = [row for file in files for row in pq.read_table(file, columns=["action", "index"]).to_pylist()]
    at = 0
    for k, frames in enumerate(dataset):
        episode = dataset.episodes[k]
        assert set(frames) == set(dataset.columns) and all(len(v) == episode.length for v in frames.values())
        for row, action, index in zip(rows[at:], frames["action"], frames["index"]):
            assert row["index"] == index and np.array_equal(np.float32(row["action"]), action)
        assert (frames["episode_index"] == k).all() and list(frames["frame_index"]) == list(range(episode.length))
        assert frames["next.done"].tolist() == [False] * (episode.length - 1) + [True]
        assert np.allclose(frames["timestamp"], np.arange(episode.length) / dataset.info.hz)
        at += episode.length
    assert at == len(rows)
    # In any order, some columns only, and from the end.
    for k in (17, 0, 3):
        own = dataset.frames(k, ["truth.ground"])
        assert list(own) == ["truth.ground"] and np.array_equal(own["truth.ground"], dataset[k - 18]["truth.ground"])
        assert dataset.frames(dataset.episodes[k])["index"][0] == dataset[k]["index"][0]


def test_what_is_given_may_be_changed(explored):
    dataset = datasets.open(explored)
    dataset[0]["action"][:] = 7
    assert (dataset[0]["action"] <= 1).all()


def test_columns_have_shapes_names_and_units(explored):
    dataset = datasets.open(explored)
    state = dataset.columns["observation.state"]
    assert state.shape == (15,) and len(state.units) == 15 and state.dtype == np.float32
    units = dict(zip(state.names, state.units))
    assert (units["x_m"], units["yaw_rad"], units["vx_m_per_s"], units["wz_rad_per_s"]) == ("m", "rad", "m/s", "rad/s")
    assert units["steering"] == "" and units["engine_speed_rad_per_s"] == "rad/s"
    crop = dataset.columns["observation.height_crop"]
    assert (crop.shape, crop.names, crop.units) == ((64, 64), (), ("m",))
    assert dataset.columns["action.speed"].shape == () and dataset.columns["action.speed"].units == ("m/s",)
    for name, values in dataset[0].items():
        column = dataset.columns[name]
        assert values.shape[1:] == column.shape and values.dtype == column.dtype, name


def test_episodes_say_everything_that_is_in_the_files(explored):
    dataset = datasets.open(explored)
    names = pq.read_schema(next(explored.glob("meta/episodes/*/*.parquet"))).names
    where = {"episode_index", "tasks", "dataset_from_index", "dataset_to_index"}
    said = {n for n in names if n not in where and not n.startswith(("stats/", "data/", "meta/"))}
    assert said == {f.name for f in dataclasses.fields(datasets.Episode)} - {"index"}
    settled = []
    for k, episode in enumerate(dataset.episodes):
        first, last = dataset[k]["observation.state"][[0, -1]]
        turn = abs(np.angle(np.exp(1j * (first[5] - episode.start[2]))))
        settled.append([np.hypot(*(first[:2] - episode.start[:2])), turn])
        assert episode.length == pytest.approx(episode.time_s * 10, abs=1)
        assert np.hypot(*(last - first)[:2]) <= episode.distance_m
    # On steep ground a vehicle slides while it settles, before the first frame; most don't.
    assert (np.median(settled, axis=0) < [0.05, 0.02]).all() and np.max(settled) < 2.5
    assert (dataset.info.kind, dataset.info.vehicle, dataset.info.licence) == ("explore", "hmmwv", "CC-BY-4.0")
    assert json.loads((explored / "dataset.json").read_text()) == dataset.info.header


@pytest.mark.parametrize("name", ["explored", "small"])
def test_worlds_are_the_ground_that_the_crops_show(name, request):
    dataset = datasets.open(request.getfixturevalue(name))
    scale = dataset.info.scale
    assert scale == (1 if name == "explored" else pytest.approx(1 / 6))
    classes = set()
    for episode, frames in zip(dataset.episodes, dataset):
        world = dataset.world(episode.world)
        assert (world.id, world.elevation, world.terrain) == (episode.world, episode.elevation, episode.terrain)
        state = frames["truth.state"] if "truth.state" in frames else frames["observation.state"]
        n = dataset.columns["observation.height_crop"].shape[0]
        cells = (np.arange(n) + 0.5) * 16 * scale / n - 8 * scale
        ahead, left = np.meshgrid(cells, cells, indexing="ij")
        for k in range(0, episode.length, 20):
            x, y, yaw = state[k, 0], state[k, 1], state[k, 5]
            east, north = x + ahead * np.cos(yaw) - left * np.sin(yaw), y + ahead * np.sin(yaw) + left * np.cos(yaw)
            # Where rounding to 32 bits puts a place on the other side of a patch's edge, it is of another class.
            patches = np.stack([east, north]) / world.patch
            clear = (np.abs(patches - np.round(patches)) > 1e-4).all(axis=0)
            height = world.height(east, north) - world.height(x, y)
            # The ground may be steep: a tenth of a millimetre for places that are off by micrometres.
            assert np.abs(frames["observation.height_crop"][k] - height).max() < 1e-4
            friction = world.friction_at(east, north)
            assert np.abs(frames["observation.friction_crop"][k] - friction)[clear].max() < 1e-6
            seen = frames["observation.class_crop"][k]
            ground = (seen != 10) & clear
            assert np.array_equal(seen[ground], world.class_at(east, north)[ground])
            for place in zip(east[seen == 10], north[seen == 10]):
                reach = [np.hypot(*np.subtract(place, (o.x, o.y))) - np.hypot(*o.size[:2]) / 2 for o in world.obstacles]
                assert min(reach) < 1e-3, "an obstacle is no larger than its box"
            classes |= set(seen[clear].tolist())
    assert name == "small" or {10, 255} < classes, f"too little was seen: {classes}"
    assert dataset.world(dataset.episodes[0].world) is dataset.world(dataset.episodes[0].world)


def test_parts_share_no_world_and_have_everything(explored):
    dataset = datasets.open(explored)
    splits = set()
    for seed in range(20):
        train, held_out = dataset.split(train=0.7, seed=seed)
        worlds = [{e.world for e in part.episodes} for part in (train, held_out)]
        assert worlds[0] and worlds[1] and not worlds[0] & worlds[1]
        assert sorted([*train.episodes, *held_out.episodes], key=lambda e: e.index) == list(dataset.episodes)
        for part in (train, held_out):
            for episode, frames in zip(part.episodes, part):
                assert (frames["episode_index"] == episode.index).all()
        assert [p.episodes for p in dataset.split(train=0.7, seed=seed)] == [train.episodes, held_out.episodes]
        splits.add(frozenset(worlds[1]))
    assert len(splits) > 1, "the seed decides"
    with pytest.raises(datasets.DatasetError, match="not in this dataset"):
        train.frames(held_out.episodes[0])
    only = dataset.where(lambda e: e.world == "w001")
    assert {e.world for e in only.episodes} == {"w001"}
    for wrong, what in [(lambda: only.split(), "one world"), (lambda: dataset.split(train=1.5), "train is 1.5")]:
        with pytest.raises(datasets.DatasetError, match=what):
            wrong()


def test_pairs_are_of_one_episode_and_so_far_apart(explored):
    dataset = datasets.open(explored)
    now, later = dataset.pairs(seconds=0.5, columns=["frame_index", "episode_index"])
    assert np.array_equal(now["episode_index"], later["episode_index"])
    assert (later["frame_index"] - now["frame_index"] == 5).all()
    assert len(now["frame_index"]) == sum(max(e.length - 5, 0) for e in dataset.episodes)
    for seconds in (0.25, 0.0, -1.0, float("nan"), float("inf"), "a"):
        with pytest.raises(datasets.DatasetError, match="whole number of frames"):
            dataset.pairs(seconds=seconds)


def test_a_dataset_is_a_sequence_of_episodes(explored):
    dataset = datasets.open(explored)
    part = dataset[2:7:2]
    assert part.episodes == dataset.episodes[2:7:2] and np.array_equal(part[1]["index"], dataset[4]["index"])
    assert dataset.episodes[4] in part and dataset.episodes[3] not in part and dataset[4] not in part
    assert part.index(dataset.episodes[6]) == 2 and part.count(dataset.episodes[3]) == 0
    assert [f["index"][0] for f in reversed(part)] == [dataset[k]["index"][0] for k in (6, 4, 2)]
    with pytest.raises(ValueError):
        part.index(dataset.episodes[3])
    nothing = dataset.where(lambda e: False)
    now, later = nothing.pairs(0.5, ["action", "timestamp"])
    assert now["action"].shape == later["action"].shape == (0, 4) and now["timestamp"].dtype == dataset.columns["timestamp"].dtype
    with pytest.raises(IndexError, match="there are 0"):
        nothing[0]
    with pytest.raises(datasets.DatasetError, match="no column speed"):
        nothing.pairs(0.5, ["speed"])
    assert list(dataset.frames(0, "action")) == ["action"]


def _edited(folder, name, change):
    file = folder / name
    file.write_bytes(change(file.read_bytes()))


DATA, EPISODES = "data/chunk-000/file-000.parquet", "meta/episodes/chunk-000/file-000.parquet"
HURT = {
    "unfinished": (lambda d: (d / "SHA256SUMS").unlink(), ["incomplete", "--resume"]),
    "no dataset": (lambda d: (d / "dataset.json").unlink(), ["not a dataset: dataset.json is missing"]),
    "newer": (lambda d: _edited(d, "dataset.json", lambda b: b.replace(b'"schema": 1', b'"schema": 9', 1)), ["version 9"]),
    "no JSON": (lambda d: _edited(d, "dataset.json", lambda b: b[:99]), ["dataset.json: not JSON"]),
    "no field": (lambda d: _edited(d, "dataset.json", lambda b: b.replace(b'"hz"', b'"hertz"')), ["a field is missing"]),
    "cut frames": (lambda d: _edited(d, DATA, lambda b: b[:-5000]), [DATA, "Parquet", "truncated"]),
    "no frames": (lambda d: (d / DATA).unlink(), [DATA, "missing"]),
    "cut episodes": (lambda d: _edited(d, EPISODES, lambda b: b[:99]), [EPISODES, "Parquet"]),
    "cut heights": (lambda d: _edited(d, "suite/worlds/w001/elevation.png", lambda b: b[:-99]), ["elevation.png", "truncated or damaged"]),
    "other heights": (
        lambda d: _edited(d, "suite/worlds/w001/world.yaml", lambda b: b.replace(b"rows: 129", b"rows: 130")),
        ["elevation.png: 129 x 129 pixels, world.yaml has 130 x 129"],
    ),
    "newer world": (
        lambda d: _edited(d, "suite/worlds/w001/world.yaml", lambda b: b.replace(b"schema: 1", b"schema: 2")),
        ["world.yaml: unsupported version 2 of the world format"],
    ),
    "no ground": (lambda d: (d / "suite/worlds/w001/semantics.yaml").unlink(), ["semantics.yaml", "cannot be read"]),
    "odd YAML": (
        lambda d: _edited(d, "suite/worlds/w001/obstacles.yaml", lambda b: b"obstacles: *all\n"),
        ["obstacles.yaml: line 1: found undefined alias"],
    ),
}


@pytest.mark.parametrize("what", HURT)
def test_what_is_hurt_is_told_in_one_line(what, explored, tmp_path):
    folder = tmp_path / "d"
    shutil.copytree(explored, folder)
    hurt, told = HURT[what]
    hurt(folder)
    with pytest.raises(datasets.DatasetError) as caught:
        dataset = datasets.open(folder)
        dataset[0]
        dataset.world("w001")
    message = str(caught.value)
    assert "\n" not in message and message.startswith(str(folder)) and message.endswith(")")
    assert all(part in message for part in told), message


def test_what_is_not_there_is_told_with_what_is(explored, tmp_path):
    dataset = datasets.open(explored)
    cases = [
        (lambda: datasets.open(tmp_path / "none"), "no such folder"),
        (lambda: dataset.frames(0, ["speed"]), "no column speed (give one of "),
        (lambda: dataset.world("w099"), "no world w099 (give one of w001, "),
    ]
    for do, told in cases:
        with pytest.raises(datasets.DatasetError) as caught:
            do()
        assert told in str(caught.value) and "\n" not in str(caught.value)
    for index in (18, -19):
        with pytest.raises(IndexError, match="there are 18"):
            dataset[index]
