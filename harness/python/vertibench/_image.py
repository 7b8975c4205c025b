"""PNG images, with Pillow."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from ._errors import MissingPackageError


def encode_png(rgb: np.ndarray) -> bytes:
    """Encodes an image of shape (height, width, 3), uint8, as PNG."""
    file = io.BytesIO()
    _pillow("images").fromarray(rgb).save(file, "PNG")
    return file.getvalue()


def read_grey16(data: bytes, rows: int, cols: int) -> np.ndarray:
    """Returns the levels of a 16-bit greyscale PNG as uint16, row 0 at the top.

    Raises `ValueError` if the data is no complete image of this type and size.
    """
    image = _pillow("elevation maps of worlds")
    try:
        # The size is known before any pixel is unpacked.
        with image.open(io.BytesIO(data), formats=["PNG"]) as opened:
            if opened.size != (cols, rows):
                raise ValueError(f"{opened.height} x {opened.width} pixels, world.yaml has {rows} x {cols}")
            # Versions of Pillow differ in the mode of 16-bit images.
            if not opened.mode.startswith("I"):
                raise ValueError("no 16-bit greyscale image")
            # Compares the checksums of all parts; `load` doesn't.
            opened.verify()
        with image.open(io.BytesIO(data), formats=["PNG"]) as opened:
            return np.asarray(opened).astype(np.uint16)
    except image.UnidentifiedImageError:
        raise ValueError("no PNG image") from None
    except (OSError, SyntaxError, image.DecompressionBombError) as e:
        raise ValueError(f"the image is truncated or damaged: {e}") from None


def _pillow(what_for: str) -> Any:
    try:
        import PIL.Image
    except ImportError:
        raise MissingPackageError("pillow", what_for) from None
    return PIL.Image
