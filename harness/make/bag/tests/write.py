"""Writes a bag of ROS 2 with rosbags: a drive of 5 s on a circle of 5 m at 0.4 rad/s, with odometry at 20 Hz and joint states at 50 Hz.

Arguments: the folder of the bag, and "none" or "zstd".
"""

import math
import sys

import numpy as np
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

store = get_typestore(Stores.ROS2_JAZZY)
types = store.types
Time, Header = types["builtin_interfaces/msg/Time"], types["std_msgs/msg/Header"]
Odometry, JointState = types["nav_msgs/msg/Odometry"], types["sensor_msgs/msg/JointState"]
Point, Quaternion, Vector3 = (types[f"geometry_msgs/msg/{name}"] for name in ("Point", "Quaternion", "Vector3"))
Pose, PoseWithCovariance = types["geometry_msgs/msg/Pose"], types["geometry_msgs/msg/PoseWithCovariance"]
Twist, TwistWithCovariance = types["geometry_msgs/msg/Twist"], types["geometry_msgs/msg/TwistWithCovariance"]
EPOCH = 1_700_000_000
RADIUS, RATE = 5.0, 0.4


def header(time, frame):
    return Header(stamp=Time(sec=EPOCH + int(time), nanosec=round(time % 1 * 1e9)), frame_id=frame)


def odometry(time):
    yaw = RATE * time
    place = Point(x=RADIUS * math.sin(yaw), y=RADIUS * (1 - math.cos(yaw)), z=0.3)
    turned = Quaternion(x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2))
    none = Vector3(x=0.0, y=0.0, z=0.0)
    return Odometry(
        header=header(time, "odom"),
        child_frame_id="base_link",
        pose=PoseWithCovariance(pose=Pose(position=place, orientation=turned), covariance=np.zeros(36)),
        twist=TwistWithCovariance(twist=Twist(linear=none, angular=none), covariance=np.zeros(36)),
    )


def joints(time):
    names = ["front_left_wheel", "front_right_wheel", "rear_left_wheel", "rear_right_wheel"]
    empty = np.zeros(0)
    return JointState(header=header(time, ""), name=names, position=empty, velocity=np.array([2.0, 3.0, 4.0, 5.0]), effort=empty)


writer = Writer(sys.argv[1], version=9, storage_plugin=StoragePlugin.MCAP)
if sys.argv[2] == "zstd":
    writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
with writer:
    for topic, kind, message, rate in (("/odom", Odometry.__msgtype__, odometry, 20), ("/joint_states", JointState.__msgtype__, joints, 50)):
        connection = writer.add_connection(topic, kind, typestore=store)
        for k in range(5 * rate + 1):
            time = k / rate
            writer.write(connection, EPOCH * 1_000_000_000 + round(time * 1e9), store.serialize_cdr(message(time), kind))
