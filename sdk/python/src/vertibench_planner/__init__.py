"""Planners for Verti-Bench in Rust as Python programs.

A planner is a class with ``init`` and ``step``::

    from vertibench_planner import Command, Planner, main

    class Stand(Planner):
        name = "stand"
        def step(self, obs):
            return Command(brake=1.0)

    main(Stand)

``vb-harness run "python3 stand.py"`` runs it. Such a planner is not ranked, because its process is not confined.

Units are SI and angles radians. World frame: x east, y north, z up, origin at the world's centre. Body frame: x
forward, y left, z up. Roll is positive with the right side down, pitch with the nose down, yaw counter-clockwise from
east.
"""

from ._data import (
    Command,
    DepthImage,
    DepthInfo,
    GnssFix,
    ImuSample,
    LidarInfo,
    LidarScan,
    LocalMap,
    Mount,
    Observation,
    Pose,
    Task,
    Vehicle,
    Wheel,
)
from ._methods import Grid
from ._path import Follower
from ._serve import Planner, main, serve

__all__ = [
    "Command",
    "DepthImage",
    "DepthInfo",
    "Follower",
    "GnssFix",
    "Grid",
    "ImuSample",
    "LidarInfo",
    "LidarScan",
    "LocalMap",
    "Mount",
    "Observation",
    "Planner",
    "Pose",
    "Task",
    "Vehicle",
    "Wheel",
    "main",
    "serve",
]
__version__ = "1.0.0rc1"
