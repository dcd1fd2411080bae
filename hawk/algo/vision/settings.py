"""Settings of the vision room."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class VisionSettings:
    """What a user may set.

    ``model``: an ONNX file of the user's own, None for the one in the package. ``use_network`` False: classical line
    geometry only. ``threads``: OpenCV's threads. Below ``minimum_height_m`` metres above the arm place pictures are
    shown but not looked at. ``minimum_stalls`` make a lot.
    """

    model: Path | None = None
    use_network: bool = True
    threads: int = 1
    minimum_height_m: float = 6.0
    minimum_stalls: int = 3
