"""Projection of ground from a first picture into a second one, for many pairs of pictures at once.

Frames and axes are those of `hawk.algo.vision.rectify`; poses are rows of north, east, height above the ground
(metres), roll, pitch, yaw (radians).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from hawk.model.pictures import CAMERA_TO_BODY

Floats = NDArray[np.float64]

_STEP = 1e-3


def rotations(angles: Floats) -> Floats:
    """Return Rz(yaw) Ry(pitch) Rx(roll), (N, 3, 3), of roll, pitch, yaw (N, 3), radians."""
    return np.asarray(Rotation.from_euler("ZYX", angles[:, ::-1]).as_matrix())


def mounted(angles: Floats) -> Floats:
    """Return (3, 3): the camera's axes in the body's, of the mount's roll, pitch, yaw (3,), radians."""
    return np.asarray(rotations(angles[None])[0] @ CAMERA_TO_BODY)


def carried(
    rays: Floats, before: Floats, now: Floats, mount: Floats, slope: tuple[float, float] = (0.0, 0.0)
) -> Floats:
    """Return where the second pictures show points of the ground, NaN where they do not: (P, K, 2), focal lengths.

    Args:
        rays: Points (P, K, 2) of the first pictures, focal lengths from the optical axis.
        before: Poses (P, 6) of the first pictures; their heights are those above the ground.
        now: Poses (P, 6) of the second pictures, heights above the same level.
        mount: `mounted`.
        slope: Rise of the ground to north and to east, metres per metre; about the place below each first picture.
    """
    first, second = rotations(before[:, 3:]) @ mount, rotations(now[:, 3:]) @ mount
    seen = np.concatenate([rays, np.ones((*rays.shape[:2], 1))], 2) @ first.transpose(0, 2, 1)
    reach = seen[..., 2] + seen[..., 0] * slope[0] + seen[..., 1] * slope[1]
    moved = np.column_stack([now[:, :2] - before[:, :2], before[:, 2] - now[:, 2]])
    with np.errstate(divide="ignore", invalid="ignore"):
        again = (seen * (before[:, 2, None] / reach)[..., None] - moved[:, None, :]) @ second
        shown = again[..., :2] / again[..., 2:]
    shown[(reach <= 0) | (again[..., 2] <= 0)] = np.nan
    return np.asarray(shown)


def motions(before: Floats, now: Floats, mount: Floats) -> tuple[NDArray[np.complex128], Floats]:
    """Return the expected movement of pictures: of the ground on the optical axis (N,), focal lengths, x + iy; and
    their turn (N,), radians. NaN where the axis meets no ground. As `hawk.algo.vision.odometry.expected_motion`.
    """
    corner = np.broadcast_to(np.array([[0.0, 0.0], [_STEP, 0.0], [0.0, _STEP]]), (len(before), 3, 2))
    shown = carried(corner, before, now, mount)
    shift, right, down = (shown[:, k, 0] + 1j * shown[:, k, 1] for k in range(3))
    across, along = (right - shift) / _STEP, (down - shift) / _STEP
    return shift, np.arctan2(across.imag - along.real, across.real + along.imag)
