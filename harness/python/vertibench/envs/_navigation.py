"""One environment."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np

from .. import _native
from .._errors import ActionError, EpisodeError, OptionError
from .._options import seed as seed_of
from ._common import TERMS, Remade, began, ended, options_of, real_numbers, setup_of, task_of
from ._render import Camera


class State:
    """An environment as it was at some time: `NavigationEnv.state` gives it, `NavigationEnv.set_state` takes it back.

    Immutable. Pickled, it holds the task, its seed and all actions (a few kB); `set_state` then replays them, at the speed of the
    simulation, and has the same state bit for bit."""

    __slots__ = ("_bytes", "_snapshot")

    def __init__(self, snapshot: _native.Snapshot) -> None:
        self._snapshot: _native.Snapshot | None = snapshot
        self._bytes = b""

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickled, (self._bytes if self._snapshot is None else self._snapshot.to_bytes(),)

    def __copy__(self) -> State:
        return self

    def __deepcopy__(self, memo: Any) -> State:
        return self


def _unpickled(how: bytes) -> State:
    """A State from serialized bytes, which `set_state` checks."""
    if not isinstance(how, bytes):
        raise OptionError(f"a pickled State holds bytes, not {type(how).__name__}")
    state = State.__new__(State)
    state._snapshot, state._bytes = None, how
    return state


class NavigationEnv(Remade, gymnasium.Env[Any, np.ndarray]):
    """Drives a vehicle over rough ground to a goal: `gymnasium.make("VertiBench/Navigation-v0", …)`.

    Tasks: `suite` is a directory or a name such as `"vb-100"`, `tasks` a selector (`"w001-w004,elevation=high"`) or a list of
    names. Without a suite the tasks are those of `worlds` training worlds of `world_seed` (7000 to 7999), which no suite has;
    that is checked against all suites that come with the package and those of `apart_from`. They are made once, about a second
    each, and kept.

    `vehicle`, `perception`, `soils`, `rules`: names of what comes with the package, or files. `scale` multiplies the worlds
    (by default as the vehicle is made for).

    Observations: `observation` names the parts (`describe_parts()` tells all; their shapes and bounds are in
    `observation_space`), of which a dictionary is made, or with `flat=True` one vector of those that are no labels, each number
    divided by its usual size. `observation="flat"` is the flat one of the default parts. `sight` sets what is seen:
    `cells`, `resolution` (m), `ahead` (m) of crops, `points` and `spacing` (m) of the path.

    Actions: `action="speed"` is steering and speed in [-1, 1], where the speed stands for `speed_range` in m/s, negative in
    reverse; `action="rate"` is the same with the change of the steering, as a part of 0.2, in the place of the steering;
    `action="pedals"` is steering in [-1, 1], throttle and brake in [0, 1], and the gear in [-1, 1] (below -1/3
    reverse, above 1/3 forward, else neutral). An action holds for 1/`control_hz` seconds.

    Rewards: `reward` names one that comes with the package (`"default"`, `"sparse"`), a file, or gives weights by the terms
    of `describe_rewards()`. What each term was worth is in `info["reward_terms"]`.

    Episodes end by the rules of the benchmark: success, rollover, stuck and out of bounds terminate, the limit of time
    truncates. `info` then has `outcome`, `is_success`, and `record`, which is the one that the benchmark writes for a planner
    that drives alike.

    `reset(seed=…)` makes all that follows reproducible to the last bit. `reset(options={"task": "w001/t03"})` chooses the task,
    `"run_seed"` the noise of the sensors, as `vb-harness run --seed` does.

    `render_mode="rgb_array"` gives pictures of `render_size` (width, height) from the `camera` `"chase"` or `"top"`.

    An environment that is copied or pickled is made anew of its options: the copy was never reset. `state()` and `set_state` are for
    a search that goes back.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}

    def __init__(
        self,
        *arguments: Any,
        render_mode: str | None = None,
        camera: str = "chase",
        render_size: tuple[int, int] = (640, 480),
        **options: Any,
    ) -> None:
        self._made_of = (arguments, {"render_mode": render_mode, "camera": camera, "render_size": render_size, **options})
        self._camera = Camera(render_mode, camera, render_size)
        self._setup = setup_of(arguments, options, "NavigationEnv")
        self.observation_space = self._setup.observation_space
        self.action_space = self._setup.action_space
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": round(1.0 / self._setup.arena.control_period)}
        self._env: _native.Env | None = _native.Env(self._setup.arena, 0)
        self._is_seeded = False

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._remake(state, NavigationEnv.__init__)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begins an episode; gives its first observation, and `task` and `run_seed` of it.

        Raises `UnknownError` for a task that isn't one of the environment's, `OptionError` for other options that make no
        sense.
        """
        env = self._native()
        seed = seed_of("seed", seed)
        task, run_seed = options_of(options, "task", "run_seed")
        task, run_seed = task_of(task), seed_of("run_seed", run_seed)
        super().reset(seed=seed)
        if seed is None and not self._is_seeded:
            seed = int(self.np_random.integers(2**63))
        env.reset(seed, task, run_seed)
        self._is_seeded = True
        return self._observe(env), began(env.episode())

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Drives on with an action for 1/`control_hz` seconds, or until the episode ends.

        Raises `ActionError` for an action of the wrong shape or with what is no finite, real number, and `EpisodeError` without an
        episode; the episode stays as it was.
        """
        env = self._native()
        numbers = real_numbers(action)
        if numbers is None:
            raise ActionError(f"an action is {len(self._setup.action_names)} numbers, not {action!r}")
        if numbers.ndim != 1:
            names = ", ".join(self._setup.action_names)
            raise ActionError(f"an action has the shape ({len(self._setup.action_names)},) ({names}), not {numbers.shape}")
        reward, terms, terminated, truncated = env.step(numbers.tolist())
        info: dict[str, Any] = {"reward_terms": dict(zip(TERMS, terms))}
        if terminated or truncated:
            info.update(ended(env.record()))
        return self._observe(env), reward, terminated, truncated, info

    def _observe(self, env: _native.Env) -> Any:
        return self._setup.collect([env.observe_flat()] if self._setup.flat else env.observe())

    def state(self) -> State:
        """The environment as it is now, for a search that comes back to it, also in another process: it can be pickled."""
        env = self._native()
        env.check()
        return State(env.snapshot())

    def set_state(self, state: State) -> Any:
        """Goes back to a state of this environment, or of one that was made alike; gives the observation there. It goes on
        exactly as it did."""
        env = self._native()
        if not isinstance(state, State):
            raise OptionError(f"set_state: {type(state).__name__} is no State: give what state() gave")
        if state._snapshot is None:
            env.restore_from(state._bytes)
        else:
            env.restore(state._snapshot)
        self._is_seeded = True
        return self._observe(env)

    @property
    def tasks(self) -> list[str]:
        """The names of the tasks, in the suite's order."""
        return self._setup.arena.tasks()

    @property
    def task(self) -> dict[str, Any] | None:
        """The task of the episode: `name`, `start` (x, y in m, heading in rad), `goal` (x, y), `goal_radius`, `time_limit` (s),
        `path` (n x 2); None without an episode."""
        return self._native().task()

    @property
    def vehicle(self) -> dict[str, Any] | None:
        """The true state of the vehicle, for rewards and analysis, never for a policy: `time` (s), `position` (m), `attitude`
        (roll, pitch, yaw in rad), `velocity` and `angular_velocity` in body axes, `steering`, `engine_speed` (rad/s), `wheels`
        (n x 4: spin rad/s, travel m, load N, sinkage m); None without an episode."""
        return self._native().vehicle()

    @property
    def reward_weights(self) -> dict[str, float]:
        """The weights of the reward's terms."""
        return self._setup.arena.weights()

    def render(self) -> np.ndarray | None:  # type: ignore[override]
        """A picture of the episode as it is now, height x width x 3 of uint8; None without a render mode."""
        env = self._native()
        env.check()
        return self._camera.picture(env)

    def close(self) -> None:
        """Lets go of everything. Closing twice does no harm."""
        self._env = None

    def _native(self) -> _native.Env:
        if self._env is None:
            raise EpisodeError("the environment is closed: make a new one")
        return self._env
