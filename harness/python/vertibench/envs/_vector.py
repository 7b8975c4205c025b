"""Many environments at a time, stepped by threads of Rust."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from .. import _native
from .._errors import ActionError, EpisodeError, OptionError
from ._common import TERMS, Setup, began, ended, seed_of
from ._navigation import State
from ._render import Camera


class NavigationVectorEnv(VectorEnv[Any, Any, Any]):
    """Many environments of one kind, stepped in one call: `gymnasium.make_vec("VertiBench/Navigation-v0", num_envs=16, …)`.

    The options are those of `NavigationEnv`. Beside them:

    - `threads`: how many threads of Rust step the environments; by default as many as there are processors. Python's lock is
      free meanwhile. What an environment does depends on its own seed and actions, never on the threads.
    - `autoreset_mode`: `NEXT_STEP` (the default) begins the next episode with the step after the last one, whose action isn't
      used; `SAME_STEP` at once, with the last observation in `infos["final_obs"]`; `DISABLED` when `reset` is called with
      `options={"reset_mask": mask}`.
    - `copy`: with False, observations, rewards and flags are the arrays that the threads write to, without a copy; they change
      with the next step.
    - `curriculum`: what chooses the tasks: the name of one that comes with the package (`uniform`, `manual`, `learnability`,
      `replay`), or a file. Without it, each environment draws by its own seed. `curriculum_seed` is the seed that it draws by, and
      `env.curriculum` tells what it has come to. It is told how episodes end in the order of the environments, when they are
      received: with `step` it chooses the same tasks again, with `send` and `recv` in batches it may not.
    - `batch_size`: for `send` and `recv`, as EnvPool has them: `recv` returns as soon as so many environments are done.

    `reset(seed=s)` gives environment k the seed s + k. `options={"task": …}` sets the task of all, or of each by a list; likewise
    `"run_seed"`.

    Threads don't survive a fork: make the environment in the process that uses it.
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
        render_mode: str | None = None,
        camera: str = "chase",
        render_size: tuple[int, int] = (640, 480),
        **options: Any,
    ) -> None:
        try:
            mode = AutoresetMode[autoreset_mode.upper()] if isinstance(autoreset_mode, str) else AutoresetMode(autoreset_mode)
        except (KeyError, ValueError):
            names = ", ".join(m.name for m in AutoresetMode)
            raise OptionError(f"autoreset_mode: {autoreset_mode!r} must be one of {names}") from None
        num_envs, threads = _count("num_envs", num_envs), _count("threads", threads or processors())
        batch_size = num_envs if batch_size is None else _count("batch_size", batch_size)
        if batch_size > num_envs:
            raise OptionError(f"batch_size: {batch_size} must lie in 1 to num_envs, which is {num_envs}")
        self._camera = Camera(render_mode, camera, render_size)
        self._setup = Setup(*arguments, **options)
        self.num_envs, self.batch_size = num_envs, batch_size
        self.render_mode = render_mode
        self.single_observation_space = self._setup.observation_space
        self.single_action_space = self._setup.action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        fps = round(1.0 / self._setup.arena.control_period)
        # As gymnasium's own have it; TorchRL looks for it.
        self.autoreset_mode = mode
        self.metadata = {**self.metadata, "render_fps": fps, "autoreset_mode": mode}
        self._mode, self._copy = mode, copy
        self._all = np.arange(num_envs, dtype=np.int64)
        self._env: _native.VectorEnv | None = _native.VectorEnv(
            self._setup.arena, num_envs, threads, mode.name.lower(), self._setup.flat
        )
        self._arrays = self._env.arrays()
        #: The curriculum that chooses the tasks; None without one.
        self.curriculum: Curriculum | None = None
        if curriculum is not None:
            self._env.follow(os.fspath(curriculum), seed_of(curriculum_seed))  # type: ignore[arg-type]
            self.curriculum = Curriculum(self)
        self._is_seeded = False

    # One call for all.

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begins episodes in all environments, or in those of `options["reset_mask"]`; gives the observations of all."""
        env = self._native()
        if env.pending():
            raise EpisodeError(f"{env.pending()} environments are still at work: call recv first")
        which = self._begin(env, seed, options)
        infos = self._receive(env, len(which))[1]
        return self._observations(None), infos

    def step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Steps all environments: `actions` has a row for each. Gives observations, rewards (float64), terminated, truncated
        (bool), and infos: `reward_terms` by name, and where an episode ended `outcome`, `is_success`, `record`."""
        env = self._native()
        env.send(self._all, self._rows(actions, self.num_envs))
        infos = self._receive(env, self.num_envs)[1]
        return (self._observations(None), *self._numbers(None), infos)

    # As EnvPool has it: without waiting for all.

    def async_reset(
        self, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> None:
        """Begins episodes without waiting for them; `recv` gives the first observations."""
        self._begin(self._native(), seed, options)

    def send(self, actions: Any, env_id: Any = None) -> None:
        """Steps the environments with the indices `env_id` (all by default) without waiting: `actions` has a row for each."""
        ids = self._all if env_id is None else np.atleast_1d(np.asarray(env_id, dtype=np.int64))
        if len(np.unique(ids)) != len(ids):
            raise OptionError("send: env_id names an environment twice")
        self._native().send(ids, self._rows(actions, len(ids)))

    def recv(self) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Waits until `batch_size` environments are done. Rows are in the order of `infos["env_id"]`, which is the order in which
        they came and so not reproducible; what each did is."""
        ids, infos = self._receive(self._native(), self.batch_size)
        picked = {name: _pick(value, ids) for name, value in infos.items()}
        picked["env_id"] = ids
        return (self._observations(ids), *self._numbers(ids), picked)

    # What they share.

    def _begin(self, env: _native.VectorEnv, seed: Any, options: dict[str, Any] | None) -> np.ndarray:
        options = dict(options or {})
        mask = options.pop("reset_mask", None)
        tasks, run_seeds = self._each("task", options.pop("task", None)), self._each("run_seed", options.pop("run_seed", None))
        if options:
            raise OptionError(
                f"reset: options has {', '.join(map(repr, options))}; there are 'reset_mask', 'task' and 'run_seed'"
            )
        if mask is None:
            which = self._all
        else:
            mask = np.asarray(mask)
            if mask.shape != (self.num_envs,) or mask.dtype != np.bool_ or not mask.any():
                raise OptionError(f"reset_mask: it must be {self.num_envs} booleans of which one is True")
            which = self._all[mask]
        if isinstance(seed, Sequence):
            seeds = self._each("seed", seed)
        else:
            first = seed_of(seed)
            if first is None and not self._is_seeded:
                first = int(np.random.default_rng().integers(2**63))
            seeds = [None if first is None else (first + k) % 2**63 for k in range(self.num_envs)]
        resets = [(int(k), seed_of(seeds[k]), tasks[k], seed_of(run_seeds[k])) for k in which]
        try:
            env.reset(resets)
        except TypeError as e:
            raise OptionError(f"reset: an option is of the wrong kind: {e}") from None
        self._is_seeded = True
        return which

    def _each(self, name: str, value: Any) -> Sequence[Any]:
        if value is None or isinstance(value, (str, int, np.integer)):
            return [value] * self.num_envs
        if len(value) != self.num_envs:
            raise OptionError(f"{name}: there must be {self.num_envs}, one for each environment, not {len(value)}")
        return list(value)

    def _rows(self, actions: Any, count: int) -> np.ndarray:
        width = len(self._setup.action_names)
        try:
            rows = np.ascontiguousarray(actions, dtype=np.float64)
        except (TypeError, ValueError):
            raise ActionError(f"actions must be numbers of the shape ({count}, {width})") from None
        if rows.shape != (count, width):
            names = ", ".join(self._setup.action_names)
            raise ActionError(f"actions have the shape ({count}, {width}) ({names} for each), not {rows.shape}")
        return rows

    def _receive(self, env: _native.VectorEnv, count: int) -> tuple[np.ndarray, dict[str, Any]]:
        arrivals = env.receive(count)
        infos: dict[str, Any] = {"reward_terms": self._terms()}
        for index, start, record in arrivals:
            told = {} if record is None else ended(record)
            if told and self._mode == AutoresetMode.SAME_STEP:
                told = {"final_info": told, "final_obs": self._row(self._arrays["finals"], index)}
            if start is not None:
                told.update(began(*start))
            for name, value in told.items():
                self._note(infos, name, value, index)
        return np.array([index for index, _, _ in arrivals], dtype=np.int64), infos

    def _note(self, infos: dict[str, Any], name: str, value: Any, index: int) -> None:
        """Puts a value of one environment into infos, as gymnasium has them: an array with a mask beside it."""
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
        table = self._arrays["terms"].copy()
        return {name: table[:, k] for k, name in enumerate(TERMS)}

    def _row(self, arrays: list[np.ndarray], index: int) -> Any:
        return self._setup.collect([array[index].copy() for array in arrays])

    def _observations(self, ids: np.ndarray | None) -> Any:
        arrays = self._arrays["observations"]
        if ids is not None:
            return self._setup.collect([array[ids] for array in arrays])
        return self._setup.collect([array.copy() for array in arrays] if self._copy else arrays)

    def _numbers(self, ids: np.ndarray | None) -> list[np.ndarray]:
        arrays = [self._arrays[name] for name in ("rewards", "terminated", "truncated")]
        if ids is not None:
            return [array[ids] for array in arrays]
        return [array.copy() for array in arrays] if self._copy else arrays

    @property
    def tasks(self) -> list[str]:
        """The names of the tasks, in the suite's order."""
        return self._setup.arena.tasks()

    def state(self, index: int) -> State:
        """One of the environments as it is now, which a `NavigationEnv` with the same options can go on with."""
        return State(self._native().snapshot(index))

    def render(self) -> tuple[np.ndarray, ...] | None:
        """A picture of each environment; None without a render mode."""
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
        """Ends the threads. Arrays that were given without a copy stay as they are."""
        self._env = None
        self._arrays = {}

    def _native(self) -> _native.VectorEnv:
        if self._env is None:
            raise EpisodeError("the environment is closed: make a new one")
        return self._env


class Curriculum:
    """What chooses the tasks of a vector environment."""

    def __init__(self, env: NavigationVectorEnv) -> None:
        self._vector = env

    def chances(self) -> dict[str, float]:
        """The chance of each task to be the next, in the mean over the environments."""
        return dict(zip(self._vector.tasks, self._told()[0]))

    def stages(self) -> list[int]:
        """Of each environment, the stage that it is at; empty where there are no stages."""
        return self._told()[1]

    def score(self, task: str, score: float) -> None:
        """Takes in what a learner thinks of a task, by which `replay` chooses: the mean size of what returns differed by from the
        values that it expected."""
        self._vector._native().score(task, score)

    def state(self) -> str:
        """All that it remembers, as text."""
        return self._vector._native().curriculum_state() or ""

    def restore(self, state: str) -> None:
        """Goes on from what one like it remembered, and chooses the next tasks anew. Training that is to be continued exactly does
        `restore(state())` where it keeps the state."""
        self._vector._native().restore_curriculum(state)

    def _told(self) -> tuple[list[float], list[int]]:
        return self._vector._native().curriculum() or ([], [])


def _pick(value: Any, ids: np.ndarray) -> Any:
    if isinstance(value, dict):
        return {name: _pick(one, ids) for name, one in value.items()}
    return value[ids]


def processors() -> int:
    """How many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _count(name: str, value: Any) -> int:
    try:
        count = int(value)
        if count != value or count < 1:
            raise ValueError
    except (TypeError, ValueError):
        raise OptionError(f"{name}: {value!r} must be a whole number of 1 at least") from None
    return count
