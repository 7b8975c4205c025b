"""Card of a policy: its training, and its results in held-out worlds compared with a baseline."""

from __future__ import annotations

import hashlib
import json
import tempfile
from pathlib import Path
from typing import Any

from .. import Run, compare, run
from .._runs.compare import Figures, RunFigures
from ..envs import NavigationVectorEnv
from ._config import Config, TrainingError
from ._export import weights_of
from ._package import package
from ._run import PROGRESS, checkpoint_of, load

#: Baseline planner: follows the path with the policy's maximum speed.
BASELINE = "pid"


def card(policy: Path, out: Path, others: list[Path]) -> str:
    """Writes the card of a policy: its training, and its success in held-out worlds compared with PID and other policies.

    Runs the held-out tasks with each policy as a planner, and with PID at the policy's maximum speed. Also writes a
    text file next to the card, with the description of the weights for a planner's metadata.

    Args:
        policy: Folder of the run, or of a checkpoint.
        out: JSON file to write.
        others: Folders of other runs to compare, with different names.

    Returns:
        One line per policy with its success rate, and a line with the written files.

    Raises:
        TrainingError: If there is no readable checkpoint, or two folders have the same name.
        ProgramError: If a run of the planners fails.
    """
    names = ["policy", BASELINE, *(other.name for other in others)]
    for k, name in enumerate(names):
        if name in names[:k]:
            raise TrainingError(others[k - 2], f"the card has another run with the name {name}", "rename the folder of the run")
    with tempfile.TemporaryDirectory() as folder:
        made, config, driven = _drive(policy, names[0], Path(folder))
        others_driven = [_drive(other, name, Path(folder))[2] for other, name in zip(others, names[2:])]
        told = compare(driven, _baseline(config, Path(folder)), *others_driven)
    held_out = {name: _figures(figures) for name, figures in zip(names, told.runs)}
    differences = {}
    for pair in told.pairs:
        if pair.first == told.runs[0].label:
            # This policy minus the other one.
            d = pair.success_rate
            name = names[[r.label for r in told.runs].index(pair.second)]
            # Without an interval if there are too few worlds.
            interval = {} if d is None or d.low is None else {"low": _p(-d.high), "high": _p(-d.low)}
            differences[name] = None if d is None else {"points": _p(-d.mean), **interval, "p": d.p}
    text = json.dumps({**made, "held_out": held_out, "success_less_that_of": differences}, indent=1)
    out.write_text(text + "\n", encoding="utf-8")
    out.with_suffix(".txt").write_text(_model(out.stem, made, config), encoding="utf-8")
    lines = [f"{name}: {held_out[name]['all']['success']} %" for name in names]
    return "\n".join([*lines, f"{out} and {out.with_suffix('.txt')}"])


def _model(name: str, made: dict[str, Any], config: Config) -> str:
    """Returns the description of the weights for a planner's metadata (`vb_sdk::export_policy!`)."""
    worlds = f"{config['worlds.count']} training worlds of seed {config['worlds.seed']}"
    return f"{name}.vbnn sha256 {made['weights_sha256']}, learned in {made['steps']} steps with seed {made['seed']} in {worlds}"


def _drive(policy: Path, name: str, folder: Path) -> tuple[dict[str, Any], Config, Run]:
    """Runs the held-out tasks with a policy as a planner; returns its training, configuration and run."""
    method, config, state = load(policy)
    made_of = weights_of(method, config, state)
    content = bytes(made_of)
    checkpoint = checkpoint_of(policy)
    seconds = 0.0
    log = checkpoint.parent / PROGRESS
    told = [json.loads(line) for line in log.read_text(encoding="utf-8").splitlines()] if log.exists() else []
    for line, later in zip(told, [*told[1:], {"held_out": None}]):
        # Each interval between checkpoints counts its seconds from 0, and ends with a measurement of success.
        if "held_out" in later and "seconds" in line and line["steps"] <= state["steps"]:
            seconds += line["seconds"]
    made = {
        "planner": state["planner"],
        "seed": state["seed"],
        "steps": state["steps"],
        "updates": state["updates"],
        "seconds": round(seconds),
        "parameters": sum(layer.weights.size + layer.bias.size for layer in made_of.layers),
        "weights_sha256": hashlib.sha256(content).hexdigest(),
        "cloned": state["cloned"],
        "config": config.values,
    }
    weights, planner = folder / f"{name}.vbnn", folder / f"{name}.wasm"
    weights.write_bytes(content)
    package(weights, planner, _name(name), "Policy of a card")
    return made, config, run(planner, out=folder / name, progress=False, **_where(config))


def _baseline(config: Config, folder: Path) -> Run:
    params = {"speed": config["speed_range"][1]}
    return run(f"{BASELINE}.wasm", out=folder / BASELINE, params=params, progress=False, **_where(config))


def _where(config: Config) -> dict[str, Any]:
    envs = NavigationVectorEnv(1, **config.held_out())
    where = {"suite": envs._setup.arena.suite, "tasks": config["held_out.tasks"]}
    where |= {name: config[name] for name in ("vehicle", "perception")}
    envs.close()
    return where


def _name(text: str) -> str:
    return "".join(c if c.isalnum() and c.isascii() else "-" for c in text.lower())


def _figures(run: RunFigures) -> dict[str, Any]:
    splits = {split: {level: _shares(f) for level, f in levels.items()} for split, levels in run.splits.items()}
    return {"all": _shares(run.all), **splits}


def _shares(figures: Figures) -> dict[str, Any]:
    shares = {name: _p(n / figures.tasks) for name, n in sorted(figures.outcomes.items()) if n and name != "success"}
    own = figures.success_rate
    interval = {} if own is None or own.low is None else {"success_low": _p(own.low), "success_high": _p(own.high)}
    return {"tasks": figures.tasks, "success": _p(figures.outcomes.get("success", 0) / figures.tasks), **interval, **shares}


def _p(share: float) -> float:
    return round(100.0 * share, 1)
