"""What pictures show along a way: the swath."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hawk.model import CameraModel


@dataclass(frozen=True, slots=True)
class Swath:
    """Ground in the good part of a picture, metres: ``width`` across the heading, ``depth`` along it, from a height."""

    width: float
    depth: float
    height: float

    @property
    def reach(self) -> float:
        """Metres from the middle of the picture to a corner."""
        return math.hypot(self.width, self.depth) / 2

    @classmethod
    def of(cls, camera: CameraModel, height: float, good_share: float) -> Swath:
        """Return the swath of a level camera at a height."""
        scale = height * good_share
        return cls(scale * camera.width / camera.fx, scale * camera.height / camera.fy, height)
