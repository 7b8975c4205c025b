"""Starts Nav2's servers on the maps and transforms of the harness: no map server and no localisation, since the harness publishes both."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import ExecuteProcess
from launch_ros.actions import Node

FOLDER = Path(__file__).resolve().parent
PARAMETERS = str(FOLDER / "nav2_params.yaml")
SERVERS = {
    "nav2_planner": "planner_server",
    "nav2_controller": "controller_server",
    "nav2_behaviors": "behavior_server",
    "nav2_bt_navigator": "bt_navigator",
}
# nav2_goal.py sends the goals, with repetition.
REMAPPINGS = [("goal_pose", "goal_pose_of_rviz")]


def generate_launch_description():
    """The servers, the manager that activates them, and the node that sends the goals."""
    servers = [
        Node(package=package, executable=name, name=name, output="screen", parameters=[PARAMETERS], remappings=REMAPPINGS)
        for package, name in SERVERS.items()
    ]
    manager = Node(
        package="nav2_lifecycle_manager",
        executable="lifecycle_manager",
        name="lifecycle_manager_navigation",
        output="screen",
        parameters=[{"use_sim_time": True, "autostart": True, "node_names": list(SERVERS.values())}],
    )
    goals = ExecuteProcess(cmd=["python3", str(FOLDER / "nav2_goal.py"), "--ros-args", "-p", "use_sim_time:=true"], output="screen")
    return LaunchDescription([*servers, manager, goals])
