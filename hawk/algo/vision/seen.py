"""What Vision App says about one frame, in metres of the map frame."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hawk.model import MapPose

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class GroundImage:
    """A raster that lies on the ground plane.

    ``values`` is (H, W) or (H, W, C). ``to_map`` is (2, 3): ``to_map @ (col, row, 1)`` is (north, east) in metres of
    the *centre* of pixel (col, row) — whole numbers are pixel centres, as in OpenCV, so the picture covers
    [-0.5, W - 0.5) x [-0.5, H - 0.5). ``valid`` is (H, W): False where the camera saw nothing.
    """

    values: NDArray[Any] = field(repr=False)
    to_map: FloatArray
    valid: NDArray[np.bool_] = field(repr=False)

    @property
    def metres_per_pixel(self) -> float:
        """Side of a pixel on the ground, metres."""
        return float(np.hypot(self.to_map[0, 0], self.to_map[1, 0]))

    def map_points(self, pixels: FloatArray) -> FloatArray:
        """Return (..., 2) of (north, east) for (..., 2) of (col, row)."""
        return np.asarray(pixels @ self.to_map[:, :2].T + self.to_map[:, 2])

    def pixel_points(self, points: FloatArray) -> FloatArray:
        """Return (..., 2) of (col, row) for (..., 2) of (north, east)."""
        return np.asarray((points - self.to_map[:, 2]) @ np.linalg.inv(self.to_map[:, :2]).T)


@dataclass(frozen=True, slots=True)
class StallSeen:
    """A stall found in one frame: an oriented rectangle on the ground.

    ``angle`` is the direction of the long side in [0, pi), clockwise from north; ``score`` how sure it is to be a stall
    and ``taken`` how likely it is taken (0..1); ``visible`` the share of it that lies in the valid picture (0..1).
    """

    north: float
    east: float
    angle: float
    width: float
    length: float
    score: float
    taken: float
    visible: float


@dataclass(frozen=True, slots=True)
class Seen:
    """Everything that one frame says.

    ``lot``, ``car`` and ``core`` are float32 probabilities (0..1) at 0.2 m: parking lot, car, inner part of a stall.
    ``picture`` is the rectified frame, uint8 BGR at 0.1 m. ``scale`` is the size of the found stalls relative to the
    usual one (1.0 where too few are seen to tell). ``captured`` is seconds of the daemon's clock.
    """

    stalls: tuple[StallSeen, ...]
    lot: GroundImage
    car: GroundImage
    core: GroundImage
    picture: GroundImage
    park_lot_detected: bool
    scale: float
    pose: MapPose
    captured: float
