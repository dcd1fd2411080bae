"""The file of a network (ONNX) and its name: the first digits of its SHA-256. It loads no library of vision."""

from __future__ import annotations

import functools
import hashlib
from importlib import resources
from pathlib import Path
from typing import Final

UNKNOWN: Final = "unknown"
"""Name of a network whose file cannot be read."""
_WEIGHTS: Final = ("weights", "lot.onnx")
_DIGITS: Final = 8


class VisionModelError(ValueError):
    """The network cannot be used; the text names the setting and the remedy."""


def packaged_weights() -> bytes:
    """Return the ONNX file that comes with the package. Raises VisionModelError when it is missing."""
    try:
        return resources.files("hawk.algo.vision").joinpath(*_WEIGHTS).read_bytes()
    except OSError as error:
        raise VisionModelError(
            "the network's file is missing from the package: install it again, or name your own in vision.model"
        ) from error


def read_weights(model: Path) -> bytes:
    """Return a user's ONNX file. Raises VisionModelError when it cannot be read."""
    try:
        return model.read_bytes()
    except OSError as error:
        raise VisionModelError(f"vision.model: {model} cannot be read: {error}; name an ONNX file") from error


@functools.cache
def network_name(model: Path | None) -> str:
    """Return the name of a network's ONNX file, None for the one in the package; `UNKNOWN` if it cannot be read."""
    try:
        weights = packaged_weights() if model is None else read_weights(model)
    except VisionModelError:
        return UNKNOWN
    return hashlib.sha256(weights).hexdigest()[:_DIGITS]
