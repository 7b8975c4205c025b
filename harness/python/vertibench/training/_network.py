"""What a policy sees as a row of numbers, and the network that torch trains on it and `vb_sdk::policy::PolicyNetwork` runs."""

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

#: Numbers that change their sign where left and right change places, by the names of `vb_sdk::policy`.
_TURNED = {"roll", "vy", "wx", "wz", "steering", "left", "fy"}
#: Parts that have a mirror image by names and columns alone.
_MIRRORED = {"state", "goal", "path", "command", "imu"}

Parts = list[dict[str, Any]]


def width(part: dict[str, Any]) -> int:
    """How many numbers a part has."""
    return int(np.prod(part["shape"]))


def rows(parts: Parts, observation: dict[str, np.ndarray]) -> np.ndarray:
    """A row for each observation: the numbers of all parts in their order, labels as numbers."""
    count = len(observation[parts[0]["name"]])
    return np.concatenate([observation[p["name"]].reshape(count, -1).astype(np.float32) for p in parts], 1)


class Rows(VecEnvWrapper):
    """Environments whose observations are rows: the library has returns over several steps for these only."""

    def __init__(self, venv: Any) -> None:
        self.parts: Parts = venv.vector._setup.parts
        count = sum(width(p) for p in self.parts)
        super().__init__(venv, observation_space=spaces.Box(-np.inf, np.inf, (count,), np.float32))

    def reset(self) -> np.ndarray:
        """Begins episodes in all environments; gives their first observations."""
        return rows(self.parts, self.venv.reset())  # type: ignore[arg-type]

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Waits for the step."""
        observations, rewards, dones, infos = self.venv.step_wait()
        for k in np.flatnonzero(dones):
            last = {name: values[None] for name, values in infos[k]["terminal_observation"].items()}
            infos[k]["terminal_observation"] = rows(self.parts, last)[0]
        return rows(self.parts, observations), rewards, dones, infos  # type: ignore[arg-type]


def mirror(parts: Parts) -> tuple[np.ndarray, np.ndarray]:
    """How a row looks where left and right change places: of each number, the index of the one that it is, and its sign."""
    indices, signs, begin = [], [], 0
    for part in parts:
        own = np.arange(width(part)).reshape(part["shape"])
        if part["is_crop"]:
            own, turned = own[:, ::-1], np.ones(own.size)
        elif part["name"] in _MIRRORED:
            turned = np.resize([-1.0 if name in _TURNED else 1.0 for name in part["names"]], own.size)
        else:
            what = f"{part['name']} has no mirror image"
            raise TrainingError("observation", what, "leave the part out, or set sac.mirror to false")
        indices.append(begin + own.ravel())
        signs.append(turned)
        begin += own.size
    return np.concatenate(indices), np.concatenate(signs).astype(np.float32)


class Leaky(nn.LeakyReLU):
    """The activation of `vb_sdk::nn`."""

    def __init__(self) -> None:
        super().__init__(LEAK)


class Planes(nn.Module):
    """What a convolution sees of rows: a plane for each crop of numbers, one of heights with that of its relief behind it where there is
    one, then for each part of labels one plane for each label, which is 1 where the label is; and all other numbers beside them.

    Numbers are divided by their usual sizes and limited.
    """

    def __init__(self, parts: Parts, labels: list[int], relief: float) -> None:
        super().__init__()
        self.parts, self.relief = parts, relief
        crops = [p for p in parts if p["is_crop"]]
        #: Rows and columns of a plane, how many planes there are, and how many numbers beside them.
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
                # A ledge that stops a wheel is a few decimetres; beside hills of metres a network would be slow to see it.
                numbers.append((self.relief * ((plane - self.around(plane)) / usual[0])).clamp(-FLAT_BOUND, FLAT_BOUND))
        planes = torch.cat(numbers + labelled, 1) if self.count else row[:, :0]
        return planes, torch.cat(others, 1)


class Eyes(BaseFeaturesExtractor):
    """What the layers of action and value both see: a convolution over the planes, and all other numbers beside it.

    An update shows the same rows to several networks with eyes of their own; `shared` makes the planes once for all of them.
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
    """Planes of rows, with the last two that were made: an update looks at the rows of now and of later in turn."""

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
