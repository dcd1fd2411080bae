"""Pictures: the camera that takes them, the one that operators see, and the motion over ground that they witness."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]

CAMERA_TO_BODY: Final = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""Axes of a camera that looks straight down (x right, y down in the picture, z ahead) in the body's."""


def rotation(roll: float, pitch: float, yaw: float) -> Matrix:
    """Return Rz(yaw) Ry(pitch) Rx(roll), (3, 3): turns body FRD vectors into NED."""
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def rotations(attitudes: Matrix) -> Matrix:
    """Return the `rotation` (N, 3, 3) of each roll, pitch, yaw (N, 3)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(attitudes).T, np.sin(attitudes).T
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def angles(matrix: Matrix) -> tuple[float, float, float]:
    """Return roll, pitch, yaw of a `rotation` (3, 3)."""
    pitch = -math.asin(min(1.0, max(-1.0, float(matrix[2, 0]))))
    return math.atan2(matrix[2, 1], matrix[2, 2]), pitch, math.atan2(matrix[1, 0], matrix[0, 0])


@dataclass(frozen=True, slots=True)
class CameraModel:
    """Pinhole camera with radial-tangential distortion (ROS ``plumb_bob``) and its mount.

    ``fx, fy, cx, cy`` in pixels of a ``width`` x ``height`` picture; ``distortion`` is k1, k2, p1, p2, k3. Mount angles
    (radians) turn the camera away from looking straight down with the picture's top towards the nose.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, ...] = ()
    mount_roll: float = 0.0
    mount_pitch: float = 0.0
    mount_yaw: float = 0.0


@dataclass(frozen=True, slots=True)
class AnnotatedFrame:
    """An annotated picture for the operators; ``captured`` is seconds of the daemon's clock."""

    sequence: int
    captured: float
    jpeg: bytes = field(repr=False)


@dataclass(frozen=True, slots=True)
class StallSize:
    """``time``: exposure, seconds of the daemon's clock. ``height``: reported, over ground, metres.

    ``width``: the usual one of the stalls that the picture shows whole, metres by that height.
    """

    time: float
    width: float
    height: float


@dataclass(frozen=True, slots=True)
class GroundAgain:
    """Ground that was seen before, in the picture at ``since`` (daemon's clock, seconds).

    ``beyond`` is what the drone has moved since then by the two pictures and the poses do not report, ``reported`` what
    they report: metres north and east. ``yawed`` is the reported turn, radians clockwise.
    """

    since: float
    beyond: tuple[float, float]
    reported: tuple[float, float]
    yawed: float


@dataclass(frozen=True, slots=True)
class GroundStep:
    """From the exposure at ``since`` to that at ``until`` (daemon's clock, seconds).

    ``seen`` is the drone's movement by the pictures, at the reported height over ground, and ``reported`` that by the
    poses: metres north and east. ``stretch`` is the logarithm of the factor by which the same ground has become larger
    at the reported heights: positive while the drone sinks and its height does not show it. ``turn`` is how far the
    drone turned, clockwise, beyond what its heading shows, radians. ``height`` is the reported one over ground at
    ``until``, metres. Steps one after the other are measured against the same earlier picture where they can be: their
    errors do not add up then.
    """

    since: float
    until: float
    seen: tuple[float, float]
    reported: tuple[float, float]
    stretch: float
    turn: float
    height: float
    again: GroundAgain | None = None
    """The comparison of the picture at ``until`` with one of long before, where ground is seen again."""

    @property
    def beyond(self) -> tuple[float, float]:
        """Movement that the poses do not report, metres north and east."""
        return self.seen[0] - self.reported[0], self.seen[1] - self.reported[1]
