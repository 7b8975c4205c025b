"""One environment: gymnasium's conventions, the benchmark's episodes, and errors that say what to do."""

import copy
import io
import json
import multiprocessing
import os
import pickle
import subprocess
import sys
import warnings
from fractions import Fraction
from pathlib import Path

import numpy as np
import PIL.Image
import pytest
from conftest import pursue

import vertibench

gymnasium = pytest.importorskip("gymnasium", reason="gymnasium is not installed")
NAME = "VertiBench/Navigation-v0"
EVERY_PART = ["state", "pose", "goal", "path", "wheels", "command", "height", "class", "friction"]
SENSED = ["imu", "gnss", "lidar", "depth", "local_height", "local_class"]


@pytest.fixture
def make(envs):
    """Makes an environment of the suite smoke, and closes it."""
    made = []

    def one(**options):
        options = {"suite": "smoke", "tasks": "w001-w003", **options}
        made.append(gymnasium.make(NAME, **options))
        return made[-1]

    yield one
    for env in made:
        env.close()


def drive(env, observation, most=10_000, speed=0.0):
    for count in range(most):
        observation, reward, terminated, truncated, info = env.step(pursue(observation["path"], speed))
        if terminated or truncated:
            return observation, reward, terminated, truncated, info, count + 1
    return observation, reward, terminated, truncated, info, most


