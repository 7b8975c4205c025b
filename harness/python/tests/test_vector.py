"""Many environments: what each does is what it would do alone, and the forms of the libraries that learn."""

import copy
import os
import pickle
import signal
import subprocess
import sys
import threading
import types

import numpy as np
import pytest
from conftest import pursue

import vertibench

gymnasium = pytest.importorskip("gymnasium", reason="gymnasium is not installed")
NAME = "VertiBench/Navigation-v0"
OPTIONS = {"suite": "smoke", "tasks": "w001-w003", "observation": ["state", "path", "class"]}


def all_pursue(observation, speed=1.0):
    return np.array([pursue(path, speed) for path in observation["path"]], dtype=np.float64)


@pytest.fixture
def make(envs):
    made = []

    def many(num_envs=4, **options):
        made.append(envs.NavigationVectorEnv(num_envs, **{**OPTIONS, **options}))
        return made[-1]

    yield many
    for env in made:
        env.close()


def test_gymnasium_makes_it_by_its_name(envs):
    env = gymnasium.make_vec(NAME, num_envs=3, vectorization_mode="vector_entry_point", threads=2, **OPTIONS)
    assert isinstance(env.unwrapped, envs.NavigationVectorEnv) and env.num_envs == 3
    observation, infos = env.reset(seed=0)
    assert env.observation_space.contains(observation) and infos["_task"].all()
    observation, rewards, terminated, truncated, infos = env.step(env.action_space.sample())
    assert env.observation_space.contains(observation)
    assert (rewards.dtype, terminated.dtype, truncated.dtype) == (np.float64, np.bool_, np.bool_)
    env.close()


@pytest.mark.parametrize("mode", ["NEXT_STEP", "SAME_STEP"])
def test_it_does_what_gymnasium_s_own_does_over_single_ones(make, envs, mode):
    from gymnasium.vector import AutoresetMode, SyncVectorEnv

    own = make(3, threads=2, autoreset_mode=mode)
    single = [lambda: gymnasium.make(NAME, **OPTIONS)] * 3
    other = SyncVectorEnv(single, autoreset_mode=AutoresetMode[mode])
    mine, theirs = own.reset(seed=7), other.reset(seed=7)
    ends = 0
    for _ in range(420):
        for name in OPTIONS["observation"]:
            assert np.array_equal(mine[0][name], theirs[0][name])
        actions = all_pursue(mine[0])
        mine, theirs = own.step(actions), other.step(actions)
        for k in (1, 2, 3):
            assert np.array_equal(mine[k], theirs[k])
        done = mine[2] | mine[3]
        ends += done.sum()
        told, known = mine[-1], theirs[-1]
        if mode == "SAME_STEP" and done.any():
            assert np.array_equal(told["_final_obs"], known["_final_obs"])
            k = np.flatnonzero(done)[0]
            assert np.array_equal(told["final_obs"][k]["state"], known["final_obs"][k]["state"])
            told, known = told["final_info"], known["final_info"]
        if done.any():
            assert np.array_equal(told["_outcome"], known["_outcome"]) and np.array_equal(told["_outcome"], done)
            assert list(told["outcome"][done]) == list(known["outcome"][done])
            assert told["record"][np.flatnonzero(done)[0]]["state_hash"]
    assert ends >= 2, "the test wants episodes that end"
    other.close()


def test_threads_and_rows_change_nothing(make):
    def story(threads, num_envs):
        env = make(num_envs, threads=threads)
        observation, _ = env.reset(seed=3)
        for _ in range(60):
            observation, rewards, *_ = env.step(all_pursue(observation))
        return observation["state"][:2].tobytes(), rewards[:2].tobytes()

    assert story(1, 2) == story(4, 5)


