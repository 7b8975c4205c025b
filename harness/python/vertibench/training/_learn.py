"""Learning in intervals between checkpoints.

All random numbers follow from the seed and the index of the interval, and each interval begins with new episodes.
Training that was interrupted therefore continues from its last checkpoint exactly as if it had not been interrupted.
"""

from __future__ import annotations

import json
import os
import pickle
import shutil
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.utils import set_random_seed

from ..envs import NavigationVectorEnv
from ..envs.sb3 import Sb3VecEnv, make_vec
from ._algorithms import make_method
from ._clone import clone
from ._config import Config, TrainingError
from ._method import Method
from ._network import Rows, rows

#: Files of a checkpoint.
MODEL, STATE = "model.pt", "state.json"
#: Folder that only the last checkpoint of a run has.
MEMORY = "memory"
#: Minimum number of steps between two progress lines.
TOLD = 8192


class Learner:
    """Training of a planner, with its folder: `progress.jsonl`, and a checkpoint after each interval.

    Args:
        folder: Folder of the run.
        config: Configuration.
        planner: Planner of the configuration, which determines the curriculum.
        seed: Random seed.
        threads: Threads that step environments.

    Attributes:
        cloned: Result of `clone`; None without a warm start.
        envs: Vector environment for training.
        method: Algorithm with the policy.

    Raises:
        TrainingError: If the configuration has no such planner, or the algorithm has no scores for its curriculum.
        OptionError: If the environments can't be created.
    """

    def __init__(self, folder: Path, config: Config, planner: str, seed: int, threads: int) -> None:
        self.folder, self.config, self.planner, self.seed = folder, config, planner, seed
        self.cloned: dict[str, Any] | None = None
        # One torch thread: the order of sums, and so the weights, must not depend on the number of processors.
        torch.set_num_threads(1)
        torch.use_deterministic_algorithms(True)
        curriculum = curriculum_of(config, planner)
        self.envs: Sb3VecEnv = make_vec(config["environments"], threads=threads, **config.environment(curriculum, seed))
        self.method: Method = make_method(config, Rows(self.envs), self.envs.vector._setup.parts, seed)
        self.model.lr_schedule = self._rate
        if self.method.surprise() is None and '"replay"' in self._curriculum_state():
            what = f"the curriculum {curriculum} needs scores of episodes, which {config['algorithm']} doesn't compute"
            raise TrainingError(planner, what, "set algorithm to ppo, or choose another curriculum")

    @property
    def model(self) -> BaseAlgorithm:
        """Model of stable-baselines3: policy, value networks and optimisers."""
        return self.method.model

    @property
    def steps(self) -> int:
        """Number of environment steps so far, summed over all environments."""
        return int(self.model.num_timesteps)

    def _rate(self, _: float) -> float:
        done = min(self.steps / self.config["steps"], 1.0)
        return float(self.config.own("learning_rate") * (1.0 - done * (1.0 - self.config["final_rate"])))

    def learn(self, steps: int, told: Callable[[dict[str, Any]], None]) -> None:
        """Trains up to a number of steps, with a checkpoint after each interval.

        Args:
            steps: Total number of environment steps; the last interval is completed.
            told: Function that receives each progress line as a dictionary.
        """
        while self.steps < steps:
            stretch = self.steps // self.config["checkpoint"]
            seed = int(np.random.SeedSequence([self.seed, stretch]).generate_state(1)[0])
            set_random_seed(seed)
            self.method.begin(seed)
            progress = Progress(self.method, self.envs, told, self._freeze)
            self.model.learn(self.config["checkpoint"], callback=progress, reset_num_timesteps=False)
            self.save()
            told({"steps": self.steps, "held_out": success(self.model, self.config.held_out(), self.envs.num_envs)})

    def clone(self, demonstrations: Path) -> dict[str, Any]:
        """Fits the policy to demonstrations before training.

        Args:
            demonstrations: Dataset of `vertibench dataset drive`; it must contain no held-out world.

        Returns:
            Result of the fit, see `_clone.clone`.

        Raises:
            TrainingError: If the dataset is unsuitable.
            OptionError: If the dataset contains a held-out world.
            DatasetError: If the dataset can't be read.
        """
        NavigationVectorEnv(1, apart_from=[demonstrations / "suite"], **self.config.held_out()).close()
        self.cloned = clone(self.method, self.config, demonstrations, self.seed)
        return self.cloned

    def _freeze(self) -> None:
        """Trains only the value networks for `clone.critic` steps after a warm start, because they are not fitted to the
        cloned policy.
        """
        self.method.freeze(self.cloned is not None and self.steps < self.config["clone.critic"])

    def save(self) -> None:
        """Writes a checkpoint atomically, and removes the replay memory from earlier checkpoints."""
        state = {
            "planner": self.planner,
            "seed": self.seed,
            "config": self.config.values,
            "cloned": self.cloned,
            "steps": self.steps,
            "updates": self.model._n_updates,  # type: ignore[attr-defined]
            "method": self.method.state(),
            "curriculum": self._curriculum_state(),
        }
        whole, half = self.folder / f"checkpoint-{self.steps:012d}", self.folder / ".checkpoint"
        shutil.rmtree(half, ignore_errors=True)
        (half / MEMORY).mkdir(parents=True)
        torch.save(self.model.get_parameters(), half / MODEL)
        (half / STATE).write_text(json.dumps(state, indent=1), encoding="utf-8")
        self.method.keep(half / MEMORY)
        shutil.rmtree(whole, ignore_errors=True)
        os.replace(half, whole)
        for earlier in self.folder.glob(f"checkpoint-*/{MEMORY}"):
            if earlier.parent != whole:
                shutil.rmtree(earlier)

    def _curriculum_state(self) -> str:
        curriculum = self.envs.vector.curriculum
        if curriculum is None:
            return ""
        state = curriculum.state()
        # As at a continuation from this checkpoint, so that both are equal.
        curriculum.restore(state)
        return state

    def resume(self, checkpoint: Path) -> None:
        """Continues from a checkpoint.

        Args:
            checkpoint: Folder of the checkpoint.

        Raises:
            TrainingError: If the checkpoint can't be read.
        """
        state = read_state(checkpoint)
        read_parameters(self.model, checkpoint)
        self.model.num_timesteps, self.model._n_updates = state["steps"], state["updates"]  # type: ignore[attr-defined]
        self.cloned = state["cloned"]
        self.method.restore(state["method"])
        self.method.fetch(checkpoint / MEMORY)
        if self.envs.vector.curriculum is not None:
            self.envs.vector.curriculum.restore(state["curriculum"])

    def close(self) -> None:
        """Ends the threads of the environments."""
        self.envs.close()


