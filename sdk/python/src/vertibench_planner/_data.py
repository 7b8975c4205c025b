"""What passes between the harness and a planner. Made by `cargo xtask abi`; edit the WIT instead."""

from dataclasses import dataclass, field
from typing import Dict, List, Optional

import numpy as np

from ._methods import CommandMethods, LidarInfoMethods, MountMethods, TaskMethods, Grid, number, numbers, one_of

GEARS = ("forward", "neutral", "reverse")
"""The direction of travel that the gearbox is in."""


@dataclass
class Vehicle:
    """The vehicle to be driven."""

    name: str
    """The name of the vehicle, e.g. ``hmmwv``."""
    scale: float
    """The size of the world over that of the full-size original: 1, 1/6 or 1/10."""
    mass: float
    """The mass of the whole vehicle, kg."""
    length: float
    """The length of what collides, hull and tyres, m."""
    width: float
    """The width of what collides, hull and tyres with the wheels straight ahead but without mirrors, m. Half of it lies
    to each side of the centre line."""
    height: float
    """The height of what collides above flat ground, m."""
    wheelbase: float
    """The distance between the first and the last axle, m."""
    track: float
    """The distance between the two wheels of an axle, m."""
    wheel_radius: float
    """The radius of the wheels, m."""
    wheels: int
    """The number of wheels. Wheel data come from front to back, left before right."""
    ground_clearance: float
    """The height of the belly above flat ground, m."""
    max_steer_angle: float
    """The road-wheel angle at steering command 1, rad: the mean of both sides."""
    max_steer_rate: float
    """The greatest rate of the steering command, 1/s."""
    min_turn_radius: float
    """The turning radius of the reference point at full lock on flat ground, m."""
    max_speed: float
    """The top speed on flat ground, m/s."""
    max_reverse_speed: float
    """The top speed in reverse on flat ground, m/s; 0 for a vehicle without a reverse gear."""
    direction_change_speed: float
    """The speed below which the gearbox changes between forward and reverse, m/s."""
    direction_change_time: float
    """The time that such a change takes, during which no torque reaches the wheels, s."""

    @classmethod
    def _from_wire(cls, wire):
        return cls(
            name=wire["name"],
            scale=wire["scale"],
            mass=wire["mass"],
            length=wire["length"],
            width=wire["width"],
            height=wire["height"],
            wheelbase=wire["wheelbase"],
            track=wire["track"],
            wheel_radius=wire["wheel_radius"],
            wheels=wire["wheels"],
            ground_clearance=wire["ground_clearance"],
            max_steer_angle=wire["max_steer_angle"],
            max_steer_rate=wire["max_steer_rate"],
            min_turn_radius=wire["min_turn_radius"],
            max_speed=wire["max_speed"],
            max_reverse_speed=wire["max_reverse_speed"],
            direction_change_speed=wire["direction_change_speed"],
            direction_change_time=wire["direction_change_time"],
        )


@dataclass
class Mount(MountMethods):
    """The place and the attitude of a sensor on the vehicle."""

    position: np.ndarray
    """The position of the sensor in the body frame, m. An array of x, y, z."""
    roll: float
    """The roll of the sensor against the body, rad."""
    pitch: float
    """The pitch of the sensor against the body, rad, positive when it looks down."""
    yaw: float
    """The yaw of the sensor against the body, rad, positive when it looks to the left."""

    @classmethod
    def _from_wire(cls, wire):
        return cls(
            position=np.array(wire["position"], float),
            roll=wire["roll"],
            pitch=wire["pitch"],
            yaw=wire["yaw"],
        )


@dataclass
class LidarInfo(LidarInfoMethods):
    """The spinning lidar of the vehicle."""

    period: float
    """The time of one turn, which is that between two scans, s."""
    rows: int
    """The number of beams, which are the rows of a scan, lowest first."""
    cols: int
    """The number of directions of a turn, which are the columns of a scan: column c looks at the azimuth
    −π + (c + 1/2) · 2π / ``cols`` in the sensor's frame, counter-clockwise from straight ahead."""
    lowest: float
    """The elevation angle of the lowest beam over the sensor's horizon, rad."""
    highest: float
    """The elevation angle of the highest beam, rad. The others lie at equal angles between the two."""
    min_range: float
    """The least distance that it measures, m."""
    max_range: float
    """The greatest distance that it measures, m."""
    mount: Mount
    """The place of the sensor on the vehicle."""

    @classmethod
    def _from_wire(cls, wire):
        return cls(
            period=wire["period"],
            rows=wire["rows"],
            cols=wire["cols"],
            lowest=wire["lowest"],
            highest=wire["highest"],
            min_range=wire["min_range"],
            max_range=wire["max_range"],
            mount=Mount._from_wire(wire["mount"]),
        )


