#!/usr/bin/env python3
"""Sends each goal of /goal_pose to Nav2 until Nav2 accepts it: its servers activate after the first ticks of the first task."""

import rclpy
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import NavigateToPose
from rclpy.action import ActionClient
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# Wall-clock time between two attempts, s.
RETRY = 0.5


class SendGoal(Node):
    """The goal of the running task, as an action of Nav2."""

    def __init__(self):
        super().__init__("send_goal")
        self.goal = None
        self.waits = False
        self.client = ActionClient(self, NavigateToPose, "navigate_to_pose")
        self.create_subscription(PoseStamped, "/goal_pose", self.on_goal, LATCHED)
        self.create_timer(RETRY, self.send, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def on_goal(self, message):
        """A new task."""
        self.goal = message
        self.send()

    def send(self):
        """Sends a goal that has not been accepted."""
        if self.goal is None or self.waits or not self.client.server_is_ready():
            return
        goal = self.goal
        self.waits = True
        answer = self.client.send_goal_async(NavigateToPose.Goal(pose=goal))
        answer.add_done_callback(lambda future: self.on_answer(goal, future.result().accepted))

    def on_answer(self, goal, accepted):
        """Nav2 accepted or rejected the goal."""
        self.waits = False
        if accepted and self.goal is goal:
            self.goal = None


def main():
    """Runs the node until it is stopped."""
    rclpy.init()
    node = SendGoal()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
