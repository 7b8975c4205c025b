"""Files of weights, as `vb_sdk::nn` reads them."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from ._config import TrainingError

_FIRST = "vb-nn: 1"


@dataclass(frozen=True)
class Layer:
    """A layer: the line of the head that announces it, weights and bias."""

    line: str
    weights: np.ndarray
    bias: np.ndarray


@dataclass(frozen=True)
class Weights:
    """Networks with what is said of them."""

    notes: dict[str, str]
    layers: list[Layer]

    def __bytes__(self) -> bytes:
        head = [_FIRST, *(f"{key}: {value}" for key, value in self.notes.items()), *(layer.line for layer in self.layers)]
        numbers = [n.astype("<f4").tobytes() for layer in self.layers for n in (layer.weights, layer.bias)]
        return "\n".join([*head, "", ""]).encode() + b"".join(numbers)


def dense(name: str, weights: np.ndarray, bias: np.ndarray) -> Layer:
    """A dense layer, with a row of weights for each output."""
    outputs, inputs = weights.shape
    return Layer(f"layer: {name} {inputs} {outputs}", weights, bias)


def convolution(name: str, cells: int, weights: np.ndarray, bias: np.ndarray, stride: int) -> Layer:
    """A convolution over squares of cells, with weights by plane of output, plane of input, row and column."""
    outputs, planes, kernel, _ = weights.shape
    return Layer(f"convolution: {name} {planes} {cells} {cells} {outputs} {kernel} {stride} 0", weights, bias)


def read_weights(path: str | PathLike[str]) -> tuple[dict[str, str], bytes]:
    """What a file of weights says of them, and its bytes. The harness checks the rest of it."""
    path = Path(path)
    try:
        content = path.read_bytes()
    except OSError as e:
        raise TrainingError(path, f"it can't be read: {e.strerror or e}", "give a file that `export` has written") from None
    head, found, _ = content.partition(b"\n\n")
    lines = head.decode("utf-8", "replace").splitlines()
    if not found or not lines or lines[0] != _FIRST:
        raise TrainingError(path, "these are no weights", "give a file that `export` has written")
    notes = dict(line.split(": ", 1) for line in lines[1:] if ": " in line)
    return notes, content
