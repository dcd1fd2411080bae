"""Name of a network: the first digits of its file's SHA-256. It loads no library of vision."""

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


def packaged_file() -> bytes:
    """Return the ONNX file that comes with the package. Raises OSError."""
    return resources.files("hawk.algo.vision").joinpath(*_WEIGHTS).read_bytes()


@functools.cache
def network_name(model: Path | None) -> str:
    """Return the name of a network's ONNX file, None for the one in the package; `UNKNOWN` if it cannot be read."""
    try:
        weights = packaged_file() if model is None else model.read_bytes()
    except OSError:
        return UNKNOWN
    return hashlib.sha256(weights).hexdigest()[:_DIGITS]
