"""Starts the example node on simulated time."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration

NODE = str(Path(__file__).resolve().parent / "follow_plan.py")


def generate_launch_description():
    """The node with its parameters as arguments: `speed:=2.0 look_ahead:=6.0`."""
    return LaunchDescription(
        [
            DeclareLaunchArgument("speed", default_value="3.0", description="m/s"),
            DeclareLaunchArgument("look_ahead", default_value="8.0", description="m"),
            ExecuteProcess(
                cmd=[
                    "python3", NODE, "--ros-args",
                    "-p", "use_sim_time:=true",
                    "-p", ["speed:=", LaunchConfiguration("speed")],
                    "-p", ["look_ahead:=", LaunchConfiguration("look_ahead")],
                ],
                output="screen",
            ),
        ]
    )
