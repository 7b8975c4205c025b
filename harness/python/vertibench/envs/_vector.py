"""The vector environment, `NavigationVectorEnv`: many environments, stepped on Rust threads."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from .. import _native
from .._errors import ActionError, EpisodeError, OptionError, UnknownError
from .._options import path, whole
from .._options import seed as seed_of
from ._common import TERMS, Remade, began, ended, options_of, real_numbers, setup_of, task_of
from ._curriculum import Curriculum
from ._limit import Limit
from ._navigation import NavigationEnv, State
from ._render import Camera

#: Attributes and methods of a single environment that change nothing, for `get_attr` and `call`.
_VIEWS = (
    "task", "vehicle", "tasks", "reward_weights", "state", "render", "render_mode", "metadata", "spec", "observation_space", "action_space",
)  # fmt: skip
#: With the default seed, this number of training worlds has tasks for all stages of the curriculum `manual`.
MANUAL_WORLDS = 36


class NavigationVectorEnv(Remade, VectorEnv[Any, Any, Any]):
    """Many navigation environments that one call steps on Rust threads.

    Create it with `gymnasium.make_vec("VertiBench/Navigation-v0", num_envs=16, vectorization_mode="vector_entry_point",
    ...)` or directly. Python's lock is released during a step. The result of an environment depends on its own seed and
    actions, never on the number of threads.

    `step` and `reset` are gymnasium's interface. `async_reset`, `send` and `recv` work in batches, as in EnvPool.
    Observations have a leading axis of length `num_envs`. As usual in gymnasium, each array in `infos` has a mask with
    the prefix `_` that marks the environments with a value.

    Threads don't survive a fork: create the environment in the process that uses it, or start processes with spawn.
    Copying or pickling creates a new environment with the same arguments, which was never reset.

    Example:
        >>> envs = NavigationVectorEnv(16, "smoke", observation="flat", threads=8)
        >>> observations, infos = envs.reset(seed=0)
        >>> observations, rewards, terminated, truncated, infos = envs.step(envs.action_space.sample())

    Args:
        num_envs: Number of environments, 1 to 65536; default 1.
        *arguments: `suite` and `tasks`, as in `NavigationEnv`.
        threads: Number of threads, 1 to 1024. None (default): the number of processors that the process may use.
        autoreset_mode: When an environment begins its next episode, as `gymnasium.vector.AutoresetMode` or its name.
            `NEXT_STEP` (default): with the step after the last one, whose action is ignored. `SAME_STEP`: at once; the
            last observation is in `infos["final_obs"]`, the information on the ended episode in `infos["final_info"]`.
            `DISABLED`: when `reset` is called with `options={"reset_mask": mask}`.
        copy: Whether results are copies; default True. With False, `step` and `reset` return the arrays that the
            threads write, which change with the next step and keep the threads alive.
        batch_size: Number of finished environments for which `recv` waits, 1 to `num_envs`. None (default): `num_envs`.
        curriculum: Curriculum that chooses the tasks: `"uniform"`, `"manual"`, `"learnability"`, `"replay"`, or a YAML
            file. None (default): each environment samples its tasks with its own seed. Choices are reproducible with
            `step`; with `recv` in smaller batches they depend on the order of results. `"manual"` needs worlds of every
            elevation and terrain type: of the training worlds with the default seed, `worlds=36` has all.
        curriculum_seed: Seed of the curriculum, 0 to 2**63 - 1; default 0.
        max_episode_steps: Truncates each episode after this number of steps, as gymnasium's `TimeLimit`; such an end
            has no `outcome` and no `record`. None (default): only the rules end an episode. Not with a curriculum, nor
            with `SAME_STEP` if `batch_size` is below `num_envs`.
        render_mode: As in `NavigationEnv`.
        camera: As in `NavigationEnv`.
        render_size: As in `NavigationEnv`.
        **options: All other arguments of `NavigationEnv`, by name.

    Attributes:
        curriculum: The `Curriculum` that chooses the tasks; None without one.

    Raises:
        OptionError: If an argument is unknown or invalid, the curriculum doesn't fit the tasks, or memory or threads
            don't suffice for `num_envs` and `threads`.
        MissingError: If the package's folder of tasks is missing.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10, "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        num_envs: int = 1,
        *arguments: Any,
        threads: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        copy: bool = True,
        batch_size: int | None = None,
        curriculum: str | os.PathLike[str] | None = None,
        curriculum_seed: int = 0,
        max_episode_steps: int | None = None,
        render_mode: str | None = None,
        camera: str = "chase",
        render_size: tuple[int, int] = (640, 480),
        **options: Any,
    ) -> None:
        own = {
            "threads": threads, "autoreset_mode": autoreset_mode, "copy": copy, "batch_size": batch_size, "curriculum": curriculum,
            "curriculum_seed": curriculum_seed, "max_episode_steps": max_episode_steps, "render_mode": render_mode, "camera": camera,
            "render_size": render_size,
        }  # fmt: skip
        self._made_of = ((num_envs, *arguments), {**own, **options})
        try:
            mode = AutoresetMode[autoreset_mode.upper()] if isinstance(autoreset_mode, str) else AutoresetMode(autoreset_mode)
        except (KeyError, ValueError):
            names = ", ".join(m.name for m in AutoresetMode)
            raise OptionError(f"autoreset_mode: {autoreset_mode!r} must be one of {names}") from None
        num_envs = whole("num_envs", num_envs, 1, 65_536)
        threads = processors() if threads is None else whole("threads", threads, 1, 1024)
        batch_size = num_envs if batch_size is None else whole("batch_size", batch_size)
        if batch_size > num_envs:
            raise OptionError(f"batch_size: {batch_size} must lie in 1 to num_envs, which is {num_envs}")
        self._camera = Camera(render_mode, camera, render_size)
        self._limit: Limit | None = None
        if max_episode_steps is not None:
            most = whole("max_episode_steps", max_episode_steps)
            self._limit = Limit(most, mode, num_envs, batch_size, curriculum is not None)
        self._setup = setup_of(arguments, options, "NavigationVectorEnv")
        self.num_envs, self.batch_size = num_envs, batch_size
        self.render_mode = render_mode
        self.single_observation_space = self._setup.observation_space
        self.single_action_space = self._setup.action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        fps = round(1.0 / self._setup.arena.control_period)
        # As in gymnasium's vector environments; TorchRL reads it.
        self.autoreset_mode = mode
        self.metadata = {**self.metadata, "render_fps": fps, "autoreset_mode": mode}
        self._mode, self._copy = mode, copy
        self._all = np.arange(num_envs, dtype=np.int64)
        self._env: _native.VectorEnv | None = _native.VectorEnv(
            self._setup.arena, num_envs, threads, mode.name.lower(), self._setup.flat
        )
        self._arrays = self._env.arrays()
        self.curriculum: Curriculum | None = None
        if curriculum is not None:
            self._follow(self._env, curriculum, curriculum_seed)
            self.curriculum = Curriculum(self)
        self._is_seeded = False

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._remake(state, NavigationVectorEnv.__init__)

    def _follow(self, env: _native.VectorEnv, curriculum: Any, seed: Any) -> None:
        try:
            env.follow(path("curriculum", curriculum), whole("curriculum_seed", seed, 0, 2**63 - 1))
        except OptionError as e:
            (_, *arguments), options = self._made_of
            if "matches none of" in str(e) and not arguments and options.get("suite") is None and options.get("tasks") is None:
                raise OptionError(f"{e}: generate more training worlds, e.g. worlds={MANUAL_WORLDS}") from None
            raise

    # All environments in one call.

    def reset(
        self, *, seed: int | Sequence[int | None] | np.ndarray | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begins episodes in all environments, or in those of a mask.

        Environments that are still busy, after `send` or Ctrl-C, are waited for and their results dropped; with a
        `reset_mask` they raise an error instead.

        Args:
            seed: Seed s gives environment k the seed s + k, modulo 2**63. A sequence has one seed or None per
                environment. None: continues the sequences of the last seeds; the first reset without a seed chooses one
                at random.
            options: Dictionary with any of these keys. `"reset_mask"`: boolean array of shape (num_envs,), the
                environments to reset, at least one. `"task"`: task name for all environments, or one or None per
                environment. `"run_seed"`: seed of the sensor noise, 0 to 2**63 - 1, in the same forms.

        Returns:
            Observations of all environments, and `infos` with `task` and `run_seed` of the new episodes.

        Raises:
            UnknownError: If there is no such task.
            OptionError: If another option is unknown or invalid, or has the wrong length.
            EpisodeError: If an environment is busy and a mask is given, the simulation fails at a start, the
                environment is closed, was created in another process, or is used by another thread.
        """
        env = self._native()
        which = self._begin(env, seed, options, is_dropped=True)
        infos = self._receive(env, len(which))[1]
        return self._observations(None), infos

    def step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Steps all environments with one action each and waits for all.

        Args:
            actions: Array of shape (num_envs, 2), or (num_envs, 4) with `action="pedals"`. Numbers outside their range
                are clipped.

        Returns:
            Observations; rewards (float64), terminated and truncated (bool), each of shape (num_envs,); and `infos`.
            `infos["reward_terms"]` has an array of shape (num_envs,) per reward term. Where an episode ended, `infos`
            has `outcome`, `is_success` and `record`, with `SAME_STEP` in `infos["final_info"]`; where one began, `task`
            and `run_seed`.

        Raises:
            ActionError: If the actions have the wrong shape, or a number is not real and finite. No environment is
                stepped.
            EpisodeError: If an environment is busy, has no episode, or its episode has ended with `DISABLED`; or if the
                environment is closed, was created in another process, or is used by another thread.
        """
        env = self._native()
        rows = self._rows(actions, self.num_envs)
        if env.pending():
            raise EpisodeError(f"{env.pending()} environments are busy: call recv for each, or reset, which discards their steps")
        self._hand_out(env, self._all, rows)
        infos = self._receive(env, self.num_envs)[1]
        return (self._observations(None), *self._numbers(None), infos)

    # Batches, as in EnvPool.

    def async_reset(
        self, seed: int | Sequence[int | None] | np.ndarray | None = None, options: dict[str, Any] | None = None
    ) -> None:
        """Begins episodes without waiting; `recv` returns the first observations.

        Args:
            seed: As in `reset`.
            options: As in `reset`.

        Raises:
            UnknownError: If there is no such task.
            OptionError: If another option is unknown or invalid, or has the wrong length.
            EpisodeError: If an environment to be reset is busy, or the environment can't be used (see `step`).
        """
        self._begin(self._native(), seed, options, is_dropped=False)

    def send(self, actions: Any, env_id: Any = None) -> None:
        """Begins a step of some environments without waiting; `recv` returns the results.

        Args:
            actions: Array with one action per environment in `env_id`, in their order.
            env_id: Indices of the environments, from 0, each at most once. None (default): all.

        Raises:
            ActionError: If the actions have the wrong shape, or a number is not real and finite. No environment is
                stepped.
            UnknownError: If there is no environment with an index.
            OptionError: If `env_id` doesn't consist of whole numbers, or contains an index twice.
            EpisodeError: As in `step`.
        """
        ids = self._all if env_id is None else self._indices("send: env_id", env_id)
        self._hand_out(self._native(), ids, self._rows(actions, len(ids)))

    def recv(self) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Waits for `batch_size` busy environments, or for all if fewer are busy.

        Returns:
            As `step`, with one row per received environment. `infos["env_id"]` has their indices, in the order of their
            arrival. This order is not reproducible; the result of each environment is. The results are copies.

        Raises:
            EpisodeError: If no environment is busy, or the environment can't be used (see `step`).
        """
        env = self._native()
        ids, infos = self._receive(env, min(self.batch_size, env.pending() or 1))
        picked = {name: _pick(value, ids) for name, value in infos.items()}
        picked["env_id"] = ids
        return (self._observations(ids), *self._numbers(ids), picked)

    # Shared helpers.

    def _begin(self, env: _native.VectorEnv, seed: Any, options: Any, is_dropped: bool) -> np.ndarray:
        mask, tasks, run_seeds = options_of(options, "reset_mask", "task", "run_seed")
        tasks, run_seeds = self._each("task", tasks, task_of), self._each("run_seed", run_seeds, lambda s: seed_of("run_seed", s))
        if mask is None:
            which = self._all
        else:
            mask = _array(mask)
            if mask.shape != (self.num_envs,) or mask.dtype != np.bool_ or not mask.any():
                raise OptionError(f"reset_mask: it must be {self.num_envs} booleans of which at least one is True")
            which = self._all[mask]
        seeds = self._each("seed", seed, lambda s: seed_of("seed", s))
        if _is_one(seed):
            first = seeds[0]
            if first is None and not self._is_seeded:
                first = int(np.random.default_rng().integers(2**63))
            seeds = [None if first is None else (first + k) % 2**63 for k in range(self.num_envs)]
        resets = [(int(k), seeds[k], tasks[k], run_seeds[k]) for k in which]
        if is_dropped:
            self._drop(env, mask, tasks)
        env.reset(resets)
        self._is_seeded = True
        return which

    def _drop(self, env: _native.VectorEnv, mask: np.ndarray | None, tasks: Sequence[str | None]) -> None:
        """Waits for busy environments and drops their results, unless the reset will be refused."""
        if not env.pending():
            return
        if mask is not None:
            raise EpisodeError(f"{env.pending()} environments are busy: call recv for each, or reset without reset_mask")
        known = set(self.tasks)
        for task in tasks:
            if task is not None and task not in known:
                # Raises the environment's own error before any result is dropped.
                _native.Env(self._setup.arena, 0).reset(None, task, None)
        while env.pending():
            env.receive(env.pending())

    def _each(self, name: str, value: Any, check: Any) -> list[Any]:
        """Returns an option of a reset per environment, given for all or for each."""
        if _is_one(value):
            return [check(value)] * self.num_envs
        if len(value) != self.num_envs:
            raise OptionError(f"{name}: give {self.num_envs} values, one per environment, not {len(value)}")
        return [check(one) for one in value]

    def _indices(self, name: str, index: Any) -> np.ndarray:
        given = np.atleast_1d(_array(index))
        if given.ndim != 1 or (given.dtype.kind not in "iu" and given.size):
            raise OptionError(f"{name} must be a one-dimensional array of whole numbers, the indices of environments")
        beyond = [k for k in given.tolist() if not 0 <= k < self.num_envs]
        if beyond:
            raise UnknownError(f"there is no environment {beyond[0]}: there are {self.num_envs}, counted from 0")
        ids = given.astype(np.int64)
        if len(np.unique(ids)) != len(ids):
            raise OptionError(f"{name} contains an environment twice")
        return ids

    def _rows(self, actions: Any, count: int) -> np.ndarray:
        width = len(self._setup.action_names)
        rows = real_numbers(actions)
        if rows is None:
            raise ActionError(f"actions must be numbers of the shape ({count}, {width})")
        if rows.shape != (count, width):
            names = ", ".join(self._setup.action_names)
            raise ActionError(f"actions have the shape ({count}, {width}) ({names} each), not {rows.shape}")
        return rows

    def _hand_out(self, env: _native.VectorEnv, ids: np.ndarray, rows: np.ndarray) -> None:
        try:
            if self._limit is None:
                env.send(ids, rows)
            else:
                self._limit.send(env, ids, rows)
        except ActionError as e:
            wrong = np.flatnonzero(~np.isfinite(rows).all(axis=1))
            raise ActionError(f"environment {ids[wrong[0]]}: {e}" if len(wrong) else str(e)) from None

    def _receive(self, env: _native.VectorEnv, count: int) -> tuple[np.ndarray, dict[str, Any]]:
        arrivals = env.receive(count)
        cut = {} if self._limit is None else self._limit.receive(env, arrivals, self._held())
        infos: dict[str, Any] = {"reward_terms": self._terms()}
        for index, start, record in arrivals:
            told = {} if record is None else ended(record)
            if told and self._mode == AutoresetMode.SAME_STEP:
                told = {"final_info": told, "final_obs": self._row(self._held()["finals"], index)}
            if index in cut:
                told = {"final_obs": self._setup.collect(cut[index])}
            if start is not None:
                told.update(began(start))
            for name, value in told.items():
                self._note(infos, name, value, index)
        return np.array([index for index, _, _ in arrivals], dtype=np.int64), infos

    def _note(self, infos: dict[str, Any], name: str, value: Any, index: int) -> None:
        """Adds a value of one environment to infos in gymnasium's form: an array and its mask."""
        mask = infos.setdefault(f"_{name}", np.zeros(self.num_envs, dtype=np.bool_))
        mask[index] = True
        if name == "final_info":
            inner = infos.setdefault(name, {})
            for key, one in value.items():
                self._note(inner, key, one, index)
            return
        kinds: dict[type, Any] = {bool: np.bool_, int: np.int64}
        if name not in infos:
            infos[name] = np.zeros(self.num_envs, dtype=kinds.get(type(value), object))
            if infos[name].dtype == object:
                infos[name][:] = None
        infos[name][index] = value

    def _terms(self) -> dict[str, np.ndarray]:
        table = self._held()["terms"].copy()
        return {name: table[:, k] for k, name in enumerate(TERMS)}

    def _row(self, arrays: list[np.ndarray], index: int) -> Any:
        return self._setup.collect([array[index].copy() for array in arrays])

    def _observations(self, ids: np.ndarray | None) -> Any:
        arrays = self._held()["observations"]
        if ids is not None:
            return self._setup.collect([array[ids] for array in arrays])
        return self._setup.collect([array.copy() for array in arrays] if self._copy else arrays)

    def _numbers(self, ids: np.ndarray | None) -> list[np.ndarray]:
        held = self._held()
        arrays = [held[name] for name in ("rewards", "terminated", "truncated")]
        if ids is not None:
            return [array[ids] for array in arrays]
        return [array.copy() for array in arrays] if self._copy else arrays

    @property
    def tasks(self) -> list[str]:
        """Names of the tasks, in the order of the suite."""
        return self._setup.arena.tasks()

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """Reads an attribute of `NavigationEnv` from every environment.

        Args:
            name: `"task"`, `"vehicle"`, `"tasks"`, `"reward_weights"`, `"render_mode"`, `"metadata"`, `"spec"`,
                `"observation_space"` or `"action_space"`.

        Returns:
            The value of each environment.

        Raises:
            UnknownError: If the name is another one.
            EpisodeError: If an environment is busy.
        """
        return self.call(name)

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Calls a read-only method of `NavigationEnv` in every environment.

        Methods that would change a single environment, such as `step`, are refused; use `send` with its index.

        Args:
            name: `"state"` or `"render"`, or an attribute of `get_attr`, whose value is returned.
            *args: Positional arguments of the method.
            **kwargs: Keyword arguments of the method.

        Returns:
            The result of each environment.

        Raises:
            UnknownError: If the name is another one.
            EpisodeError: If an environment is busy, or has no episode where the method needs one.
        """
        if name not in _VIEWS:
            raise UnknownError(f"call: environments have no {name!r}; there are {', '.join(_VIEWS)}")
        env = self._native()
        one = NavigationEnv.__new__(NavigationEnv)
        one._setup, one._camera = self._setup, self._camera
        one.observation_space, one.action_space = self.single_observation_space, self.single_action_space
        one.render_mode, one.metadata, one.spec = self.render_mode, self.metadata, self.spec
        told = []
        for index in range(self.num_envs):
            snapshot, one._env = env.snapshot(index), _native.Env(self._setup.arena, 0)
            # Before the first reset there is no episode to restore.
            with contextlib.suppress(EpisodeError):
                one._env.restore(snapshot)
            value = getattr(one, name)
            told.append(value(*args, **kwargs) if callable(value) else value)
        return tuple(told)

    def set_attr(self, name: str, values: Any) -> None:
        """Refuses the change: attributes follow from the arguments and are equal in all environments.

        Args:
            name: Attribute name.
            values: Ignored.

        Raises:
            OptionError: Always.
        """
        raise OptionError(f"set_attr: {name!r} can't be set: create environments with other options")

    def state(self, index: int) -> State:
        """Saves the simulation of one environment.

        Args:
            index: Index of the environment, from 0.

        Returns:
            The state, which a `NavigationEnv` with the same options can restore with `set_state`.

        Raises:
            UnknownError: If there is no environment with this index.
            EpisodeError: If the environment is busy or closed.
        """
        env = self._native()
        (own,) = self._indices("state: index", [index])
        return State(env.snapshot(int(own)))

    def render(self) -> tuple[np.ndarray, ...] | None:
        """Renders every environment.

        Returns:
            One image per environment, of shape (height, width, 3), uint8; None without a render mode.

        Raises:
            EpisodeError: If an environment has no episode or is busy.
        """
        if self.render_mode is None:
            return None
        env = self._native()
        single = _native.Env(self._setup.arena, 0)
        pictures = []
        for index in range(self.num_envs):
            single.restore(env.snapshot(index))
            single.check()
            pictures.append(self._camera.picture(single))
        return tuple(pictures)  # type: ignore[arg-type]

    def close_extras(self, **kwargs: Any) -> None:
        """Releases the environments; `close` calls this.

        With `copy=False` the returned arrays keep their values, and the threads end when none of these arrays is held.
        Otherwise the threads end at once.

        Args:
            **kwargs: Ignored.
        """
        self._env = None
        self._arrays = {}

    def _held(self) -> dict[str, Any]:
        """Returns the arrays that the threads write."""
        arrays = self._arrays
        if not arrays:
            # Another thread may have closed the environment.
            self._native()
        return arrays

    def _native(self) -> _native.VectorEnv:
        if self._env is None:
            raise EpisodeError("the environment is closed: create a new one")
        return self._env


def _pick(value: Any, ids: np.ndarray) -> Any:
    if isinstance(value, dict):
        return {name: _pick(one, ids) for name, one in value.items()}
    return value[ids]


def processors() -> int:
    """Returns the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _array(given: Any) -> np.ndarray:
    """Converts the argument to an array; returns an invalid one for arguments such as rows of different lengths."""
    try:
        return np.asarray(given)
    except (TypeError, ValueError):
        return np.array([None])


def _is_one(value: Any) -> bool:
    """Returns whether the value is for all environments, rather than one per environment."""
    if isinstance(value, np.ndarray):
        return value.ndim == 0
    return isinstance(value, (str, bytes)) or not isinstance(value, Sequence)
