"""Verti-Bench in Rust, for Python: the program, its tasks and planners, and datasets (`vertibench.datasets`)."""

from ._errors import MissingError, VertiBenchError
from ._program import harness_path, plugin_path, plugins_path, tasks_path

__all__ = ["MissingError", "VertiBenchError", "harness_path", "plugin_path", "plugins_path", "tasks_path"]
__version__ = "0.2.0"
