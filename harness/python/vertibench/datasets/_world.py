"""The worlds of a dataset: heights, kinds of ground, friction and obstacles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .. import _yaml
from . import _png
from ._errors import DatasetError

#: The kinds of ground, in the order of their labels.
CLASSES = ("clay", "concrete", "dirt", "grass", "gravel", "rock", "wood", "mud", "sand", "snow")

#: The version of the suites' format that this package reads.
_SCHEMA = 1
#: What can be done about a damaged world of a dataset.
_AGAIN = "make or fetch the dataset again"


@dataclass(frozen=True)
class Obstacle:
    """A boulder, box or trunk. It stands on the ground under its centre."""

    kind: str  #: `boulder`, `box` or `trunk`
    x: float  #: centre, m
    y: float  #: centre, m
    yaw: float  #: heading of its own x axis, rad
    buried: float  #: how much of its height is below the ground at its centre, m
    size: tuple[float, float, float]  #: extents along its own axes, m


@dataclass(frozen=True)
class World:
    """A world, at the scale of the dataset. x is east, y north, and the origin is its centre; row 0 of all arrays is in the
    south and column 0 in the west, so that indices grow with coordinates."""

    id: str
    elevation: str  #: the level of its relief: `low`, `medium` or `high`
    terrain: str  #: `rigid`, `deformable` or `mixed`
    density: str  #: of obstacles: `sparse`, `medium` or `dense`
    resolution: float  #: the distance between nodes, m
    heights: np.ndarray  #: of the nodes, m, float64
    patch: float  #: the side of a patch, m
    classes: np.ndarray  #: the label of each patch, uint8: the place in `CLASSES`
    friction: np.ndarray  #: the friction coefficient of each patch; 0 where the ground yields
    soil: dict[str, str]  #: `soft`, `medium` or `hard` of each kind of ground that yields, where it isn't `medium`
    obstacles: tuple[Obstacle, ...]

    @property
    def size(self) -> tuple[float, float]:
        """The extents along x and y, m."""
        rows, cols = self.heights.shape
        return ((cols - 1) * self.resolution, (rows - 1) * self.resolution)

    def height(self, x: Any, y: Any) -> np.ndarray:
        """The height of the ground at places, m. As in the simulator each cell is two triangles, which share the diagonal
        from its south-west to its north-east corner, and beyond the edge the last triangle goes on."""
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
        """The labels of the ground at places, as `CLASSES` has them; 255 beyond the edge. Obstacles don't count."""
        inside, row, col = self._patch(x, y)
        return np.where(inside, self.classes[row, col], 255).astype(np.uint8)

    def friction_at(self, x: Any, y: Any) -> np.ndarray:
        """The friction coefficients at places; 0 where the ground yields and beyond the edge."""
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
    """Reads the world in a folder of a suite, and multiplies its lengths by the scale. `error` is what is raised, and `again`
    what can be done about damage."""
    file = folder / "world.yaml"
    try:
        world = _document(file)
        if world["schema"] != _SCHEMA:
            raise error(
                file, f"version {world['schema']} of worlds, this package reads version {_SCHEMA}", "use a newer vertibench"
            )
        grid = world["grid"]
        low, high = grid["height_range"]
        file = folder / "elevation.png"
        levels = _png.read_grey16(file.read_bytes())
        if levels.shape != (grid["rows"], grid["cols"]):
            raise ValueError(f"{levels.shape[0]} x {levels.shape[1]} pixels, world.yaml has {grid['rows']} x {grid['cols']}")
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
    value = _yaml.parse(file.read_text(encoding="utf-8"))
    if not isinstance(value, dict):
        raise ValueError("it has no fields")
    return value


def _obstacle(o: dict, scale: float) -> Obstacle:
    # A trunk is as long and wide as its circle.
    size = (2 * o["radius"], 2 * o["radius"], o["height"]) if o["kind"] == "trunk" else o["size"]
    x, y, buried, *size = (scale * length for length in (o["x"], o["y"], o["buried"], *size))
    return Obstacle(o["kind"], x, y, float(o["yaw"]), buried, tuple(size))
