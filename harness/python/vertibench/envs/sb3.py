"""Vector environment for stable-baselines3, which has its own interface for vector environments.

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
    """`NavigationVectorEnv` with the interface of stable-baselines3's `VecEnv`.

    The next episode begins at once (`SAME_STEP`). At the end of an episode `infos[k]` has its last observation in
    `"terminal_observation"` and the next task in `"next_task"`; `"TimeLimit.truncated"` is True if it was truncated.

    Args:
        num_envs: Number of environments, 1 to 65536.
        **options: Arguments of `NavigationVectorEnv` except `autoreset_mode`, by name.

    Attributes:
        vector: The wrapped `NavigationVectorEnv`.
        reset_infos: Per environment, `task` and `run_seed` of the episode that the last `reset` began.

    Raises:
        OptionError: If an argument is unknown or invalid.
    """

    def __init__(self, num_envs: int, **options: Any) -> None:
        self.vector = NavigationVectorEnv(num_envs, autoreset_mode="SAME_STEP", **options)
        self.render_mode = self.vector.render_mode
        super().__init__(num_envs, self.vector.single_observation_space, self.vector.single_action_space)
        self._returns, self._lengths = np.zeros(num_envs), np.zeros(num_envs, dtype=np.int64)

    def reset(self) -> Any:
        """Begins episodes in all environments.

        Uses the seeds of `seed()` and the options `"task"` and `"run_seed"` of `set_options()` once. A pending step is
        dropped.

        Returns:
            The first observations.

        Raises:
            OptionError: If an option is unknown or invalid.
            UnknownError: If there is no such task.
            EpisodeError: If the simulation fails at a start, or the environment can't be used.
        """
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
        """Returns the options of `set_options` by name, one value per environment."""
        given = self._options
        if len(given) != self.num_envs or not all(isinstance(own, dict) for own in given):
            raise OptionError(f"set_options: give one dictionary, or {self.num_envs}, one per environment")
        names = dict.fromkeys(name for own in given for name in own)
        return {name: [own.get(name) for own in given] for name in names}

    def step_async(self, actions: np.ndarray) -> None:
        """Begins a step of all environments.

        Args:
            actions: Array of shape (num_envs, numbers per action).

        Raises:
            ActionError: If the shape is wrong, or a number is not real and finite.
            EpisodeError: If a step is pending, there is no episode, or the environment can't be used.
        """
        self.vector.send(actions)

    def step_wait(self) -> tuple[Any, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Waits for the step.

        Returns:
            Observations; rewards (float32) and dones (bool), each of shape (num_envs,); and one information dictionary
            per environment. It has the value of each reward term in `"reward_terms"`. At the end of an episode it also
            has `outcome`, `is_success`, `record`, and, as with SB3's Monitor, `"episode"`: return `r`, length `l` in
            steps and simulated duration `t` in s. An episode that `max_episode_steps` ended has no `outcome`,
            `is_success` and `record`.

        Raises:
            EpisodeError: If no step is pending, or the environment can't be used.
        """
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
            # An episode that `max_episode_steps` ended has no record.
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
        """Releases the environments and ends the threads."""
        self.vector.close()

    def get_images(self) -> Sequence[np.ndarray | None]:
        """Renders every environment.

        Returns:
            Images of shape (height, width, 3), uint8; None for each environment without a render mode.
        """
        return self.vector.render() or [None] * self.num_envs

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Reads an attribute that all environments share.

        Args:
            attr_name: Attribute of `NavigationVectorEnv`.
            indices: Index or indices of environments. None (default): all.

        Returns:
            The value, once per index.

        Raises:
            AttributeError: If there is no such attribute.
        """
        return [getattr(self.vector, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Refuses the change: attributes are shared and fixed.

        Args:
            attr_name: Attribute name.
            value: Ignored.
            indices: Ignored.

        Raises:
            AttributeError: Always.
        """
        raise AttributeError(f"{attr_name}: the environments share their options: create new ones with other options")

    def env_method(self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any) -> list[Any]:
        """Calls a method of `NavigationVectorEnv` that takes an index, i.e. `state`; call other methods on `vector`.

        Args:
            method_name: `"state"`.
            *method_args: Further positional arguments.
            indices: Index or indices of environments. None (default): all.
            **method_kwargs: Keyword arguments.

        Returns:
            One result per index.

        Raises:
            AttributeError: If there is no such method.
        """
        method = getattr(self.vector, method_name)
        return [method(index, *method_args, **method_kwargs) for index in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Returns whether environments are wrapped; True only for SB3's Monitor, whose records this class provides.

        Args:
            wrapper_class: Wrapper class.
            indices: Index or indices of environments. None (default): all.

        Returns:
            One bool per index.
        """
        from stable_baselines3.common.monitor import Monitor

        return [wrapper_class is Monitor for _ in self._get_indices(indices)]


def make_vec(num_envs: int, **options: Any) -> Sb3VecEnv:
    """Creates a vector environment for stable-baselines3.

    Args:
        num_envs: Number of environments, 1 to 65536.
        **options: Arguments of `NavigationVectorEnv` except `autoreset_mode`, by name.

    Returns:
        The vector environment.

    Raises:
        OptionError: If an argument is unknown or invalid.
    """
    return Sb3VecEnv(num_envs, **options)
