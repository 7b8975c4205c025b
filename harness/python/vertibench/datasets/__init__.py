"""Reader for the datasets of `vb-harness dataset`, with NumPy arrays.

>>> from vertibench import datasets
>>> train, held_out = datasets.open("explore").split(train=0.8, seed=0)
>>> for episode, frames in zip(train.episodes, train):
...     print(episode.world, episode.outcome, frames["observation.state"].shape)

Units are SI and angles radians. World axes are x east, y north, z up; body axes are x forward, y left, z up.
docs/datasets.md of the repository describes the files and their columns.
"""

from ._dataset import Column, Dataset, Episode, Info, open
from ._errors import DatasetError
from ._minari import to_minari
from ._world import CLASSES, Obstacle, World

__all__ = [
    "CLASSES",
    "Column",
    "Dataset",
    "DatasetError",
    "Episode",
    "Info",
    "Obstacle",
    "World",
    "open",
    "to_minari",
]
