"""A small neural network drives: two points ahead on the path, in the vehicle's frame, to a steering command.

train_neural.py makes its weights, `neural_weights.npz` in the same folder.
"""

from pathlib import Path

import numpy as np
from vertibench_planner import Command, Follower, Planner, main

AHEAD = (4.0, 9.0)  # m at full scale


class Neural(Planner):
    name = "neural-python"
    about = "Steers by a small neural network that has learned pure pursuit"
    params = {"speed": (4.0, "target speed, m/s")}

    def init(self, task):
        self.speed, self.scale, self.wheelbase = task.number("speed"), task.vehicle.scale, task.vehicle.wheelbase
        self.max_steer_angle = task.vehicle.max_steer_angle
        self.follower = Follower(task.path, 12.0 * self.scale)
        self.weights = np.load(Path(__file__).with_name("neural_weights.npz"))

    def step(self, obs):
        pose = obs.pose
        self.follower.update(pose.position[0], pose.position[1])
        turn = np.array([[np.cos(pose.yaw), np.sin(pose.yaw)], [-np.sin(pose.yaw), np.cos(pose.yaw)]])
        points = [turn @ (self.follower.look_ahead(d * self.scale) - pose.position[:2]) for d in AHEAD]
        curvature = network(self.weights, np.concatenate(points) / self.scale / 10.0) / self.scale
        steering = np.arctan(self.wheelbase * curvature) / self.max_steer_angle
        return Command.for_speed(steering, self.speed, pose.linear_velocity[0])


def network(w, x):
    """Curvature, 1/m at full scale, from the two points, in units of 10 m."""
    hidden = np.tanh(x @ w["w1"] + w["b1"])
    hidden = np.tanh(hidden @ w["w2"] + w["b2"])
    return (hidden @ w["w3"] + w["b3"])[..., 0]


if __name__ == "__main__":
    main(Neural)