def test_without_a_copy_the_arrays_are_those_that_the_threads_write(make):
    env = make(2, copy=False)
    first, _ = env.reset(seed=0)
    before = first["state"].copy()
    second, rewards, *_ = env.step(all_pursue(first))
    assert second["state"] is first["state"] and not np.array_equal(first["state"], before)
    assert rewards is env.step(all_pursue(second))[1]
    copying = make(2)
    first, _ = copying.reset(seed=0)
    before = first["state"].copy()
    copying.step(all_pursue(first))
    assert np.array_equal(first["state"], before)
    env.close()
    assert np.isfinite(second["state"]).all(), "arrays outlive the environment"


def test_send_and_recv_give_what_a_step_gives(make):
    together = make(4, threads=2)
    apart = make(4, threads=2, batch_size=2)
    observation, _ = together.reset(seed=1)
    apart.async_reset(seed=1)
    known = {k: [observation["state"][k].tobytes()] for k in range(4)}
    for _ in range(30):
        observation, *_ = together.step(all_pursue(observation))
        for k in range(4):
            known[k].append(observation["state"][k].tobytes())
    counts = dict.fromkeys(range(4), 0)
    while min(counts.values()) < 20:
        observation, rewards, terminated, truncated, infos = apart.recv()
        ids = infos["env_id"]
        assert len(ids) == 2 and observation["state"].shape == (2, 11) and rewards.shape == (2,)
        for row, k in enumerate(ids):
            if counts[k] < 30:
                assert observation["state"][row].tobytes() == known[k][counts[k]]
            counts[k] += 1
        apart.send(all_pursue(observation), ids)
    with pytest.raises(vertibench.EpisodeError, match="4 environments are busy: call recv for each, or reset"):
        apart.step(np.zeros((4, 2)))


def test_what_is_at_work_can_be_received_or_dropped(make):
    env = make(4, threads=2, batch_size=3, autoreset_mode="DISABLED")
    env.reset(seed=1)
    env.send(np.zeros((4, 2)))
    # The last batch has what is left.
    assert sorted([*env.recv()[-1]["env_id"], *env.recv()[-1]["env_id"]]) == [0, 1, 2, 3]
    with pytest.raises(vertibench.EpisodeError, match="no environment is stepping"):
        env.recv()
    env.send(np.zeros((4, 2)))
    for error, options in [
        (vertibench.UnknownError, {"task": "w999/t00"}),
        (vertibench.OptionError, {"taks": "w001/t00"}),
        (vertibench.EpisodeError, {"reset_mask": np.array([True] * 4)}),
    ]:
        with pytest.raises(error):
            env.reset(options=options)
        assert env._native().pending() == 4, "what was refused has dropped nothing"
    observation, infos = env.reset(seed=1)
    again = make(4).reset(seed=1)
    assert np.array_equal(observation["state"], again[0]["state"]) and list(infos["task"]) == list(again[1]["task"])
    env.step(np.zeros((4, 2)))


def test_episodes_begin_where_it_is_asked_for(make):
    env = make(3, autoreset_mode="DISABLED")
    tasks = ["w001/t00", "w002/t01", "w003/t02"]
    _, infos = env.reset(seed=0, options={"task": tasks, "run_seed": 9})
    assert list(infos["task"]) == tasks and list(infos["run_seed"]) == [9, 9, 9]
    observation, *_ = env.step(np.zeros((3, 2)))
    mask = np.array([False, True, False])
    again, infos = env.reset(options={"reset_mask": mask, "task": "w001/t03"})
    assert infos["task"][1] == "w001/t03" and list(infos["_task"]) == list(mask)
    assert np.array_equal(again["state"][[0, 2]], observation["state"][[0, 2]])
    for wrong in (np.zeros(3, bool), np.ones(2, bool), np.ones(3), [[True], [True, False]]):
        with pytest.raises(vertibench.OptionError, match="reset_mask: it must be 3 booleans of which at least one is True"):
            env.reset(options={"reset_mask": wrong})
    with pytest.raises(vertibench.OptionError, match="task: give 3 values"):
        env.reset(options={"task": ["w001/t00"]})
    for seeds in (np.arange(4, 7), np.array(4)):
        assert list(env.reset(seed=seeds)[1]["task"]) == list(env.reset(seed=[4, 5, 6])[1]["task"])


