"""Simulation of vehicle fleets on a GPU, for massively parallel reinforcement learning.

>>> import torch, vertibench.gpu
>>> fleet = vertibench.gpu.Fleet(16384, suite="training", tasks="w*/t00", vehicle="hmmwv")
>>> fleet.reset(torch.arange(16384) % len(fleet.tasks))
>>> states, controls = torch.from_dlpack(fleet.states), torch.from_dlpack(fleet.controls)
>>> controls[:] = policy(states)     # written on the GPU, where the fleet reads it
>>> fleet.advance(0.1)               # 0.1 s for all vehicles; `states` has the new states

The states are those of the simulator on a CPU, bit for bit. A fleet has no sensors, observations, rewards or rules;
`starts`, `goals` and `ground` are the inputs for rewards and maps. The arrays are the fleet's own GPU memory, and every
DLPack library uses them without a copy: torch, JAX (with `jax_enable_x64`), CuPy. Methods are synchronous: they first
wait for all GPU work of the process, and return when the GPU has finished.

The kernels for NVIDIA GPUs come with the package, or `cargo xtask kernel` compiles them in a checkout. They were tested
on the H100 and the H200; `Fleet.verify` checks another GPU.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _options
from ._errors import OptionError, missing_module
from ._program import KERNEL as KERNEL
from ._program import kernels_path, tasks_path

try:
    from . import _native as _native
except ImportError as e:
    raise missing_module("vertibench.gpu", e) from None

#: Columns of `Fleet.states`, as (name, unit): time, position, attitude quaternion, velocity and angular velocity in body axes
#: (x forward, y left, z up), roll, pitch, yaw, steering in [−1, 1] (positive to the left), gear (1, 0 or −1) and engine speed.
STATES: tuple[tuple[str, str], ...] = tuple(_native.fleet_states())
#: Columns of `Fleet.controls`: steering in [−1, 1], positive to the left; throttle and brake in [0, 1]; gear 1 (forward),
#: 0 (neutral) or −1 (reverse).
CONTROLS = ("steering", "throttle", "brake", "gear")
#: Meanings of the values of `Fleet.faults`, by index; 0 is "fine". A vehicle with another value stands still until its reset.
FAULTS: tuple[str, ...] = tuple(name for name, _ in sorted(_native.fleet_faults(), key=lambda fault: fault[1]))
#: Value in `Fleet.resets` of a vehicle that continues.
GO_ON = -1


class Fleet:
    """Vehicles of one type on a GPU, each in one of the tasks of a suite, that one call steps together.

    Initially no vehicle has a task: all stand still until `reset`. A fleet belongs to the process that created it and
    can't be used in a fork.

    Args:
        vehicles: Number of vehicles, 1 to 2**31 - 1.
        suite: Suite directory, or name of a shipped suite. Use a suite that was generated for training (`vb-harness
            suite generate --training`); worlds of the benchmark are not refused.
        tasks: Selector, e.g. `"w*/t00"`, or list of task names. None (default): all tasks of the suite.
        vehicle: Vehicle name or file; default `"hmmwv"`.
        time_step: Simulation time step, s: 0.0001 to 0.005, and a divisor of 0.01. Only the default 0.001 is the
            benchmark's; 0.005 is for training.
        kernel: Kernel file, or folder of kernel files for several GPUs. None (default): the variable `VB_KERNEL`,
            otherwise the kernels of the package or checkout.
        device: Index of the GPU, from 0; default 0.
        memory: GPU memory, bytes, that all vehicles share beyond 128 kB each, at least 0. It stores ruts in soft soil,
            up to 5 MB per vehicle and minute. None (default): the maximum need, up to half of the free memory.

    Attributes:
        vehicles: Number of vehicles.
        tasks: Names of the tasks. The index in this tuple is the number of a task.
        starts: Start of each task: x (m), y (m), heading (rad); float64, shape (tasks, 3), a NumPy array.
        goals: Goal of each task: x (m), y (m); float64, shape (tasks, 2), a NumPy array.
        worlds: Number of each task's world, for `ground`; int64, shape (tasks,), a NumPy array.
        time_step: Simulation time step, s.
        states: State of each vehicle after the last `advance`, with the columns `STATES`; float64, shape (vehicles,
            20), on the GPU.
        controls: Controls of each vehicle, with the columns `CONTROLS`, which hold until they are overwritten; float64,
            shape (vehicles, 4), on the GPU, initially 0. Values out of range are clipped.
        resets: Number of the task that each vehicle begins with the next `reset()`, or -1 to continue; int32, shape
            (vehicles,), on the GPU.
        faults: Fault of each vehicle, as index in `FAULTS`; int32, shape (vehicles,), on the GPU.

    Raises:
        OptionError: If an argument is invalid, or a suite, task or vehicle doesn't exist.
        GpuError: If there is no GPU for which there are kernels, its memory is insufficient, or the kernels were
            compiled from other sources than the package.
        MissingError: If there are no kernels, or no folder of tasks.
    """

    def __init__(
        self,
        vehicles: int,
        *,
        suite: str | os.PathLike[str],
        tasks: str | Sequence[str] | None = None,
        vehicle: str | os.PathLike[str] = "hmmwv",
        time_step: float = 0.001,
        kernel: str | os.PathLike[str] | None = None,
        device: int = 0,
        memory: int | None = None,
    ):
        vehicles = _options.whole("vehicles", vehicles, 1, 2**31 - 1)
        self._native = _native.Fleet(
            tasks_dir=tasks_path(),
            kernel=kernels_path() if kernel is None else Path(_options.path("kernel", kernel)),
            suite=Path(_options.path("suite", suite)),
            tasks=_options.selector(tasks),
            vehicle=_options.path("vehicle", vehicle),
            time_step=_options.number("time_step", time_step),
            vehicles=vehicles,
            device=_options.whole("device", device, 0, 2**31 - 1),
            spare_memory=None if memory is None else _options.whole("memory", memory, 0, 2**63 - 1),
        )
        self.vehicles = vehicles
        self.tasks: tuple[str, ...] = tuple(self._native.tasks())
        self.starts: NDArray[np.float64] = self._native.starts()
        self.goals: NDArray[np.float64] = self._native.goals()
        self.worlds: NDArray[np.int64] = np.asarray(self._native.worlds(), dtype=np.int64)
        self.time_step: float = self._native.time_step()
        states, controls, resets, faults = self._native.arrays()
        self.states: _native.Array = states
        self.controls: _native.Array = controls
        self.resets: _native.Array = resets
        self.faults: _native.Array = faults

    def reset(self, tasks: Sequence[int] | NDArray[Any] | Any = None) -> None:
        """Lets vehicles begin tasks.

        Args:
            tasks: Task number per vehicle, or -1 for vehicles that continue: a sequence of ints, or an integer array of
                shape (vehicles,) of any library. None (default): the numbers in `resets`, which are -1 afterwards.

        Raises:
            OptionError: If the argument has another shape or type, or a task doesn't exist.
            GpuError: If the GPU fails.
        """
        if tasks is not None:
            # Tensors of other libraries have `tolist`, also on the GPU.
            try:
                told = np.asarray(tasks.tolist() if hasattr(tasks, "tolist") else tasks)
            except ValueError:
                told = np.array(None)
            if told.ndim != 1 or told.dtype.kind not in "iu":
                raise OptionError(f"reset: tasks must be whole numbers, one per vehicle, not {told.dtype}{told.shape}")
            tasks = told.tolist()
        self._native.reset(tasks)

    def advance(self, seconds: float = 0.1) -> None:
        """Simulates all vehicles with their `controls` and updates `states` and `faults`.

        Args:
            seconds: Simulated time, s, a positive multiple of `time_step`; default 0.1.

        Raises:
            OptionError: If the time is not a positive multiple of the time step.
            GpuError: If the GPU fails, or vehicles need more memory than there is. The fleet is then lost.
        """
        steps = _options.number("advance", seconds) / self.time_step
        if not 0.5 <= steps <= 1e9 or abs(steps - round(steps)) > 1e-6:
            raise OptionError(f"advance: {seconds} s is not a whole number of steps of {self.time_step} s")
        self._native.advance(round(steps))

    def verify(self, vehicles: int = 64, seconds: float = 1.0) -> int:
        """Compares the states of the GPU with those of the CPU.

        The first vehicles begin the tasks in turn and are simulated with different controls, on both GPU and CPU.
        Afterwards all vehicles must be reset and their controls set again.

        Args:
            vehicles: Maximum number of vehicles to compare, at least 1; default 64.
            seconds: Simulated time, s, above 0 and up to 1e6; default 1.

        Returns:
            Number of compared vehicles.

        Raises:
            GpuError: If a state differs, or the GPU fails.
            OptionError: If an argument is invalid.
        """
        vehicles, seconds = _options.whole("verify: vehicles", vehicles), _options.number("verify: seconds", seconds)
        if not 0.0 < seconds <= 1e6:
            raise OptionError(f"verify: {seconds} s must be above 0")
        return self._native.verify(vehicles, seconds)

    def hashes(self) -> NDArray[np.uint64]:
        """Returns the hash of each vehicle's states since its start, taken every 10 ms, as in the records of runs.

        Returns:
            Hashes of shape (vehicles,), uint64. Equal hashes mean equal trajectories, bit for bit.

        Raises:
            GpuError: If the GPU fails.
        """
        return np.asarray(self._native.hashes(), dtype=np.uint64)

    def ground(self, world: int) -> tuple[NDArray[np.float64], float]:
        """Returns the elevation map of a world.

        Args:
            world: Number of the world, as in `worlds`.

        Returns:
            Heights of the nodes, m, float64, shape (rows, columns), and the distance between nodes, m. Row 0 is in the
            south, column 0 in the west; the centre of the array is at x = y = 0.

        Raises:
            OptionError: If there is no such world.
        """
        found = self._native.ground(_options.whole("ground: world", world, 0, 2**31 - 1))
        if found is None:
            raise OptionError(f"ground: there is no world {world}; there are {int(self.worlds.max()) + 1}, counted from 0")
        return found
