"""Many environments at a time, stepped by threads of Rust."""

from __future__ import annotations

import contextlib
import math
import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from .. import _native
from .._errors import ActionError, EpisodeError, OptionError, UnknownError
from .._options import number, path, whole
from .._options import seed as seed_of
from ._common import TERMS, Remade, began, ended, options_of, real_numbers, setup_of, task_of
from ._limit import Limit
from ._navigation import NavigationEnv, State
from ._render import Camera

#: What can be asked of each environment: attributes and methods of one that change nothing.
_VIEWS = (
    "task", "vehicle", "tasks", "reward_weights", "state", "render", "render_mode", "metadata", "spec", "observation_space", "action_space",
)  # fmt: skip
#: So many training worlds of the default seed have tasks for all stages of the curriculum `manual`.
MANUAL_WORLDS = 36


class NavigationVectorEnv(Remade, VectorEnv[Any, Any, Any]):
    """Many environments of one kind, stepped in one call: `gymnasium.make_vec("VertiBench/Navigation-v0", num_envs=16, …)`.

    The options are those of `NavigationEnv`. Beside them:

    - `threads`: how many threads of Rust step the environments; by default as many as there are processors. Python's lock is
      free meanwhile. What an environment does depends on its own seed and actions, never on the threads.
    - `autoreset_mode`: `NEXT_STEP` (the default) begins the next episode with the step after the last one, whose action isn't
      used; `SAME_STEP` at once, with the last observation in `infos["final_obs"]`; `DISABLED` when `reset` is called with
      `options={"reset_mask": mask}`.
    - `copy`: with False, observations, rewards and flags are the arrays that the threads write to, without a copy; they change
      with the next step, and keep the threads alive.
    - `curriculum`: what chooses the tasks: the name of one that comes with the package (`uniform`, `manual`, `learnability`,
      `replay`), or a file. Without it, each environment draws by its own seed. `curriculum_seed` is the seed that it draws by, and
      `env.curriculum` tells what it has come to. It is told how episodes end in the order of the environments, when they are
      received: with `step` it chooses the same tasks again, with `send` and `recv` in batches it may not. `manual` has stages that
      need tasks of every kind: of the default seed, 36 `worlds` have them.
    - `batch_size`: for `send` and `recv`, as EnvPool has them: `recv` returns as soon as so many environments are done.
    - `max_episode_steps`: truncates each episode after so many steps, as gymnasium's `TimeLimit` does for one environment; such an
      end has no `outcome` and no `record`. Not with a curriculum, nor with SAME_STEP in batches.

    `reset(seed=s)` gives environment k the seed s + k. `options={"task": …}` sets the task of all, or of each by a list; likewise
    `"run_seed"`.

    Threads don't survive a fork: make the environment in the process that uses it. One that is copied or pickled is made anew of
    its options: the copy was never reset.
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
                raise OptionError(f"{e}: make more training worlds, e.g. worlds={MANUAL_WORLDS}") from None
            raise

    # One call for all.

    def reset(
        self, *, seed: int | Sequence[int | None] | np.ndarray | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begins episodes in all environments, or in those of `options["reset_mask"]`; gives the observations of all. What they are
        still at, after `send` or Ctrl-C, is waited for and dropped; only a `reset_mask` is refused then."""
        env = self._native()
        which = self._begin(env, seed, options, is_dropped=True)
        infos = self._receive(env, len(which))[1]
        return self._observations(None), infos

    def step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Steps all environments: `actions` has a row for each. Gives observations, rewards (float64), terminated, truncated
        (bool), and infos: `reward_terms` by name, and where an episode ended `outcome`, `is_success`, `record`."""
        env = self._native()
        rows = self._rows(actions, self.num_envs)
        if env.pending():
            raise EpisodeError(f"{env.pending()} environments are still at work: call recv until none is, or reset, which drops it")
        self._hand_out(env, self._all, rows)
        infos = self._receive(env, self.num_envs)[1]
        return (self._observations(None), *self._numbers(None), infos)

    # As EnvPool has it: without waiting for all.

    def async_reset(
        self, seed: int | Sequence[int | None] | np.ndarray | None = None, options: dict[str, Any] | None = None
    ) -> None:
        """Begins episodes without waiting for them; `recv` gives the first observations."""
        self._begin(self._native(), seed, options, is_dropped=False)

    def send(self, actions: Any, env_id: Any = None) -> None:
        """Steps the environments with the indices `env_id` (all by default) without waiting: `actions` has a row for each."""
        ids = self._all if env_id is None else self._indices("send: env_id", env_id)
        self._hand_out(self._native(), ids, self._rows(actions, len(ids)))

    def recv(self) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Waits until `batch_size` environments are done, or all that are at work where these are fewer. Rows are in the order of
        `infos["env_id"]`, which is the order in which they came and so not reproducible; what each did is."""
        env = self._native()
        ids, infos = self._receive(env, min(self.batch_size, env.pending() or 1))
        picked = {name: _pick(value, ids) for name, value in infos.items()}
        picked["env_id"] = ids
        return (self._observations(ids), *self._numbers(ids), picked)

    # What they share.

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
        """Waits for what is at work, unless the reset can't be done."""
        if not env.pending():
            return
        if mask is not None:
            raise EpisodeError(f"{env.pending()} environments are still at work: call recv until none is, or reset without reset_mask")
        known = set(self.tasks)
        for task in tasks:
            if task is not None and task not in known:
                # This is told before anything is dropped, in the words of the environment.
                _native.Env(self._setup.arena, 0).reset(None, task, None)
        while env.pending():
            env.receive(env.pending())

    def _each(self, name: str, value: Any, check: Any) -> list[Any]:
        """An option of a reset for each environment: the same for all, or each its own."""
        if _is_one(value):
            return [check(value)] * self.num_envs
        if len(value) != self.num_envs:
            raise OptionError(f"{name}: there must be {self.num_envs}, one for each environment, not {len(value)}")
        return [check(one) for one in value]

    def _indices(self, name: str, index: Any) -> np.ndarray:
        given = np.atleast_1d(_array(index))
        if given.ndim != 1 or (given.dtype.kind not in "iu" and given.size):
            raise OptionError(f"{name} must be made of whole numbers in one dimension, the indices of environments")
        beyond = [k for k in given.tolist() if not 0 <= k < self.num_envs]
        if beyond:
            raise UnknownError(f"there is no environment {beyond[0]}: there are {self.num_envs}, counted from 0")
        ids = given.astype(np.int64)
        if len(np.unique(ids)) != len(ids):
            raise OptionError(f"{name} names an environment twice")
        return ids

    def _rows(self, actions: Any, count: int) -> np.ndarray:
        width = len(self._setup.action_names)
        rows = real_numbers(actions)
        if rows is None:
            raise ActionError(f"actions must be numbers of the shape ({count}, {width})")
        if rows.shape != (count, width):
            names = ", ".join(self._setup.action_names)
            raise ActionError(f"actions have the shape ({count}, {width}) ({names} for each), not {rows.shape}")
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
        """The names of the tasks, in the suite's order."""
        return self._setup.arena.tasks()

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """What an attribute of `NavigationEnv` is in each environment: `task`, `vehicle`, `tasks`, `reward_weights`, or the spaces.

        Raises `UnknownError` for any other name."""
        return self.call(name)

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """What a method of `NavigationEnv` that changes nothing gives in each environment: `state` or `render`. An attribute is given
        as it is. What would change one environment alone, such as `step`, can't be called: step all, or use `send` with its index.

        Raises `UnknownError` for any other name."""
        if name not in _VIEWS:
            raise UnknownError(f"call: {name!r} can't be asked of environments: there are {', '.join(_VIEWS)}")
        env = self._native()
        one = NavigationEnv.__new__(NavigationEnv)
        one._setup, one._camera = self._setup, self._camera
        one.observation_space, one.action_space = self.single_observation_space, self.single_action_space
        one.render_mode, one.metadata, one.spec = self.render_mode, self.metadata, self.spec
        told = []
        for index in range(self.num_envs):
            snapshot, one._env = env.snapshot(index), _native.Env(self._setup.arena, 0)
            # Without an episode, as before the first reset, there is nothing to go back to.
            with contextlib.suppress(EpisodeError):
                one._env.restore(snapshot)
            value = getattr(one, name)
            told.append(value(*args, **kwargs) if callable(value) else value)
        return tuple(told)

    def set_attr(self, name: str, values: Any) -> None:
        """Raises `OptionError`: what an environment is like is said when it is made, and is the same in all."""
        raise OptionError(f"set_attr: {name!r} can't be set: make environments with other options")

    def state(self, index: int) -> State:
        """One of the environments as it is now, which a `NavigationEnv` with the same options can go on with."""
        env = self._native()
        (own,) = self._indices("state: index", [index])
        return State(env.snapshot(int(own)))

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
        """Lets go of everything. Arrays that were given without a copy stay as they are; the threads end when none of these is held any
        more, or at once with copies."""
        self._env = None
        self._arrays = {}

    def _held(self) -> dict[str, Any]:
        """The arrays that the threads write to."""
        arrays = self._arrays
        if not arrays:
            # Another thread may have closed it meanwhile.
            self._native()
        return arrays

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
        own = number("score", score)
        if not math.isfinite(own):
            raise OptionError(f"score: {own} must be a finite number")
        self._vector._native().score(task_of(task) or "", own)

    def state(self) -> str:
        """All that it remembers, as text."""
        return self._vector._native().curriculum_state() or ""

    def restore(self, state: str) -> None:
        """Goes on from what one like it remembered, and chooses the next tasks anew. Training that is to be continued exactly does
        `restore(state())` where it keeps the state."""
        if not isinstance(state, str):
            raise OptionError(f"restore: {type(state).__name__} is no state of a curriculum: give what state() gave")
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


def _array(given: Any) -> np.ndarray:
    """What was given as an array; one of no use if it is none, such as rows of several lengths."""
    try:
        return np.asarray(given)
    except (TypeError, ValueError):
        return np.array([None])


def _is_one(value: Any) -> bool:
    """Whether it is a value for all environments, rather than one for each."""
    if isinstance(value, np.ndarray):
        return value.ndim == 0
    return isinstance(value, (str, bytes)) or not isinstance(value, Sequence)
