"""What pictures show along a way: the swath."""

from __future__ import annotations

from dataclasses import dataclass

from hawk.model import CameraModel


@dataclass(frozen=True, slots=True)
class Swath:
    """Ground in the good part of a picture, metres: ``width`` across the heading, ``depth`` along it."""

    width: float
    depth: float

    @classmethod
    def of(cls, camera: CameraModel, height: float, good_share: float) -> Swath:
        """Return the swath of a level camera at a height."""
        return cls(height * camera.width / camera.fx * good_share, height * camera.height / camera.fy * good_share)
