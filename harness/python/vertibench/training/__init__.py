"""Training of policies in `vertibench.envs`: the end-to-end planners RL, MCL and ACL, and your own.

The command line trains with stable-baselines3 (SAC, or PPO with `algorithm: ppo`) and makes planners of the policies:

- `python -m vertibench.training train acl --out runs/acl-0` trains; an interrupted run continues
- `export` writes the policy's weights in the planners' format
- `package` makes a planner from weights, for `vertibench run` and leaderboards
- `evaluate` measures success, `curves` plots it over steps, `card` compares policies

All settings are in a YAML file, `tasks/training/policy.yaml` by default. docs/training.md is a step-by-step guide. The
names of this module don't need stable-baselines3 and torch; training needs them (`pip install 'verti-bench[train]'`).

>>> from vertibench.training import package, read_config
>>> config = read_config("policy", {"sac.batch": "512"})
>>> package("mine.vbnn", "mine.wasm", "mine", "My policy")
"""

from ._config import Config, TrainingError, read_config
from ._package import package
from ._weights import Weights, read_weights

__all__ = ["Config", "TrainingError", "Weights", "package", "read_config", "read_weights"]
