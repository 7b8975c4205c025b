"""Observations as rows of numbers, and the network on them, which `vb_sdk::policy::PolicyNetwork` runs in planners."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from gymnasium import spaces
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from stable_baselines3.common.vec_env import VecEnvWrapper
from torch import nn

from .._native import FLAT_BOUND, LEAK
from ._config import TrainingError

#: Entries whose sign changes in the mirror image, with the names of `vb_sdk::policy`.
_TURNED = {"roll", "vy", "wx", "wz", "steering", "left", "fy"}
#: Parts whose mirror image follows from the names of their entries.
_MIRRORED = {"state", "goal", "path", "command", "imu"}

Parts = list[dict[str, Any]]


def width(part: dict[str, Any]) -> int:
    """Returns the number of entries of a part."""
    return int(np.prod(part["shape"]))


def rows(parts: Parts, observation: dict[str, np.ndarray]) -> np.ndarray:
    """Returns a row per observation, float32: the entries of all parts in order, with labels as numbers."""
    count = len(observation[parts[0]["name"]])
    return np.concatenate([observation[p["name"]].reshape(count, -1).astype(np.float32) for p in parts], 1)


class Rows(VecEnvWrapper):
    """Wraps environments so that observations are rows; stable-baselines3 supports multi-step returns for these only."""

    def __init__(self, venv: Any) -> None:
        self.parts: Parts = venv.vector._setup.parts
        count = sum(width(p) for p in self.parts)
        super().__init__(venv, observation_space=spaces.Box(-np.inf, np.inf, (count,), np.float32))

    def reset(self) -> np.ndarray:
        """Begins episodes in all environments and returns the first observations."""
        return rows(self.parts, self.venv.reset())  # type: ignore[arg-type]

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Waits for the step."""
        observations, rewards, dones, infos = self.venv.step_wait()
        for k in np.flatnonzero(dones):
            last = {name: values[None] for name, values in infos[k]["terminal_observation"].items()}
            infos[k]["terminal_observation"] = rows(self.parts, last)[0]
        return rows(self.parts, observations), rewards, dones, infos  # type: ignore[arg-type]


def mirror(parts: Parts) -> tuple[np.ndarray, np.ndarray]:
    """Returns the left-right mirror image of a row: for each entry, the index of its source and its sign."""
    indices, signs, begin = [], [], 0
    for part in parts:
        own = np.arange(width(part)).reshape(part["shape"])
        if part["is_crop"]:
            own, turned = own[:, ::-1], np.ones(own.size)
        elif part["name"] in _MIRRORED:
            turned = np.resize([-1.0 if name in _TURNED else 1.0 for name in part["names"]], own.size)
        else:
            what = f"{part['name']} has no mirror augmentation"
            raise TrainingError("observation", what, "remove the part, or set sac.mirror to false")
        indices.append(begin + own.ravel())
        signs.append(turned)
        begin += own.size
    return np.concatenate(indices), np.concatenate(signs).astype(np.float32)


class Leaky(nn.LeakyReLU):
    """Activation of `vb_sdk::nn`: leaky rectifier."""

    def __init__(self) -> None:
        super().__init__(LEAK)


class Planes(nn.Module):
    """Converts rows to the input of a convolution.

    Each crop of numbers becomes a plane; a height crop is followed by its relief if `relief` is above 0. Then each crop
    of labels becomes one plane per label, 1 where the label is and 0 elsewhere. All other entries are returned next to
    the planes. Numbers are divided by their normalisation scales and clipped.
    """

    def __init__(self, parts: Parts, labels: list[int], relief: float) -> None:
        super().__init__()
        self.parts, self.relief = parts, relief
        crops = [p for p in parts if p["is_crop"]]
        #: Rows and columns of a plane, number of planes, and number of other entries.
        self.cells = crops[0]["shape"][0] if crops else 0
        self.count = sum(self._planes(p, labels) for p in crops)
        self.beside = sum(width(p) for p in parts if not p["is_crop"])
        usual = [np.resize(p["usual"], width(p)) for p in parts]
        self.register_buffer("usual", torch.from_numpy(np.concatenate(usual).astype(np.float32)))
        self.register_buffer("labels", torch.tensor(labels, dtype=torch.float32).view(1, -1, 1, 1))
        self.around = nn.Sequential(nn.ReplicationPad2d(2), nn.AvgPool2d(5, 1))

    def _planes(self, part: dict[str, Any], labels: list[int]) -> int:
        if part["dtype"] != "float32":
            return len(labels)
        return 2 if self._has_relief(part) else 1

    def _has_relief(self, part: dict[str, Any]) -> bool:
        return self.relief > 0.0 and part["is_crop"] and "height" in part["name"]

    def forward(self, row: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        numbers: list[torch.Tensor] = []
        labelled: list[torch.Tensor] = []
        others: list[torch.Tensor] = [row[:, :0]]
        for part, own, usual in zip(self.parts, *(v.split([width(p) for p in self.parts], -1) for v in (row, self.usual))):
            if not part["is_crop"]:
                others.append((own / usual).clamp(-FLAT_BOUND, FLAT_BOUND))
                continue
            plane = own.view(-1, 1, self.cells, self.cells)
            if part["dtype"] != "float32":
                labelled.append((plane == self.labels).float())
                continue
            numbers.append((plane / usual[0]).clamp(-FLAT_BOUND, FLAT_BOUND))
            if self._has_relief(part):
                # A step that stops a wheel is a few decimetres high; next to hills, a network would learn slowly to detect it.
                numbers.append((self.relief * ((plane - self.around(plane)) / usual[0])).clamp(-FLAT_BOUND, FLAT_BOUND))
        planes = torch.cat(numbers + labelled, 1) if self.count else row[:, :0]
        return planes, torch.cat(others, 1)


class Eyes(BaseFeaturesExtractor):
    """Feature extractor of action and value networks: a convolution over the planes, next to all other entries.

    An update passes the same rows to several networks, each with its own extractor; `shared` computes their planes
    once.
    """

    def __init__(self, space: spaces.Box, shared: SharedPlanes, planes: int, kernel: int, stride: int) -> None:
        own = shared.planes
        side = (own.cells - kernel) // stride + 1 if own.count else 0
        super().__init__(space, planes * side * side + own.beside)
        self.shared = shared
        self.convolution = nn.Conv2d(own.count, planes, kernel, stride) if own.count else None
        self.leak = Leaky()

    def forward(self, row: torch.Tensor) -> torch.Tensor:
        planes, others = self.shared(row)
        if self.convolution is None:
            return others
        return torch.cat([self.leak(self.convolution(planes)).flatten(1), others], 1)


class SharedPlanes:
    """Planes of rows, with a cache of the last two results: an update alternates between current and next observations."""

    def __init__(self, parts: Parts, labels: list[int], relief: float) -> None:
        self.planes = Planes(parts, labels, relief)
        self.made: list[tuple[torch.Tensor, tuple[torch.Tensor, torch.Tensor]]] = []

    def __call__(self, row: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        for of, made in self.made:
            if of is row:
                return made
        with torch.no_grad():
            made = self.planes(row)
        self.made = [*self.made[-1:], (row, made)]
        return made

    def __deepcopy__(self, _: Any) -> SharedPlanes:
        return self
