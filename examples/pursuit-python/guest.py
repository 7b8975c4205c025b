"""Pure pursuit: drive the circle that goes through a point ahead on the path."""

from math import atan, atan2, isfinite, sin

import wit_world.exports.guest
from componentize_py_types import Err
from faults import reported
from following import Follower, Path, clamp, hypot, throttle_and_brake, turn
from wit_world.imports.types import Command, Gear, Observation, Task


def number(task: Task, key: str) -> float:
    """A parameter as a number; the harness gives every parameter that planner.yaml declares."""
    text = next((p.value for p in task.params if p.key == key), None)
    try:
        value = float(text)
    except (TypeError, ValueError):
        value = float("nan")
    if not isfinite(value):
        # `Err` aborts the task; any other exception counts as a bug.
        raise Err(f"parameter {key} is {text!r}; it must be a number")
    return value


class Planner(wit_world.exports.guest.Planner):
    """One planner for one task. All state lives in this object."""

    @classmethod
    @reported
    def init(cls, task: Task) -> "Planner":
        planner = cls()
        planner.wheelbase = task.vehicle.wheelbase
        planner.max_steer_angle = task.vehicle.max_steer_angle
        planner.speed = number(task, "speed")
        planner.ahead = number(task, "ahead") * task.vehicle.scale
        if not task.path:
            raise Err("the global path has no points")
        path = Path([(p.x, p.y) for p in task.path])
        planner.follower = Follower(path, 2.0 * planner.ahead)
        return planner

    @reported
    def step(self, o: Observation) -> Command:
        if o.pose is None:
            raise Err("there is no pose")
        pose = o.pose
        # Rejects implausible numbers. Comparisons with NaN are false, so NaN is rejected, too.
        seen = (pose.position.x, pose.position.y, pose.yaw, pose.linear_velocity.x)
        if not all(abs(value) < 1e9 for value in seen):
            raise Err(f"invalid position, heading or speed: {seen}")
        self.follower.update(pose.position.x, pose.position.y)
        x, y = self.follower.look_ahead(self.ahead)
        dx, dy = x - pose.position.x, y - pose.position.y
        angle = turn(pose.yaw, atan2(dy, dx))
        curvature = 2.0 * sin(angle) / max(hypot(dx, dy), 0.1)
        steering = atan(self.wheelbase * curvature) / self.max_steer_angle
        throttle, brake = throttle_and_brake(self.speed, pose.linear_velocity.x)
        return Command(clamp(steering, -1.0, 1.0), throttle, brake, Gear.FORWARD, [])
