"""Algorithms by name."""

from __future__ import annotations

from stable_baselines3.common.vec_env import VecEnv

from ._config import Config
from ._method import Method
from ._network import Parts
from ._ppo import Ppo
from ._sac import Sac

_ALGORITHMS: dict[str, type[Ppo] | type[Sac]] = {"ppo": Ppo, "sac": Sac}


def make_method(config: Config, envs: VecEnv, parts: Parts, seed: int) -> Method:
    """Creates the configuration's algorithm with untrained networks."""
    return _ALGORITHMS[config["algorithm"]](config, envs, parts, seed)
