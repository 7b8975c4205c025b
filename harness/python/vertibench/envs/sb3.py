"""Many environments for stable-baselines3, which has a kind of vector environment of its own.

>>> from stable_baselines3 import PPO
>>> from vertibench.envs.sb3 import make_vec
>>> model = PPO("MultiInputPolicy", make_vec(8, observation=["state", "path", "height"])).learn(100_000)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

try:
    from stable_baselines3.common.vec_env import VecEnv
except ImportError as e:
    from .._errors import MissingPackageError

    raise MissingPackageError("stable-baselines3", "vertibench.envs.sb3", "sb3") from e

from .._errors import OptionError
from ._common import TERMS
from ._vector import NavigationVectorEnv


class Sb3VecEnv(VecEnv):
    """A `NavigationVectorEnv` in stable-baselines3's form: it begins the next episode at once, and tells the last observation in
    `infos[k]["terminal_observation"]` and whether time ran out in `infos[k]["TimeLimit.truncated"]`. What each term of
    the reward was worth is in `infos[k]["reward_terms"]`."""

    def __init__(self, num_envs: int, **options: Any) -> None:
        self.vector = NavigationVectorEnv(num_envs, autoreset_mode="SAME_STEP", **options)
        self.render_mode = self.vector.render_mode
        super().__init__(num_envs, self.vector.single_observation_space, self.vector.single_action_space)
        self._returns, self._lengths = np.zeros(num_envs), np.zeros(num_envs, dtype=np.int64)

    def reset(self) -> Any:
        """Begins episodes in all environments, with the seeds of `seed` and the `"task"` and `"run_seed"` of `set_options`; gives their
        first observations. A step that nobody has waited for is dropped."""
        seeds = list(self._seeds)
        options = self._chosen()
        observations, infos = self.vector.reset(seed=seeds if any(s is not None for s in seeds) else None, options=options)
        self._reset_seeds()
        self._reset_options()
        self.reset_infos = [{"task": task, "run_seed": int(seed)} for task, seed in zip(infos["task"], infos["run_seed"])]
        self._returns[:] = 0.0
        self._lengths[:] = 0
        return observations

    def _chosen(self) -> dict[str, list[Any]]:
        """What `set_options` has given for each environment."""
        given = self._options
        if len(given) != self.num_envs or not all(isinstance(own, dict) for own in given):
            raise OptionError(f"set_options: there must be a dictionary, or {self.num_envs}, one for each environment")
        names = dict.fromkeys(name for own in given for name in own)
        return {name: [own.get(name) for own in given] for name in names}

    def step_async(self, actions: np.ndarray) -> None:
        """Begins a step of all environments."""
        self.vector.send(actions)

    def step_wait(self) -> tuple[Any, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Waits for the step. The reward of a whole episode and its length are in `infos[k]["episode"]`, as SB3's Monitor has
        them."""
        native = self.vector._native()
        _, told = self.vector._receive(native, self.num_envs)
        observations = self.vector._observations(None)
        rewards, terminated, truncated = self.vector._numbers(None)
        self._returns += rewards
        self._lengths += 1
        worth = zip(*(values.tolist() for values in told["reward_terms"].values()))
        infos: list[dict[str, Any]] = [{"reward_terms": dict(zip(TERMS, w)), "TimeLimit.truncated": False} for w in worth]
        period = self.vector._setup.arena.control_period
        for k in np.flatnonzero(terminated | truncated):
            # What `max_episode_steps` has cut off has no record.
            has_record = "final_info" in told and told["_final_info"][k]
            final = {name: v[k] for name, v in told["final_info"].items() if not name.startswith("_")} if has_record else {}
            seconds = final["record"]["time_s"] if has_record else period * int(self._lengths[k])
            infos[k].update(
                final,
                next_task=told["task"][k],
                terminal_observation=told["final_obs"][k],
                episode={"r": float(self._returns[k]), "l": int(self._lengths[k]), "t": seconds},
            )
            infos[k]["TimeLimit.truncated"] = bool(truncated[k] and not terminated[k])
            self._returns[k], self._lengths[k] = 0.0, 0
        return observations, rewards.astype(np.float32), terminated | truncated, infos

    def close(self) -> None:
        """Lets go of everything; the threads end."""
        self.vector.close()

    def get_images(self) -> Sequence[np.ndarray | None]:
        """A picture of each environment."""
        return self.vector.render() or [None] * self.num_envs

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute that all environments share, once for each of `indices`."""
        return [getattr(self.vector, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Environments share their attributes, which are fixed: this always fails."""
        raise AttributeError(f"{attr_name}: the environments share their options: make new ones with other options")

    def env_method(self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any) -> list[Any]:
        """Calls `state` of single environments; other methods are of all environments and are called on `vector`."""
        method = getattr(self.vector, method_name)
        return [method(index, *method_args, **method_kwargs) for index in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Whether an environment is wrapped: SB3 asks for its Monitor, whose work is done here."""
        from stable_baselines3.common.monitor import Monitor

        return [wrapper_class is Monitor for _ in self._get_indices(indices)]


def make_vec(num_envs: int, **options: Any) -> Sb3VecEnv:
    """So many environments for stable-baselines3. `options` are those of `NavigationVectorEnv`."""
    return Sb3VecEnv(num_envs, **options)
