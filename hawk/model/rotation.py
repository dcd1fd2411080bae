"""Rotations of body and camera: right-handed axes x ahead, y right, z down (FRD, NED); angles in radians."""

from __future__ import annotations

import math
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


def angles(matrix: Matrix) -> tuple[float, float, float]:
    """Return roll, pitch, yaw of a `rotation` (3, 3)."""
    pitch = -math.asin(min(1.0, max(-1.0, float(matrix[2, 0]))))
    return math.atan2(matrix[2, 1], matrix[2, 2]), pitch, math.atan2(matrix[1, 0], matrix[0, 0])
