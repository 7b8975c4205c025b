"""Soft actor-critic (Haarnoja et al. 2018, arXiv 1812.05905) of stable-baselines3, with multi-step returns."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3 import SAC
from stable_baselines3.common.buffers import NStepReplayBuffer
from stable_baselines3.common.type_aliases import ReplayBufferSamples
from stable_baselines3.common.vec_env import VecEnv

from ._config import Config, TrainingError
from ._method import Method, policy_options
from ._network import Eyes, Parts, mirror

#: File of a checkpoint with the replay buffer, and the arrays in it.
BUFFER = "buffer.npz"
_COLUMNS = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")


class Sac(Method):
    """SAC with multi-step returns and mirror augmentation."""

    model: SAC
    squash = "tanh"

    def __init__(self, config: Config, envs: VecEnv, parts: Parts, seed: int) -> None:
        super().__init__(config)
        mirrored = mirror(parts) if config["sac.mirror"] else None
        self.model = SAC(
            "MlpPolicy",
            envs,
            buffer_size=config["sac.buffer"],
            learning_starts=config["sac.begin"],
            batch_size=config["sac.batch"],
            tau=config["sac.tau"],
            gamma=config["sac.gamma"],
            train_freq=1,
            gradient_steps=config["sac.updates"],
            replay_buffer_class=Memory,
            replay_buffer_kwargs={"n_steps": config["sac.returns"], "gamma": config["sac.gamma"], "mirrored": mirrored},
            ent_coef=f"auto_{config['sac.temperature']}",
            target_entropy=config["sac.entropy"],
            policy_kwargs={**policy_options(config, parts), "net_arch": config["network.widths"]},
            seed=seed,
            device="cpu",
        )
        # The update of the actor needs no gradients of the critics' parameters.
        self.model.critic.optimizer.register_step_post_hook(lambda *_: self._train_critics(False))
        self.model.actor.optimizer.register_step_post_hook(lambda *_: self._train_critics(True))

    def _train_critics(self, trained: bool) -> None:
        self.model.critic.requires_grad_(trained)

    @property
    def _memory(self) -> Memory:
        return self.model.replay_buffer  # type: ignore[return-value]

    @property
    def _log_temperature(self) -> torch.Tensor:
        return self.model.log_ent_coef  # type: ignore[return-value]

    def begin(self, seed: int) -> None:
        self.model.env.seed(seed)  # type: ignore[union-attr]
        self.model.action_space.seed(seed)
        self.model._last_obs = None
        self._memory.cut()

    def told(self) -> dict[str, Any]:
        return {"temperature": round(float(np.exp(self._log_temperature.item())), 6)}

    def state(self) -> dict[str, Any]:
        return {"log_temperature": self._log_temperature.item()}

    def restore(self, state: dict[str, Any]) -> None:
        with torch.no_grad():
            self._log_temperature.fill_(state["log_temperature"])

    def keep(self, folder: Path) -> None:
        self._memory.keep(folder / BUFFER)

    def fetch(self, folder: Path) -> None:
        self._memory.fetch(folder / BUFFER)

    def actions(self, rows: torch.Tensor) -> torch.Tensor:
        return torch.tanh(self.model.actor.get_action_dist_params(rows)[0])

    def layers(self) -> tuple[Eyes, list[torch.nn.Linear]]:
        actor = self.model.actor
        hidden = [layer for layer in actor.latent_pi if isinstance(layer, torch.nn.Linear)]
        return actor.features_extractor, [*hidden, actor.mu]  # type: ignore[return-value, list-item]

    def action_parameters(self) -> Iterator[tuple[str, torch.nn.Parameter]]:
        yield from self.model.actor.named_parameters()

    def set_spread(self, spread: float) -> None:
        with torch.no_grad():
            self.model.actor.log_std.weight.zero_()  # type: ignore[union-attr]
            self.model.actor.log_std.bias.fill_(float(np.log(spread)))  # type: ignore[union-attr]


class Memory(NStepReplayBuffer):
    """Replay buffer of SAC.

    With `mirrored`, half of each batch is replaced with its mirror image (mirror augmentation, p = 0.5), because the
    vehicle is symmetric.
    """

    def __init__(self, *arguments: Any, mirrored: tuple[np.ndarray, np.ndarray] | None, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.mirrored = mirrored

    def _get_samples(self, batch_inds: np.ndarray, env: Any = None) -> ReplayBufferSamples:
        drawn = super()._get_samples(batch_inds, env)
        if self.mirrored is not None:
            half = len(batch_inds) // 2
            indices, signs = torch.from_numpy(self.mirrored[0]), torch.from_numpy(self.mirrored[1])
            for seen in (drawn.observations, drawn.next_observations):
                seen[:half] = seen[:half, indices] * signs
            # An action consists of steering, or its change, and speed.
            drawn.actions[:half, 0] *= -1.0
        return drawn

    def cut(self) -> None:
        """Marks the last steps as time-outs, so that no return extends into the following episodes."""
        if self.size():
            last = self.pos - 1
            self.timeouts[last] = np.maximum(self.timeouts[last], 1.0 - self.dones[last])
            self.dones[last] = 1.0

    def keep(self, file: Path) -> None:
        """Writes all steps to a file."""
        size = self.size()
        np.savez(file, pos=self.pos, full=self.full, **{name: getattr(self, name)[:size] for name in _COLUMNS})

    def fetch(self, file: Path) -> None:
        """Reads the file of `keep`."""
        try:
            with np.load(file) as kept:
                for name in _COLUMNS:
                    getattr(self, name)[: len(kept[name])] = kept[name]
                self.pos, self.full = int(kept["pos"]), bool(kept["full"])
        except (OSError, ValueError, KeyError) as e:
            what = f"the replay buffer can't be read: {e}"
            raise TrainingError(file, what, "start a new training in another folder; export and evaluate don't need the file") from None
