"""Images of an episode."""

from __future__ import annotations

import numpy as np

from .. import _native
from .._errors import OptionError
from .._image import encode_png
from .._options import whole


class Picture:
    """Image that a notebook displays; `picture(env.render())` returns one.

    Args:
        rgb: Image of shape (height, width, 3), uint8.
    """

    def __init__(self, rgb: np.ndarray) -> None:
        self.rgb = rgb

    def _repr_png_(self) -> bytes:
        return encode_png(self.rgb)


def picture(rgb: np.ndarray) -> Picture:
    """Wraps an image for display in a notebook.

    Args:
        rgb: Image of `render()`, of shape (height, width, 3), uint8.

    Returns:
        The picture; a notebook displays it at the end of a cell.

    Raises:
        OptionError: If the argument is no such array.
    """
    if not (isinstance(rgb, np.ndarray) and rgb.dtype == np.uint8 and rgb.ndim == 3 and rgb.shape[2] == 3):
        raise OptionError("picture: give a result of render() with render_mode='rgb_array'")
    return Picture(rgb)


class Camera:
    """Validated render mode, camera and image size. Raises `OptionError` for invalid values."""

    def __init__(self, mode: str | None, camera: str, size: tuple[int, int]) -> None:
        if mode not in (None, "rgb_array"):
            raise OptionError(f"render_mode: {mode!r} must be 'rgb_array' or None")
        if camera not in ("chase", "top"):
            raise OptionError(f"camera: {camera!r} must be 'chase' or 'top'")
        try:
            width, height = (whole("render_size", n, 1, 4096) for n in size)
        except (TypeError, ValueError):
            raise OptionError(f"render_size: {size!r} must be (width, height), whole numbers from 1 to 4096") from None
        self._mode, self._camera, self._size = mode, camera, (width, height)

    def picture(self, env: _native.Env) -> np.ndarray | None:
        """Renders an image; returns None without a render mode."""
        if self._mode is None:
            return None
        return env.render(self._camera, *self._size)