class Progress(BaseCallback):
    """Callback that reports the ends of episodes after updates, and reports scores to the curriculum."""

    def __init__(self, method: Method, envs: Sb3VecEnv, told: Callable[[dict[str, Any]], None], begins: Callable[[], None]) -> None:
        super().__init__()
        self.method, self.envs, self.told, self.begins = method, envs, told, begins
        self.outcomes: Counter[str] = Counter()
        self.returns: list[float] = []
        self.driving: list[str] = []
        self.tasks: list[list[str]] = []
        self.told_at = 0
        self.began = time.monotonic()

    def _on_training_start(self) -> None:
        self.driving = [info["task"] for info in self.envs.reset_infos]
        self.told_at = int(self.model.num_timesteps)

    def _on_rollout_start(self) -> None:
        self.begins()
        self.tasks = []

    def _on_step(self) -> bool:
        self.tasks.append(list(self.driving))
        for k, info in enumerate(self.locals["infos"]):
            if "outcome" in info:
                self.outcomes[info["outcome"]] += 1
                self.returns.append(info["episode"]["r"])
                self.driving[k] = info["next_task"]
        return True

    def _on_rollout_end(self) -> None:
        self._score()
        if int(self.model.num_timesteps) - self.told_at >= TOLD:
            self._tell()

    def _on_training_end(self) -> None:
        if self.told_at != int(self.model.num_timesteps):
            self._tell()

    def _tell(self) -> None:
        steps = int(self.model.num_timesteps)
        curriculum = self.envs.vector.curriculum
        stages = curriculum.stages() if curriculum else []
        self.told(
            {
                "steps": steps,
                "seconds": round(time.monotonic() - self.began, 1),
                "episodes": sum(self.outcomes.values()),
                "outcomes": dict(sorted(self.outcomes.items())),
                "return": float(np.mean(self.returns)) if self.returns else None,
                **self.method.told(),
                **({"stage": float(np.mean(stages))} if stages else {}),
            }
        )
        self.told_at, self.outcomes, self.returns = steps, Counter(), []

    def _score(self) -> None:
        curriculum, surprise = self.envs.vector.curriculum, self.method.surprise()
        if curriculum is None or surprise is None:
            return
        for k in range(surprise.shape[1]):
            begin = 0
            for t in range(1, len(self.tasks) + 1):
                if t == len(self.tasks) or self.tasks[t][k] != self.tasks[begin][k]:
                    curriculum.score(self.tasks[begin][k], float(surprise[begin:t, k].mean()))
                    begin = t


