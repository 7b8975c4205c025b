"""Pictures of an episode."""

from __future__ import annotations

import numpy as np

from .. import _native
from .._errors import OptionError


class Camera:
    """How pictures are taken. Raises `OptionError` for a mode, a camera or a size that there isn't."""

    def __init__(self, mode: str | None, camera: str, size: tuple[int, int]) -> None:
        if mode not in (None, "rgb_array"):
            raise OptionError(f"render_mode: {mode!r} must be 'rgb_array' or None")
        if camera not in ("chase", "top"):
            raise OptionError(f"camera: {camera!r} must be 'chase' or 'top'")
        try:
            width, height = (int(n) for n in size)
        except (TypeError, ValueError):
            raise OptionError(f"render_size: {size!r} must be (width, height)") from None
        if not (1 <= width <= 4096 and 1 <= height <= 4096):
            raise OptionError(f"render_size: {size!r} must lie in 1 to 4096")
        self._mode, self._camera, self._size = mode, camera, (width, height)

    def picture(self, env: _native.Env) -> np.ndarray | None:
        """A picture, or None without a mode."""
        if self._mode is None:
            return None
        return env.render(self._camera, *self._size)
