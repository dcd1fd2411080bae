"""The drone's motion over ground, measured from picture to picture: a witness of position, height and heading.

The features of two pictures are projected onto level ground by the reported attitudes and heights. The similarity that
most of them agree on is the drone's movement, the change of the scale and that of the heading, each beside the reported
one. A picture is compared with the same earlier one for as long as enough of it is seen again: while the drone holds a
place nothing adds up. Places on the ground are complex: metres north + i east of the drone.
"""

from __future__ import annotations

import cmath
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.frame import FrameInput
from hawk.algo.vision.anchors import Anchors
from hawk.algo.vision.rectify import camera_to_ned, intrinsics, scaled_camera
from hawk.algo.vision.similarity import (
    LEAST,
    NEVER,
    OUTLIER_PIXELS,
    REACH_M,
    GroundFeatures,
    Similarity,
    compare,
    hamming,
    mutual,
)
from hawk.model.pictures import CameraModel, GroundStep
from hawk.model.poses import MapPose

_WIDTH = 320  # pixels of the pictures that are compared
_ORB_FEATURES = 300
_ORB = {"patchSize": 25, "edgeThreshold": 15, "nlevels": 3, "fastThreshold": 7}
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
    orb = cv2.ORB.create(_ORB_FEATURES, **_ORB)
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


LEAST_S = 0.24
"""Shortest time between two comparisons: each costs some milliseconds."""
LONGEST_S = 5.0
"""Pictures farther apart than this are not compared: too much may have happened between them, seconds."""
PATIENCE_S = 1.0
"""A picture that agrees with none of the earlier ones is passed over for so long, seconds: it may be a bad one."""
KEY_S = 20.0
"""The same earlier picture is used for no longer: light and shadows move, seconds."""
RATE_GAIN = 0.5
"""Share by which the last step corrects the speed that the poses do not show."""
LEAP_M = 0.5
LEAP_M_S = 3.0
"""A reported movement that is longer than the reported speed allows, by this and by this speed, is a leap and no
motion; a match that is as far from the expected place is a wrong one."""
STEP_M, STEP_M_S = 0.6, 0.8
"""The same of a smaller leap: what was seen before it is compared no more with what is seen after it."""
TALL, TALLEST, ASIDE = 1.25, 4.0, 0.25
"""Ground that seems to move as reported, but faster by a factor between the first two, and to the side by a share below
the third, may be a roof: one of 10 m moves 1.7 times as fast below a flight at 25 m."""
ROOF_S = 2.0
"""After a longer time between two pictures, seconds, or after one that was not recognised, what may be a roof is taken
for one: the drone may have come over it unseen. At a slower rate of pictures its edge is still seen."""
ROOF_M = 0.15
"""A drone that moves less from picture to picture holds: what seems to be a roof is noise, or a walk, metres."""
SAME_ROOF = 0.2
"""Share by which the factor of one roof changes from picture to picture."""
FLATTEST = 0.5
"""Sine of the lowest elevation at which ground is used: far ground is measured badly."""
COLUMNS, ROWS, CELL_FEATURES = 10, 6, 6
"""Cells of the picture, and the greatest number of features that each gives."""
FEW_FEATURES, CONTRAST = 150, 4.0
"""With fewer features the picture's contrast is raised, by this limit (CLAHE; Zuiderveld, 1994)."""
_SPREAD_FEATURES = 1200  # found, of which the cells keep some


_SAME = Similarity()


@dataclass(frozen=True, slots=True)
class _Picture:
    """A picture that later ones are compared with: its time, the reported pose and speed, and its features."""

    time: float
    pose: MapPose
    speed: float
    ground: GroundFeatures


@dataclass(frozen=True, slots=True)
class _Pair:
    """The key picture, the last picture, and the comparison of the two."""

    key: _Picture
    last: _Picture
    found: Similarity = _SAME
    beyond_m_s: complex = 0j
    """Speed of the drone that the poses do not show, m/s."""
    roof: float = 0.0
    """Factor by which a roof that fills most of the last picture moves faster than the ground; 0 without one."""
    has_missed: bool = False
    """A picture after the last one was not recognised."""