def test_a_state_of_one_goes_on_alone(make, envs):
    env = make(3)
    observation, _ = env.reset(seed=5)
    for _ in range(10):
        observation, *_ = env.step(all_pursue(observation))
    alone = envs.NavigationEnv(**OPTIONS)
    seen = alone.set_state(env.state(1))
    assert np.array_equal(seen["state"], observation["state"][1])
    action = all_pursue(observation)
    assert np.array_equal(alone.step(action[1])[0]["state"], env.step(action)[0]["state"][1])


def test_what_is_wrong_is_told_before_anything_is_stepped(make, envs):
    env = make(2)
    for mode in ("NEXT_STEP", "SAME_STEP", "DISABLED"):
        with pytest.raises(vertibench.EpisodeError, match="no episode is active: call reset first"):
            make(1, autoreset_mode=mode).step(np.zeros((1, 2)))
    observation, _ = env.reset(seed=0)
    for actions, message in [
        (np.zeros((3, 2)), r"actions have the shape \(2, 2\)"),
        ([[0, 0], [0, np.nan]], r"environment 1: action\[1\] \(speed\) is NaN"),
        ([["a", "b"]] * 2, "actions must be numbers"),
        ([["1", "0"]] * 2, "actions must be numbers"),
        (np.zeros((2, 2), complex), "actions must be numbers"),
        (np.zeros((2, 2), "M8[s]"), "actions must be numbers"),
        (np.ma.zeros((2, 2)), "actions must be numbers"),
        ([[10**400, 0]] * 2, "actions must be numbers"),
        ([[0, 0], [0]], "actions must be numbers"),
    ]:
        with pytest.raises(vertibench.ActionError, match=message):
            env.step(actions)
    with pytest.raises(vertibench.OptionError, match="contains an environment twice"):
        env.send(np.zeros((2, 2)), [1, 1])
    for index in (7, -1, 2**63):
        for call in (lambda k: env.send(np.zeros((1, 2)), [k]), env.state):
            with pytest.raises(vertibench.UnknownError, match=f"there is no environment {index}: there are 2"):
                call(index)
    for wrong in ([0.0, 1.0], [True, False], [[0], [1]], ["a"], [None], [[0], [0, 1]]):
        with pytest.raises(vertibench.OptionError, match="env_id must be a one-dimensional array of whole numbers"):
            env.send(np.zeros((2, 2)), wrong)
    for error, options in [
        (vertibench.UnknownError, {"task": 1.5}),
        (vertibench.UnknownError, {"task": ["w001/t00", 5]}),
        (vertibench.OptionError, {"run_seed": 1.5}),
        (vertibench.OptionError, 5),
        (vertibench.OptionError, "ab"),
    ]:
        with pytest.raises(error):
            env.reset(options=options)
    with pytest.raises(vertibench.OptionError, match="run_seed: -1 must lie in"):
        env.reset(options={"run_seed": -1})
    with pytest.raises(vertibench.EpisodeError, match="no environment is stepping"):
        env.recv()
    assert np.array_equal(env.step(all_pursue(observation))[0]["state"].shape, (2, 11))
    for options, message in [
        ({"num_envs": 0}, "num_envs: 0 must be a whole number"),
        ({"threads": -1}, "threads: -1 must"),
        ({"autoreset_mode": "never"}, "autoreset_mode: 'never' must be one of NEXT_STEP"),
        ({"num_envs": 2, "batch_size": 3}, "batch_size: 3 must lie in 1 to num_envs, which is 2"),
        ({"num_envs": float("inf")}, "num_envs: inf must be a whole number"),
        ({"threads": 0}, "threads: 0 must be a whole number"),
        ({"curriculum": 5}, "curriculum: 5 must be a name or a path"),
        ({"curriculum": "uniform", "curriculum_seed": None}, "curriculum_seed: None must be a whole number"),
        ({"curriculum": "uniform", "curriculum_seed": -1}, "curriculum_seed: -1 must be a whole number"),
        ({"max_episode_steps": 0}, "max_episode_steps: 0 must be a whole number"),
        ({"max_episode_steps": 9, "curriculum": "uniform"}, "max_episode_steps: 9: a curriculum needs the ends"),
        ({"num_envs": 2, "batch_size": 1, "autoreset_mode": "SAME_STEP", "max_episode_steps": 9}, "batch_size must be the number of environments"),
    ]:
        with pytest.raises(vertibench.OptionError, match=message):
            envs.NavigationVectorEnv(**{**OPTIONS, **options})
    env.close()
    with pytest.raises((vertibench.EpisodeError, gymnasium.error.ClosedEnvironmentError)):
        env.step(np.zeros((2, 2)))


