"""Verti-Bench in Rust, for Python. See `vertibench.datasets`."""

__version__ = "0.2.0"
