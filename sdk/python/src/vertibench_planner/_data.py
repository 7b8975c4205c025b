"""What passes between the harness and a planner."""

from dataclasses import dataclass, field
from typing import Dict

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
        data = np.frombuffer(wire["data"], dtype).reshape(wire["rows"], wire["cols"])
        return cls(data, wire["resolution"], wire["origin_x"], wire["origin_y"])


@dataclass
class Vehicle:
    """The vehicle to be driven."""

    name: str
    scale: float
    mass: float
    length: float
    """Of what collides, hull and tyres, m; so are width and height."""
    width: float
    """Wheels straight ahead, without mirrors; half of it lies to each side of the centre line."""
    height: float
    wheelbase: float
    track: float
    wheel_radius: float
    wheels: int
    ground_clearance: float
    max_steer_angle: float
    max_steer_rate: float
    min_turn_radius: float
    max_speed: float


@dataclass
class Task:
    """What a planner is told at the start of a task."""

    id: str
    vehicle: Vehicle
    elevation: Grid
    """Heights, m, float32."""
    semantics: Grid
    """0 clay, 1 concrete, 2 dirt, 3 grass, 4 gravel, 5 rock, 6 wood, 7 mud, 8 sand, 9 snow."""
    occupancy: Grid
    """1 where an obstacle covers any part of the sample's square."""
    path: np.ndarray
    """The global path, start to goal: n rows of x, y."""
    start: np.ndarray
    """x, y, yaw."""
    goal: np.ndarray
    """x, y."""
    goal_radius: float
    time_limit: float
    control_period: float
    seed: int
    """For the planner's own randomness: ``numpy.random.default_rng(task.seed)``."""
    params: Dict[str, str]
    """Every parameter that the planner declares, as the user wrote it."""

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

    @classmethod
    def _from_wire(cls, wire):
        known = {name: wire[name] for name in cls.__dataclass_fields__}
        vehicle = {name: wire["vehicle"][name] for name in Vehicle.__dataclass_fields__}
        known.update(
            vehicle=Vehicle(**vehicle),
            elevation=Grid._from_wire(wire["elevation"], "<f4"),
            semantics=Grid._from_wire(wire["semantics"], "u1"),
            occupancy=Grid._from_wire(wire["occupancy"], "u1"),
            path=np.array(wire["path"], float).reshape(-1, 2),
            start=np.array(wire["start"], float),
            goal=np.array(wire["goal"], float),
            params={key: value for key, value in wire["params"]},
        )
        return cls(**known)


@dataclass
class Observation:
    """What a planner sees every control period."""

    time: float
    """Simulated time since the start, s."""
    position: np.ndarray
    """x, y, z of the vehicle's reference point."""
    roll: float
    pitch: float
    yaw: float
    linear_velocity: np.ndarray
    """Body axes, m/s."""
    angular_velocity: np.ndarray
    """Body axes, rad/s."""
    wheel_speeds: np.ndarray
    """rad/s, front to back, left before right."""
    wheel_deflections: np.ndarray
    """Suspension travel, m, positive in compression."""
    last_steering: float
    last_throttle: float
    last_brake: float

    @classmethod
    def _from_wire(cls, wire):
        wheels = wire["wheels"]
        return cls(
            time=wire["time"],
            position=np.array(wire["position"], float),
            roll=wire["roll"],
            pitch=wire["pitch"],
            yaw=wire["yaw"],
            linear_velocity=np.array(wire["linear_velocity"], float),
            angular_velocity=np.array(wire["angular_velocity"], float),
            wheel_speeds=np.array([w["speed"] for w in wheels], float),
            wheel_deflections=np.array([w["deflection"] for w in wheels], float),
            last_steering=wire["last_steering"],
            last_throttle=wire["last_throttle"],
            last_brake=wire["last_brake"],
        )


@dataclass
class Command:
    """What a planner wants done until the next step."""

    steering: float = 0.0
    """[-1, 1], positive to the left."""
    throttle: float = 0.0
    """[0, 1]."""
    brake: float = 0.0
    """[0, 1]."""
    debug: Dict[str, np.ndarray] = field(default_factory=dict)
    """Numbers to be recorded beside the trajectory, by name."""

    @classmethod
    def for_speed(cls, steering, target, speed):
        """Steering within its range, and throttle or brake in proportion to the error in speed, 1 per m/s, as Verti-Bench
        does."""
        wanted = float(np.clip(target - speed, -1.0, 1.0))
        return cls(float(np.clip(steering, -1.0, 1.0)), max(wanted, 0.0), max(-wanted, 0.0))

    def _to_wire(self):
        wire = {name: _number(name, getattr(self, name)) for name in ("steering", "throttle", "brake")}
        if self.debug:
            wire["debug"] = [{"name": str(name), "values": _numbers(name, v)} for name, v in self.debug.items()]
        return wire


def _number(name, value):
    try:
        return float(value)
    except (TypeError, ValueError):
        raise TypeError(f"the command's {name} is {value!r}; it must be a number") from None


def _numbers(name, values):
    try:
        return np.ravel(values).astype(float).tolist()
    except (TypeError, ValueError):
        raise TypeError(f'the command\'s debug["{name}"] is {values!r}; it must be numbers') from None
