"""Movement of the picture between two frames: as the drone's poses make it, and as the pictures show it.

Both are of the picture itself, in the camera's own axes: z = x + iy (x right, y down), in focal lengths. A camera that
is turned about its optical axis turns the measured movement against the expected one, whatever the drone's attitude; a
camera that mirrors its picture mirrors it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.rectify import camera_to_ned, intrinsics, scaled_camera
from hawk.model.pictures import CameraModel
from hawk.model.poses import MapPose

_WIDTH = 320  # pixels of the pictures that are compared
_FEATURES = 300
_FEATURE = {"patchSize": 25, "edgeThreshold": 15, "nlevels": 3, "fastThreshold": 7}
_OUTLIER = 2.0  # pixels
_LEAST = 12  # features that agree
_LEAST_SHARE = 0.3
_STEP = 1e-3
_FLATTEST = 0.1  # sine of the lowest elevation at which the optical axis meets the ground


@dataclass(frozen=True, slots=True)
class Motion:
    """``shift`` of the ground on the optical axis, focal lengths; ``turn`` of the picture, radians from x to y."""

    shift: complex
    turn: float


@dataclass(frozen=True, slots=True)
class Features:
    """Points (N, 2) of a picture, in focal lengths from the optical axis, and their descriptors (N, 32)."""

    points: NDArray[np.float32] = field(repr=False)
    descriptors: NDArray[np.uint8] = field(repr=False)
    pixel: float
    """Size of a pixel, focal lengths."""


def find_features(image: NDArray[np.uint8], camera: CameraModel) -> Features:
    """Return the features of a picture, BGR (H, W, 3); the lens distortion is taken out.

    They are ORB features (Rublee et al., 2011), which are found again wherever and however turned they are.
    """
    small = shrunk(image)
    orb = cv2.ORB.create(_FEATURES, **_FEATURE)
    return features_at(small, orb, orb.detect(small, None), camera)


def shrunk(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return a picture, BGR (H, W, 3), as it is compared: grey and small."""
    height = max(1, round(image.shape[0] * _WIDTH / image.shape[1]))
    resized = cv2.resize(image, (_WIDTH, height), interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.cvtColor(resized, cv2.COLOR_BGR2GRAY), np.uint8)


def features_at(small: NDArray[np.uint8], orb: cv2.ORB, keys: Sequence[cv2.KeyPoint], camera: CameraModel) -> Features:
    """Return the features of a small picture at its key points."""
    keys, descriptors = orb.compute(small, keys)
    scaled = scaled_camera(camera, small.shape[1], small.shape[0])
    if not keys:
        return Features(np.zeros((0, 2), np.float32), np.zeros((0, 32), np.uint8), 1 / scaled.fx)
    distortion = np.array(scaled.distortion or (0.0,) * 5)
    seen = np.array([[key.pt] for key in keys], np.float32)
    rays = cv2.undistortPoints(seen, intrinsics(scaled), distortion).reshape(-1, 2)
    return Features(np.asarray(rays, np.float32), np.asarray(descriptors, np.uint8), 1 / scaled.fx)


def expected_motion(camera: CameraModel, before: MapPose, now: MapPose) -> Motion | None:
    """Return the movement of the picture over level ground between two poses; None where the axis meets no ground."""
    shift, right, down = (_seen_again(camera, before, now, at) for at in (0j, _STEP + 0j, _STEP * 1j))
    if shift is None or right is None or down is None:
        return None
    across, along = (right - shift) / _STEP, (down - shift) / _STEP
    return Motion(shift, math.atan2(across.imag - along.real, across.real + along.imag))


def measured_motion(before: Features, now: Features) -> Motion | None:
    """Return the movement between two pictures: the similarity that most features agree on; None without one.

    RANSAC (Fischler and Bolles, 1981) over features that are each other's nearest by their descriptors.
    """
    if min(len(before.points), len(now.points)) < _LEAST:
        return None
    matches = cv2.BFMatcher(cv2.NORM_HAMMING, crossCheck=True).match(before.descriptors, now.descriptors)
    if len(matches) < _LEAST:
        return None
    first = before.points[[match.queryIdx for match in matches]]
    second = now.points[[match.trainIdx for match in matches]]
    fit, agree = cv2.estimateAffinePartial2D(first, second, ransacReprojThreshold=_OUTLIER * now.pixel, maxIters=500)
    if fit is None or np.count_nonzero(agree) < max(_LEAST, _LEAST_SHARE * len(matches)):
        return None
    return Motion(complex(fit[0, 2], fit[1, 2]), math.atan2(fit[1, 0], fit[0, 0]))


def _seen_again(camera: CameraModel, before: MapPose, now: MapPose, at: complex) -> complex | None:
    """Return where ground that was seen at ``at`` is seen from the other pose; None where there is none."""
    ray = camera_to_ned(camera, before) @ (at.real, at.imag, 1.0)
    if ray[2] <= _FLATTEST * np.linalg.norm(ray):
        return None
    north, east, _ = ray * before.height / ray[2]
    offset = (before.north + north - now.north, before.east + east - now.east, now.height)
    x, y, ahead = camera_to_ned(camera, now).T @ offset
    return None if ahead <= 0 else complex(x / ahead, y / ahead)