@dataclass
class DepthInfo:
    """The depth camera of the vehicle, a pinhole camera with square pixels."""

    period: float
    """The time between two images, s."""
    rows: int
    """The number of rows of an image, topmost first."""
    cols: int
    """The number of columns of an image, leftmost first."""
    field_of_view: float
    """The angle between the left and the right edge of an image, rad."""
    min_depth: float
    """The least depth that it measures, m."""
    max_depth: float
    """The greatest depth that it measures, m."""
    labels: bool
    """Whether the images have a label for each pixel."""
    mount: Mount
    """The place of the sensor on the vehicle."""

    @classmethod
    def _from_wire(cls, wire):
        return cls(
            period=wire["period"],
            rows=wire["rows"],
            cols=wire["cols"],
            field_of_view=wire["field_of_view"],
            min_depth=wire["min_depth"],
            max_depth=wire["max_depth"],
            labels=wire["labels"],
            mount=Mount._from_wire(wire["mount"]),
        )


@dataclass
class Task(TaskMethods):
    """What a planner is told at the start of a task."""

    id: str
    """The name of the task within the suite, e.g. ``w003/t07``."""
    vehicle: Vehicle
    """The vehicle to be driven."""
    elevation: Optional[Grid]
    """The heights of the ground, m, as far as the perception profile gives them; absent if it gives none."""
    semantics: Optional[Grid]
    """The kinds of ground, as far as the perception profile gives them: 0 clay, 1 concrete, 2 dirt, 3 grass, 4 gravel,
    5 rock, 6 wood, 7 mud, 8 sand, 9 snow; absent if it gives none."""
    occupancy: Optional[Grid]
    """The obstacles, as far as the perception profile gives them: 1 where any part of the sample's square is covered by
    an obstacle, else 0; absent if it gives none."""
    half_extent: np.ndarray
    """Half of the world's extent along x and y, m: the vehicle must stay between −x and x, −y and y. An array of x, y."""
    path: np.ndarray
    """The global path, from the start to the goal. An array with a row of x, y for each point."""
    start: np.ndarray
    """The pose from which the vehicle starts, at rest. An array of x, y, yaw."""
    goal: np.ndarray
    """The point to which the vehicle must go. An array of x, y."""
    goal_radius: float
    """The distance from the goal within which the task is done, m."""
    time_limit: float
    """The time limit, s."""
    control_period: float
    """The time between two calls of ``step``, s."""
    seed: int
    """The seed for the planner's own randomness: the same in every run of this task with the same run seed."""
    params: Dict[str, str]
    """All parameters that the planner declares, with the user's values or the defaults."""
    perception: str
    """The name of the perception profile, e.g. ``oracle``."""
    lidar: Optional[LidarInfo]
    """The lidar; absent if the planner doesn't ask for it."""
    depth: Optional[DepthInfo]
    """The depth camera; absent if the planner doesn't ask for it."""

    @classmethod
    def _from_wire(cls, wire):
        return cls(
            id=wire["id"],
            vehicle=Vehicle._from_wire(wire["vehicle"]),
            elevation=None if wire["elevation"] is None else Grid._from_wire(wire["elevation"], "<f4"),
            semantics=None if wire["semantics"] is None else Grid._from_wire(wire["semantics"], "u1"),
            occupancy=None if wire["occupancy"] is None else Grid._from_wire(wire["occupancy"], "u1"),
            half_extent=np.array(wire["half_extent"], float),
            path=np.array(wire["path"], float).reshape(-1, 2),
            start=np.array(wire["start"], float),
            goal=np.array(wire["goal"], float),
            goal_radius=wire["goal_radius"],
            time_limit=wire["time_limit"],
            control_period=wire["control_period"],
            seed=wire["seed"],
            params={p["key"]: p["value"] for p in wire["params"]},
            perception=wire["perception"],
            lidar=None if wire["lidar"] is None else LidarInfo._from_wire(wire["lidar"]),
            depth=None if wire["depth"] is None else DepthInfo._from_wire(wire["depth"]),
        )


