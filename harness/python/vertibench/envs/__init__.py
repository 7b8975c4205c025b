"""Environments for reinforcement learning: tasks of the benchmark, driven step by step.

>>> import gymnasium, vertibench
>>> env = gymnasium.make("VertiBench/Navigation-v0", suite="smoke", tasks="w003/t00")
>>> observation, info = env.reset(seed=0)
>>> observation, reward, terminated, truncated, info = env.step(env.action_space.sample())

`NavigationEnv` is one environment, `NavigationVectorEnv` many at a time on threads of Rust. `vertibench.envs.sb3` has them for
stable-baselines3, `vertibench.envs.puffer` for PufferLib. `describe_parts()` and `describe_rewards()` tell what an observation
and a reward can be made of.
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
