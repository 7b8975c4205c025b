#!/usr/bin/env python3
"""A planner on Cyclone DDS, without ROS: pure pursuit of /plan from /odom, with a command on /cmd_vel at each time of /clock.

Needs `pip install cyclonedds` only. The arithmetic has no functions whose last bits differ between libraries: a test compares its drives with
those of the same planner in Rust.
"""

import argparse
import os
import time
from dataclasses import dataclass, field

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--domain", type=int, default=int(os.environ.get("ROS_DOMAIN_ID") or 0), help="DDS domain; default: ROS_DOMAIN_ID, or 0")
parser.add_argument("--seconds", type=float, default=float("inf"), help="wall-clock time after which it ends; default: when it is stopped")
parser.add_argument("--step", action="store_true", help="after the first command, call the service /vertibench/step instead of commanding")
args = parser.parse_args()

# Loopback only, as the harness.
os.environ["CYCLONEDDS_URI"] = """<CycloneDDS><Domain>
  <General><Interfaces><NetworkInterface address="127.0.0.1" multicast="false"/></Interfaces><AllowMulticast>false</AllowMulticast></General>
  <Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers></Discovery>
</Domain></CycloneDDS>"""

from cyclonedds.core import Policy, Qos, ReadCondition, SampleState, ViewState, InstanceState, WaitSet
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float64, int32, int64, sequence, uint8, uint32, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32 = 0
    nanosec: uint32 = 0


@dataclass
class Clock(IdlStruct, typename="rosgraph_msgs::msg::dds_::Clock_"):
    clock: Time = field(default_factory=Time)


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time = field(default_factory=Time)
    frame_id: str = ""


@dataclass
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0


@dataclass
class Point(IdlStruct, typename="geometry_msgs::msg::dds_::Point_"):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0


@dataclass
class Quaternion(IdlStruct, typename="geometry_msgs::msg::dds_::Quaternion_"):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0
    w: float64 = 1.0


@dataclass
class Pose(IdlStruct, typename="geometry_msgs::msg::dds_::Pose_"):
    position: Point = field(default_factory=Point)
    orientation: Quaternion = field(default_factory=Quaternion)


@dataclass
class PoseStamped(IdlStruct, typename="geometry_msgs::msg::dds_::PoseStamped_"):
    header: Header = field(default_factory=Header)
    pose: Pose = field(default_factory=Pose)


@dataclass
class Path(IdlStruct, typename="nav_msgs::msg::dds_::Path_"):
    header: Header = field(default_factory=Header)
    poses: sequence[PoseStamped] = field(default_factory=list)


@dataclass
class Twist(IdlStruct, typename="geometry_msgs::msg::dds_::Twist_"):
    linear: Vector3 = field(default_factory=Vector3)
    angular: Vector3 = field(default_factory=Vector3)


@dataclass
class TwistStamped(IdlStruct, typename="geometry_msgs::msg::dds_::TwistStamped_"):
    header: Header = field(default_factory=Header)
    twist: Twist = field(default_factory=Twist)


@dataclass
class PoseWithCovariance(IdlStruct, typename="geometry_msgs::msg::dds_::PoseWithCovariance_"):
    pose: Pose = field(default_factory=Pose)
    covariance: array[float64, 36] = field(default_factory=lambda: [0.0] * 36)


@dataclass
class TwistWithCovariance(IdlStruct, typename="geometry_msgs::msg::dds_::TwistWithCovariance_"):
    twist: Twist = field(default_factory=Twist)
    covariance: array[float64, 36] = field(default_factory=lambda: [0.0] * 36)


@dataclass
class Odometry(IdlStruct, typename="nav_msgs::msg::dds_::Odometry_"):
    header: Header = field(default_factory=Header)
    child_frame_id: str = ""
    pose: PoseWithCovariance = field(default_factory=PoseWithCovariance)
    twist: TwistWithCovariance = field(default_factory=TwistWithCovariance)


# Cyclone's middleware of ROS 2 puts the caller and a number before requests and replies.
@dataclass
class TriggerRequest(IdlStruct, typename="std_srvs::srv::dds_::Trigger_Request_"):
    guid: uint64 = 0
    sequence: int64 = 0
    nothing: uint8 = 0


@dataclass
class TriggerResponse(IdlStruct, typename="std_srvs::srv::dds_::Trigger_Response_"):
    guid: uint64 = 0
    sequence: int64 = 0
    success: bool = False
    message: str = ""