@dataclass
class Pose:
    """An estimate of the vehicle's state, as the perception profile lets it be: the truth under ``oracle``."""

    position: np.ndarray
    """The position of the vehicle's reference point in the world frame, m. An array of x, y, z."""
    roll: float
    """The roll, rad, positive with the right side down."""
    pitch: float
    """The pitch, rad, positive with the nose down."""
    yaw: float
    """The heading, rad, counter-clockwise from east."""
    linear_velocity: np.ndarray
    """The velocity of the reference point in body axes, m/s. An array of x, y, z."""
    angular_velocity: np.ndarray
    """The angular velocity in body axes, rad/s. An array of x, y, z."""

    @classmethod
    def _from_wire(cls, wire):
        return cls(
            position=np.array(wire["position"], float),
            roll=wire["roll"],
            pitch=wire["pitch"],
            yaw=wire["yaw"],
            linear_velocity=np.array(wire["linear_velocity"], float),
            angular_velocity=np.array(wire["angular_velocity"], float),
        )


@dataclass
class Wheel:
    """The state of one wheel, as its sensors measure it."""

    spin: float
    """The angular velocity of the wheel about its axle, rad/s, positive when rolling forward."""
    travel: float
    """The suspension travel from the design position, m, positive in compression."""

    @classmethod
    def _from_wire(cls, wire):
        return cls(
            spin=wire["spin"],
            travel=wire["travel"],
        )


@dataclass
class ImuSample:
    """One measurement of the inertial measurement unit."""

    time: float
    """The simulated time of the measurement, s."""
    specific_force: np.ndarray
    """The specific force at the vehicle's reference point in body axes, m/s²: the acceleration less that of gravity, so
    +9.81 along z at rest. An array of x, y, z."""
    angular_velocity: np.ndarray
    """The angular velocity in body axes, rad/s. An array of x, y, z."""

    @classmethod
    def _from_wire(cls, wire):
        return cls(
            time=wire["time"],
            specific_force=np.array(wire["specific_force"], float),
            angular_velocity=np.array(wire["angular_velocity"], float),
        )


@dataclass
class GnssFix:
    """A position from satellites."""

    time: float
    """The simulated time of the measurement, s."""
    position: np.ndarray
    """The measured position of the vehicle's reference point in the world frame, m. An array of x, y, z."""

    @classmethod
    def _from_wire(cls, wire):
        return cls(
            time=wire["time"],
            position=np.array(wire["position"], float),
        )


@dataclass
class LidarScan:
    """One turn of the lidar."""

    time: float
    """The simulated time at which the turn ended, s. Column c was measured (1 − (c + 1/2) / ``cols``) · ``period`` before,
    while the vehicle moved."""
    ranges: np.ndarray
    """The ``rows`` · ``cols`` measured distances, m, by rows; 0 where nothing came back."""

    @classmethod
    def _from_wire(cls, wire):
        return cls(
            time=wire["time"],
            ranges=np.frombuffer(wire["ranges"], "<f4"),
        )


@dataclass
class DepthImage:
    """One image of the depth camera."""

    time: float
    """The simulated time of the image, s."""
    depths: np.ndarray
    """The ``rows`` · ``cols`` depths along the camera's axis, m, by rows; 0 where nothing was measured."""
    labels: np.ndarray
    """The kinds of ground that the pixels are recognised as, with the numbers of the task's ``semantics``, 10 for an
    obstacle, and 255 where nothing was measured; empty if the camera has no labels."""

    @classmethod
    def _from_wire(cls, wire):
        return cls(
            time=wire["time"],
            depths=np.frombuffer(wire["depths"], "<f4"),
            labels=np.frombuffer(wire["labels"], "u1"),
        )


