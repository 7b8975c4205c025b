"""Maps, and methods of the data classes."""

from dataclasses import dataclass

import numpy as np


@dataclass
class Grid:
    """Map on a square grid: ``data[row, col]`` is at x = origin_x + col * resolution, y = origin_y + row * resolution.

    Rows run north and columns run east, so row 0 is the southernmost.

    Attributes:
        data: Samples, shape (rows, columns).
        resolution: Distance between neighbouring samples, m.
        origin_x: Position of ``data[0, 0]`` to the east, m.
        origin_y: Position of ``data[0, 0]`` to the north, m.
    """

    data: np.ndarray
    resolution: float
    origin_x: float
    origin_y: float

    def cell(self, x, y):
        """Returns the indices of the nearest sample, limited to the grid.

        Args:
            x: Position to the east, m: a number or an array.
            y: Position to the north, m, with the same shape.

        Returns:
            Row and column, integers with the shape of the arguments.
        """
        rows, cols = self.data.shape
        # Halves are rounded up, as everywhere in the harness; numpy rounds to even.
        row = np.floor((np.asarray(y) - self.origin_y) / self.resolution + 0.5)
        col = np.floor((np.asarray(x) - self.origin_x) / self.resolution + 0.5)
        return np.clip(row, 0, rows - 1).astype(int), np.clip(col, 0, cols - 1).astype(int)

    def at(self, x, y):
        """Returns the nearest sample.

        Args:
            x: Position to the east, m: a number or an array.
            y: Position to the north, m, with the same shape.

        Returns:
            Samples with the shape of the arguments. Outside the grid these are the samples at its edge.
        """
        return self.data[self.cell(x, y)]

    @classmethod
    def _from_wire(cls, wire, dtype):
        frame = wire["frame"]
        data = np.frombuffer(wire["data"], dtype).reshape(frame["rows"], frame["cols"])
        return cls(data, frame["resolution"], frame["origin_x"], frame["origin_y"])


class TaskMethods:
    """Methods of :class:`Task`."""

    def number(self, key):
        """Returns a parameter of the planner as a number.

        Args:
            key: Name of the parameter, as in ``Planner.params``.

        Returns:
            The user's value or the default, a finite float.

        Raises:
            ValueError: If the planner doesn't declare the parameter, or its value is not a finite number.
        """
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
    """Methods of :class:`LidarInfo`."""

    def points(self, scan):
        """Converts a scan to points.

        Args:
            scan: :class:`LidarScan` of this lidar.

        Returns:
            Points with a return, in the body frame: array of shape (n, 3), x, y and z, m. The motion of the vehicle
            during the turn is not compensated.
        """
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
    """Methods of :class:`Mount`."""

    def rotation(self):
        """Returns the rotation from the sensor's frame to the body frame: yaw, then pitch, then roll.

        Returns:
            Matrix of shape (3, 3); ``rotation() @ v`` is the direction ``v`` of the sensor in the body frame.
        """
        (sr, cr), (sp, cp), (sy, cy) = ((np.sin(a), np.cos(a)) for a in (self.roll, self.pitch, self.yaw))
        yaw = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
        pitch = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
        roll = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
        return yaw @ pitch @ roll


class CommandMethods:
    """Methods of :class:`Command`."""

    @classmethod
    def for_speed(cls, steering, target, speed):
        """Returns a command with throttle or brake in proportion to the speed error, 1 per m/s, as in Verti-Bench.

        Args:
            steering: Steering, limited to [-1, 1], positive to the left.
            target: Target speed, m/s.
            speed: Present forward speed, m/s.

        Returns:
            The command, with the forward gear.
        """
        wanted = float(np.clip(target - speed, -1.0, 1.0))
        return cls(float(np.clip(steering, -1.0, 1.0)), max(wanted, 0.0), max(-wanted, 0.0))


def number(name, value):
    """Returns a field of a command as float; raises ``TypeError`` if it is no number."""
    try:
        return float(value)
    except (TypeError, ValueError):
        raise TypeError(f"the command's {name} is {value!r}; it must be a number") from None


def numbers(name, values):
    """Returns a debug series as list of floats; raises ``TypeError`` if it doesn't consist of numbers."""
    try:
        return np.ravel(values).astype(float).tolist()
    except (TypeError, ValueError):
        raise TypeError(f'the command\'s debug["{name}"] is {values!r}; it must be numbers') from None


def one_of(name, value, names):
    """Returns the value; raises ``ValueError`` if it is none of the names."""
    if value not in names:
        raise ValueError(f"the command's {name} is {value!r}; it must be one of {', '.join(names)}")
    return value
