"""Worlds of a dataset: heights, terrain classes, friction and obstacles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .. import _image, _yaml
from ._errors import DatasetError

#: Names of the terrain classes, in the order of their labels.
CLASSES = ("clay", "concrete", "dirt", "grass", "gravel", "rock", "wood", "mud", "sand", "snow")

#: Supported version of the suite format.
_SCHEMA = 1
#: Next step for a damaged world of a dataset.
_AGAIN = "make or fetch the dataset again"


@dataclass(frozen=True)
class Obstacle:
    """Obstacle on the ground: a boulder, box or trunk.

    Attributes:
        kind: `boulder`, `box` or `trunk`.
        x: Position of the centre to the east, m.
        y: Position of the centre to the north, m.
        yaw: Direction of its own x axis, counter-clockwise from east, rad.
        buried: Part of its height below the ground at its centre, m.
        size: Extents along its own axes x, y and z, m.
    """

    kind: str
    x: float
    y: float
    yaw: float
    buried: float
    size: tuple[float, float, float]


@dataclass(frozen=True)
class World:
    """World, in lengths of the scaled world.

    x is east, y is north, and the origin is the centre. Row 0 of all arrays is in the south and column 0 in the west,
    so indices grow with coordinates. The world consists of square patches with one terrain class each.

    Attributes:
        id: World id, e.g. `w001`.
        elevation: Elevation level: `low`, `medium` or `high`.
        terrain: Terrain type: `rigid`, `deformable` or `mixed`.
        density: Obstacle density: `sparse`, `medium` or `dense`.
        resolution: Distance between nodes, m.
        heights: Heights of the nodes, m; float64, shape (rows, columns).
        patch: Side of a patch, m.
        classes: Terrain class of each patch, as index in `CLASSES`; uint8, shape (rows, columns).
        friction: Friction coefficient of each patch, 0 on deformable terrain; float64, shape (rows, columns).
        soil: Soil strength by deformable terrain class, `soft` or `hard`; absent classes are `medium`.
        obstacles: The obstacles.
    """

    id: str
    elevation: str
    terrain: str
    density: str
    resolution: float
    heights: np.ndarray
    patch: float
    classes: np.ndarray
    friction: np.ndarray
    soil: dict[str, str]
    obstacles: tuple[Obstacle, ...]

    @property
    def size(self) -> tuple[float, float]:
        """Extents along x and y, m."""
        rows, cols = self.heights.shape
        return ((cols - 1) * self.resolution, (rows - 1) * self.resolution)

    def height(self, x: Any, y: Any) -> np.ndarray:
        """Returns the ground height, as in the simulator.

        Each cell consists of two triangles along the diagonal from its south-west to its north-east corner. Outside the
        world the nearest triangle is extended.

        Args:
            x: Positions to the east, m: a number or an array.
            y: Positions to the north, m, with the same shape.

        Returns:
            Heights, m, float64, with the shape of the arguments.
        """
        rows, cols = self.heights.shape
        u = np.asarray(x, float) / self.resolution + (cols - 1) / 2
        v = np.asarray(y, float) / self.resolution + (rows - 1) / 2
        col, row = (np.clip(np.floor(w).astype(int), 0, n - 2) for w, n in ((u, cols), (v, rows)))
        u, v = u - col, v - row
        southwest, southeast = self.heights[row, col], self.heights[row, col + 1]
        northwest, northeast = self.heights[row + 1, col], self.heights[row + 1, col + 1]
        upper = southwest + (northeast - northwest) * u + (northwest - southwest) * v
        lower = southwest + (southeast - southwest) * u + (northeast - southeast) * v
        return np.where(v >= u, upper, lower)

    def class_at(self, x: Any, y: Any) -> np.ndarray:
        """Returns the terrain class; obstacles are ignored.

        Args:
            x: Positions to the east, m: a number or an array.
            y: Positions to the north, m, with the same shape.

        Returns:
            Indices in `CLASSES`, 255 outside the world; uint8, with the shape of the arguments.
        """
        inside, row, col = self._patch(x, y)
        return np.where(inside, self.classes[row, col], 255).astype(np.uint8)

    def friction_at(self, x: Any, y: Any) -> np.ndarray:
        """Returns the friction coefficient.

        Args:
            x: Positions to the east, m: a number or an array.
            y: Positions to the north, m, with the same shape.

        Returns:
            Friction coefficients, 0 on deformable terrain and outside the world; float64, with the shape of the
            arguments.
        """
        inside, row, col = self._patch(x, y)
        return np.where(inside, self.friction[row, col], 0.0)

    def _patch(self, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        x, y = np.asarray(x, float), np.asarray(y, float)
        rows, cols = self.classes.shape
        half_x, half_y = cols * self.patch / 2, rows * self.patch / 2
        col = np.clip(np.floor((x + half_x) / self.patch).astype(int), 0, cols - 1)
        row = np.clip(np.floor((y + half_y) / self.patch).astype(int), 0, rows - 1)
        return (np.abs(x) <= half_x) & (np.abs(y) <= half_y), row, col


def read_world(
    folder: Path, scale: float, error: Callable[[Path, str, str], Exception] = DatasetError, again: str = _AGAIN
) -> World:
    """Reads the world in a folder of a suite and multiplies its lengths by the scale.

    `error` is the exception for a damaged world, and `again` the next step in its message.
    """
    file = folder / "world.yaml"
    try:
        world = _document(file)
        if world["schema"] != _SCHEMA:
            raise error(
                file, f"unsupported version {world['schema']} of the world format, supported: {_SCHEMA}", "use a newer vertibench"
            )
        grid = world["grid"]
        low, high = grid["height_range"]
        file = folder / "elevation.png"
        levels = _image.read_grey16(file.read_bytes(), grid["rows"], grid["cols"])
        heights = scale * (low + (high - low) * (levels[::-1] / 65535))
        file = folder / "semantics.yaml"
        ground = _document(file)
        shape = (ground["rows"], ground["cols"])
        legend = {letter: CLASSES.index(name) for letter, name in ground["legend"].items()}
        classes = np.array([[legend[letter] for letter in row] for row in ground["classes"]], np.uint8)
        friction = np.array(ground["friction"], float)
        if classes.shape != shape or friction.shape != shape:
            raise ValueError(f"classes and friction must have {shape[0]} rows of {shape[1]}")
        patch = scale * ground["patch"]
        file = folder / "obstacles.yaml"
        obstacles = tuple(_obstacle(o, scale) for o in _document(file)["obstacles"] or ())
    except OSError as e:
        raise error(file, f"cannot be read: {e.strerror}", again) from None
    except (KeyError, TypeError, ValueError) as e:
        what = f"no field {e}" if isinstance(e, KeyError) else str(e)
        raise error(file, what, f"the file is damaged or was changed: {again}") from None
    return World(
        id=world["id"],
        elevation=world["elevation"],
        terrain=world["terrain"],
        density=world["density"],
        resolution=scale * grid["pitch"],
        heights=heights,
        patch=patch,
        classes=classes[::-1],
        friction=friction[::-1],
        soil=ground.get("soil") or {},
        obstacles=obstacles,
    )


def _document(file: Path) -> dict:
    value = _yaml.read(file)
    if not isinstance(value, dict):
        raise ValueError("not a mapping of fields")
    return value


def _obstacle(o: dict, scale: float) -> Obstacle:
    # Length and width of a trunk are the diameter.
    size = (2 * o["radius"], 2 * o["radius"], o["height"]) if o["kind"] == "trunk" else o["size"]
    x, y, buried, *size = (scale * length for length in (o["x"], o["y"], o["buried"], *size))
    return Obstacle(o["kind"], x, y, float(o["yaw"]), buried, tuple(size))
