"""Vector environment for PufferLib: one `PufferEnv` with one agent per environment.

>>> import pufferlib.vector
>>> from vertibench.envs.puffer import PufferNavigation
>>> env = pufferlib.vector.make(PufferNavigation, env_kwargs={"num_envs": 64})      # in this process: threads are in Rust

Observations are flat, as PufferLib needs them.
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
    """`NavigationVectorEnv` with the interface of PufferLib's `PufferEnv`.

    Results are written into PufferLib's buffers. The next episode begins at once (`SAME_STEP`).

    Args:
        num_envs: Number of environments, 1 to 65536; default 16.
        buf: PufferLib's buffers. None (default): PufferLib allocates them.
        seed: Seed of a `reset` without one; default 0.
        **options: Arguments of `NavigationVectorEnv` except `autoreset_mode` and `copy`, by name. `observation` is
            `"flat"` by default; the parts of other observations are flattened.

    Attributes:
        vector: The wrapped `NavigationVectorEnv`.

    Raises:
        OptionError: If an argument is unknown or invalid.
    """

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
        """Begins episodes in all environments.

        Args:
            seed: Seed s gives environment k the seed s + k. None (default): the seed of the constructor.

        Returns:
            Observations of shape (num_envs, width), float32, and an empty list.
        """
        observations, _ = self.vector.reset(seed=self._seed if seed is None else seed)
        self.observations[:] = observations
        self._returns[:] = 0.0
        self._lengths[:] = 0
        return self.observations, []

    def step(self, actions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Steps all environments.

        Args:
            actions: Array of shape (num_envs, numbers per action).

        Returns:
            PufferLib's buffers of observations, rewards, terminals and truncations, and one dictionary per ended
            episode, whose numbers PufferLib averages: `episode_return`, `episode_length` in steps, `success` (0 or 1)
            and `time_s`.

        Raises:
            ActionError: If the shape is wrong, or a number is not real and finite.
        """
        observations, rewards, terminated, truncated, told = self.vector.step(actions)
        self.observations[:], self.rewards[:] = observations, rewards
        self.terminals[:], self.truncations[:] = terminated, truncated
        self._returns += rewards
        self._lengths += 1
        infos = []
        for k in np.flatnonzero(terminated | truncated):
            # An episode that `max_episode_steps` ended has no record.
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
        """Renders the first environment.

        Returns:
            Image of shape (height, width, 3), uint8; None without a render mode.
        """
        pictures = self.vector.render()
        return None if pictures is None else pictures[0]

    def close(self) -> None:
        """Releases the environments; the threads end when no array of the environments is held."""
        self.vector.close()