@pytest.mark.parametrize("code", [
    "import vertibench, gymnasium; name = 'VertiBench/Navigation-v0'",
    "import gymnasium, vertibench; gymnasium.register_envs(vertibench); name = 'VertiBench/Navigation-v0'",
    "import gymnasium; name = 'vertibench:VertiBench/Navigation-v0'",
    "import vertibench, gymnasium; name = 'vertibench:VertiBench/Navigation-v0'",
    "import vertibench, importlib.util; importlib.util.find_spec('gymnasium'); import gymnasium; name = 'VertiBench/Navigation-v0'",
    "from vertibench import envs; import gymnasium; name = 'VertiBench/Navigation-v0'",
])
def test_whoever_imports_the_package_finds_the_environment_by_its_name(envs, code):
    # In an interpreter of its own: what a test before has imported would register it here.
    code += "; env = gymnasium.make(name, suite='smoke', tasks='w001/t00'); env.reset(seed=0); env.close()"
    path = os.pathsep.join([str(Path(vertibench.__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run([sys.executable, "-B", "-c", code], env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("options", [
    {"observation": EVERY_PART},
    {"observation": "flat"},
    {"action": "pedals", "observation": ["state"]},
    {"perception": "degraded", "observation": ["state", "local_height"], "reward": "sparse"},
])
def test_gymnasium_s_checker_passes(make, options):
    from gymnasium.utils.env_checker import check_env

    env = make(render_mode="rgb_array", render_size=(64, 48), **options)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # Bounds are open where nature has none, and the checker would rather have some.
        warnings.filterwarnings("ignore", message=".*(infinity|normalized|symmetric).*")
        check_env(env.unwrapped)


def test_stable_baselines_checker_passes(make):
    pytest.importorskip("stable_baselines3", reason="stable-baselines3 is not installed")
    from stable_baselines3.common.env_checker import check_env

    for options in ({"observation": EVERY_PART}, {"observation": "flat"}):
        check_env(make(**options).unwrapped)


@pytest.mark.parametrize("parts,perception", [(EVERY_PART, "oracle"), (EVERY_PART + SENSED, "onboard")])
def test_observations_lie_in_their_space_with_the_shapes_that_it_tells(make, parts, perception):
    env = make(observation=parts, perception=perception)
    observation, _ = env.reset(seed=1)
    assert set(observation) == set(env.observation_space) == set(parts)
    for _ in range(40):
        for name, box in env.observation_space.items():
            assert box.contains(observation[name]), (name, observation[name])
        observation, *_, = env.step(pursue(observation["path"]))
    assert observation["height"].shape == (16, 16) and observation["class"].dtype == np.uint8
    assert observation["wheels"].shape == (4, 2) and observation["path"].shape == (10, 2)


def test_sight_sets_what_is_seen(make):
    env = make(observation=["path", "height"], sight={"cells": 32, "resolution": 0.5, "points": 4, "spacing": 5.0})
    observation, _ = env.reset(seed=0, options={"task": "w001/t00"})
    assert observation["height"].shape == (32, 32) and observation["path"].shape == (4, 2)
    # Points lie 5 m apart along the path, which is nearly straight there.
    assert np.allclose(np.linalg.norm(np.diff(observation["path"], axis=0), axis=1), 5.0, atol=0.2)


def test_a_flat_observation_is_the_parts_of_numbers_by_their_usual_size(make):
    parts = ["goal", "class", "command"]
    flat, _ = make(observation=parts, flat=True).reset(seed=3)
    apart, _ = make(observation=parts).reset(seed=3)
    # docs/environments.md: the goal by 50 m; commands as they are; labels are left out.
    assert np.allclose(flat, [*(apart["goal"] / 50.0), *apart["command"]])


def test_a_seed_gives_the_same_bits_and_another_one_other_tasks(make):
    env = make(observation=["state", "path", "height"])

    def story(seed):
        observation, info = env.reset(seed=seed)
        told = [info["task"]]
        for _ in range(3):
            observation, reward, *_ = env.step([0.2, 0.4])
            told.append((reward, observation["state"].tobytes(), observation["height"].tobytes()))
        told.append(env.reset()[1]["task"])
        return told

    assert story(5) == story(5)
    assert len({story(seed)[0] for seed in range(8)}) > 3


def test_an_episode_ends_by_the_rules_and_tells_the_record_of_the_benchmark(make):
    env = make(observation=["state", "path"])
    observation, info = env.reset(seed=0, options={"task": "w001/t00", "run_seed": 0})
    assert info == {"task": "w001/t00", "run_seed": 0}
    *_, terminated, truncated, info, count = drive(env, observation)
    assert (terminated, truncated, info["outcome"], info["is_success"]) == (True, False, "success", True)
    assert info["record"]["task"] == "w001/t00" and info["record"]["planner_steps"] == count
    assert set(info["reward_terms"]) == set(vertibench.envs.describe_rewards())
    assert info["reward_terms"]["success"] == 10.0
    with pytest.raises(vertibench.EpisodeError, match=r"the episode has ended \(.* from the goal .*\): call reset"):
        env.unwrapped.step([0.0, 0.0])
    json.dumps(info)
    # Who stands still is stuck after 10 s, and who drives 120 m at 1.8 m/s runs out of time.
    env.reset(options={"task": "w001/t00"})
    for _ in range(100):
        *_, terminated, truncated, info = env.step([0.0, -1.0])
    assert terminated and info["outcome"] == "stuck"
    observation, _ = env.reset(options={"task": "w001/t00"})
    *_, terminated, truncated, info, count = drive(env, observation, speed=-0.4)
    assert count == 600 and (terminated, truncated, info["outcome"]) == (False, True, "timeout")


def test_the_reward_is_its_terms_times_weights(make):
    weights = {"progress": 2.0, "time": -1.0}
    env = make(observation=["path"], reward=weights)
    assert {k: v for k, v in env.unwrapped.reward_weights.items() if v} == weights
    observation, _ = env.reset(seed=0, options={"task": "w001/t00"})
    for _ in range(20):
        observation, reward, _, _, info = env.step(pursue(observation["path"]))
        terms = info["reward_terms"]
        assert np.isclose(reward, sum(terms.values())) and np.isclose(terms["time"], -0.1)
    assert terms["progress"] > 0.2, "3 m/s are 0.3 m a step"


def test_a_state_is_gone_back_to_exactly(make):
    env = make(observation=["state", "path"]).unwrapped
    observation, _ = env.reset(seed=2)
    observation, *_ = drive(env, observation, 20)
    state, there = env.state(), observation
    first = drive(env, there, 30)
    other, pickled = make(observation=["state", "path"]).unwrapped, pickle.dumps(state)
    assert len(pickled) < 2000
    assert copy.deepcopy(state) is state
    for one, kept in ((env, state), (other, state), (other, pickle.loads(pickled)), (env, pickle.loads(pickled))):
        back = one.set_state(kept)
        assert all(np.array_equal(back[name], there[name]) for name in back)
        again = drive(one, back, 30)
        assert np.array_equal(again[0]["state"], first[0]["state"]) and again[1] == first[1]
    assert pickle.dumps(pickle.loads(pickled)) == pickled


def test_states_that_were_forged_or_are_of_other_options_are_refused(make):
    env = make(observation=["state"]).unwrapped
    seen, _ = env.reset(seed=2)
    env.step([0.0, 1.0])
    state = env.state()
    how = state.__reduce__()[1][0]
    remade = state.__reduce__()[0]
    with pytest.raises(vertibench.OptionError, match="with other options"):
        make(observation=["state", "path"]).unwrapped.set_state(pickle.loads(pickle.dumps(state)))
    for forged in (b"", b"vbstate1", how[:-1], how + b"x", b"\x00" * 100, how[:8] + b"\x9f" * 50, b"vbstate1\xdd\xff\xff\xff\xff"):
        with pytest.raises(vertibench.OptionError, match="the state can't be read"):
            env.set_state(remade(forged))
    with pytest.raises(vertibench.OptionError, match="holds bytes, not int"):
        remade(7)
    # Nothing has changed.
    assert env.vehicle["time"] == pytest.approx(0.1)


def test_a_search_in_another_process_takes_a_state(make):
    env = make(observation=["state"]).unwrapped
    env.reset(seed=2)
    for _ in range(10):
        env.step([0.2, 1.0])
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        time, position = pool.apply(_one_step_on, (env.state(), env._made_of))
    env.step([0.0, 1.0])
    assert (time, position) == (env.vehicle["time"], env.vehicle["position"].tolist())


def _one_step_on(state, made_of):
    from vertibench.envs import NavigationEnv

    env = NavigationEnv(*made_of[0], **made_of[1])
    env.set_state(state)
    env.step([0.0, 1.0])
    return env.vehicle["time"], env.vehicle["position"].tolist()


def test_the_environment_of_a_dataset_is_recovered_by_minari(explored, tmp_path, monkeypatch):
    minari = pytest.importorskip("minari", reason="Minari is not installed")
    for module in ("h5py", "pyarrow"):
        pytest.importorskip(module, reason=f"{module} is not installed")
    from vertibench import datasets

    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    dataset = datasets.open(explored)
    datasets.to_minari(dataset, "explored-v0")
    made = minari.load_dataset("explored-v0")
    env = made.recover_environment()
    _, info = env.reset(seed=0)
    env.step(made[0].actions[0])
    assert info["task"] in env.unwrapped.tasks and env.action_space.shape == made.action_space.shape
    assert env.unwrapped.vehicle["time"] == pytest.approx(1 / dataset.info.hz)
    env.close()


def test_truth_is_told_apart_from_what_is_observed(make):
    env = make(observation=["pose"], perception="degraded").unwrapped
    env.reset(seed=0, options={"task": "w002/t00"})
    for _ in range(60):
        observation, *_ = env.step([0.0, 0.5])
    vehicle, task = env.vehicle, env.task
    assert vehicle["time"] == pytest.approx(6.0) and vehicle["wheels"].shape == (4, 4)
    # The weight of 2493.56 kg rests on the wheels, more or less.
    assert 0.3 * 2493.56 * 9.81 < vehicle["wheels"][:, 2].sum() < 2.0 * 2493.56 * 9.81
    off = np.linalg.norm(observation["pose"][:3] - vehicle["position"])
    assert 0.001 < off < 20.0
    assert task["name"] == "w002/t00" and task["path"].shape[1] == 2 and task["goal_radius"] == 10.0


def test_pictures_are_taken_without_a_screen(make):
    for camera in ("chase", "top"):
        env = make(observation=["path"], render_mode="rgb_array", camera=camera, render_size=(160, 120))
        observation, _ = env.reset(seed=0, options={"task": "w001/t00"})
        first = env.render()
        assert first.shape == (120, 160, 3) and first.dtype == np.uint8 and first.std() > 10
        drive(env, observation, 30)
        assert not np.array_equal(env.render(), first)
    assert make(observation=["path"]).unwrapped.render_mode is None


def test_a_picture_is_a_png_that_readers_read(envs):
    rgb = np.arange(5 * 7 * 3, dtype=np.uint8).reshape(5, 7, 3)
    file = envs.picture(rgb)._repr_png_()
    assert np.array_equal(np.asarray(PIL.Image.open(io.BytesIO(file))), rgb)
    with pytest.raises(vertibench.OptionError, match="picture: give a result of render"):
        envs.picture(None)


def test_gymnasium_records_a_video(make, tmp_path):
    pytest.importorskip("moviepy", reason="moviepy is not installed")
    from gymnasium.wrappers import RecordVideo

    env = RecordVideo(make(observation=["path"], render_mode="rgb_array", render_size=(160, 120)), tmp_path, name_prefix="drive")
    observation, _ = env.reset(seed=0, options={"task": "w001/t00"})
    drive(env, observation, 15)
    env.close()
    (video,) = tmp_path.glob("drive*.mp4")
    assert video.stat().st_size > 1000


@pytest.mark.parametrize("options,message", [
    ({"suite": "nowhere"}, "there is no suite nowhere"),
    ({"tasks": "w777/t00"}, "w777"),
    ({"vehicle": "tank"}, "there is no vehicle tank"),
    ({"perception": "psychic"}, "there is no perception profile psychic"),
    ({"observation": ["hight"]}, "observation: hight: unknown part; parts: state"),
    ({"observation": []}, "at least one part"),
    ({"observation": ["class"], "flat": True}, "a flat one needs at least one part with numbers"),
    ({"control_hz": 30}, "control_hz: 30: must be 100 over a whole number"),
    ({"control_hz": "fast"}, "control_hz: 'fast' is not a number"),
    ({"action": "fly"}, "action: fly: must be speed, rate or pedals"),
    ({"speed_range": (4, 2)}, "speed_range"),
    ({"sight": {"cells": 1}}, "sight: cells: 1 must lie in 2 to 256"),
    ({"sight": {"depth": 1}}, "sight: depth: there are cells"),
    ({"reward": {"luck": 1}}, "unknown term luck"),
    ({"reward": {"success": float("nan")}}, "weights.success: NaN"),
    ({"reward": "nowhere.yaml"}, "cannot read reward nowhere.yaml"),
    ({"suite": None, "tasks": None, "world_seed": 1}, "training worlds need a seed from 7000 to 7999"),
    ({"suite": None, "tasks": None, "worlds": -1}, "worlds: -1 must be a whole number, at least 1"),
    ({"suite": 5}, "suite: 5 must be a name or a path"),
    ({"tasks": 5}, "tasks: 5 must be a selector"),
    ({"tasks": [1]}, "tasks: [1] must be a selector"),
    ({"action": 5}, "an option has the wrong type"),
    ({"sight": 5}, "sight: 5 must be a dictionary"),
    ({"sight": {"cells": 16.7}}, "sight: cells: 16.7 must be a whole number"),
    ({"sight": {"points": 1.9}}, "sight: points: 1.9 must be a whole number"),
    ({"speed_range": (0, 1, 2)}, "speed_range: (0, 1, 2) must be two speeds"),
    ({"speed_range": 5}, "speed_range: 5 must be two speeds"),
    ({"scale": 10**400}, "is not a number"),
    ({"apart_from": "nowhere", "suite": None, "tasks": None, "worlds": 1}, "nowhere"),
    ({"foo": 1}, "there is no option 'foo': help(NavigationEnv) lists all"),
    ({"render_size": (64.5, 64)}, "render_size: (64.5, 64) must be (width, height)"),
    ({"render_size": (float("inf"), 5)}, "render_size: (inf, 5) must be (width, height)"),
    ({"render_mode": "human"}, "render_mode: 'human' must be"),
    ({"camera": "moon", "render_mode": "rgb_array"}, "camera: 'moon' must be"),
    ({"render_size": (0, 9), "render_mode": "rgb_array"}, "render_size"),
])
def test_options_that_make_no_sense_are_told(envs, options, message):
    with pytest.raises(vertibench.OptionError) as told:
        envs.NavigationEnv(**{"suite": "smoke", "tasks": "w001", **options})
    assert message in str(told.value) and "\n" not in str(told.value)


def test_a_vehicle_file_that_is_wrong_is_told_with_its_field(envs, tmp_path):
    text = (vertibench.tasks_path() / "vehicles/hmmwv.yaml").read_text()
    assert "max_speed:" in text
    file = tmp_path / "mine.yaml"
    file.write_text(text.replace("max_speed:", "max_spede:", 1))
    with pytest.raises(vertibench.OptionError, match="mine.yaml.*max_spede"):
        envs.NavigationEnv(suite="smoke", tasks="w001", vehicle=file)


def test_what_is_no_action_or_no_seed_is_told_and_changes_nothing(make):
    env = make(observation=["state"]).unwrapped
    for before in (lambda: env.step([0, 0]), env.state, env.render):
        with pytest.raises(vertibench.EpisodeError, match="no episode is active: call reset first"):
            before()
    env.reset(seed=0)
    for action, message in [
        ([0.0], "an action has 2 numbers"),
        ([0.0, float("nan")], r"action\[1\] \(speed\) is NaN"),
        ([[0.0, 0.0]], r"an action has the shape \(2,\)"),
        (["left", 1], "an action is 2 numbers"),
        (["0.1", "1"], "an action is 2 numbers"),
        ([0.1 + 1j, 0.0], "an action is 2 numbers"),
        (np.zeros(2, "M8[s]"), "an action is 2 numbers"),
        (np.ma.array([0.0, 0.0], mask=[True, False]), "an action is 2 numbers"),
        ([10**400, 0], "an action is 2 numbers"),
        (None, "an action"),
    ]:
        with pytest.raises(vertibench.ActionError, match=message):
            env.step(action)
    for seed in (2**63, 1.5, "one", float("inf")):
        with pytest.raises(vertibench.OptionError, match="seed"):
            env.reset(seed=seed)
    with pytest.raises(vertibench.UnknownError, match="^there is no task w999/t00 among the 30 tasks"):
        env.reset(options={"task": "w999/t00"})
    with pytest.raises(vertibench.OptionError, match="options has 'taks'"):
        env.reset(options={"taks": "w001/t00"})
    for options in (5, "ab"):
        with pytest.raises(vertibench.OptionError, match="it must be a dictionary of 'task' and 'run_seed'"):
            env.reset(options=options)
    with pytest.raises(vertibench.OptionError, match="^run_seed: -1 must lie in"):
        env.reset(options={"run_seed": -1})
    with pytest.raises(vertibench.OptionError, match="set_state: dict is not a State"):
        env.set_state({})
    observation, *_ = env.step([0.0, 0.0])
    env.reset(seed=0)
    assert np.array_equal(env.step([0.0, 0.0])[0]["state"], observation["state"])


def test_positions_of_options_are_told(envs):
    for arguments, options in [(("smoke", "w001", 3), {}), (("smoke",), {"suite": "smoke"})]:
        with pytest.raises(vertibench.OptionError, match="only suite and tasks can be given by position"):
            envs.NavigationEnv(*arguments, **options)


def test_a_copy_is_a_fresh_one_of_the_same_options(make):
    env = make(observation=["state"], render_mode="rgb_array", render_size=(64, 48))
    first, info = env.reset(seed=5)
    for again in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        assert again.spec == env.spec and again.unwrapped.spec == env.unwrapped.spec
        with pytest.raises(vertibench.EpisodeError, match="no episode is active: call reset first"):
            again.unwrapped.step([0.0, 0.0])
        seen, told = again.reset(seed=5)
        assert np.array_equal(seen["state"], first["state"]) and told == info and again.render().shape == (48, 64, 3)
        again.close()


def test_a_closed_environment_says_so(envs):
    env = envs.NavigationEnv(suite="smoke", tasks="w001")
    env.close()
    env.close()
    for call in (env.reset, env.render, env.state, lambda: env.step([0, 0])):
        with pytest.raises(vertibench.EpisodeError, match="the environment is closed: create a new one"):
            call()


@pytest.mark.parametrize("wrong", ["--stretches=0", "--envs=0", "--seconds=-1"])
def test_measurements_of_nothing_are_refused(envs, wrong, monkeypatch, capsys):
    from vertibench.envs import bench

    monkeypatch.setattr("sys.argv", ["bench", wrong])
    monkeypatch.setattr(gymnasium, "make", None)
    with pytest.raises(SystemExit) as ended:
        bench.main()
    assert ended.value.code == 2 and f"argument {wrong.split('=')[0]}: " in capsys.readouterr().err


def test_what_there_is_can_be_read(envs):
    parts, rewards = envs.describe_parts(), envs.describe_rewards()
    assert "m" in rewards["progress"] and set(EVERY_PART + SENSED) <= set(parts)
    for name in ("reset", "step", "state", "set_state", "render"):
        assert getattr(envs.NavigationEnv, name).__doc__
    assert "speed_range" in envs.NavigationEnv.__doc__ and "autoreset_mode" in envs.NavigationVectorEnv.__doc__


def test_numbers_of_all_kinds_are_actions(make):
    env = make(observation=["state"]).unwrapped
    seen = []
    for action in ([0.5, 1], np.array([0.5, 1], np.float32), np.array([0.5, 1], object), (np.float16(0.5), True), [Fraction(1, 2), 1]):
        env.reset(seed=0)
        seen.append(env.step(action)[0]["state"].tobytes())
    assert len(set(seen)) == 1


def test_the_errors_are_kinds_of_python_s(envs):
    assert issubclass(vertibench.OptionError, ValueError) and issubclass(vertibench.ActionError, ValueError)
    assert issubclass(vertibench.UnknownError, KeyError) and issubclass(vertibench.EpisodeError, RuntimeError)
    assert issubclass(vertibench.EnvError, vertibench.VertibenchError)