def curriculum_of(config: Config, planner: str) -> str:
    """Returns the curriculum of a planner. Raises `TrainingError` if the configuration has no such planner."""
    known = config["planners"]
    if planner not in known:
        raise TrainingError(planner, "there is no such planner in the configuration", f"there are {', '.join(known)}")
    return str(known[planner])


def success(model: BaseAlgorithm, options: dict[str, Any], count: int) -> dict[str, float]:
    """Runs every task of an environment once, without exploration noise.

    Args:
        model: Model of stable-baselines3.
        options: Arguments of `NavigationVectorEnv`.
        count: Number of environments.

    Returns:
        Number of `tasks`, and the percentage of each outcome.
    """
    counts = Counter(endings(lambda seen: model.predict(seen, deterministic=True)[0], options, count))
    total = sum(counts.values())
    return {"tasks": total, **{name: round(100.0 * n / total, 2) for name, n in sorted(counts.items())}}


def endings(act: Callable[[Any], np.ndarray], options: dict[str, Any], count: int) -> list[str]:
    """Runs every task of an environment once. Environments without a remaining task repeat their last one.

    Args:
        act: Function from observations as rows to actions.
        options: Arguments of `NavigationVectorEnv`.
        count: Number of environments.

    Returns:
        Outcomes, in the order of the tasks.
    """
    envs = NavigationVectorEnv(count, autoreset_mode="DISABLED", **options)
    tasks, parts = envs.tasks, envs._setup.parts
    ended: dict[str, str] = {}
    driving = [tasks[k % len(tasks)] for k in range(count)]
    waiting = tasks[count:][::-1]
    observation, _ = envs.reset(seed=0, options={"task": driving, "run_seed": 0})
    while len(ended) < len(tasks):
        observation, _, terminated, truncated, infos = envs.step(act(rows(parts, observation)))
        over = terminated | truncated
        for k in np.flatnonzero(over):
            ended[driving[k]] = infos["outcome"][k]
            driving[k] = waiting.pop() if waiting else driving[k]
        if over.any():
            observation, _ = envs.reset(options={"reset_mask": over, "task": driving, "run_seed": 0})
    envs.close()
    return [ended[task] for task in tasks]


def read_state(checkpoint: Path) -> dict[str, Any]:
    """Reads the state of a checkpoint. Raises `TrainingError` if it can't be read."""
    try:
        return json.loads((checkpoint / STATE).read_text(encoding="utf-8"))
    except (OSError, ValueError) as e:
        raise TrainingError(checkpoint, f"not a checkpoint: {e}", "give a folder that `train` has written") from None


def read_parameters(model: BaseAlgorithm, checkpoint: Path) -> None:
    """Loads parameters and optimiser state of a checkpoint into a model. Raises `TrainingError` if they can't be read."""
    try:
        parameters = torch.load(checkpoint / MODEL, map_location="cpu", weights_only=True)
    except (OSError, RuntimeError, ValueError, pickle.UnpicklingError) as e:
        raise TrainingError(checkpoint / MODEL, f"it can't be read: {e}", "continue from an earlier checkpoint") from None
    model.set_parameters(parameters, device="cpu")


def last_checkpoint(folder: Path) -> Path | None:
    """Returns the last checkpoint in the folder of a run; None if there is none."""
    there = sorted(folder.glob("checkpoint-*"))
    return there[-1] if there else None