def test_closing_while_another_thread_steps_is_told(make):
    env = make(2)
    env.reset(seed=0)
    native, closed = env._native(), []

    class Closing:
        def __getattr__(self, name):
            return getattr(native, name)

        def receive(self, count):
            arrivals = native.receive(count)
            closed.append(env.close())
            return arrivals

    env._env = Closing()
    with pytest.raises(vertibench.EpisodeError, match="the environment is closed"):
        env.step(np.zeros((2, 2)))
    assert closed


def test_a_copy_is_a_fresh_one_of_the_same_options(make, envs):
    class Own(envs.NavigationVectorEnv):
        pass

    env = gymnasium.make_vec(NAME, num_envs=2, threads=1, batch_size=1, curriculum="uniform", max_episode_steps=None, **OPTIONS)
    first, infos = env.reset(seed=3)
    for again in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        assert (again.num_envs, again.batch_size, again.spec, again.tasks) == (2, 1, env.spec, env.tasks)
        with pytest.raises(vertibench.EpisodeError, match="no episode is active: call reset first"):
            again.step(np.zeros((2, 2)))
        seen, told = again.reset(seed=3)
        assert np.array_equal(seen["state"], first["state"]) and list(told["task"]) == list(infos["task"])
        again.close()
    env.close()
    own = Own(1, **OPTIONS)
    own.mine = [7]
    again = copy.deepcopy(own)
    assert type(again) is Own and again.mine == [7] and again.mine is not own.mine


def test_attributes_and_methods_of_each_environment_can_be_asked_for(make):
    from gymnasium.vector import SyncVectorEnv

    own = make(2, threads=1, render_mode="rgb_array", render_size=(32, 24))
    assert own.get_attr("task") == (None, None)
    theirs = SyncVectorEnv([lambda: gymnasium.make(NAME, render_mode="rgb_array", render_size=(32, 24), **OPTIONS)] * 2)
    for one in (own, theirs):
        one.reset(seed=3)
        one.step(np.full((2, 2), 0.5, np.float32))
    for name in ("task", "vehicle", "tasks", "reward_weights"):
        for mine, other in zip(own.get_attr(name), theirs.get_attr(name)):
            assert repr(mine) == repr(other), name
    for mine, other in zip(own.call("render"), theirs.call("render")):
        assert np.array_equal(mine, other)
    single = gymnasium.make(NAME, **OPTIONS).unwrapped
    for k, state in enumerate(own.call("state")):
        single.set_state(state)
        assert repr(single.vehicle) == repr(own.get_attr("vehicle")[k])
    for name in ("step", "reset", "close", "_env", "no_such"):
        with pytest.raises(vertibench.UnknownError, match=f"call: environments have no '{name}'; there are task, "):
            own.call(name)
    with pytest.raises(vertibench.OptionError, match="set_attr: 'reward_weights' can't be set"):
        own.set_attr("reward_weights", {})
    own.close()
    with pytest.raises(vertibench.EpisodeError, match="closed"):
        own.get_attr("task")


