"""Planners for Verti-Bench in Rust as Python programs.

A planner is a class with ``init`` and ``step``::

    from vertibench_planner import Command, Planner, main

    class Stand(Planner):
        name = "stand"
        def step(self, obs):
            return Command(brake=1.0)

    main(Stand)

``vb-harness --plugin "python3 stand.py"`` drives with it. Units are SI and angles radians. World frame: x east, y north,
z up, origin at the world's centre. Body frame: x forward, y left, z up.
"""

from ._data import Command, Grid, Observation, Task, Vehicle
from ._path import Follower
from ._serve import Planner, main, serve

__all__ = ["Command", "Follower", "Grid", "Observation", "Planner", "Task", "Vehicle", "main", "serve"]
__version__ = "0.1.0"
