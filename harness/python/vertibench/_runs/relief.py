"""Image of a world's ground: colours of the terrain classes, shaded by slope."""

from __future__ import annotations

import numpy as np

from .._image import encode_png
from ..datasets._world import CLASSES, World

#: Colours of the terrain classes, in the order of their labels, as in replays.
COLOURS = dict(
    zip(
        CLASSES,
        ("#cf724c", "#bec4cc", "#966f4a", "#7cb342", "#c4b0a0", "#748096", "#d9a058", "#684f42", "#f3d56e", "#ecf5ff"),
    )
)
#: Exaggeration of slopes in the shading, so that low relief is visible.
_STEEPER = 2.0
#: Direction towards the light, north-west as on maps: east, north, up.
_LIGHT = np.array([-1.0, 1.0, 1.4])
#: Maximum number of pixels along the longer side.
_MOST = 520


def png(world: World) -> bytes:
    """Renders the world from above as PNG, north up: three pixels per cell, fewer in large worlds."""
    rows, cols = world.heights.shape
    per_cell = min(3.0, _MOST / max(rows - 1, cols - 1))
    height, width = max(2, round((rows - 1) * per_cell)), max(2, round((cols - 1) * per_cell))
    size_x, size_y = world.size
    x = (np.arange(width) + 0.5) / width * size_x - size_x / 2
    # The first row of an image is the northernmost.
    y = size_y / 2 - (np.arange(height) + 0.5) / height * size_y
    east, north = np.meshgrid(x, y)
    palette = np.array([[int(c[k : k + 2], 16) for k in (1, 3, 5)] for c in COLOURS.values()], float)
    labels = np.minimum(world.class_at(east, north), len(palette) - 1)
    # Mixed with grey, so that lines stand out.
    ground = 0.8 * palette[labels] + 0.2 * 190.0
    shaded = ground * _between(_shade(world), (east, north), world)[..., None]
    return encode_png(np.clip(np.round(shaded), 0, 255).astype(np.uint8))


def _shade(world: World) -> np.ndarray:
    """Returns the brightness of each node: 1 on level ground."""
    north, east = np.gradient(_STEEPER * world.heights, world.resolution)
    light = _LIGHT / np.linalg.norm(_LIGHT)
    lit = (light[2] - light[0] * east - light[1] * north) / np.sqrt(1 + east**2 + north**2)
    return 0.35 + 0.65 * np.clip(lit, 0, None) / light[2]


def _between(values: np.ndarray, at: tuple[np.ndarray, np.ndarray], world: World) -> np.ndarray:
    """Interpolates values of the nodes linearly."""
    rows, cols = values.shape
    u, v = (w / world.resolution + (n - 1) / 2 for w, n in zip(at, (cols, rows)))
    col, row = (np.clip(np.floor(w).astype(int), 0, n - 2) for w, n in ((u, cols), (v, rows)))
    u, v = u - col, v - row
    south = values[row, col] * (1 - u) + values[row, col + 1] * u
    north = values[row + 1, col] * (1 - u) + values[row + 1, col + 1] * u
    return south * (1 - v) + north * v
