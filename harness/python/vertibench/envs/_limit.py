"""A step limit for each environment of a vector environment, as gymnasium's `TimeLimit` for a single one."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode

from .. import _native
from .._errors import EpisodeError, OptionError

#: Result of an environment: index, task and run seed if an episode has begun, record if one has ended.
Arrival = tuple[int, tuple[str, int] | None, str | None]


class Limit:
    """Truncates each episode after `most` steps; the mode determines when the next one begins. Such an end has no record."""

    def __init__(self, most: int, mode: AutoresetMode, count: int, batch_size: int, has_curriculum: bool) -> None:
        if has_curriculum:
            what = "a curriculum needs the ends of all episodes: use rules with another time limit"
            raise OptionError(f"max_episode_steps: {most}: {what}")
        if batch_size < count and mode == AutoresetMode.SAME_STEP:
            what = "with SAME_STEP, batch_size must be the number of environments: use NEXT_STEP, or rules with another time limit"
            raise OptionError(f"max_episode_steps: {most}: {what}")
        self.most, self.mode = most, mode
        #: Steps of each episode, and whether it was truncated here and no new one has begun.
        self.steps, self.is_cut = np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.bool_)

    def send(self, env: _native.VectorEnv, ids: np.ndarray, rows: np.ndarray) -> None:
        """Steps environments; truncated ones begin a new episode."""
        cut = self.is_cut[ids]
        if not cut.any():
            env.send(ids, rows)
            return
        if self.mode == AutoresetMode.DISABLED:
            raise EpisodeError(f"the episode has ended (max_episode_steps is {self.most}): call reset")
        if not np.isfinite(rows).all():
            # Raises the error for these numbers before any environment is stepped.
            env.send(ids, rows)
        if not cut.all():
            env.send(ids[~cut], rows[~cut])
        env.reset([(int(k), None, None, None) for k in ids[cut]])
        self.is_cut[ids] = False

    def receive(self, env: _native.VectorEnv, arrivals: list[Arrival], arrays: dict[str, Any]) -> dict[int, Any]:
        """Counts the received steps and truncates episodes that have reached the limit.

        Returns the last observations of environments that began a new episode in the same step, as rows of the arrays,
        and notes the new episodes in `arrivals`.
        """
        cut = []
        for place, (index, began, record) in enumerate(arrivals):
            if began is None or record is not None:
                self.steps[index] += 1
                if self.steps[index] >= self.most:
                    arrays["truncated"][index] = True
                    if record is None:
                        cut.append(place)
            if began is not None:
                self.steps[index], self.is_cut[index] = 0, False
        over = [arrivals[place][0] for place in cut]
        if self.mode != AutoresetMode.SAME_STEP or not cut:
            self.is_cut[over] = True
            return {}
        last = {index: [array[index].copy() for array in arrays["observations"]] for index in over}
        worth = {name: arrays[name][over] for name in ("rewards", "terms", "truncated")}
        env.reset([(index, None, None, None) for index in over])
        again = {index: began for index, began, _ in env.receive(len(over))}
        for name, values in worth.items():
            arrays[name][over] = values
        for place, index in zip(cut, over):
            arrivals[place] = (index, again[index], None)
        self.steps[over] = 0
        return last
