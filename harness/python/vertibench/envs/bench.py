"""Measures the speed of environments: `python -m vertibench.envs.bench`.

Each figure is the median of several intervals of the same length. A vehicle follows the path of its task at 3 m/s with
ten actions per second, so the simulation does the work of driving, not of standing still. The last lines are
gymnasium's own vector environments over the single environment, for comparison.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np

from .._command import above_zero, whole_number
from ._vector import processors

NAME = "VertiBench/Navigation-v0"
STATE = ("state", "path")
# Simulation time step of the shipped policies' training (`tasks/training/policy.yaml`), s.
TRAINING_STEP = 0.005


def pursue(observation: Any) -> np.ndarray:
    """Steers to the third path point, 6 m ahead, at half of the maximum speed.

    Args:
        observation: Dictionary with `path`, of shape (..., points, 2): metres ahead and to the left.

    Returns:
        Actions of shape (..., 2), float32.
    """
    point = observation["path"][..., 2, :]
    steering = np.clip(1.5 * point[..., 1] / np.maximum(np.abs(point[..., 0]), 1.0), -1.0, 1.0)
    return np.stack([steering, np.zeros_like(steering)], axis=-1).astype(np.float32)


def steps_a_second(env: Any, seconds: float, stretches: int) -> float:
    """Measures the speed of an environment.

    Args:
        env: Vector environment or single environment.
        seconds: Length of an interval, s.
        stretches: Number of intervals; one more is run before to load worlds.

    Returns:
        Median number of actions per second, summed over all environments.
    """
    count = getattr(env, "num_envs", 1)
    is_single = not hasattr(env, "num_envs")
    observation, _ = env.reset(seed=0)

    def stretch() -> float:
        nonlocal observation
        done, begin = 0, time.perf_counter()
        while time.perf_counter() - begin < seconds:
            observation, _, terminated, truncated, _ = env.step(pursue(observation))
            if is_single and (terminated or truncated):
                observation, _ = env.reset()
            done += count
        return done / (time.perf_counter() - begin)

    stretch()  # Loads worlds.
    return statistics.median(stretch() for _ in range(stretches))


def reset_ms(env: gymnasium.Env, tasks: list[str]) -> tuple[float, float]:
    """Measures the duration of a reset.

    Args:
        env: Single environment.
        tasks: Task names, all in one world; at least two.

    Returns:
        Median duration, ms, of a reset to a task that was begun before, and of the first reset to a task in a loaded
        world.
    """

    def times() -> list[float]:
        spent = []
        for task in tasks:
            begin = time.perf_counter()
            env.reset(options={"task": task})
            spent.append(1e3 * (time.perf_counter() - begin))
        return spent

    first, again = times()[1:], times()
    return statistics.median(again), statistics.median(first)


def main() -> None:
    """Runs all measurements and prints them."""
    parser = argparse.ArgumentParser(prog="python -m vertibench.envs.bench", description=__doc__)
    parser.add_argument("--seconds", type=above_zero, default=2.0, help="length of a stretch (default: 2)")
    parser.add_argument("--stretches", type=whole_number, default=5, help="number of stretches (default: 5)")
    parser.add_argument("--envs", type=whole_number, default=16, help="environments of a vector environment (default: 16)")
    chosen = parser.parse_args()
    threads = processors()

    def show(what: str, make: Callable[[], Any]) -> None:
        env = make()
        print(f"{what:62} {steps_a_second(env, chosen.seconds, chosen.stretches):8.0f} steps/s", flush=True)
        env.close()

    def vector(tasks: str, threads: int, observation: tuple[str, ...] = STATE, **options: Any) -> Callable[[], Any]:
        return lambda: gymnasium.make_vec(
            NAME,
            num_envs=chosen.envs,
            vectorization_mode="vector_entry_point",
            threads=threads,
            suite="vb-100",
            tasks=tasks,
            observation=observation,
            **options,
        )

    def single(tasks: str) -> gymnasium.Env:
        return gymnasium.make(NAME, suite="vb-100", tasks=tasks, observation=STATE)

    rigid = "terrain=rigid"
    for what, tasks in (("low, rigid", f"{rigid},elevation=low"), ("rigid", rigid), ("deformable", "terrain=deformable")):
        show(f"{what}: one environment", lambda tasks=tasks: single(tasks))
        for count in sorted({1, threads // 2 or 1, threads}):
            show(f"{what}: {chosen.envs} environments, {count} threads", vector(tasks, count))
    for what, tasks in (("rigid", rigid), ("deformable", "terrain=deformable")):
        label = f"{what}: {chosen.envs} environments, {threads} threads, step of {1e3 * TRAINING_STEP:.0f} ms"
        show(label, vector(tasks, threads, time_step=TRAINING_STEP))
    crops = (*STATE, "height", "class", "friction")
    show(f"rigid: {chosen.envs} environments, {threads} threads, with three crops", vector(rigid, threads, crops))
    env = single(rigid)
    again, first = reset_ms(env, env.unwrapped.tasks[:10])
    print(f"{'rigid: reset of a task that was begun before':62} {again:8.2f} ms")
    print(f"{'rigid: reset of a task that is begun for the first time':62} {first:8.2f} ms")
    env.close()
    for name, kind in (("AsyncVectorEnv", gymnasium.vector.AsyncVectorEnv), ("SyncVectorEnv", gymnasium.vector.SyncVectorEnv)):
        makers = [lambda: single(rigid)] * chosen.envs
        show(f"rigid: {chosen.envs} environments in gymnasium's {name}", lambda: kind(makers))


if __name__ == "__main__":
    main()
