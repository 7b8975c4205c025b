"""The curriculum of a vector environment, `Curriculum`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from .._errors import OptionError
from .._options import number
from ._common import task_of

if TYPE_CHECKING:
    from ._vector import NavigationVectorEnv


class Curriculum:
    """Curriculum of a vector environment: chooses the task of each new episode.

    `NavigationVectorEnv.curriculum` is an instance. All methods raise `EpisodeError` if the environment is closed, was
    created in another process, or is used by another thread.
    """

    def __init__(self, env: NavigationVectorEnv) -> None:
        self._vector = env

    def chances(self) -> dict[str, float]:
        """Returns the probability of each task to be chosen next.

        Returns:
            Probability in [0, 1] by task name, averaged over the environments.
        """
        return dict(zip(self._vector.tasks, self._told()[0]))

    def stages(self) -> list[int]:
        """Returns the current stage of each environment.

        Returns:
            Stage numbers, from 0; empty if the curriculum has no stages.
        """
        return self._told()[1]

    def score(self, task: str, score: float) -> None:
        """Reports a learner's score of a task, which `replay` uses for its choice; other curricula ignore it.

        Args:
            task: Task name.
            score: Mean absolute difference between returns and expected values in an episode. Must be finite.

        Raises:
            OptionError: If the score is not a finite number.
            UnknownError: If there is no such task.
        """
        own = number("score", score)
        if not math.isfinite(own):
            raise OptionError(f"score: {own} must be a finite number")
        self._vector._native().score(task_of(task) or "", own)

    def state(self) -> str:
        """Saves all that the curriculum has learned.

        Returns:
            The state as text, for `restore`.
        """
        return self._vector._native().curriculum_state() or ""

    def restore(self, state: str) -> None:
        """Restores a saved state and chooses the next tasks again.

        For an exact continuation, an uninterrupted training must also call `restore(state())` when it saves the state,
        because the tasks that were already chosen are not part of it.

        Args:
            state: Text that `state()` returned, of a curriculum with the same settings.

        Raises:
            OptionError: If the state doesn't fit this curriculum.
            EpisodeError: If an environment is busy.
        """
        if not isinstance(state, str):
            raise OptionError(f"restore: {type(state).__name__} is not a state of a curriculum: give a result of state()")
        self._vector._native().restore_curriculum(state)

    def _told(self) -> tuple[list[float], list[int]]:
        return self._vector._native().curriculum() or ([], [])
