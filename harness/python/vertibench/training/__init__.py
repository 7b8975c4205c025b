"""Training of policies: the end-to-end planners RL, MCL and ACL, and your own.

`python -m vertibench.training train acl --out runs/acl-0` learns by stable-baselines3's SAC, or PPO where the configuration says so, in
`vertibench.envs`; `export` writes the policy's weights as planners read them; `package` makes a planner of them, which `vertibench`
drives and a leaderboard takes; `curves` draws what several runs have come to. docs/training.md goes through it step by step.

What to learn is data: `tasks/training/policy.yaml`, or a file of your own.
"""

from ._config import Config, TrainingError, read_config
from ._package import package
from ._weights import Weights, read_weights

__all__ = ["Config", "TrainingError", "Weights", "package", "read_config", "read_weights"]
