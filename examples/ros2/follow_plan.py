#!/usr/bin/env python3
"""Follows /plan with pure pursuit, and answers each tick of /clock with one command."""

import math

import rclpy
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry, Path
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock

RELIABLE = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)

# The clocks of two tasks are this far apart, s.
TASKS_APART = 10_000


def seconds(time):
    """A time as two numbers that are compared one after the other."""
    return time.sec, time.nanosec


class FollowPlan(Node):
    """Pure pursuit in lockstep: a command is sent when odometry and clock have the same, new time."""

    def __init__(self):
        super().__init__("follow_plan")
        self.speed = self.declare_parameter("speed", 3.0).value
        self.look_ahead = self.declare_parameter("look_ahead", 8.0).value
        self.path = []
        self.start = None
        self.nearest = 0
        self.odometry = None
        self.now = None
        self.answered = None
        self.commands = self.create_publisher(TwistStamped, "/cmd_vel", RELIABLE)
        self.create_subscription(Path, "/plan", self.on_plan, LATCHED)
        self.create_subscription(Odometry, "/odom", self.on_odometry, RELIABLE)
        self.create_subscription(Clock, "/clock", self.on_clock, RELIABLE)

    def on_plan(self, message):
        """A new task."""
        self.start = message.header.stamp
        self.path = [(p.pose.position.x, p.pose.position.y) for p in message.poses]
        self.nearest = 0
        self.answered = None
        if self.now != self.start:
            self.now = None

    def on_odometry(self, message):
        """The pose of a tick."""
        self.odometry = message
        self.answer()

    def on_clock(self, message):
        """The last message of a tick, though it may come before the others."""
        self.now = message.clock
        self.answer()

    def answer(self):
        """Answers the tick once all of it is there. A tick that is repeated has been answered."""
        if not self.path or self.odometry is None or self.now is None:
            return
        # The path is that of the last task until the next one comes.
        if not 0 <= self.now.sec - self.start.sec < TASKS_APART:
            return
        if self.odometry.header.stamp != self.now or self.now == self.answered:
            return
        # The clock has gone back: another run begins, and its path is still to come.
        if self.answered is not None and seconds(self.now) < seconds(self.answered):
            return
        command = TwistStamped()
        command.header.stamp = self.now
        command.header.frame_id = "base_link"
        command.twist.linear.x = self.speed
        command.twist.angular.z = self.speed * self.curvature()
        self.answered = self.now
        self.commands.publish(command)

    def curvature(self):
        """The curvature of the circle to the point of the path that is `look_ahead` away, 1/m, positive to the left."""
        pose = self.odometry.pose.pose
        x, y, q = pose.position.x, pose.position.y, pose.orientation

        def distance(k):
            return math.hypot(self.path[k][0] - x, self.path[k][1] - y)

        last = len(self.path) - 1
        while self.nearest < last and distance(self.nearest + 1) <= distance(self.nearest):
            self.nearest += 1
        goal = self.nearest
        while goal < last and distance(goal) < self.look_ahead:
            goal += 1
        dx, dy = self.path[goal][0] - x, self.path[goal][1] - y
        if dx == 0.0 and dy == 0.0:
            return 0.0
        along, left = 1.0 - 2.0 * (q.y * q.y + q.z * q.z), 2.0 * (q.x * q.y + q.w * q.z)
        return 2.0 * (along * dy - left * dx) / (dx * dx + dy * dy)


def main():
    """Runs the node until it is stopped."""
    rclpy.init()
    node = FollowPlan()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