@pytest.mark.parametrize("mode", ["NEXT_STEP", "SAME_STEP"])
def test_a_limit_of_steps_is_that_of_gymnasium(envs, mode):
    from gymnasium.vector import AutoresetMode, SyncVectorEnv

    # One stands still, and so is stuck after 100 steps.
    for most in (7, 100):
        own = gymnasium.make_vec(NAME, num_envs=2, threads=2, autoreset_mode=mode, max_episode_steps=most, **OPTIONS)
        single = [lambda: gymnasium.make(NAME, max_episode_steps=most, **OPTIONS)] * 2
        other = SyncVectorEnv(single, autoreset_mode=AutoresetMode[mode])
        mine, theirs = own.reset(seed=7), other.reset(seed=7)
        ends = 0
        for _ in range(2 * most + 10):
            assert np.array_equal(mine[0]["state"], theirs[0]["state"])
            actions = np.array([pursue(mine[0]["path"][0], 0.5), [0.0, -1.0]])
            mine, theirs = own.step(actions), other.step(actions)
            for k in (1, 2, 3):
                assert np.array_equal(mine[k], theirs[k]), k
            done = mine[2] | mine[3]
            ends += done.sum()
            if mode == "SAME_STEP" and done.any():
                k = np.flatnonzero(done)[0]
                assert np.array_equal(mine[-1]["final_obs"][k]["state"], theirs[-1]["final_obs"][k]["state"])
        assert ends >= 3 and mine[0]["state"].shape == (2, 11)
        own.close()
        other.close()


def test_a_limit_of_steps_without_autoreset_asks_for_a_reset(make):
    env = make(2, autoreset_mode="DISABLED", max_episode_steps=3, batch_size=1)
    env.reset(seed=0)
    for k in range(3):
        truncated = env.step(np.zeros((2, 2)))[3]
        assert list(truncated) == [k == 2] * 2
    with pytest.raises(vertibench.EpisodeError, match=r"the episode has ended \(max_episode_steps is 3\): call reset"):
        env.step(np.zeros((2, 2)))
    env.reset(options={"reset_mask": np.array([True, False])})
    env.send(np.zeros((1, 2)), [0])
    assert not env.recv()[3].any()


def test_a_curriculum_is_told_what_makes_no_sense(make):
    env = make(2, curriculum="replay")
    with pytest.raises(vertibench.OptionError, match="restore: NoneType is not a state of a curriculum"):
        env.curriculum.restore(None)
    for score in ("a", float("nan")):
        with pytest.raises(vertibench.OptionError, match="score: "):
            env.curriculum.score(env.tasks[0], score)
    with pytest.raises(vertibench.UnknownError, match="there is no task 5"):
        env.curriculum.score(5, 1.0)


def test_stages_without_tasks_ask_for_more_worlds(envs):
    with pytest.raises(vertibench.OptionError, match="manual: stages.* matches none of .*: generate more training worlds, e.g. worlds=36"):
        envs.NavigationVectorEnv(1, worlds=1, curriculum="manual")


def test_pictures_of_all(make):
    env = make(2, render_mode="rgb_array", render_size=(80, 60))
    env.reset(seed=0)
    pictures = env.render()
    assert len(pictures) == 2 and all(p.shape == (60, 80, 3) for p in pictures)


_SCRIPT = """
import numpy as np, os, signal, sys, time
# A shell starts what runs in its background with Ctrl-C ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
from vertibench.envs import NavigationVectorEnv
env = NavigationVectorEnv(64, suite="smoke", tasks="w001-w003", observation=["state"])
env.reset(seed=0)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="forks are not installed here")
def test_a_fork_is_told_instead_of_waited_for(envs):
    script = _SCRIPT + """
if os.fork() == 0:
    try:
        env.step(np.zeros((64, 2)))
    except Exception as e:
        print(type(e).__name__, e, flush=True)
    os._exit(0)
