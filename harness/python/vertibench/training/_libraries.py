"""Imports stable-baselines3 and torch; raises `MissingPackageError` with the extra that installs them."""

from __future__ import annotations

from .._errors import MissingPackageError

try:
    import stable_baselines3 as stable_baselines3
    import torch as torch
except ImportError as e:
    raise MissingPackageError(e.name or "stable-baselines3", "vertibench.training", "train") from e
