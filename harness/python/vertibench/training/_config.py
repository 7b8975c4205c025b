"""Configuration of a training: settings as data."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

from .. import _yaml
from .._errors import VertibenchError, one_line
from .._program import tasks_path


class TrainingError(VertibenchError, ValueError):
    """A configuration, checkpoint, weight file or planner is missing or invalid. The message is one line."""


#: Fields of a configuration, with minimum and maximum of numbers; None for other fields.
_FIELDS: dict[str, tuple[float, float] | None] = {
    "schema": (1, 1),
    "name": None,
    "planners": None,
    "worlds.count": (1, 1000),
    "worlds.seed": (7000, 7999),
    "held_out.count": (1, 1000),
    "held_out.seed": (7000, 7999),
    "held_out.tasks": None,
    "vehicle": None,
    "perception": None,
    "reward": None,
    "rules": None,
    "time_step": (1e-4, 5e-3),
    "observation": None,
    "ahead": (-50, 50),
    "labels": None,
    "action": None,
    "speed_range": None,
    "environments": (1, 65536),
    "network.planes": (1, 256),
    "network.kernel": (1, 16),
    "network.stride": (1, 16),
    "network.relief": (0, 1000),
    "network.widths": None,
    "algorithm": None,
    "final_rate": (0, 1),
    "sac.learning_rate": (1e-7, 1),
    "sac.buffer": (1, 10**9),
    "sac.begin": (0, 10**9),
    "sac.batch": (2, 2**20),
    "sac.updates": (1, 10000),
    "sac.returns": (1, 1000),
    "sac.gamma": (0, 1),
    "sac.tau": (1e-6, 1),
    "sac.temperature": (1e-6, 100),
    "sac.entropy": (-100, 100),
    "sac.mirror": None,
    "ppo.steps": (1, 65536),
    "ppo.batch": (2, 2**20),
    "ppo.epochs": (1, 100),
    "ppo.learning_rate": (1e-7, 1),
    "ppo.gamma": (0, 1),
    "ppo.gae_lambda": (0, 1),
    "ppo.clip": (1e-3, 10),
    "ppo.entropy": (0, 10),
    "ppo.value": (0, 100),
    "ppo.gradient": (1e-3, 1e3),
    "ppo.spread": (1e-3, 10),
    "ppo.hold": (0, 10000),
    "clone.epochs": (1, 1000),
    "clone.batch": (1, 2**20),
    "clone.rate": (1e-7, 1),
    "clone.spread": (1e-3, 10),
    "clone.critic": (0, 10**12),
    "steps": (1, 10**12),
    "checkpoint": (1, 10**12),
}
#: Fields with whole numbers.
_COUNTS = {
    *("schema", "worlds.count", "worlds.seed", "held_out.count", "held_out.seed", "environments", "network.planes", "network.kernel"),
    *("network.stride", "sac.buffer", "sac.begin", "sac.batch", "sac.updates", "sac.returns", "ppo.steps", "ppo.batch", "ppo.epochs"),
    *("ppo.hold", "clone.epochs", "clone.batch", "clone.critic", "steps", "checkpoint"),
}
_LISTS = {"observation": str, "labels": int, "speed_range": float, "network.widths": int}
#: Minimum and maximum of the entries of lists of numbers.
_ENTRIES: dict[str, tuple[float, float]] = {"labels": (0, 255), "speed_range": (-10, 30), "network.widths": (1, 65536)}
#: Sampling period of the rules, s; a multiple of the time step.
_TICK = 0.01
#: Allowed values of fields with few choices.
_CHOICES: dict[str, tuple[Any, ...]] = {"algorithm": ("sac", "ppo"), "action": ("speed", "rate"), "sac.mirror": (True, False)}


@dataclass(frozen=True)
class Config:
    """Configuration of a training. `config["ppo.batch"]` returns the value of a field.

    `read_config` reads and validates it; `tasks/training/policy.yaml` documents the fields.

    Attributes:
        values: Values by field name; nested fields have names such as `sac.batch`.
    """

    values: dict[str, Any]

    def __getitem__(self, field: str) -> Any:
        return self.values[field]

    def own(self, field: str) -> Any:
        """Returns a field of the chosen algorithm.

        Args:
            field: Name without the algorithm, e.g. `"learning_rate"` for `sac.learning_rate` or `ppo.learning_rate`.

        Returns:
            The value.
        """
        return self.values[f"{self['algorithm']}.{field}"]

    @property
    def hash(self) -> str:
        """SHA-256 of all values, 64 hexadecimal digits."""
        text = json.dumps(self.values, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()

    def environment(self, curriculum: str | None, seed: int) -> dict[str, Any]:
        """Returns the options of the vector environment for training.

        Args:
            curriculum: Name or file of the curriculum. None: tasks are sampled uniformly.
            seed: Seed of the curriculum.

        Returns:
            Arguments of `NavigationVectorEnv`.
        """
        return {
            **self.sees_and_does(),
            "worlds": self["worlds.count"],
            "world_seed": self["worlds.seed"],
            "time_step": self["time_step"],
            "rules": self["rules"],
            "curriculum": curriculum,
            "curriculum_seed": seed,
        }

    def sight(self) -> dict[str, float]:
        """Returns the observation window.

        Returns:
            The argument `sight` of environments, in the order of the metadata of weights.
        """
        return {"cells": 16, "resolution": 1.0, "ahead": self["ahead"], "points": 10, "spacing": 2.0}

    def held_out(self) -> dict[str, Any]:
        """Returns the options of an environment with the held-out worlds, under the benchmark's rules and time step.

        Returns:
            Arguments of `NavigationVectorEnv`.
        """
        own = {"worlds": self["held_out.count"], "world_seed": self["held_out.seed"], "tasks": self["held_out.tasks"]}
        return {**self.sees_and_does(), **own}

    def sees_and_does(self) -> dict[str, Any]:
        """Returns the options that training and held-out environments share: vehicle, perception, reward, observation and
        action.

        Returns:
            Arguments of `NavigationVectorEnv`.
        """
        return {
            "vehicle": self["vehicle"],
            "perception": self["perception"],
            "reward": self["reward"],
            "observation": self["observation"],
            "sight": self.sight(),
            "action": self["action"],
            "speed_range": tuple(self["speed_range"]),
        }


def read_config(name: str | PathLike[str] = "policy", changes: dict[str, str] | None = None) -> Config:
    """Reads and validates a configuration.

    Args:
        name: Name of a file in `tasks/training` without suffix, or a YAML file; default `"policy"`.
        changes: Fields to replace, with their values as YAML text, e.g. `{"sac.batch": "512"}`. None (default): no
            changes.

    Returns:
        The configuration.

    Raises:
        TrainingError: If the file can't be read, a field is unknown or missing, or a value is invalid.
        MissingError: If the package's folder of tasks is missing.
    """
    path = Path(name)
    if path.suffix == "" and path.name == str(name):
        path = tasks_path() / "training" / f"{name}.yaml"
    values = _read(path)
    for field, text in (changes or {}).items():
        if field not in _FIELDS:
            raise TrainingError(f"--set {field}", "there is no such field", f"there are {', '.join(_FIELDS)}")
        try:
            values[field] = _yaml.parse(f"value: {text}")["value"]
        except (ValueError, TypeError):
            raise TrainingError(f"--set {field}", f"{text!r} is not a value", "give a number, text or list in YAML") from None
    return checked(path, values)


def _read(path: Path, is_base: bool = False) -> dict[str, Any]:
    """Returns the values of a file by field. The field `base` names a file in its folder whose values it changes."""
    try:
        read = _yaml.read(path)
    except OSError as e:
        there = ", ".join(sorted(p.stem for p in (tasks_path() / "training").glob("*.yaml")))
        raise TrainingError(path, f"it can't be read: {e.strerror or e}", f"give a YAML file, or one of {there}") from None
    except ValueError as e:
        raise TrainingError(path, one_line(e), "correct it") from None
    base = read.pop("base", None) if isinstance(read, dict) else None
    if base is None:
        return _flat(path, read)
    if is_base or not isinstance(base, str) or Path(base).name != base:
        raise TrainingError(path, f"base: {base!r} is not a file beside this one without a base", "give its name without suffix")
    return {**_read(path.with_name(f"{base}.yaml"), is_base=True), **_flat(path, read)}


def checked(path: Path, values: dict[str, Any]) -> Config:
    """Validates values and returns them as configuration; `path` is their source in error messages."""
    for field, bounds in _FIELDS.items():
        if field not in values:
            raise TrainingError(path, f"{field}: the field is missing", "add it")
        _check(path, field, values[field], bounds)
    ppo = values["algorithm"] == "ppo"
    one = values["environments"] * (values["ppo.steps"] if ppo else 1)
    if values["checkpoint"] % one:
        what = f"checkpoint: {values['checkpoint']} is not a multiple of environments{' times ppo.steps' if ppo else ''}, {one}"
        raise TrainingError(path, what, "change one of them")
    if values["held_out.seed"] == values["worlds.seed"]:
        raise TrainingError(path, "held_out.seed: it must differ from worlds.seed, the seed of the training worlds", "choose another seed")
    return Config(values)


def _flat(path: Path, read: Any) -> dict[str, Any]:
    if not isinstance(read, dict):
        raise TrainingError(path, "it has no fields", "see tasks/training/policy.yaml")
    values: dict[str, Any] = {}
    for key, value in read.items():
        if isinstance(value, dict) and key != "planners":
            values.update({f"{key}.{inner}": v for inner, v in value.items()})
        else:
            values[key] = value
    for field in values:
        if field not in _FIELDS:
            raise TrainingError(path, f"{field}: there is no such field", f"there are {', '.join(_FIELDS)}")
    return values


def _check(path: Path, field: str, value: Any, bounds: tuple[float, float] | None) -> None:
    problem = _problem(field, value, bounds)
    if problem is not None:
        to_do = "see tasks/training/policy.yaml" if field == "planners" else "correct it"
        raise TrainingError(path, f"{field}: {value!r} must {problem}", to_do)


def _problem(field: str, value: Any, bounds: tuple[float, float] | None) -> str | None:
    """Returns the condition that a value violates, or None."""
    if bounds is not None:
        if not _is_number(value) or not bounds[0] <= value <= bounds[1]:
            return f"lie in {bounds[0]} to {bounds[1]}"
        if field in _COUNTS and not isinstance(value, int):
            return "be a whole number without decimal point"
        if field == "time_step" and abs(_TICK / value - round(_TICK / value)) > 1e-9:
            return f"divide {_TICK} s"
    elif field in _LISTS:
        return _problem_of_list(field, value)
    elif field == "planners":
        if not isinstance(value, dict) or not value or not all(isinstance(c, str) and c for c in value.values()):
            return "map names of planners to curricula"
    elif field in _CHOICES:
        if not any(value is choice or (isinstance(value, str) and value == choice) for choice in _CHOICES[field]):
            return f"be {' or '.join(str(choice).lower() for choice in _CHOICES[field])}"
    elif not isinstance(value, str) or not value:
        return "be a text"
    return None


def _problem_of_list(field: str, value: Any) -> str | None:
    kind = _LISTS[field]
    kinds = (int, float) if kind is float else (kind,)
    if not isinstance(value, list) or not value or not all(isinstance(v, kinds) and not isinstance(v, bool) for v in value):
        return f"be a list of {kind.__name__}s"
    if field in _ENTRIES:
        low, high = _ENTRIES[field]
        if not all(low <= v <= high for v in value):
            return f"have entries from {low} to {high}"
    if field == "speed_range" and (len(value) != 2 or not value[0] < value[1]):
        return "be two speeds, the lower one first"
    if field == "observation":
        try:
            from .._native import parts
        except ImportError:
            # Environments report the missing module.
            return None
        known = [name for name, _, _ in parts()]
        if not set(value) <= set(known):
            return f"consist of {', '.join(known)}"
    return None


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)
