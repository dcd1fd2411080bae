"""Results of vision for one frame, in metres of the map frame, the interfaces that give them, the size of stalls."""

from __future__ import annotations

from dataclasses import dataclass, field
from statistics import median
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from hawk.algo.frame import FrameInput
from hawk.algo.topic_interface import AlgorithmTopicInterface, FrameCamera
from hawk.model.operation import Health
from hawk.model.pictures import StallSize
from hawk.model.poses import MapPose
from hawk.model.vehicles import VehicleKind

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class CameraView:
    """The camera's own picture, without the lens's distortion, at most twice as fine as `GroundImage` is.

    ``image`` is uint8 BGR. ``to_image`` (3, 3): ``to_image @ (north, east, 1)`` of ground in metres of the map is the
    place (col, row) in ``image``, homogeneous; whole numbers are pixel centres.
    """

    image: NDArray[np.uint8] = field(repr=False)
    to_image: FloatArray


@dataclass(frozen=True, slots=True)
class GroundImage:
    """A raster that lies on the ground plane.

    ``values`` is (H, W) or (H, W, C). ``to_map`` is (2, 3): ``to_map @ (col, row, 1)`` is (north, east) in metres of
    the *centre* of pixel (col, row) — whole numbers are pixel centres, as in OpenCV, so the picture covers
    [-0.5, W - 0.5) x [-0.5, H - 0.5). ``valid`` is (H, W): False where the camera saw nothing. ``view`` is the picture
    that the values were sampled from.
    """

    values: NDArray[Any] = field(repr=False)
    to_map: FloatArray
    valid: NDArray[np.bool_] = field(repr=False)
    view: CameraView | None = field(default=None, repr=False)

    @property
    def metres_per_pixel(self) -> float:
        """Side of a pixel on the ground, metres."""
        return float(np.hypot(self.to_map[0, 0], self.to_map[1, 0]))

    def map_points(self, pixels: FloatArray) -> FloatArray:
        """Return (..., 2) of (north, east) for (..., 2) of (col, row)."""
        return np.asarray(pixels @ self.to_map[:, :2].T + self.to_map[:, 2])

    def in_pixels(self, metres: tuple[float, float]) -> FloatArray:
        """Return a vector of (north, east) as (2,) along columns and rows, metres."""
        return np.asarray(np.linalg.solve(self.to_map[:, :2] / self.metres_per_pixel, np.asarray(metres)))

    def map_angle(self, angle: FloatArray) -> FloatArray:
        """Return directions (N,) of the map, [0, pi) clockwise from north, for those of pixels (atan2 of row, col)."""
        long = np.stack([np.cos(angle), np.sin(angle)], -1) @ self.to_map[:, :2].T
        return np.asarray(np.arctan2(long[:, 1], long[:, 0]) % np.pi)

    def pixel_points(self, points: FloatArray) -> FloatArray:
        """Return (..., 2) of (col, row) for (..., 2) of (north, east)."""
        return np.asarray((points - self.to_map[:, 2]) @ np.linalg.inv(self.to_map[:, :2]).T)


@dataclass(frozen=True, slots=True)
class Detection:
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
class Vehicle:
    """A vehicle found in one picture: an oriented rectangle on the ground, metres.

    ``angle`` and ``visible`` as of `Detection`; ``probability`` that it is one.
    """

    kind: VehicleKind
    north: float
    east: float
    angle: float
    width: float
    length: float
    probability: float
    visible: float


@dataclass(frozen=True, slots=True)
class Found:
    """Stalls of one rectified picture with float32 probabilities (0..1) at 0.2 m.

    ``lot`` is parking lot, ``car`` is car, ``core`` is the inner part of a stall, ``taken`` is that a stall there is
    taken. ``vehicles``: none of a network that does not know them.
    """

    stalls: tuple[Detection, ...]
    lot: GroundImage = field(repr=False)
    car: GroundImage = field(repr=False)
    core: GroundImage = field(repr=False)
    taken: GroundImage = field(repr=False)
    vehicles: tuple[Vehicle, ...] = field(default=(), kw_only=True)


@dataclass(frozen=True, slots=True)
class FrameGround(Found):
    """Ground part of one frame.

    ``picture`` is the rectified frame, uint8 BGR at 0.1 m; ``pose`` its pose; ``captured`` seconds of the daemon's
    clock. ``is_blurred``: measured in the picture (`hawk.algo.vision.blur`).
    """

    picture: GroundImage = field(repr=False)
    pose: MapPose
    captured: float
    is_blurred: bool = False


@dataclass(frozen=True, slots=True)
class VisionResult:
    """Vision's result for one frame.

    ``park_lot_detected`` is steady over single frames. ``image`` is the camera's picture, uint8 BGR, None when it could
    not be decoded; ``ground`` is None when the frame could not be projected onto the ground. ``is_damaged``: a part of
    the picture was lost in transit.
    """

    park_lot_detected: bool = False
    health: Health = field(default_factory=Health)
    image: NDArray[np.uint8] | None = field(default=None, repr=False)
    ground: FrameGround | None = field(default=None, repr=False)
    is_damaged: bool = False


class FrameVision(Protocol):
    """The Vision App as manager and mapper use it."""

    def init(self, drone_camera: FrameCamera, topic_interface: AlgorithmTopicInterface) -> None:
        """Take camera and topics."""
        ...

    def see(self, frame: FrameInput) -> VisionResult:
        """Return what a frame shows. Raises NoImage, AlgoError."""
        ...

    def fail(self, reason: str) -> VisionResult:
        """Return the result of a frame that failed."""
        ...

    def publish(self) -> None:
        """Publish the last result."""
        ...

    @property
    def seen(self) -> VisionResult:
        """The last result."""
        ...


LEAST_STALLS: Final = 6
WHOLE: Final = 0.95
"""Share of a stall that the picture must show."""


def stall_size(frame: FrameInput, seen: VisionResult) -> StallSize | None:
    """Return the usual size in this frame.

    None where fewer stalls than `LEAST_STALLS` are whole, and where a rangefinder gives the picture its scale: the
    reported height has no part in it then.
    """
    if seen.ground is None or frame.ground:
        return None
    widths = [stall.width for stall in seen.ground.stalls if stall.visible >= WHOLE]
    if len(widths) < LEAST_STALLS:
        return None
    return StallSize(frame.captured, median(widths), seen.ground.pose.height)
