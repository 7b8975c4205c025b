"""Warm start: behaviour cloning of planners' drives from a dataset of demonstrations."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import torch

from .. import datasets
from .._native import STEERING_STEP
from ..envs import NavigationVectorEnv
from ._config import Config, TrainingError
from ._method import Method
from ._network import rows

#: Time after a frame whose speed is the frame's target speed, s.
_AHEAD = 1.0


def clone(method: Method, config: Config, folder: Path, seed: int) -> dict[str, Any]:
    """Fits the policy's actions to demonstrations.

    Args:
        method: Algorithm whose policy is fitted.
        config: Configuration, with the fields `clone.*`.
        folder: Dataset of `vertibench dataset drive`.
        seed: Seed of the order of frames.

    Returns:
        Dataset hash, numbers of episodes and frames, and `error`: root mean squared error of steering and speed in the
        last epoch, in units of actions.

    Raises:
        TrainingError: If the dataset is unsuitable (see `demonstrations`).
        DatasetError: If the dataset can't be read.
    """
    observations, actions, told = demonstrations(config, folder)
    optimiser = torch.optim.Adam([p for _, p in method.action_parameters()], lr=config["clone.rate"])
    generator = torch.Generator().manual_seed(seed)
    count, batch = len(actions), config["clone.batch"]
    seen, wanted = torch.from_numpy(observations), torch.from_numpy(actions)
    squares = torch.zeros(actions.shape[1])
    for _ in range(config["clone.epochs"]):
        squares = torch.zeros(actions.shape[1])
        for chosen in torch.randperm(count, generator=generator).split(batch):
            errors = (method.actions(seen[chosen]) - wanted[chosen]) ** 2
            optimiser.zero_grad()
            errors.mean().backward()
            optimiser.step()
            squares += errors.detach().sum(0)
    method.set_spread(config["clone.spread"])
    rms = [round(float(v), 4) for v in (squares / count).sqrt()]
    return {**told, "frames": count, "error": rms}


def demonstrations(config: Config, folder: Path) -> tuple[np.ndarray, np.ndarray, dict[str, Any]]:
    """Reads demonstrations as observations and actions of the policy.

    Args:
        config: Configuration of the policy.
        folder: Dataset of `vertibench dataset drive`.

    Returns:
        Observations as rows, float32; actions equivalent to the demonstrated commands, float32, shape (frames, 2); and
        the dataset's hash with the number of episodes.

    Raises:
        TrainingError: If the dataset's worlds belong to a benchmark suite, it has another vehicle or rate than the policy,
            or an episode has no task.
        DatasetError: If the dataset can't be read.
    """
    data = datasets.open(folder)
    if data.info.of_a_suite:
        raise TrainingError(folder, "its worlds belong to a benchmark suite", "use demonstrations from training worlds")
    if data.info.vehicle != config["vehicle"] or data.info.hz != 10:
        what = f"it has {data.info.vehicle} at {data.info.hz} Hz; the policy needs {config['vehicle']} at 10 Hz"
        raise TrainingError(folder, what, "use another dataset")
    slowest, fastest = config["speed_range"]
    envs = NavigationVectorEnv(1, suite=folder / "suite", **config.sees_and_does())
    arena, parts = envs._setup.arena, envs._setup.parts
    columns: list[list[np.ndarray]] = [[] for _ in parts]
    actions = []
    for k, episode in enumerate(data.episodes):
        if not episode.task:
            raise TrainingError(folder, f"episode {episode.index} has no task", "use a dataset of `vertibench dataset drive`")
        frames = data.frames(k, ["observation.state", "action"])
        state, command = frames["observation.state"].astype(np.float64), frames["action"].astype(np.float64)
        held = np.vstack([np.zeros((1, 3)), command[:-1, :3]])
        for column, values in zip(columns, arena.recall(episode.task, state, np.clip(held, [-1, 0, 0], 1))):
            column.append(values)
        later = np.minimum(np.arange(len(state)) + round(_AHEAD * data.info.hz), len(state) - 1)
        speed = 2.0 * (state[later, 6] - slowest) / (fastest - slowest) - 1.0
        turn = (command[:, 0] - held[:, 0]) / STEERING_STEP if config["action"] == "rate" else command[:, 0]
        actions.append(np.clip(np.stack([turn, speed], 1), -1, 1).astype(np.float32))
    envs.close()
    observations = {part["name"]: np.concatenate(column) for part, column in zip(parts, columns)}
    return rows(parts, observations), np.concatenate(actions), {"dataset": data.info.hash, "episodes": len(data.episodes)}
