"""Proximal policy optimisation (Schulman et al. 2017, arXiv 1707.06347) of stable-baselines3."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

from ._config import Config
from ._method import Method, policy_options
from ._network import Eyes, Parts


class Ppo(Method):
    """PPO with normalised returns."""

    model: PPO

    def __init__(self, config: Config, envs: VecEnv, parts: Parts, seed: int) -> None:
        super().__init__(config)
        self.normalised = VecNormalize(envs, norm_obs=False, norm_reward=True, gamma=config["ppo.gamma"])
        widths = config["network.widths"]
        self.model = PPO(
            "MlpPolicy",
            self.normalised,
            n_steps=config["ppo.steps"],
            batch_size=config["ppo.batch"],
            n_epochs=config["ppo.epochs"],
            gamma=config["ppo.gamma"],
            gae_lambda=config["ppo.gae_lambda"],
            clip_range=config["ppo.clip"],
            ent_coef=config["ppo.entropy"],
            vf_coef=config["ppo.value"],
            max_grad_norm=config["ppo.gradient"],
            use_sde=config["ppo.hold"] > 0,
            sde_sample_freq=config["ppo.hold"] or -1,
            policy_kwargs={
                **policy_options(config, parts),
                "net_arch": {"pi": widths, "vf": widths},
                "log_std_init": float(np.log(config["ppo.spread"])),
            },
            seed=seed,
            device="cpu",
        )

    def begin(self, seed: int) -> None:
        self.normalised.seed(seed)
        self.model._last_obs = None

    def told(self) -> dict[str, Any]:
        spread = np.atleast_2d(self.model.policy.log_std.exp().detach().numpy()).mean(axis=0)
        return {"spread": [round(float(s), 4) for s in spread]}

    def state(self) -> dict[str, Any]:
        rms = self.normalised.ret_rms
        return {"returns": [float(rms.mean), float(rms.var), rms.count]}

    def restore(self, state: dict[str, Any]) -> None:
        rms = self.normalised.ret_rms
        rms.mean, rms.var, rms.count = (np.float64(state["returns"][0]), np.float64(state["returns"][1]), state["returns"][2])

    def surprise(self) -> np.ndarray | None:
        return np.abs(self.model.rollout_buffer.advantages)

    def actions(self, rows: torch.Tensor) -> torch.Tensor:
        return self.model.policy.get_distribution(rows).distribution.mean

    def layers(self) -> tuple[Eyes, list[torch.nn.Linear]]:
        policy = self.model.policy
        hidden = [layer for layer in policy.mlp_extractor.policy_net if isinstance(layer, torch.nn.Linear)]
        return policy.pi_features_extractor, [*hidden, policy.action_net]

    def action_parameters(self) -> Iterator[tuple[str, torch.nn.Parameter]]:
        for name, parameter in self.model.policy.named_parameters():
            if not name.startswith(("value_net", "mlp_extractor.value_net")):
                yield name, parameter

    def set_spread(self, spread: float) -> None:
        with torch.no_grad():
            self.model.policy.log_std.fill_(float(np.log(spread)))
