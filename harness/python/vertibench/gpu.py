"""Fleets of vehicles on a GPU, for those who train policies there.

>>> import torch, vertibench.gpu
>>> fleet = vertibench.gpu.Fleet(16384, suite="training", tasks="w*/t00", vehicle="hmmwv")
>>> fleet.reset(torch.arange(16384) % len(fleet.tasks))
>>> states, controls = torch.from_dlpack(fleet.states), torch.from_dlpack(fleet.controls)
>>> controls[:] = policy(states)     # written on the GPU, where the fleet reads it
>>> fleet.advance(0.1)               # 0.1 s of all vehicles; `states` shows the new ones

The states are those of the simulator on a CPU, bit for bit. Rules, rewards and maps are the caller's matter: `starts`, `goals`
and `ground` have what these need. The arrays are the fleet's own memory on the GPU, and any library that knows DLPack can take
them: torch, JAX (with `jax_enable_x64`), CuPy. A method returns when the GPU has done it, and waits first for all that its
process does on the GPU, so nothing else has to be waited for.

The kernels for NVIDIA's GPUs come with the package, or are made by `cargo xtask kernel` in a checkout of Verti-Bench. They were
tried on the H100 and the H200; `Fleet.verify` tells whether another GPU computes the same.
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

#: The names of the columns of `Fleet.states`, each with its unit.
STATES: tuple[tuple[str, str], ...] = tuple(_native.fleet_states())
#: The columns of `Fleet.controls`: steering in [−1, 1], positive to the left, throttle and brake in [0, 1], and the gear, which
#: is 1 for forward, 0 for neutral and −1 for reverse.
CONTROLS = ("steering", "throttle", "brake", "gear")
#: What the numbers of `Fleet.faults` say: 0 is "fine". A vehicle with another one stands still until it is reset.
FAULTS: tuple[str, ...] = tuple(name for name, _ in sorted(_native.fleet_faults(), key=lambda fault: fault[1]))
#: In `Fleet.resets`: a vehicle goes on.
GO_ON = -1


class Fleet:
    """Vehicles of one kind on a GPU, each in one of the tasks of a suite, which are stepped together.

    `vehicles` is their number. `suite`, `tasks` and `vehicle` are names or files, and a selector, as for `vertibench.run`. A
    learner's suite is one that was made for training: nothing here keeps it from the worlds of a benchmark. `time_step` (s)
    is the benchmark's, 0.001; longer ones, up to 0.005, are for training, as in environments. `device` is the number of
    the GPU. `memory` (bytes) is for what vehicles need beyond 128 kB each, which is the ruts that they make in soft soil, up to
    5 MB in a minute; by default it is up to half of what is free. `kernel` is the file of the kernels, or the folder of those
    for several kinds of GPUs; by default it is what the variable `VB_KERNEL` names, or what came with the package. A fleet
    belongs to the process that made it: a fork has no part in it.

    Raises `OptionError` for options that make no sense, and `GpuError` without a GPU that the kernels are for, or too little
    memory.
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
        #: The number of vehicles.
        self.vehicles = vehicles
        #: The names of the tasks, whose numbers are their places here.
        self.tasks: tuple[str, ...] = tuple(self._native.tasks())
        #: Where the tasks start: x (m), y (m), yaw (rad), shape (tasks, 3).
        self.starts: NDArray[np.float64] = self._native.starts()
        #: Where their goals are: x (m), y (m), shape (tasks, 2).
        self.goals: NDArray[np.float64] = self._native.goals()
        #: The number of each task's world, shape (tasks,).
        self.worlds: NDArray[np.int64] = np.asarray(self._native.worlds(), dtype=np.int64)
        #: The simulator's time step, s.
        self.time_step: float = self._native.time_step()
        states, controls, resets, faults = self._native.arrays()
        #: The numbers of `STATES` of each vehicle when the fleet was last advanced, float64, shape (vehicles, 20).
        self.states: _native.Array = states
        #: What each vehicle is told, until it is told something else: `CONTROLS`, float64, shape (vehicles, 4). Zero at first.
        self.controls: _native.Array = controls
        #: The number of the task that each vehicle begins with the next `reset()`, or −1 to go on, int32, shape (vehicles,).
        self.resets: _native.Array = resets
        #: What is wrong with each vehicle, by its number in `FAULTS`, int32, shape (vehicles,).
        self.faults: _native.Array = faults

    def reset(self, tasks: Sequence[int] | NDArray[Any] | Any = None) -> None:
        """Lets vehicles begin tasks: a number of a task for each vehicle, or −1 for one that goes on.

        Without numbers they are taken from `resets` on the GPU, which are −1 from then on.
        """
        if tasks is not None:
            # Tensors of other libraries, also those on the GPU, have `tolist`.
            try:
                told = np.asarray(tasks.tolist() if hasattr(tasks, "tolist") else tasks)
            except ValueError:
                told = np.array(None)
            if told.ndim != 1 or told.dtype.kind not in "iu":
                raise OptionError(f"reset: tasks must be whole numbers, one for each vehicle, not {told.dtype}{told.shape}")
            tasks = told.tolist()
        self._native.reset(tasks)

    def advance(self, seconds: float = 0.1) -> None:
        """Drives all vehicles on for this time (s), a whole number of time steps, with the controls that they were told."""
        steps = _options.number("advance", seconds) / self.time_step
        if not 0.5 <= steps <= 1e9 or abs(steps - round(steps)) > 1e-6:
            raise OptionError(f"advance: {seconds} s is no whole number of steps of {self.time_step} s")
        self._native.advance(round(steps))

    def verify(self, vehicles: int = 64, seconds: float = 1.0) -> int:
        """Sees whether the GPU computes what a CPU does; returns how many vehicles were compared.

        The first vehicles begin the tasks in turn and drive for this time (s), each with other controls, here and on the CPU. All
        vehicles have to be reset after it, and told their controls again. Raises `GpuError` if states differ.
        """
        vehicles, seconds = _options.whole("verify: vehicles", vehicles), _options.number("verify: seconds", seconds)
        if not 0.0 < seconds <= 1e6:
            raise OptionError(f"verify: {seconds} s is nothing to compare")
        return self._native.verify(vehicles, seconds)

    def hashes(self) -> NDArray[np.uint64]:
        """Of each vehicle the hash of all its states since its start, every 10 ms, as records of runs have it."""
        return np.asarray(self._native.hashes(), dtype=np.uint64)

    def ground(self, world: int) -> tuple[NDArray[np.float64], float]:
        """The heights (m) of a world's nodes, and the distance (m) between nodes.

        The first row is in the south, the first column in the west, and the middle of the array at x = y = 0.
        """
        found = self._native.ground(_options.whole("ground: world", world, 0, 2**31 - 1))
        if found is None:
            raise OptionError(f"ground: there is no world {world}; there are {int(self.worlds.max()) + 1}, counted from 0")
        return found
