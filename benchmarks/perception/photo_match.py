"""Photographs of one lot on the ground: levelled pictures, matched by features to the labelled photograph.

The ground is the plane of the lot: metres north and east of the point below the camera of the labelled photograph. A
photograph's pose follows from the ties of its features with that one's, since XMP gives the attitude of the aircraft to
some degrees only; labels are carried over by the homography of the same ties, which no error of the pose moves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from benchmarks.perception.photo_shots import Shot
from hawk.picture.orthophoto.tile_detector import GROUND_M
from hawk.picture.orthorectification import border_of, seen_by
from hawk.survey.accuracy import FloatArray

FEATURES: Final = 8000
RATIO: Final = 0.75
"""Greatest distance of a feature's descriptor by that of the second best (Lowe 2004)."""
GUIDED_RATIO: Final = 0.9
GUIDED_M: Final = 3.0
"""The same where a feature's place is known to this many metres."""
INLIER_M: Final = 0.3
LEAST_TIES: Final = 25
ATTITUDE_SIGMA: Final = math.radians(5)
HEADING_SIGMA: Final = math.radians(20)
TURNING_SIGMA: Final = 0.3
HEIGHT_SIGMA: Final = 0.05
"""Expected errors of what EXIF and XMP say of roll and pitch, heading, turning (radians, also a second) and height (a
share), by which they weigh beside the ties: those of the one flight that was measured.
"""
TIE_SIGMA_M: Final = 0.1


@dataclass(frozen=True, slots=True)
class Levelled:
    """A photograph on the ground, north up, `GROUND_M` a pixel. ``north`` and ``east`` are metres of the middle of its
    first pixel from the point below its camera; ``missing`` (H, W) is ground that it does not show.
    """

    image: NDArray[np.uint8] = field(repr=False)
    missing: NDArray[np.bool_] = field(repr=False)
    north: float
    east: float

    def points(self, pixels: FloatArray) -> FloatArray:
        """Return metres (N, 2) north and east of pixels (N, 2) (x, y)."""
        return np.column_stack([self.north - pixels[:, 1] * GROUND_M, self.east + pixels[:, 0] * GROUND_M])

    def corners(self, points: FloatArray) -> FloatArray:
        """Return metres (..., 2) (x right, y down) from the picture's upper left corner of points (..., 2)."""
        north, east = points[..., 0], points[..., 1]
        return np.stack([east - self.east, self.north - north], axis=-1) + GROUND_M / 2


@dataclass(frozen=True, slots=True)
class Features:
    """Pixels (N, 2) of a levelled picture as points of its photograph's ground, and their descriptors (N, 128)."""

    points: FloatArray = field(repr=False)
    descriptors: NDArray[np.float32] = field(repr=False)


@dataclass(frozen=True, slots=True)
class Carried:
    """A photograph placed over the labelled one. ``shot`` has the attitude and ``height_m`` the height that the ties
    give; ``foot`` is the point of the common ground below its camera; ``homography`` (3, 3) carries the common ground
    to points about that foot; ``ties`` (N, 2) are the points of the common ground that were found in the photograph,
    ``residual_m`` is their median distance from where the homography carries them.
    """

    shot: Shot
    height_m: float
    foot: FloatArray
    homography: FloatArray = field(repr=False)
    ties: FloatArray = field(repr=False)
    residual_m: float

    def carry(self, points: FloatArray) -> FloatArray:
        """Return points (..., 2) of the common ground as points about the foot."""
        carried = cv2.perspectiveTransform(points.reshape(-1, 1, 2), self.homography)
        return np.array(carried, np.float64).reshape(points.shape)


def level(shot: Shot, height_m: float) -> Levelled:
    """Return the photograph on the ground."""
    posed = shot.posed(height_m)
    border = posed.ground(border_of(shot.camera.width, shot.camera.height))
    (south, west), (north, east) = border.min(axis=0), border.max(axis=0)
    size = (int((north - south) / GROUND_M), int((east - west) / GROUND_M))
    seen = seen_by(posed, np.array([north, west]), size, GROUND_M)
    shrink = max(1, int(GROUND_M * shot.camera.fx / height_m))
    small = cv2.resize(shot.image, None, fx=1 / shrink, fy=1 / shrink, interpolation=cv2.INTER_AREA)
    at = np.asarray((seen + 0.5) / shrink - 0.5, np.float32)
    image = cv2.remap(small, at[..., 0], at[..., 1], cv2.INTER_LINEAR)
    inside = (seen >= 0) & (seen <= (shot.camera.width - 1, shot.camera.height - 1))
    missing = np.asarray(~inside.all(axis=-1), np.bool_)
    return Levelled(np.asarray(image, np.uint8), missing, float(north), float(west))


