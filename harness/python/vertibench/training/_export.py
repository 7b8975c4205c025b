"""Export of a checkpoint's weights, verified against the trained policy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .. import _native
from ..envs import NavigationVectorEnv
from ._config import Config, TrainingError
from ._libraries import torch
from ._method import Method
from ._network import rows
from ._run import load
from ._weights import Weights, convolution, dense

#: Maximum difference between an action of the planner's networks and of the trained policy.
TOLERANCE = 1e-5
#: Numbers of steps and environments whose observations are compared.
STEPS, ENVIRONMENTS = 60, 16


def export(run: Path, weights: Path) -> str:
    """Writes the weights of a checkpoint in the planners' format.

    The actions of the file, computed as in a planner, are compared with those of the trained policy on 960 observations
    of held-out worlds.

    Args:
        run: Folder of a run, for its last checkpoint, or of a checkpoint.
        weights: File to write.

    Returns:
        Line with the size of the file and the maximum difference of actions.

    Raises:
        TrainingError: If there is no readable checkpoint, or an action differs by more than 1e-5.
    """
    method, config, state = load(run)
    content = bytes(weights_of(method, config, state))
    greatest, count = compare(method, config, content)
    if greatest > TOLERANCE:
        what = f"actions of these weights differ from those of the policy by {greatest:.2e} on {count} observations"
        raise TrainingError(weights, what, f"the limit is {TOLERANCE:g}: please report it")
    weights.write_bytes(content)
    return f"{weights}: {len(content)} bytes; actions differ from those of the policy by at most {greatest:.1e} on {count} observations"


def weights_of(method: Method, config: Config, state: dict[str, Any]) -> Weights:
    """Returns the action networks with the metadata that planners and readers need."""
    slowest, fastest = config["speed_range"]
    notes = {
        "policy": state["planner"],
        "parts": " ".join(config["observation"]),
        "sight": " ".join(f"{size:g}" for size in config.sight().values()),
        "labels": " ".join(map(str, config["labels"])),
        "action": f"{config['action']} {slowest:g} {fastest:g}",
        "control_hz": "10",
        "vehicle": config["vehicle"],
        "perception": config["perception"],
        "curriculum": config["planners"][state["planner"]],
        "worlds": f"{config['worlds.count']} of seed {config['worlds.seed']}",
        "steps": str(state["steps"]),
        "seed": str(state["seed"]),
        "config": config.hash,
    }
    if config["network.relief"] > 0.0:
        notes["relief"] = f"{config['network.relief']:g}"
    if method.squash is not None:
        notes["squash"] = method.squash
    eyes, linear = method.layers()
    layers = []
    if eyes.convolution is not None:
        own = eyes.convolution
        layers.append(convolution("eyes.0", config.sight()["cells"], *_numbers(own), int(own.stride[0])))
    layers += [dense(f"head.{k}", *_numbers(layer)) for k, layer in enumerate(linear)]
    return Weights(notes, layers)


def _numbers(layer: Any) -> tuple[np.ndarray, np.ndarray]:
    return layer.weight.detach().numpy(), layer.bias.detach().numpy()


def compare(method: Method, config: Config, content: bytes) -> tuple[float, int]:
    """Returns the maximum difference between actions of the weights and of the policy, and the number of observations."""
    envs = NavigationVectorEnv(ENVIRONMENTS, **config.held_out())
    parts = envs._setup.parts
    observation, _ = envs.reset(seed=0)
    greatest, noise = 0.0, np.random.default_rng(0)
    for _ in range(STEPS):
        with torch.no_grad():
            wanted = method.actions(torch.from_numpy(rows(parts, observation))).numpy()
        seen = [np.ascontiguousarray(observation[part["name"]]) for part in parts]
        given = _native.policy_actions(envs._setup.arena, content, seen)
        greatest = max(greatest, float(np.abs(given - wanted).max()))
        # With noise, so that observations also cover positions away from the path.
        actions = np.clip(wanted + noise.normal(0.0, 0.3, wanted.shape), -1.0, 1.0)
        observation = envs.step(actions)[0]
    envs.close()
    return greatest, STEPS * ENVIRONMENTS
