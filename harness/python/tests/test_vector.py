"""Many environments: what each does is what it would do alone, and the forms of the libraries that learn."""

import os
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
    with pytest.raises(vertibench.EpisodeError, match="at work: call recv first"):
        apart.step(np.zeros((4, 2)))


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
    for wrong in (np.zeros(3, bool), np.ones(2, bool), np.ones(3)):
        with pytest.raises(vertibench.OptionError, match="reset_mask: it must be 3 booleans"):
            env.reset(options={"reset_mask": wrong})
    with pytest.raises(vertibench.OptionError, match="task: there must be 3"):
        env.reset(options={"task": ["w001/t00"]})


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
        with pytest.raises(vertibench.EpisodeError, match="there is no episode: call reset first"):
            make(1, autoreset_mode=mode).step(np.zeros((1, 2)))
    observation, _ = env.reset(seed=0)
    for actions, message in [
        (np.zeros((3, 2)), r"actions have the shape \(2, 2\)"),
        (np.full((2, 2), np.nan), r"action\[0\] \(steering\) is NaN"),
        ([["a", "b"]] * 2, "actions must be numbers"),
    ]:
        with pytest.raises(vertibench.ActionError, match=message):
            env.step(actions)
    with pytest.raises(vertibench.OptionError, match="names an environment twice"):
        env.send(np.zeros((2, 2)), [1, 1])
    with pytest.raises(vertibench.UnknownError, match="there is no environment"):
        env.send(np.zeros((1, 2)), [7])
    with pytest.raises(vertibench.EpisodeError, match="no environment is at work"):
        env.recv()
    assert np.array_equal(env.step(all_pursue(observation))[0]["state"].shape, (2, 11))
    for options, message in [
        ({"num_envs": 0}, "num_envs: 0 must be a whole number"),
        ({"threads": -1}, "threads: -1 must"),
        ({"autoreset_mode": "never"}, "autoreset_mode: 'never' must be one of NEXT_STEP"),
        ({"num_envs": 2, "batch_size": 3}, "batch_size: 3 must lie in 1 to num_envs, which is 2"),
    ]:
        with pytest.raises(vertibench.OptionError, match=message):
            envs.NavigationVectorEnv(**{**OPTIONS, **options})
    env.close()
    with pytest.raises((vertibench.EpisodeError, gymnasium.error.ClosedEnvironmentError)):
        env.step(np.zeros((2, 2)))


def test_pictures_of_all(make):
    env = make(2, render_mode="rgb_array", render_size=(80, 60))
    env.reset(seed=0)
    pictures = env.render()
    assert len(pictures) == 2 and all(p.shape == (60, 80, 3) for p in pictures)


_SCRIPT = """
import numpy as np, os, sys, time
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
    while env._native().pending():
        env._receive(env._native(), env._native().pending())
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
    assert told and all("another thread" in t or "at work" in t or "no environment" in t for t in told), told


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
    told = []
    for _ in range(101):
        observation, rewards, terminals, truncations, infos = env.step(np.tile([0.0, -1.0], (3, 1)))
        assert observation is env.observations and rewards is env.rewards and terminals is env.terminals
        told += infos
    assert len(told) == 3 and all(t["episode_length"] == 100 and t["success"] == 0.0 for t in told)
    env.close()
    sys.modules.pop("vertibench.envs.puffer", None)
