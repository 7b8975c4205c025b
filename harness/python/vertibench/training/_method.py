"""Interface of an algorithm for training, checkpoints and export."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm

from ._config import Config
from ._network import Eyes, Leaky, Parts, SharedPlanes


class Method(ABC):
    """Algorithm of stable-baselines3 with its policy.

    Args:
        config: Configuration.

    Attributes:
        model: Model of stable-baselines3.
        squash: Function from the network's output to an action, as in the metadata of weights; None for the identity.
    """

    squash: str | None = None

    def __init__(self, config: Config) -> None:
        self.config = config
        self.model: BaseAlgorithm = None  # type: ignore[assignment]

    # For training.

    @abstractmethod
    def begin(self, seed: int) -> None:
        """Begins an interval: new episodes, and the algorithm's random numbers from this seed."""

    @abstractmethod
    def told(self) -> dict[str, Any]:
        """Returns the algorithm's entries of a progress line."""

    @abstractmethod
    def state(self) -> dict[str, Any]:
        """Returns the state that is not in the model's parameters and optimisers, JSON-compatible."""

    @abstractmethod
    def restore(self, state: dict[str, Any]) -> None:
        """Restores the result of `state`."""

    def keep(self, folder: Path) -> None:  # noqa: B027
        """Writes further state that only the last checkpoint needs."""

    def fetch(self, folder: Path) -> None:  # noqa: B027
        """Reads the files of `keep`."""

    def surprise(self) -> np.ndarray | None:
        """Returns absolute differences of returns and expected values, shape (steps, environments), since the last update;
        None if unknown.
        """
        return None

    # For the policy.

    @abstractmethod
    def actions(self, rows: torch.Tensor) -> torch.Tensor:
        """Returns the policy's actions without noise, for observations as rows."""

    @abstractmethod
    def layers(self) -> tuple[Eyes, list[torch.nn.Linear]]:
        """Returns the feature extractor and the dense layers of the action network."""

    @abstractmethod
    def action_parameters(self) -> Iterator[tuple[str, torch.nn.Parameter]]:
        """Yields names and parameters of the action network."""

    @abstractmethod
    def set_spread(self, spread: float) -> None:
        """Sets the standard deviation of actions before squashing."""

    def freeze(self, frozen: bool) -> None:
        """Fixes the action network while the value networks learn, or releases it."""
        for _, parameter in self.action_parameters():
            parameter.requires_grad = not frozen


def policy_options(config: Config, parts: Parts) -> dict[str, Any]:
    """Returns the options of a policy's networks, without the widths of layers."""
    eyes = {name: config[f"network.{name}"] for name in ("planes", "kernel", "stride")}
    shared = SharedPlanes(parts, config["labels"], config["network.relief"])
    return {
        "features_extractor_class": Eyes,
        "features_extractor_kwargs": {"shared": shared, **eyes},
        "activation_fn": Leaky,
    }