@dataclass
class LocalMap:
    """The map of the vehicle's surroundings that is built from lidar and depth camera at the estimated pose. Its axes are
    those of the world frame as far as the estimate is right, and the vehicle is in its middle."""

    time: float
    """The simulated time at which the map was last brought up to date, s."""
    elevation: Grid
    """The heights of the ground, m; NaN where it has not been seen."""
    semantics: Grid
    """The kinds of ground, with the numbers of the task's ``semantics``; 255 where it has not been seen, or isn't known."""
    occupancy: Grid
    """1 where an obstacle was seen, 0 where ground was seen, and 255 where nothing was."""

    @classmethod
    def _from_wire(cls, wire):
        return cls(
            time=wire["time"],
            elevation=Grid._from_wire(wire["elevation"], "<f4"),
            semantics=Grid._from_wire(wire["semantics"], "u1"),
            occupancy=Grid._from_wire(wire["occupancy"], "u1"),
        )


@dataclass
class Observation:
    """What a planner sees every control period: what its sensors have measured since the last one. A sensor that the
    planner doesn't ask for, or that has measured nothing since, is absent."""

    time: float
    """The simulated time since the start, s."""
    pose: Optional[Pose]
    """The estimate of the vehicle's state (``pose``)."""
    wheels: List[Wheel]
    """The wheels (``wheel-odometry``), from front to back, left before right."""
    imu: List[ImuSample]
    """The measurements of the inertial measurement unit (``imu``), oldest first."""
    gnss: Optional[GnssFix]
    """The last position from satellites (``gnss``)."""
    lidar: Optional[LidarScan]
    """The last turn of the lidar (``lidar``)."""
    depth: Optional[DepthImage]
    """The last image of the depth camera (``depth``)."""
    local_map: Optional[LocalMap]
    """The map of the surroundings (``local-map``)."""
    gear: str
    """The gear that is in: neutral while a change of direction takes its time."""
    engine_speed: float
    """The speed of the engine, rad/s."""
    steering: float
    """The steering that the wheels have now, which follows the command at ``max_steer_rate``, in [-1, 1], positive to the
    left."""
    last_steering: float
    """The steering command applied until now, after clamping; 0 at first."""
    last_throttle: float
    """The throttle command applied until now, after clamping; 0 at first."""
    last_brake: float
    """The brake command applied until now, after clamping; 0 at first."""

    @classmethod
    def _from_wire(cls, wire):
        return cls(
            time=wire["time"],
            pose=None if wire["pose"] is None else Pose._from_wire(wire["pose"]),
            wheels=[Wheel._from_wire(x) for x in wire["wheels"]],
            imu=[ImuSample._from_wire(x) for x in wire["imu"]],
            gnss=None if wire["gnss"] is None else GnssFix._from_wire(wire["gnss"]),
            lidar=None if wire["lidar"] is None else LidarScan._from_wire(wire["lidar"]),
            depth=None if wire["depth"] is None else DepthImage._from_wire(wire["depth"]),
            local_map=None if wire["local_map"] is None else LocalMap._from_wire(wire["local_map"]),
            gear=wire["gear"],
            engine_speed=wire["engine_speed"],
            steering=wire["steering"],
            last_steering=wire["last_steering"],
            last_throttle=wire["last_throttle"],
            last_brake=wire["last_brake"],
        )


@dataclass
class Command(CommandMethods):
    """The command that holds until the next step."""

    steering: float = 0.0
    """The steering, in [-1, 1], positive to the left."""
    throttle: float = 0.0
    """The throttle, in [0, 1]."""
    brake: float = 0.0
    """The brake, in [0, 1]."""
    gear: str = "forward"
    """The direction of travel. A change between forward and reverse waits until the vehicle is slower than
    ``direction_change_speed``, with the throttle closed; brake to bring that about."""
    debug: Dict[str, np.ndarray] = field(default_factory=dict)
    """Series that are recorded beside the trajectory and drawn by ``vb-harness replay``. Leave this empty in normal runs."""

    def _to_wire(self):
        wire = {}
        wire["steering"] = number("steering", self.steering)
        wire["throttle"] = number("throttle", self.throttle)
        wire["brake"] = number("brake", self.brake)
        wire["gear"] = one_of("gear", self.gear, GEARS)
        if self.debug:
            wire["debug"] = [{"name": str(k), "values": numbers(k, v)} for k, v in self.debug.items()]
        return wire
