"""The single environment, `NavigationEnv`."""

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
    """Saved state of an environment, for a search that returns to it.

    `NavigationEnv.state` returns a state and `NavigationEnv.set_state` restores it. A state is immutable; copies are
    the same object. It can be pickled (a few kB): the pickle contains the task, the seed and all actions. `set_state`
    of an unpickled state repeats the simulation and reaches the identical state, bit for bit.
    """

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
    """Returns a State from pickled bytes; `set_state` verifies them."""
    if not isinstance(how, bytes):
        raise OptionError(f"a pickled State holds bytes, not {type(how).__name__}")
    state = State.__new__(State)
    state._snapshot, state._bytes = None, how
    return state


class NavigationEnv(Remade, gymnasium.Env[Any, np.ndarray]):
    """Off-road navigation as a gymnasium environment: drive over rough terrain to a goal.

    Create it with `gymnasium.make("VertiBench/Navigation-v0", ...)` or directly. An episode is a trial of the
    benchmark, with the same rules, vehicle, perception and time step as `vb-harness run`. All arguments except `suite`
    and `tasks` must be given by name. Units are SI and angles radians; body axes are x forward, y left, z up.

    The benchmark's rules end an episode. The outcomes `success`, `rollover`, `stuck` and `out_of_bounds` terminate it;
    the time limit (`timeout`) and a failed simulation (`sim_error`) truncate it.

    `reset(seed=...)` determines the tasks and the sensor noise of all later episodes on every machine. Copying or
    pickling an environment creates a new environment with the same arguments, which was never reset; use `state()` and
    `set_state()` for a search.

    Example:
        >>> env = NavigationEnv("smoke", "w001-w003", observation="flat")
        >>> observation, info = env.reset(seed=0)
        >>> observation, reward, terminated, truncated, info = env.step([0.0, 1.0])

    Args:
        suite: Suite directory, or name of a shipped suite, e.g. `"vb-100"`. None (default): generated training worlds,
            which no suite contains.
        tasks: Selector, e.g. `"elevation=high,terrain=rigid"`, or list of task names. None (default): all tasks of the
            suite.
        worlds: Number of training worlds if `suite` is None, 1 to 1000; default 18. Worlds are generated once (about 1
            s each) and cached.
        world_seed: Seed of the training worlds, 7000 to 7999; default 7000.
        apart_from: Directory, or list of directories, of further suites that must contain no training world. Shipped
            suites are always compared.
        vehicle: Vehicle name or file; default `"hmmwv"`.
        perception: Name or file of the perception profile: `"oracle"` (default), `"onboard"` or `"degraded"`.
        soils: Name or file of the soil set: `"default"`, `"original"` or `"wong"`.
        rules: Name or file of the rules that end an episode; default `"paper"`.
        scale: Factor on all lengths of the worlds, 0.01 to 10. None (default): the scale that the vehicle is made for.
        control_hz: Actions per second of simulated time: 100 divided by a whole number from 1 to 100; default 10.
        time_step: Simulation time step, s: 0.0001 to 0.005, and a divisor of 0.01. Only the default 0.001 makes an
            episode a trial of the benchmark.
        observation: Name or names of the parts of an observation, which becomes a dictionary by part name
            (`describe_parts()`; shapes, dtypes and bounds are in `observation_space`). Default: `state`, `goal`,
            `path`, `command` and `height`. `"flat"` means `flat=True` with the default parts.
        flat: Whether an observation is one float32 vector of all parts without labels, in order. Each number is divided
            by its normalisation scale and clipped to [-5, 5]. Default False.
        sight: Observation window, a dictionary with any of these keys; lengths are those of the full-size world.
            `cells`: rows and columns of a crop, 2 to 256 (16). `resolution`: distance between its samples, m, 0.05 to
            10 (1.0). `ahead`: distance of its centre ahead of the vehicle, m, -50 to 50 (0.0). `points`: number of path
            points, 1 to 256 (10). `spacing`: distance between them, m, 0.1 to 50 (2.0).
        action: Kind of action. `"speed"` (default): steering and speed in [-1, 1]; a controller holds the speed.
            `"rate"`: the first number is the change of the steering command per step instead, as a fraction of 0.2.
            `"pedals"`: steering in [-1, 1], throttle and brake in [0, 1], and gear in [-1, 1]: reverse below -1/3,
            forward above 1/3, otherwise neutral. Steering is positive to the left.
        speed_range: Speeds that the speed actions -1 and 1 stand for, m/s of the full-size vehicle; the lower first,
            from -10 to 30, negative in reverse. Default (0.0, 6.0). Not used with `"pedals"`.
        reward: Name of a shipped reward (`"default"`, `"sparse"`), a YAML file, or a dictionary of weights by term
            (`describe_rewards()`); absent terms have the weight 0.
        render_mode: `"rgb_array"` lets `render()` return images. None (default): `render()` returns None.
        camera: Camera of `render()`: `"chase"` (default), from behind the vehicle, or `"top"`, from above.
        render_size: Width and height of an image, pixels, each 1 to 4096; default (640, 480).

    Raises:
        OptionError: If an argument is unknown or invalid, a name or file doesn't exist, or a training world occurs in
            another suite.
        MissingError: If the package's folder of tasks is missing.
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
        """Begins an episode.

        Args:
            seed: Seed of the choice of tasks and of the sensor noise for this and all later episodes, 0 to 2**63 - 1.
                None: continues the sequence of the last seed; the first reset without a seed chooses one at random.
            options: Dictionary with any of `"task"`, the name of the task, and `"run_seed"`, the seed of the sensor
                noise, 0 to 2**63 - 1 (`vb-harness run --seed`). Absent or None: sampled.

        Returns:
            The first observation, and an `info` dictionary with the `task` name and the `run_seed` of the episode.

        Raises:
            UnknownError: If the environment has no such task.
            OptionError: If another option is unknown or invalid.
            EpisodeError: If the simulation fails at the start of the task, or the environment is closed.
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
        """Simulates 1/`control_hz` seconds with one action, or less if the episode ends.

        Args:
            action: Array of shape (2,), or (4,) with `action="pedals"`, as in `action_space`. Numbers outside their
                range are clipped and counted in the record.

        Returns:
            Observation, reward (float), whether the episode has terminated, whether it was truncated, and `info`.
            `info["reward_terms"]` has the value of each reward term. After the last step `info` also has `outcome`,
            `is_success`, and `record`: the dictionary that the benchmark writes for a planner with the same commands.

        Raises:
            ActionError: If the action has the wrong shape, or a number in it is not real and finite. The episode is
                unchanged.
            EpisodeError: If there is no episode, it has ended, or the environment is closed.
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
        """Saves the whole simulation.

        Returns:
            The state, which this environment, one with the same arguments, or one in another process (by pickling) can
            restore.

        Raises:
            EpisodeError: If there is no episode, or the environment is closed.
        """
        env = self._native()
        env.check()
        return State(env.snapshot())

    def set_state(self, state: State) -> Any:
        """Restores a state; the simulation then continues exactly as it did from there.

        Args:
            state: State of this environment, or of one with the same arguments. A state that was pickled is restored by
                repeating its actions, at the speed of the simulation.

        Returns:
            The observation in this state.

        Raises:
            OptionError: If it is no `State`, is from an environment with other arguments or from another version, or
                the files of the suite have changed.
            EpisodeError: If the state contains no episode, or the environment is closed.
        """
        env = self._native()
        if not isinstance(state, State):
            raise OptionError(f"set_state: {type(state).__name__} is not a State: give a result of state()")
        if state._snapshot is None:
            env.restore_from(state._bytes)
        else:
            env.restore(state._snapshot)
        self._is_seeded = True
        return self._observe(env)

    @property
    def tasks(self) -> list[str]:
        """Names of the tasks, in the order of the suite."""
        return self._setup.arena.tasks()

    @property
    def task(self) -> dict[str, Any] | None:
        """Task of the episode; None without an episode.

        A dictionary with `name`; `start` (x and y, m; heading, rad); `goal` (x and y, m); `goal_radius` (m);
        `time_limit` (s); and `path`, the global path as a float64 array of shape (n, 2), x and y in m. World axes are x
        east, y north.
        """
        return self._native().task()

    @property
    def vehicle(self) -> dict[str, Any] | None:
        """True state of the vehicle, for rewards and analysis, never for a policy; None without an episode.

        A dictionary with `time` (s); `position` (x, y, z in the world, m); `attitude` (roll, pitch, yaw, rad);
        `velocity` (m/s) and `angular_velocity` (rad/s) in body axes; `steering` in [-1, 1], positive to the left;
        `engine_speed` (rad/s); and `wheels`, of shape (wheels, 4): spin (rad/s), suspension travel (m), load (N) and
        sinkage (m), front to back, left before right.
        """
        return self._native().vehicle()

    @property
    def reward_weights(self) -> dict[str, float]:
        """Weights of the reward terms, by name."""
        return self._setup.arena.weights()

    def render(self) -> np.ndarray | None:  # type: ignore[override]
        """Renders the current state of the episode.

        Returns:
            Image of shape (height, width, 3), uint8; None without a render mode.

        Raises:
            EpisodeError: If there is no episode, or the environment is closed.
        """
        env = self._native()
        env.check()
        return self._camera.picture(env)

    def close(self) -> None:
        """Releases the simulation. Calling it again has no effect."""
        self._env = None

    def _native(self) -> _native.Env:
        if self._env is None:
            raise EpisodeError("the environment is closed: create a new one")
        return self._env