def spread_features(image: NDArray[np.uint8], camera: CameraModel) -> Features:
    """Return features of a picture, BGR (H, W, 3), from all over it: those of one tree say little about the ground."""
    small = shrunk(image)
    orb = cv2.ORB.create(_SPREAD_FEATURES, **_ORB)
    kept = _spread(small, orb)
    if len(kept) < FEW_FEATURES:
        small = np.asarray(cv2.createCLAHE(CONTRAST, (COLUMNS // 2, ROWS // 2)).apply(small), np.uint8)
        kept = _spread(small, orb)
    return features_at(small, orb, kept, camera)


def _spread(small: NDArray[np.uint8], orb: cv2.ORB) -> list[cv2.KeyPoint]:
    """Return the key points that are found, the best of each cell."""
    keys = sorted(orb.detect(small, None), key=lambda key: key.response, reverse=True)
    height, width = small.shape[:2]
    cells: Counter[tuple[int, int]] = Counter()
    kept = []
    for key in keys:
        cell = int(key.pt[0] * COLUMNS / width), int(key.pt[1] * ROWS / height)
        cells[cell] += 1
        if cells[cell] <= CELL_FEATURES:
            kept.append(key)
    return kept


def project(features: Features, camera: CameraModel, pose: MapPose) -> GroundFeatures:
    """Project features onto level ground below ``pose``, whose height is above that ground."""
    rays = np.column_stack([features.points, np.ones(len(features.points))]) @ camera_to_ned(camera, pose).T
    good = rays[:, 2] >= FLATTEST * np.linalg.norm(rays, axis=1)
    north, east, down = rays[good].T
    return GroundFeatures(
        (north + 1j * east) * (pose.height / down), features.descriptors[good], features.pixel * pose.height
    )


class Odometry:
    """Compares pictures as they come. Worker thread only."""

    def __init__(self, minimum_height_m: float = 4.0) -> None:
        """Below ``minimum_height_m`` metres over ground, as reported, nothing is compared."""
        self._minimum_height_m = minimum_height_m
        self._pair: _Pair | None = None
        self._anchors = Anchors()

    def look(self, frame: FrameInput, image: NDArray[np.uint8] | None) -> GroundStep | None:
        """Return the movement since the last comparison; None when there is none to report.

        ``image`` is the frame's picture, BGR (H, W, 3); None when it cannot be decoded.
        """
        pose, pair = frame.over_ground, self._pair
        if image is None or (pair is not None and 0.0 <= frame.captured - pair.last.time < LEAST_S):
            return None
        if pose is None or not pose.is_finite() or pose.height < self._minimum_height_m:
            self._pair = None
            self._anchors.clear()
            return None
        if frame.mount_problem:
            self._pair = None
            return None
        ground = project(spread_features(image, frame.camera), frame.camera, pose)
        picture = _Picture(frame.captured, pose, frame.speed, ground)
        if pair is not None and _leapt(pair.last, picture, STEP_M_S, STEP_M):
            self._anchors.clear()
        self._pair, step = _followed(pair, picture)
        beyond = 0j if step is None else complex(*step.beyond)
        again = self._anchors.look(frame.captured, pose, ground, beyond)
        return None if step is None else replace(step, again=again)


def _followed(pair: _Pair | None, now: _Picture) -> tuple[_Pair, GroundStep | None]:
    """Return what the next picture is compared with, and the step to this one."""
    if pair is None or not 0.0 < now.time - pair.last.time <= LONGEST_S:
        return _Pair(now, now), None
    last, seconds = pair.last, now.time - pair.last.time
    moved, slack = _moved(last.pose, now.pose), LEAP_M_S * seconds + LEAP_M
    if _leapt(last, now, LEAP_M_S, LEAP_M):
        return _Pair(now, now), None
    before, expected = pair.found, moved + pair.beyond_m_s * seconds
    found = compare(pair.key.ground, now.ground, before.then_moved(expected), slack)
    is_over = found is None or found.is_far(now.pose.height) or now.time - pair.key.time > KEY_S
    if found is None:  # the last picture has more in common with this one
        before = _SAME
        found = compare(last.ground, now.ground, before.then_moved(expected), slack)
    if found is None:
        is_usable = len(last.ground.places) >= LEAST  # else it was the bad one
        kept = pair if is_usable and seconds < PATIENCE_S else _Pair(now, now)
        return replace(kept, has_missed=True), None
    roof = _roof(before.offset - found.offset, moved)
    if roof and (beside := _beside(last, now, moved, before, found)) is not None:
        flat = Similarity(offset=beside)
        return _Pair(now, now, beyond_m_s=pair.beyond_m_s, roof=roof), _step(last, now, _SAME, flat)
    if roof and (pair.has_missed or seconds > ROOF_S or _is_same(roof, pair.roof)):  # and no ground beside it
        return _Pair(now, now, beyond_m_s=pair.beyond_m_s, roof=pair.roof), None
    beyond = (before.then_moved(moved).offset - found.offset) / seconds
    rate = pair.beyond_m_s + RATE_GAIN * (beyond - pair.beyond_m_s)
    kept = _Pair(now, now, beyond_m_s=rate) if is_over else _Pair(pair.key, now, found, rate)
    return kept, _step(last, now, before, found)


def _leapt(last: _Picture, now: _Picture, faster: float, farther: float) -> bool:
    """Return True when the report moved by more than its speed allows, by ``faster`` m/s and ``farther`` metres."""
    seconds = now.time - last.time
    return abs(_moved(last.pose, now.pose)) > (max(last.speed, now.speed) + faster) * seconds + farther


def _roof(seen: complex, moved: complex) -> float:
    """Return the factor by which the drone was seen to move faster than reported, where a roof explains it; else 0."""
    factor = seen / moved if abs(moved) >= ROOF_M else 0j
    return factor.real if TALL <= factor.real <= TALLEST and abs(factor.imag) <= ASIDE * factor.real else 0.0


def _is_same(roof: float, other: float) -> bool:
    """Return True when both are the factor of the same roof."""
    return other > 0.0 and abs(roof / other - 1) < SAME_ROOF


def _beside(last: _Picture, now: _Picture, moved: complex, before: Similarity, found: Similarity) -> complex | None:
    """Return the offset of ground that moved as reported while most of the picture did not; None without such ground.

    Ground that a drifting position misreports does not move as reported anywhere in the picture: features that agree
    with the reported movement, and not with the one that most have made, are the ground beside something tall.
    """
    first, second = last.ground, now.ground
    sought, limit = first.places - moved, OUTLIER_PIXELS * second.grain
    near = abs(sought[:, None] - second.places[None]) <= REACH_M
    i, j = mutual(np.where(near, hamming(first.descriptors, second.descriptors), NEVER))
    by_most = (found.factor / before.factor) * (first.places[i] - before.offset) + found.offset
    apart = second.places[j] - sought[i]
    agrees = (abs(apart) <= limit) & (abs(by_most - second.places[j]) > limit)
    return complex(apart[agrees].mean()) - moved if np.count_nonzero(agrees) >= LEAST else None


def _step(last: _Picture, now: _Picture, before: Similarity, found: Similarity) -> GroundStep:
    seen, reported, ratio = before.offset - found.offset, _moved(last.pose, now.pose), found.factor / before.factor
    return GroundStep(
        since=last.time,
        until=now.time,
        seen=(seen.real, seen.imag),
        reported=(reported.real, reported.imag),
        stretch=math.log(abs(ratio)),
        turn=-cmath.phase(ratio),
        height=now.pose.height,
    )


def _moved(before: MapPose, now: MapPose) -> complex:
    return complex(now.north - before.north, now.east - before.east)
