"""Verti-Bench in Rust, for Python: a simulation benchmark for off-road navigation.

>>> import vertibench
>>> run = vertibench.run("pid.wasm", suite="smoke", tasks="w*/t00")   # runs a planner with vb-harness
>>> run.results()                                                    # data frame with one row per task
>>> run.summary().success_rate                                       # with its 95 % interval
>>> run.show("w003/t00")                                             # map, trajectory and replay, in a notebook
>>> vertibench.compare(run, "runs/pid-1")                            # paired differences with intervals

Submodules:

- `vertibench.envs`: environments for reinforcement learning
- `vertibench.training`: training of policies in these environments
- `vertibench.datasets`: reader for datasets
- `vertibench.scale`: runs on many machines
- `vertibench.gpu`: simulation of vehicle fleets on a GPU

All errors are `VertibenchError`s. Their message is one line: place, problem and, in brackets, the next step. Modules and
names are imported at their first use. Results as pandas or polars data frames need these packages.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .registration import register_when_imported

__version__ = "1.0.0rc1"

if TYPE_CHECKING:
    from . import datasets as datasets
    from . import envs as envs
    from . import gpu as gpu
    from . import scale as scale
    from . import training as training
    from ._errors import ActionError as ActionError
    from ._errors import EnvError as EnvError
    from ._errors import EpisodeError as EpisodeError
    from ._errors import GpuError as GpuError
    from ._errors import MissingError as MissingError
    from ._errors import MissingPackageError as MissingPackageError
    from ._errors import OptionError as OptionError
    from ._errors import PanicError as PanicError
    from ._errors import UnknownError as UnknownError
    from ._errors import VertibenchError as VertibenchError
    from ._program import harness_path as harness_path
    from ._program import plugin_path as plugin_path
    from ._program import plugins_path as plugins_path
    from ._program import tasks_path as tasks_path
    from ._runs.compare import Comparison as Comparison
    from ._runs.compare import compare as compare
    from ._runs.errors import FailedStartError as FailedStartError
    from ._runs.errors import HostError as HostError
    from ._runs.errors import InputError as InputError
    from ._runs.errors import InternalError as InternalError
    from ._runs.errors import OutputError as OutputError
    from ._runs.errors import ProgramError as ProgramError
    from ._runs.errors import RunError as RunError
    from ._runs.errors import StoppedError as StoppedError
    from ._runs.errors import UsageError as UsageError
    from ._runs.frames import Trace as Trace
    from ._runs.launch import Progress as Progress
    from ._runs.launch import run as run
    from ._runs.run import Run as Run
    from ._runs.run import results as results
    from ._runs.run import show as show
    from ._runs.run import summary as summary
    from ._runs.run import trace as trace
    from ._runs.show import Shown as Shown
    from ._runs.show import show_task as show_task
    from ._runs.summary import Estimate as Estimate
    from ._runs.summary import Summary as Summary

#: Module of each public name; it is imported when one of its names is first used (PEP 562).
_FROM = {
    "_errors": (
        "ActionError",
        "EnvError",
        "EpisodeError",
        "GpuError",
        "MissingError",
        "MissingPackageError",
        "OptionError",
        "PanicError",
        "UnknownError",
        "VertibenchError",
    ),
    "_program": ("harness_path", "plugin_path", "plugins_path", "tasks_path"),
    "_runs.compare": ("Comparison", "compare"),
    "_runs.errors": (
        "FailedStartError",
        "HostError",
        "InputError",
        "InternalError",
        "OutputError",
        "ProgramError",
        "RunError",
        "StoppedError",
        "UsageError",
    ),
    "_runs.frames": ("Trace",),
    "_runs.launch": ("Progress", "run"),
    "_runs.run": ("Run", "results", "show", "summary", "trace"),
    "_runs.show": ("Shown", "show_task"),
    "_runs.summary": ("Estimate", "Summary"),
}
_MODULES = {name: module for module, names in _FROM.items() for name in names}

#: Submodules, which are imported in the same way.
_PARTS = ("datasets", "envs", "gpu", "scale", "training")

__all__ = [*_PARTS, *sorted(_MODULES)]


def __getattr__(name: str) -> Any:
    if name in _PARTS:
        return importlib.import_module(f".{name}", __name__)
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f".{_MODULES[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


register_when_imported()
