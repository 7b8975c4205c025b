"""Weight files in the format of `vb_sdk::nn`."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from ._config import TrainingError

_FIRST = "vb-nn: 1"


@dataclass(frozen=True)
class Layer:
    """Layer of a network.

    Attributes:
        line: Line of the file's header that declares the layer.
        weights: Weights, float32; of a dense layer (outputs, inputs), of a convolution (outputs, inputs, rows,
            columns).
        bias: Bias, float32, shape (outputs,).
    """

    line: str
    weights: np.ndarray
    bias: np.ndarray


@dataclass(frozen=True)
class Weights:
    """Layers of networks with metadata. `bytes(weights)` returns the content of a weight file.

    Attributes:
        notes: Metadata by key.
        layers: Layers, in the order of the file.
    """

    notes: dict[str, str]
    layers: list[Layer]

    def __bytes__(self) -> bytes:
        head = [_FIRST, *(f"{key}: {value}" for key, value in self.notes.items()), *(layer.line for layer in self.layers)]
        numbers = [n.astype("<f4").tobytes() for layer in self.layers for n in (layer.weights, layer.bias)]
        return "\n".join([*head, "", ""]).encode() + b"".join(numbers)


def dense(name: str, weights: np.ndarray, bias: np.ndarray) -> Layer:
    """Returns a dense layer; weights have the shape (outputs, inputs)."""
    outputs, inputs = weights.shape
    return Layer(f"layer: {name} {inputs} {outputs}", weights, bias)


def convolution(name: str, cells: int, weights: np.ndarray, bias: np.ndarray, stride: int) -> Layer:
    """Returns a convolution over squares of `cells` × `cells`; weights have the shape (outputs, inputs, rows, columns)."""
    outputs, planes, kernel, _ = weights.shape
    return Layer(f"convolution: {name} {planes} {cells} {cells} {outputs} {kernel} {stride} 0", weights, bias)


def read_weights(path: str | PathLike[str]) -> tuple[dict[str, str], bytes]:
    """Reads the metadata of a weight file. The layers are not parsed; the harness validates them.

    Args:
        path: File that `export` has written.

    Returns:
        Metadata by key, and the whole content of the file.

    Raises:
        TrainingError: If the file can't be read, or is no weight file.
    """
    path = Path(path)
    try:
        content = path.read_bytes()
    except OSError as e:
        raise TrainingError(path, f"it can't be read: {e.strerror or e}", "give a file that `export` has written") from None
    head, found, _ = content.partition(b"\n\n")
    lines = head.decode("utf-8", "replace").splitlines()
    if not found or not lines or lines[0] != _FIRST:
        raise TrainingError(path, "not a weight file", "give a file that `export` has written")
    notes = dict(line.split(": ", 1) for line in lines[1:] if ": " in line)
    return notes, content
