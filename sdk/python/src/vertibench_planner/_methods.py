"""What the data can do, beside what they hold."""

from dataclasses import dataclass

import numpy as np


@dataclass
class Grid:
    """Samples on a square grid: ``data[row, col]`` is at x = origin_x + col * resolution, y = origin_y + row * resolution."""

    data: np.ndarray
    resolution: float
    origin_x: float
    origin_y: float

    def cell(self, x, y):
        """Row and column of the sample nearest to (x, y), within the grid; arrays give arrays."""
        rows, cols = self.data.shape
        # Half-way goes up, as everywhere in the harness; numpy's own rounding goes to even.
        row = np.floor((np.asarray(y) - self.origin_y) / self.resolution + 0.5)
        col = np.floor((np.asarray(x) - self.origin_x) / self.resolution + 0.5)
        return np.clip(row, 0, rows - 1).astype(int), np.clip(col, 0, cols - 1).astype(int)

    def at(self, x, y):
        """The sample nearest to (x, y)."""
        return self.data[self.cell(x, y)]

    @classmethod
    def _from_wire(cls, wire, dtype):
        frame = wire["frame"]
        data = np.frombuffer(wire["data"], dtype).reshape(frame["rows"], frame["cols"])
        return cls(data, frame["resolution"], frame["origin_x"], frame["origin_y"])


class TaskMethods:
    """Methods of a task."""

    def number(self, key):
        """A parameter as a finite number."""
        if key not in self.params:
            known = ", ".join(self.params) or "nothing"
            raise ValueError(f"parameter `{key}` is not declared in the planner's params, which have {known}")
        text = self.params[key]
        try:
            value = float(text)
        except ValueError:
            value = np.nan
        if not np.isfinite(value):
            raise ValueError(f"parameter `{key}`: `{text}` is not a number")
        return value


class LidarInfoMethods:
    """Methods of a lidar."""

    def points(self, scan):
        """The points of a scan in the body frame, n rows of x, y, z, where something came back."""
        ranges = np.asarray(scan.ranges, float).reshape(self.rows, self.cols)
        azimuth = -np.pi + (np.arange(self.cols) + 0.5) * 2.0 * np.pi / self.cols
        elevation = np.linspace(self.lowest, self.highest, self.rows)[:, None]
        rays = np.stack(
            [
                np.cos(elevation) * np.cos(azimuth),
                np.cos(elevation) * np.sin(azimuth),
                np.sin(elevation) * np.ones_like(azimuth),
            ],
            axis=-1,
        )
        seen = ranges > 0.0
        return (ranges[..., None] * rays)[seen] @ self.mount.rotation().T + self.mount.position


class MountMethods:
    """Methods of a sensor's place."""

    def rotation(self):
        """The matrix that turns directions of the sensor into those of the body: yaw, then pitch, then roll."""
        (sr, cr), (sp, cp), (sy, cy) = ((np.sin(a), np.cos(a)) for a in (self.roll, self.pitch, self.yaw))
        yaw = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
        pitch = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
        roll = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
        return yaw @ pitch @ roll


class CommandMethods:
    """Methods of a command."""

    @classmethod
    def for_speed(cls, steering, target, speed):
        """Steering within its range, and throttle or brake in proportion to the error in speed, 1 per m/s, as Verti-Bench
        does."""
        wanted = float(np.clip(target - speed, -1.0, 1.0))
        return cls(float(np.clip(steering, -1.0, 1.0)), max(wanted, 0.0), max(-wanted, 0.0))


def number(name, value):
    try:
        return float(value)
    except (TypeError, ValueError):
        raise TypeError(f"the command's {name} is {value!r}; it must be a number") from None


def numbers(name, values):
    try:
        return np.ravel(values).astype(float).tolist()
    except (TypeError, ValueError):
        raise TypeError(f'the command\'s debug["{name}"] is {values!r}; it must be numbers') from None


def one_of(name, value, names):
    if value not in names:
        raise ValueError(f"the command's {name} is {value!r}; it must be one of {', '.join(names)}")
    return value