RELIABLE = [
    Policy.Reliability.Reliable(duration(seconds=1)),
    Policy.History.KeepLast(100),
    Policy.DataRepresentation(use_cdrv0_representation=True),
]
LIVE = Qos(*RELIABLE)
LATCHED = Qos(*RELIABLE, Policy.Durability.TransientLocal)

# Speed, m/s, and look-ahead distance, m.
SPEED = 3.0
LOOK_AHEAD = 8.0
# The clocks of two tasks are this far apart, s.
TASKS_APART = 10_000
# In requests to the service.
CALLER = 7


class Pursuit:
    """The velocity and the yaw rate towards the first point of the path that is at least LOOK_AHEAD away."""

    def __init__(self, path):
        self.points = [(p.pose.position.x, p.pose.position.y) for p in path.poses]
        self.nearest = 0
        self.start = path.header.stamp

    def is_for(self, now):
        """Whether the path is that of the task to which a time belongs."""
        return 0 <= now.sec - self.start.sec < TASKS_APART

    def distance(self, k, x, y):
        dx, dy = self.points[k][0] - x, self.points[k][1] - y
        return dx * dx + dy * dy

    def follow(self, odometry):
        place, q = odometry.pose.pose.position, odometry.pose.pose.orientation
        last = len(self.points) - 1
        while self.nearest < last and self.distance(self.nearest + 1, place.x, place.y) <= self.distance(self.nearest, place.x, place.y):
            self.nearest += 1
        goal = self.nearest
        while goal < last and self.distance(goal, place.x, place.y) < LOOK_AHEAD * LOOK_AHEAD:
            goal += 1
        dx, dy = self.points[goal][0] - place.x, self.points[goal][1] - place.y
        along, left = 1.0 - 2.0 * (q.y * q.y + q.z * q.z), 2.0 * (q.x * q.y + q.w * q.z)
        square = dx * dx + dy * dy
        curvature = 2.0 * (along * dy - left * dx) / square if square > 0.0 else 0.0
        return SPEED, SPEED * curvature


def main():
    """Runs all tasks, one after the other."""
    participant = DomainParticipant(args.domain)

    def reader(name, kind, qos):
        return DataReader(participant, Topic(participant, name, kind, qos=qos), qos=qos)

    def writer(name, kind, qos):
        return DataWriter(participant, Topic(participant, name, kind, qos=qos), qos=qos)

    clock = reader("rt/clock", Clock, LIVE)
    odom = reader("rt/odom", Odometry, LIVE)
    plan = reader("rt/plan", Path, LATCHED)
    replies = reader("rr/vertibench/stepReply", TriggerResponse, LIVE)
    commands = writer("rt/cmd_vel", TwistStamped, LIVE)
    calls = writer("rq/vertibench/stepRequest", TriggerRequest, LIVE)
    new_data = WaitSet(participant)
    for source in (clock, odom, plan, replies):
        new_data.attach(ReadCondition(source, ViewState.Any | InstanceState.Any | SampleState.NotRead))

    pursuit, odometry, now, answered, called = None, None, None, None, 0
    started = time.monotonic()
    while time.monotonic() - started < args.seconds:
        new_data.wait(duration(milliseconds=100))
        # A sample without data reports that its writer has left.
        for message in (m for m in plan.take(10) if isinstance(m, Path)):
            pursuit, answered = Pursuit(message), None
            if now != pursuit.start:
                now = None
        for message in (m for m in odom.take(100) if isinstance(m, Odometry)):
            odometry = message
        for message in (m for m in clock.take(100) if isinstance(m, Clock)):
            now = message.clock
        replied = [r for r in replies.take(100) if isinstance(r, TriggerResponse) and r.guid == CALLER]
        assert all(r.success and r.message.startswith("t = ") for r in replied), replied
        if now is None or now == answered or odometry is None or odometry.header.stamp != now:
            continue
        # The topics of a tick and the path of the next task are received in any order.
        if pursuit is None or not pursuit.is_for(now):
            continue
        # The clock has gone back: another run begins, and its path is still to come.
        if answered is not None and (now.sec, now.nanosec) < (answered.sec, answered.nanosec):
            continue
        answered = now
        if args.step and called > 0:
            calls.write(TriggerRequest(CALLER, called, 0))
        else:
            speed, rate = pursuit.follow(odometry)
            commands.write(TwistStamped(Header(now, "base_link"), Twist(Vector3(speed), Vector3(0.0, 0.0, rate))))
        called += 1


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
