"""Many environments for PufferLib: one `PufferEnv` of as many agents as there are environments.

>>> import pufferlib.vector
>>> from vertibench.envs.puffer import PufferNavigation
>>> env = pufferlib.vector.make(PufferNavigation, env_kwargs={"num_envs": 64})      # in this process: the threads are Rust's

Observations are flat, as PufferLib wants them. What the environment is made of is `NavigationVectorEnv`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

try:
    import pufferlib
except ImportError as e:
    from .._errors import MissingPackageError

    raise MissingPackageError("pufferlib", "vertibench.envs.puffer") from e

from ._vector import NavigationVectorEnv


class PufferNavigation(pufferlib.PufferEnv):
    """A `NavigationVectorEnv` in PufferLib's form: it writes into PufferLib's buffers, and begins the next episode at once. `options`
    are those of `NavigationVectorEnv`."""

    def __init__(self, num_envs: int = 16, buf: Any = None, seed: int = 0, **options: Any) -> None:
        options = {"observation": "flat", **options}
        if options["observation"] != "flat":
            options["flat"] = True
        self.vector = NavigationVectorEnv(num_envs, autoreset_mode="SAME_STEP", copy=False, **options)
        self.single_observation_space = self.vector.single_observation_space
        self.single_action_space = self.vector.single_action_space
        self.num_agents = num_envs
        self.render_mode = self.vector.render_mode
        self._seed = seed
        self._returns, self._lengths = np.zeros(num_envs), np.zeros(num_envs, dtype=np.int64)
        super().__init__(buf)

    def reset(self, seed: int | None = None) -> tuple[np.ndarray, list[dict[str, Any]]]:
        """Begins episodes in all environments."""
        observations, _ = self.vector.reset(seed=self._seed if seed is None else seed)
        self.observations[:] = observations
        self._returns[:] = 0.0
        self._lengths[:] = 0
        return self.observations, []

    def step(self, actions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Steps all environments. Each episode that has ended is told by a dictionary of numbers, which PufferLib averages."""
        observations, rewards, terminated, truncated, told = self.vector.step(actions)
        self.observations[:], self.rewards[:] = observations, rewards
        self.terminals[:], self.truncations[:] = terminated, truncated
        self._returns += rewards
        self._lengths += 1
        infos = []
        for k in np.flatnonzero(terminated | truncated):
            # What `max_episode_steps` has cut off has no record.
            record = told["final_info"]["record"][k] if "final_info" in told and told["_final_info"][k] else {}
            infos.append({
                "episode_return": float(self._returns[k]),
                "episode_length": int(self._lengths[k]),
                "success": float(record.get("outcome") == "success"),
                "time_s": record.get("time_s", self.vector._setup.arena.control_period * int(self._lengths[k])),
            })
            self._returns[k], self._lengths[k] = 0.0, 0
        return self.observations, self.rewards, self.terminals, self.truncations, infos

    def render(self) -> np.ndarray | None:
        """A picture of the first environment."""
        pictures = self.vector.render()
        return None if pictures is None else pictures[0]

    def close(self) -> None:
        """Lets go of everything; the threads end when no array of the environments is held any more."""
        self.vector.close()
