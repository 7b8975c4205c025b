"""Training runs: start, continuation and evaluation."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, TextIO

from ..envs._vector import processors
from . import _libraries as _libraries
from ._algorithms import make_method
from ._config import Config, TrainingError, checked, read_config
from ._learn import MODEL, Learner, last_checkpoint, read_parameters, read_state, success
from ._method import Method
from ._network import Rows

#: File with the progress of training, one JSON object per line.
PROGRESS = "progress.jsonl"


def train(
    planner: str,
    folder: Path,
    seed: int,
    config_name: str,
    changes: dict[str, str],
    until: int | None,
    threads: int | None,
    demonstrations: Path | None,
    out: TextIO,
) -> None:
    """Trains a planner in a folder, or continues from the folder's last checkpoint.

    The result is the same, byte for byte, with interruptions and with any number of threads.

    Args:
        planner: Planner of the configuration: `rl`, `mcl` or `acl` by default.
        folder: Folder of the run, created if it doesn't exist.
        seed: Random seed.
        config_name: Name of a file in `tasks/training`, or a file.
        changes: Fields to replace, as in `read_config`.
        until: Number of environment steps at which to stop, rounded up to a checkpoint. None: the configuration's
            `steps`, which is also the maximum.
        threads: Threads that step environments. None: the number of processors.
        demonstrations: Dataset of `vertibench dataset drive` from which a new run clones the policy first. None: no
            warm start.
        out: Stream for progress lines.

    Raises:
        TrainingError: If the configuration is invalid, has no such planner, or differs from that of the run in the
            folder; or if a checkpoint is damaged or the demonstrations are unsuitable.
        DatasetError: If the demonstrations can't be read.
        OptionError: If the environments can't be created.
    """
    config = read_config(config_name, changes)
    checkpoint = last_checkpoint(folder)
    if checkpoint is not None:
        _same(folder, read_state(checkpoint), planner, seed, config)
    folder.mkdir(parents=True, exist_ok=True)
    print(f"{planner}, seed {seed}: generating worlds", file=out, flush=True)
    learner = Learner(folder, config, planner, seed, processors() if threads is None else threads)
    try:
        if checkpoint is not None:
            learner.resume(checkpoint)
            print(f"continuing from {checkpoint.name}", file=out, flush=True)
        elif demonstrations is not None:
            print(f"cloned: {json.dumps(learner.clone(demonstrations))}", file=out, flush=True)
            learner.save()
        _forget(folder / PROGRESS, learner.steps)
        with (folder / PROGRESS).open("a", encoding="utf-8") as log:

            def told(line: dict[str, Any]) -> None:
                print(json.dumps(line), file=log, flush=True)
                print(_short(line), file=out, flush=True)

            learner.learn(config["steps"] if until is None else min(until, config["steps"]), told)
    finally:
        learner.close()


def _same(folder: Path, state: dict[str, Any], planner: str, seed: int, config: Config) -> None:
    own = {"planner": planner, "seed": seed, "config": config.values}
    for key, value in own.items():
        if state[key] != value:
            told = "another configuration" if key == "config" else f"{key} {state[key]}"
            raise TrainingError(folder, f"the folder contains a run with {told}", "give another folder with --out, or the settings of that run")


def _forget(log: Path, steps: int) -> None:
    """Removes progress lines after the checkpoint from which training continues."""
    if log.exists():
        lines = log.read_text(encoding="utf-8").splitlines(keepends=True)
        log.write_text("".join(line for line in lines if line.endswith("\n") and json.loads(line)["steps"] <= steps), encoding="utf-8")


def _short(line: dict[str, Any]) -> str:
    if "held_out" in line:
        told = ", ".join(f"{name} {value}" for name, value in line["held_out"].items())
        return f"{line['steps']:>12,} steps: held-out worlds: {told}"
    episodes = max(line["episodes"], 1)
    told = ", ".join(f"{name} {100 * n / episodes:.0f} %" for name, n in line["outcomes"].items())
    stage = f", stage {line['stage']:.2f}" if "stage" in line else ""
    return f"{line['steps']:>12,} steps: {line['episodes']} episodes: {told}{stage}"


def checkpoint_of(folder: Path) -> Path:
    """Returns the folder itself if it is a checkpoint, otherwise the last checkpoint of the run in it."""
    if (folder / MODEL).exists():
        return folder
    checkpoint = last_checkpoint(folder)
    if checkpoint is None:
        raise TrainingError(folder, "no checkpoint", "give the folder of a run that `train` has written")
    return checkpoint


def load(folder: Path) -> tuple[Method, Config, dict[str, Any]]:
    """Returns the policy of a checkpoint, its configuration, and its state."""
    from ..envs.sb3 import make_vec

    checkpoint = checkpoint_of(folder)
    state = read_state(checkpoint)
    config = checked(checkpoint, state["config"])
    envs = make_vec(config["environments"], **config.held_out())
    method = make_method(config, Rows(envs), envs.vector._setup.parts, 0)
    envs.close()
    read_parameters(method.model, checkpoint)
    return method, config, state


def evaluate(folder: Path, suite: str | None, tasks: str | None) -> dict[str, float]:
    """Measures the success of a checkpoint's policy, without exploration noise.

    Each task is run once, with the benchmark's rules and time step.

    Args:
        folder: Folder of a run, for its last checkpoint, or of a checkpoint.
        suite: Suite directory, or name of a shipped suite. None: the held-out worlds of the configuration.
        tasks: Task selector. None: the configuration's held-out tasks, or all tasks of `suite`.

    Returns:
        Number of `tasks`, and the percentage of each outcome, 0 to 100.

    Raises:
        TrainingError: If there is no readable checkpoint.
        OptionError: If the suite or a task doesn't exist.
    """
    method, config, _ = load(folder)
    options = config.held_out()
    if suite is not None:
        options = {name: value for name, value in options.items() if name not in ("worlds", "world_seed", "tasks")}
        options["suite"] = suite
    if tasks is not None:
        options["tasks"] = tasks
    return success(method.model, options, config["environments"])
