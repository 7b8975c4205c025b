"""Weights of a checkpoint as planners read them, checked against the policy that was trained."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3 import PPO

from .. import _native
from ..envs import NavigationVectorEnv
from ._config import Config, TrainingError
from ._run import load
from ._weights import Layer, Weights, convolution, dense

#: The most by which an action of the planner's networks may differ from the trained policy's.
TOLERANCE = 1e-5
#: How many observations are compared.
STEPS, ENVIRONMENTS = 60, 16


def export(run: Path, weights: Path) -> str:
    """Writes the weights of a checkpoint; says how far actions by them are from those of the policy, over recorded observations."""
    model, config, state = load(run)
    content = bytes(weights_of(model, config, state))
    greatest, count = compare(model, config, content)
    if greatest > TOLERANCE:
        what = f"actions by these weights differ from the policy's by {greatest:.2e} on {count} observations"
        raise TrainingError(weights, what, f"{TOLERANCE:g} is allowed: please report it")
    weights.write_bytes(content)
    return f"{weights}: {len(content)} bytes; actions differ from the policy's by {greatest:.1e} at most, on {count} observations"


def weights_of(model: PPO, config: Config, state: dict[str, Any]) -> Weights:
    """The networks of the action, with what planners and readers must know of them."""
    slowest, fastest = config["speed_range"]
    notes = {
        "policy": state["planner"],
        "parts": " ".join(config["observation"]),
        "sight": " ".join(f"{size:g}" for size in config.sight().values()),
        "labels": " ".join(map(str, config["labels"])),
        "action": f"{config['action']} {slowest:g} {fastest:g}",
        "control_hz": "10",
        "vehicle": config["vehicle"],
        "curriculum": config["planners"][state["planner"]],
        "worlds": f"{config['worlds.count']} of seed {config['worlds.seed']}",
        "steps": str(state["steps"]),
        "seed": str(state["seed"]),
        "config": config.hash,
    }
    eyes, layers = model.policy.pi_features_extractor, []
    if eyes.convolution is not None:
        own = eyes.convolution
        weights, bias = _numbers(own)
        # Planners multiply by nothing: the weights do.
        gains = np.ones(weights.shape[1], dtype=np.float32)
        gains[: len(eyes.crops)] = eyes.gains.numpy().ravel()
        layers.append(convolution("eyes.0", config.sight()["cells"], weights * gains[None, :, None, None], bias, own.stride[0]))
    linear = [layer for layer in model.policy.mlp_extractor.policy_net if isinstance(layer, torch.nn.Linear)]
    for k, layer in enumerate([*linear, model.policy.action_net]):
        layers.append(_dense(f"head.{k}", layer))
    return Weights(notes, layers)


def _dense(name: str, layer: torch.nn.Linear) -> Layer:
    return dense(name, *_numbers(layer))


def _numbers(layer: Any) -> tuple[np.ndarray, np.ndarray]:
    return layer.weight.detach().numpy(), layer.bias.detach().numpy()


def compare(model: PPO, config: Config, content: bytes) -> tuple[float, int]:
    """The greatest difference between actions by the weights and by the policy, on observations of drives in held-out worlds, and
    the number of observations."""
    envs = NavigationVectorEnv(ENVIRONMENTS, **config.held_out())
    observation, _ = envs.reset(seed=0)
    greatest, noise = 0.0, np.random.default_rng(0)
    for _ in range(STEPS):
        with torch.no_grad():
            tensors, _ = model.policy.obs_to_tensor(observation)
            wanted = model.policy.get_distribution(tensors).distribution.mean.numpy()
        parts = [np.ascontiguousarray(observation[part["name"]]) for part in envs._setup.parts]
        given = _native.policy_actions(envs._setup.arena, content, parts)
        greatest = max(greatest, float(np.abs(given - wanted).max()))
        # With noise, so that not all observations are of the middle of the path.
        actions = np.clip(wanted + noise.normal(0.0, 0.3, wanted.shape), -1.0, 1.0)
        observation = envs.step(actions)[0]
    envs.close()
    return greatest, STEPS * ENVIRONMENTS
