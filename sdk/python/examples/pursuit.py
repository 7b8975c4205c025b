"""Pure pursuit: drive the circle that goes through a point ahead on the path."""

import numpy as np
from vertibench_planner import Command, Follower, Planner, main


class Pursuit(Planner):
    name = "pursuit-python"
    about = "Drives the circle through a point ahead on the global path, in Python"
    params = {"speed": (4.0, "target speed, m/s"), "ahead": (6.0, "distance of the point ahead, m at full scale")}

    def init(self, task):
        self.vehicle, self.speed = task.vehicle, task.number("speed")
        self.ahead = task.number("ahead") * task.vehicle.scale
        self.follower = Follower(task.path, 2.0 * self.ahead)

    def step(self, obs):
        pose = obs.pose
        self.follower.update(pose.position[0], pose.position[1])
        dx, dy = self.follower.look_ahead(self.ahead) - pose.position[:2]
        curvature = 2.0 * np.sin(np.arctan2(dy, dx) - pose.yaw) / max(np.hypot(dx, dy), 0.1)
        steering = np.arctan(self.vehicle.wheelbase * curvature) / self.vehicle.max_steer_angle
        return Command.for_speed(steering, self.speed, pose.linear_velocity[0])


main(Pursuit)
