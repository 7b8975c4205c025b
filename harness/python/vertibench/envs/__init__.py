"""Environments for reinforcement learning: the tasks of the benchmark, one action per step.

>>> import gymnasium, vertibench
>>> env = gymnasium.make("VertiBench/Navigation-v0", suite="smoke", tasks="w003/t00")
>>> observation, info = env.reset(seed=0)
>>> observation, reward, terminated, truncated, info = env.step(env.action_space.sample())

`NavigationEnv` is one environment; `NavigationVectorEnv` steps many environments on Rust threads. `vertibench.envs.sb3`
contains a vector environment for stable-baselines3, `vertibench.envs.puffer` one for PufferLib. `describe_parts()` and
`describe_rewards()` list the parts of observations and the terms of rewards.
"""

from .._errors import missing_module

try:
    from .. import _native as _native
except ImportError as e:
    raise missing_module("vertibench.envs", e) from None

from ._common import describe_parts, describe_rewards
from ._navigation import NavigationEnv, State
from ._render import Picture, picture
from ._vector import NavigationVectorEnv

__all__ = ["NavigationEnv", "NavigationVectorEnv", "Picture", "State", "describe_parts", "describe_rewards", "picture"]
