"""Options, spaces and episode information that single and vector environments share."""

from __future__ import annotations

import inspect
import json
import numbers
from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any

import numpy as np
from gymnasium import spaces

from .. import _native, _options
from .._errors import EpisodeError, OptionError, UnknownError
from .._program import tasks_path

#: Parts of an observation by default.
DEFAULT_PARTS = ("state", "goal", "path", "command", "height")
#: Names of the reward terms, in the order of their values.
TERMS = tuple(name for name, _, _ in _native.terms())
_ANOTHER = "another thread is using the environment: use it from one thread at a time"


def describe_parts() -> dict[str, str]:
    """Lists the parts that an observation can contain.

    Returns:
        Description by part name, with the required sensor if there is one.
    """
    return {name: f"{about}." + (f" Needs the sensor {s}." if s else "") for name, about, s in _native.parts()}


def describe_rewards() -> dict[str, str]:
    """Lists the terms that a reward can contain.

    Returns:
        Description by term name, with the unit of the measured quantity.
    """
    return {name: f"{about}{f', {unit}' if unit else ''}." for name, unit, about in _native.terms()}


class Setup:
    """Validated options of environments: the shared arena, and the spaces that follow from it."""

    def __init__(
        self,
        suite: str | PathLike[str] | None = None,
        tasks: str | Sequence[str] | None = None,
        *,
        worlds: int = 18,
        world_seed: int = 7000,
        apart_from: str | PathLike[str] | Sequence[str | PathLike[str]] = (),
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
        if isinstance(observation, str):
            flat = flat or observation == "flat"
            observation = DEFAULT_PARTS if observation == "flat" else (observation,)
        if isinstance(apart_from, (str, PathLike)):
            apart_from = (apart_from,)
        weights = {str(k): _options.number(f"reward[{k!r}]", v) for k, v in reward.items()} if isinstance(reward, Mapping) else None
        try:
            self.arena = _native.Arena(
                tasks_dir=tasks_path(),
                suite=None if suite is None else _options.path("suite", suite),
                tasks=_options.selector(tasks),
                worlds=_options.whole("worlds", worlds),
                world_seed=_options.whole("world_seed", world_seed, 0, 2**63 - 1),
                apart_from=[_options.path("apart_from", s) for s in apart_from],
                vehicle=_options.path("vehicle", vehicle),
                perception=_options.path("perception", perception),
                soils=_options.path("soils", soils),
                rules=_options.path("rules", rules),
                scale=None if scale is None else _options.number("scale", scale),
                control_hz=_options.number("control_hz", control_hz),
                time_step=_options.number("time_step", time_step),
                observation=list(observation),
                sight=_sight(sight),
                action=action,
                speed_range=_speeds(speed_range),
                reward=_options.path("reward", reward) if weights is None else weights,
            )
        except (TypeError, OverflowError) as e:
            raise OptionError(f"an option has the wrong type: {e}") from None
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
                raise OptionError("observation: a flat one needs at least one part with numbers (class has labels only)")
            return spaces.Box(-bound, bound, (self.arena.flat_width,), np.float32)
        boxes: dict[str, spaces.Space[Any]] = {}
        for part in self.parts:
            shape, dtype = tuple(part["shape"]), np.dtype(part["dtype"])
            low = np.broadcast_to(np.array(part["low"], dtype), shape)
            high = np.broadcast_to(np.array(part["high"], dtype), shape)
            boxes[part["name"]] = spaces.Box(low, high, shape, dtype.type)
        return spaces.Dict(boxes)

    def collect(self, arrays: Sequence[np.ndarray]) -> Any:
        """Returns the arrays of the parts as an observation: a dictionary by part name, or the flat vector."""
        if self.flat:
            return arrays[0]
        return {part["name"]: array for part, array in zip(self.parts, arrays)}


def setup_of(arguments: Sequence[Any], options: Mapping[str, Any], kind: str) -> Setup:
    """Returns the setup for these arguments; `kind` is the class that error messages name."""
    known = inspect.signature(Setup)
    for name in options:
        if name not in known.parameters:
            raise OptionError(f"there is no option {name!r}: help({kind}) lists all")
    try:
        known.bind(*arguments, **options)
    except TypeError as e:
        raise OptionError(f"only suite and tasks can be given by position, and each once: {e}") from None
    return Setup(*arguments, **options)


class Remade:
    """Base of environments that are copied and pickled by their arguments: a copy is new and was never reset."""

    #: Arguments of the environment: by position, and by name.
    _made_of: tuple[tuple[Any, ...], dict[str, Any]]
    #: Attributes that a copy doesn't take over: objects in Rust, and the state of episodes.
    _OWN = ("_setup", "_env", "_arrays", "_limit", "_all", "curriculum", "closed", "_is_seeded", "_np_random", "_np_random_seed")

    def __getstate__(self) -> dict[str, Any]:
        """Returns the arguments, and attributes that others have added."""
        return {name: value for name, value in self.__dict__.items() if name not in self._OWN}

    def _remake(self, state: dict[str, Any], init: Any) -> None:
        arguments, options = state["_made_of"]
        init(self, *arguments, **options)
        self.__dict__.update(state)


def options_of(options: Any, *known: str) -> list[Any]:
    """Returns the options of a reset in the order of the names `known`, None where absent."""
    if options is not None and not isinstance(options, Mapping):
        raise OptionError(f"reset: options is {options!r}; it must be a dictionary of {_told(known)}")
    given = dict(options or {})
    values = [given.pop(name, None) for name in known]
    if given:
        raise OptionError(f"reset: options has {', '.join(map(repr, given))}; there are {_told(known)}")
    return values


def _told(names: Sequence[str]) -> str:
    return f"{', '.join(map(repr, names[:-1]))} and {names[-1]!r}"


def task_of(value: Any) -> str | None:
    """Returns a task name or None."""
    if value is not None and not isinstance(value, str):
        raise UnknownError(f"there is no task {value!r}: give a name such as 'w001/t03'")
    return value


def real_numbers(given: Any) -> np.ndarray | None:
    """Converts the argument to a float64 array; returns None if it doesn't consist of real numbers."""
    if isinstance(given, np.ma.MaskedArray):
        return None
    try:
        array = np.asarray(given)
        kind = array.dtype.kind
        if kind == "O" and not all(isinstance(value, numbers.Real) for value in array.flat):
            return None
        # Learning libraries have short floats of their own, whose kind is V, like that of structured arrays.
        if kind not in "biufO" and (kind != "V" or array.dtype.type is np.void):
            return None
        return np.ascontiguousarray(array, dtype=np.float64) if array.ndim else array.astype(np.float64)
    except (TypeError, ValueError, OverflowError, RuntimeError):
        # Rows with different lengths, numbers that are too large, tensors on a GPU or with a gradient.
        return None


def began(episode: tuple[str, int] | None) -> dict[str, Any]:
    """Returns the `info` entries at the start of an episode."""
    if episode is None:
        raise EpisodeError(_ANOTHER)
    return {"task": episode[0], "run_seed": episode[1]}


def ended(record: str | None) -> dict[str, Any]:
    """Returns the `info` entries at the end of an episode: outcome and record."""
    if record is None:
        raise EpisodeError(_ANOTHER)
    told = json.loads(record)
    return {"outcome": told["outcome"], "is_success": told["outcome"] == "success", "record": told}


def _sight(sight: Any) -> dict[str, float]:
    if sight is None:
        return {}
    if not isinstance(sight, Mapping):
        raise OptionError(f"sight: {sight!r} must be a dictionary of cells, resolution, ahead, points and spacing")
    counts = ("cells", "points")
    return {str(k): _options.whole(f"sight: {k}", v) if k in counts else _options.number(f"sight[{k!r}]", v) for k, v in sight.items()}


def _speeds(speed_range: Any) -> tuple[float, float]:
    try:
        slowest, fastest = speed_range
    except (TypeError, ValueError):
        raise OptionError(f"speed_range: {speed_range!r} must be two speeds, the slowest and the fastest") from None
    return _options.number("speed_range", slowest), _options.number("speed_range", fastest)
