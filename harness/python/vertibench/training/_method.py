"""What training, checkpoints and export know of an algorithm."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecEnv

from ._config import Config
from ._network import Eyes, Leaky, Parts, SharedPlanes


class Method(ABC):
    """An algorithm of stable-baselines3 with the policy that learns by it."""

    #: What becomes of the network's numbers before they are an action, as weights note it; None if nothing does.
    squash: str | None = None

    def __init__(self, config: Config) -> None:
        self.config = config
        self.model: BaseAlgorithm = None  # type: ignore[assignment]

    # What learning needs.

    @abstractmethod
    def begin(self, seed: int) -> None:
        """Begins a stretch: new episodes, and what is random in the algorithm by this seed."""

    @abstractmethod
    def told(self) -> dict[str, Any]:
        """What progress tells of the algorithm."""

    @abstractmethod
    def state(self) -> dict[str, Any]:
        """What it remembers beside the parameters of the model and its optimisers, as JSON has it."""

    @abstractmethod
    def restore(self, state: dict[str, Any]) -> None:
        """Goes on from what one like it remembered."""

    def keep(self, folder: Path) -> None:  # noqa: B027
        """Writes what it remembers beyond that, where only the last checkpoint needs it."""

    def fetch(self, folder: Path) -> None:  # noqa: B027
        """Reads what `keep` has written."""

    def surprise(self) -> np.ndarray | None:
        """How much returns differed from the values that were expected, by step and environment since the last update; None where
        the algorithm doesn't know."""
        return None

    # The policy.

    @abstractmethod
    def actions(self, rows: torch.Tensor) -> torch.Tensor:
        """The policy's actions without noise."""

    @abstractmethod
    def layers(self) -> tuple[Eyes, list[torch.nn.Linear]]:
        """The eyes, and the layers behind them, of the action."""

    @abstractmethod
    def action_parameters(self) -> Iterator[tuple[str, torch.nn.Parameter]]:
        """The parameters that the action depends on, with their names."""

    @abstractmethod
    def set_spread(self, spread: float) -> None:
        """Sets the standard deviation of actions before they are squashed."""

    def freeze(self, frozen: bool) -> None:
        """Whether the action stays as it is while the value learns."""
        for _, parameter in self.action_parameters():
            parameter.requires_grad = not frozen


def policy_options(config: Config, parts: Parts) -> dict[str, Any]:
    """The options of a policy's network, without its layers' widths."""
    eyes = {name: config[f"network.{name}"] for name in ("planes", "kernel", "stride")}
    shared = SharedPlanes(parts, config["labels"], config["network.relief"])
    return {
        "features_extractor_class": Eyes,
        "features_extractor_kwargs": {"shared": shared, **eyes},
        "activation_fn": Leaky,
    }


def make_method(config: Config, envs: VecEnv, parts: Parts, seed: int) -> Method:
    """The configuration's algorithm, as it is before it has learned anything."""
    from ._ppo import Ppo
    from ._sac import Sac

    return {"ppo": Ppo, "sac": Sac}[config["algorithm"]](config, envs, parts, seed)