def features(picture: Levelled) -> Features:
    """Return the SIFT features of a levelled picture."""
    grey = cv2.cvtColor(picture.image, cv2.COLOR_BGR2GRAY)
    keys, descriptors = cv2.SIFT.create(FEATURES).detectAndCompute(grey, (~picture.missing).astype(np.uint8))
    if not keys:
        return Features(np.zeros((0, 2)), np.zeros((0, 128), np.float32))
    return Features(picture.points(np.array([key.pt for key in keys])), np.asarray(descriptors, np.float32))


def place(common: Features, shot: Shot, height_m: float) -> Carried | None:
    """Return a photograph placed over the labelled one by the features of that one's ground; None where fewer than
    `LEAST_TIES` agree with one homography. ``height_m`` is the photograph's height by EXIF.

    Levelled by the first ties it is matched once more, near where they carry each feature, which gives more ties.
    """
    carried = _carried(common, shot, height_m, None)
    return None if carried is None else _carried(common, carried.shot, carried.height_m, carried) or carried


def _carried(common: Features, shot: Shot, height_m: float, known: Carried | None) -> Carried | None:
    own = features(level(shot, height_m))
    first, second = _pairs(common, own, RATIO if known is None else GUIDED_RATIO)
    there, here = common.points[first], own.points[second]
    if known is not None:
        near = np.linalg.norm(known.carry(there) - here, axis=1) < GUIDED_M
        there, here = there[near], here[near]
    if len(there) < LEAST_TIES:
        return None
    _, inlier = cv2.findHomography(there, here, cv2.RANSAC, INLIER_M, maxIters=5000)
    good = np.ravel(inlier) > 0
    if good.sum() < LEAST_TIES:
        return None
    there, pixels = there[good], shot.pixels(here[good], height_m)
    settled, height, foot = _settle(shot, height_m, there, pixels)
    here = settled.ground(pixels, height)
    homography, _ = cv2.findHomography(there, here, 0)
    carried = Carried(settled, height, foot, np.asarray(homography, float), there, 0.0)
    off = np.linalg.norm(carried.carry(there) - here, axis=1)
    return replace(carried, residual_m=float(np.median(off)))


def _pairs(first: Features, second: Features, ratio: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the indices of features that are alike."""
    if min(len(first.points), len(second.points)) < 2:
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    both = cv2.BFMatcher().knnMatch(first.descriptors, second.descriptors, k=2)
    good = [one for one, other in both if one.distance < ratio * other.distance]
    return np.array([m.queryIdx for m in good], np.intp), np.array([m.trainIdx for m in good], np.intp)


def _settle(shot: Shot, height_m: float, points: FloatArray, pixels: FloatArray) -> tuple[Shot, float, FloatArray]:
    """Return the photograph with the attitude and turning, the height and the foot by which it shows ``points`` (N, 2)
    of the common ground at ``pixels`` (N, 2), by robust least squares from what its tags say.
    """
    metres = height_m / shot.camera.fx / TIE_SIGMA_M
    weights = 1 / np.array([ATTITUDE_SIGMA, ATTITUDE_SIGMA, HEADING_SIGMA, *[TURNING_SIGMA] * 3, HEIGHT_SIGMA])
    before = np.concatenate([shot.attitude, shot.turning, [math.log(height_m)]])

    def errors(pose: FloatArray) -> FloatArray:
        seen = _posed(shot, pose).pixels(points - pose[7:], math.exp(pose[6]))
        return np.concatenate([((seen - pixels) * metres).ravel(), (pose[:7] - before) * weights])

    start = np.concatenate([before, (points - shot.ground(pixels, height_m)).mean(axis=0)])
    found = least_squares(errors, start, loss="soft_l1", x_scale=[*[0.1] * 7, 10.0, 10.0]).x
    return _posed(shot, found), math.exp(found[6]), found[7:]


def _posed(shot: Shot, pose: FloatArray) -> Shot:
    """Return the photograph with another attitude (3) and turning (3)."""
    roll, pitch, yaw, *turning = (float(value) for value in pose[:6])
    return replace(shot, attitude=(roll, pitch, yaw), turning=(turning[0], turning[1], turning[2]))
