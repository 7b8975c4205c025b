"""The libraries that learning needs. What needs them imports this first, so that it is told how to get them where they are missing."""

from __future__ import annotations

from .._errors import MissingPackageError

try:
    import stable_baselines3 as stable_baselines3
    import torch as torch
except ImportError as e:
    raise MissingPackageError(e.name or "stable-baselines3", "vertibench.training", "train") from e