os.wait()
env.step(np.zeros((64, 2)))
print("and the parent goes on")
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120, check=False)
    assert "EpisodeError the vector environment was made in another process" in done.stdout, done.stderr
    assert "and the parent goes on" in done.stdout


@pytest.mark.skipif(sys.platform == "win32", reason="signals are not installed here")
def test_ctrl_c_ends_the_waiting(envs):
    script = _SCRIPT + """
print("begun", flush=True)
try:
    while True:
        env.step(np.zeros((64, 2)))
except KeyboardInterrupt:
    print("interrupted", flush=True)
    env.reset(seed=0)
    env.step(np.zeros((64, 2)))
    print("goes on", flush=True)
"""
    child = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
    try:
        assert child.stdout.readline() == "begun\n"
        threading.Event().wait(0.5)
        child.send_signal(signal.SIGINT)
        told, _ = child.communicate(timeout=60)
        assert told == "interrupted\ngoes on\n" and child.returncode == 0
    finally:
        # One that can't be interrupted would drive for ever.
        child.kill()


def test_two_threads_at_once_are_told(make):
    env = make(32)
    observation, _ = env.reset(seed=0)
    told = []

    def step():
        try:
            for _ in range(20):
                env.step(np.zeros((32, 2)))
        except vertibench.EpisodeError as e:
            told.append(str(e))

    threads = [threading.Thread(target=step) for _ in range(2)]
    [t.start() for t in threads]
    [t.join(60) for t in threads]
    assert told and all("another thread" in t or "are busy" in t or "no environment" in t for t in told), told


def test_stable_baselines_trains_on_it(envs):
    pytest.importorskip("stable_baselines3", reason="stable-baselines3 is not installed")
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecNormalize

    from vertibench.envs.sb3 import make_vec

    env = make_vec(4, **{**OPTIONS, "observation": "flat"})
    env.seed(3)
    observation = env.reset()
    assert observation.shape == (4, env.observation_space.shape[0])
    for _ in range(120):
        observation, rewards, dones, infos = env.step(np.tile([0.0, -1.0], (4, 1)))
    assert not dones.any()
    ends = []
    for _ in range(320):
        observation, rewards, dones, infos = env.step(np.tile([0.0, -1.0], (4, 1)))
        ends += [infos[k] for k in np.flatnonzero(dones)]
    assert ends and all(e["outcome"] == "stuck" and not e["TimeLimit.truncated"] for e in ends)
    assert all(e["episode"]["l"] == 100 and e["terminal_observation"].shape == observation[0].shape for e in ends)
    model = PPO("MlpPolicy", VecNormalize(make_vec(4, **{**OPTIONS, "observation": "flat"})), n_steps=32, batch_size=64, seed=0)
    model.learn(256)
    env.close()


@pytest.fixture
def sb3(envs, monkeypatch):
    """The form of stable-baselines3, over the base class that its release 2.9 publishes where the library isn't installed."""
    try:
        import stable_baselines3  # noqa: F401
    except ImportError:

        class VecEnv:
            def __init__(self, num_envs, observation_space, action_space):
                self.num_envs, self.observation_space, self.action_space = num_envs, observation_space, action_space
                self._reset_seeds()
                self._reset_options()

            def _reset_seeds(self):
                self._seeds = [None] * self.num_envs

            def _reset_options(self):
                self._options = [{} for _ in range(self.num_envs)]

            def set_options(self, options):
                self._options = [options] * self.num_envs if isinstance(options, dict) else options

        for name in ("stable_baselines3", "stable_baselines3.common", "stable_baselines3.common.vec_env"):
            monkeypatch.setitem(sys.modules, name, types.SimpleNamespace(VecEnv=VecEnv))
    sys.modules.pop("vertibench.envs.sb3", None)
    import vertibench.envs.sb3

    yield vertibench.envs.sb3
    sys.modules.pop("vertibench.envs.sb3", None)


