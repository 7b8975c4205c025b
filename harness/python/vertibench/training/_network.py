"""The network of a policy, as torch trains it and `vb_sdk::policy::PolicyNetwork` runs it."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from gymnasium import spaces
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from torch import nn

#: The bound of scaled numbers, `Layout::FLAT_BOUND`.
BOUND = 5.0
#: The slope of the activation below 0, `vb_sdk::nn::LEAK`.
LEAK = 0.1


class Leaky(nn.LeakyReLU):
    """The activation of `vb_sdk::nn`."""

    def __init__(self) -> None:
        super().__init__(LEAK)


class Eyes(BaseFeaturesExtractor):
    """What the layers of action and value both see: a convolution over the crops, and all other numbers beside it.

    Numbers are divided by their usual sizes and limited. Planes of numbers come first, in the order of the parts, then for each part
    of labels one plane for each label, which is 1 where the label is.
    """

    def __init__(
        self,
        space: spaces.Dict,
        parts: list[dict[str, Any]],
        labels: list[int],
        planes: int,
        kernel: int,
        stride: int,
        relief: float,
    ) -> None:
        self.crops = [p["name"] for p in parts if p["is_crop"] and p["dtype"] == "float32"]
        self.labelled = [p["name"] for p in parts if p["is_crop"] and p["dtype"] == "uint8"]
        others = [p for p in parts if not p["is_crop"]]
        self.others = [p["name"] for p in others]
        width = sum(int(np.prod(p["shape"])) for p in others)
        inputs = len(self.crops) + len(labels) * len(self.labelled)
        cells = next((p["shape"][0] for p in parts if p["is_crop"]), 0)
        side = (cells - kernel) // stride + 1 if inputs else 0
        super().__init__(space, planes * side * side + width)
        usual = {p["name"]: np.resize(p["usual"], int(np.prod(p["shape"]))).astype(np.float32) for p in parts}
        self.register_buffer("usual", torch.from_numpy(np.concatenate([usual[n] for n in self.others] or [np.zeros(0)])))
        self.register_buffer("usual_of_crops", torch.tensor([float(usual[n][0]) for n in self.crops]).view(1, -1, 1, 1))
        # Steps of a few decimetres are what a wheel meets; beside hills of metres a network would be slow to see them.
        gains = [relief if "height" in name else 1.0 for name in self.crops]
        self.register_buffer("gains", torch.tensor(gains).view(1, -1, 1, 1))
        self.register_buffer("labels", torch.tensor(labels, dtype=torch.float32).view(1, -1, 1, 1))
        self.convolution = nn.Conv2d(inputs, planes, kernel, stride) if inputs else None
        self.leak = Leaky()

    def forward(self, observation: dict[str, torch.Tensor]) -> torch.Tensor:
        seen = []
        if self.convolution is not None:
            planes = []
            if self.crops:
                numbers = torch.stack([observation[name] for name in self.crops], 1)
                planes.append(self.gains * (numbers / self.usual_of_crops).clamp(-BOUND, BOUND))
            planes += [(observation[name].unsqueeze(1) == self.labels).float() for name in self.labelled]
            seen.append(self.leak(self.convolution(torch.cat(planes, 1))).flatten(1))
        if self.others:
            numbers = torch.cat([observation[name].flatten(1) for name in self.others], 1)
            seen.append((numbers / self.usual).clamp(-BOUND, BOUND))
        return torch.cat(seen, 1)
