"""What one environment and many have in common: options, spaces, what is told of an episode."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any

import numpy as np
from gymnasium import spaces

from .. import _native
from .._errors import OptionError
from .._program import tasks_path

#: The parts of an observation where none are named.
DEFAULT_PARTS = ("state", "goal", "path", "command", "height")
#: The terms of a reward, in order.
TERMS = tuple(name for name, _, _ in _native.terms())


def describe_parts() -> dict[str, str]:
    """What an observation can be made of: the parts by name."""
    return {name: f"{about}." + (f" Needs the sensor {s}." if s else "") for name, about, s in _native.parts()}


def describe_rewards() -> dict[str, str]:
    """What a reward can be made of: the terms by name, with the unit of what is measured."""
    return {name: f"{about}{f', {unit}' if unit else ''}." for name, unit, about in _native.terms()}


class Setup:
    """The options of environments, made into an arena, and the spaces that follow from them."""

    def __init__(
        self,
        suite: str | PathLike[str] | None = None,
        tasks: str | Sequence[str] | None = None,
        *,
        worlds: int = 18,
        world_seed: int = 7000,
        apart_from: Sequence[str | PathLike[str]] = (),
        vehicle: str | PathLike[str] = "hmmwv",
        perception: str | PathLike[str] = "oracle",
        soils: str | PathLike[str] = "default",
        rules: str | PathLike[str] = "paper",
        scale: float | None = None,
        control_hz: float = 10.0,
        time_step: float = 0.001,
        observation: str | Sequence[str] = DEFAULT_PARTS,
        flat: bool = False,
        sight: Mapping[str, float] | None = None,
        action: str = "speed",
        speed_range: tuple[float, float] = (0.0, 6.0),
        reward: str | PathLike[str] | Mapping[str, float] = "default",
    ) -> None:
        if observation == "flat":
            observation, flat = DEFAULT_PARTS, True
        elif isinstance(observation, str):
            observation = (observation,)
        if tasks is not None and not isinstance(tasks, str):
            tasks = ",".join(tasks)
        weights = {str(k): _number(f"reward[{k!r}]", v) for k, v in reward.items()} if isinstance(reward, Mapping) else None
        try:
            self.arena = _native.Arena(
                tasks_dir=tasks_path(),
                suite=None if suite is None else os.fspath(suite),
                tasks=tasks,
                worlds=worlds,
                world_seed=world_seed,
                apart_from=[os.fspath(s) for s in apart_from],
                vehicle=os.fspath(vehicle),
                perception=os.fspath(perception),
                soils=os.fspath(soils),
                rules=os.fspath(rules),
                scale=None if scale is None else _number("scale", scale),
                control_hz=_number("control_hz", control_hz),
                time_step=_number("time_step", time_step),
                observation=list(observation),
                sight={str(k): _number(f"sight[{k!r}]", v) for k, v in (sight or {}).items()},
                action=action,
                speed_range=tuple(_number("speed_range", v) for v in speed_range),
                reward=os.fspath(reward) if weights is None else weights,  # type: ignore[arg-type]
            )
        except (TypeError, OverflowError) as e:
            raise OptionError(f"an option has a value of the wrong kind: {e}") from None
        self.flat = flat
        self.parts = self.arena.parts()
        self.observation_space = self._observation_space()
        names, lows, highs, _ = zip(*self.arena.action())
        self.action_names: tuple[str, ...] = names
        self.action_space = spaces.Box(np.float32(lows), np.float32(highs), dtype=np.float32)

    def _observation_space(self) -> spaces.Space[Any]:
        if self.flat:
            bound = self.arena.flat_bound
            if not self.arena.flat_width:
                raise OptionError("observation: a flat one takes one part of numbers at least (class has labels only)")
            return spaces.Box(-bound, bound, (self.arena.flat_width,), np.float32)
        boxes: dict[str, spaces.Space[Any]] = {}
        for part in self.parts:
            shape, dtype = tuple(part["shape"]), np.dtype(part["dtype"])
            low = np.broadcast_to(np.array(part["low"], dtype), shape)
            high = np.broadcast_to(np.array(part["high"], dtype), shape)
            boxes[part["name"]] = spaces.Box(low, high, shape, dtype.type)
        return spaces.Dict(boxes)

    def collect(self, arrays: Sequence[np.ndarray]) -> Any:
        """The arrays of the parts as an observation: a dictionary by the parts' names, or the flat one."""
        if self.flat:
            return arrays[0]
        return {part["name"]: array for part, array in zip(self.parts, arrays)}


def began(task: str, run_seed: int) -> dict[str, Any]:
    """What is told when an episode begins."""
    return {"task": task, "run_seed": run_seed}


def ended(record: str) -> dict[str, Any]:
    """What is told when an episode ends: how, and the record of the benchmark."""
    told = json.loads(record)
    return {"outcome": told["outcome"], "is_success": told["outcome"] == "success", "record": told}


def seed_of(value: Any) -> int | None:
    """A seed, checked: None or a whole number below 2^63."""
    if value is None:
        return None
    try:
        seed = int(value)
        if seed != value:
            raise ValueError
    except (TypeError, ValueError):
        raise OptionError(f"seed: {value!r} is no whole number") from None
    if not 0 <= seed < 2**63:
        raise OptionError(f"seed: {seed} must lie in 0 to 2**63 - 1")
    return seed


def _number(name: str, value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise OptionError(f"{name}: {value!r} is no number") from None