def test_the_form_of_stable_baselines_keeps_its_promises(sb3):
    env = sb3.make_vec(2, **OPTIONS, max_episode_steps=5)
    env.set_options([{"task": "w001/t02", "run_seed": 7}, {"task": "w003/t01"}])
    env.reset()
    assert [info["task"] for info in env.reset_infos] == ["w001/t02", "w003/t01"] and env.reset_infos[0]["run_seed"] == 7
    env.set_options({"task": "w002/t00"})
    # A step that nobody has waited for is dropped.
    env.step_async(np.zeros((2, 2)))
    env.reset()
    assert [info["task"] for info in env.reset_infos] == ["w002/t00"] * 2
    for k in range(5):
        env.step_async(np.tile([0.0, 1.0], (2, 1)))
        _, rewards, dones, infos = env.step_wait()
        assert np.allclose([sum(info["reward_terms"].values()) for info in infos], rewards, atol=1e-6)
    assert dones.all() and all(info["TimeLimit.truncated"] and info["episode"]["l"] == 5 for info in infos)
    assert infos[0]["terminal_observation"]["state"].shape == (11,) and infos[0]["episode"]["t"] == pytest.approx(0.5)
    env.set_options({"taks": "w002/t00"})
    with pytest.raises(vertibench.OptionError, match="options has 'taks'"):
        env.reset()
    env.close()


def test_torchrl_rolls_it_out(envs):
    gym = pytest.importorskip("torchrl.envs.libs.gym", reason="TorchRL is not installed")
    from torchrl.envs import check_env_specs

    one = gym.GymWrapper(gymnasium.make("VertiBench/Navigation-v0", disable_env_checker=True, **OPTIONS))
    check_env_specs(one)
    many = gym.GymWrapper(gymnasium.make_vec("VertiBench/Navigation-v0", num_envs=3, autoreset_mode="DISABLED", **OPTIONS))
    check_env_specs(many)
    # Longer than an episode that stands still, so that TorchRL begins some anew.
    rolled = many.rollout(700, break_when_any_done=False)
    assert rolled.shape == (3, 700) and rolled["next", "done"].any() and rolled["next", "reward"].isfinite().all()


def test_puffer_s_form(envs, monkeypatch):
    # PufferLib isn't for every machine: its base class, as release 3.0 publishes it, is stood in for.
    class PufferEnv:
        def __init__(self, buf=None):
            shape = self.single_observation_space.shape
            self.observations = np.zeros((self.num_agents, *shape), np.float32)
            self.rewards = np.zeros(self.num_agents, np.float32)
            self.terminals, self.truncations = np.zeros((2, self.num_agents), bool)

    monkeypatch.setitem(sys.modules, "pufferlib", types.SimpleNamespace(PufferEnv=PufferEnv))
    sys.modules.pop("vertibench.envs.puffer", None)
    from vertibench.envs.puffer import PufferNavigation

    env = PufferNavigation(num_envs=3, suite="smoke", tasks="w001-w003", seed=2)
    observation, infos = env.reset()
    assert observation is env.observations and infos == [] and np.abs(observation).sum() > 0
    # Without throttle each vehicle is stuck, after 10 s if its start is level and later if it rolls first.
    ended = np.zeros(3, bool)
    for step in range(1, 400):
        observation, rewards, terminals, truncations, infos = env.step(np.tile([0.0, -1.0], (3, 1)))
        assert observation is env.observations and rewards is env.rewards and terminals is env.terminals
        assert len(infos) == (terminals | truncations).sum()
        if not ended.any():
            assert all(t["episode_length"] == step and step - 1 < 10 * t["time_s"] <= step for t in infos)
        assert all(t["episode_length"] >= 100 and t["success"] == 0.0 for t in infos)
        ended |= terminals
        if ended.all():
            break
    assert ended.all()
    env.close()
    sys.modules.pop("vertibench.envs.puffer", None)
