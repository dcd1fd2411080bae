"""Pairs of pictures of a flight that show the same ground, and the points that both show."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from hawk.algo.vision.rectify import intrinsics, scaled_camera
from hawk.calibrate.flight import Flight, Look, pictures
from hawk.formats.image import NoImage, decode
from hawk.model.pictures import CAMERA_TO_BODY, CameraModel

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


Floats = NDArray[np.float64]
Grey = NDArray[np.uint8]

MARGIN_S: Final = 1.5
"""Seconds that the track covers before and after each picture: the largest error of the latency that is found."""
LONGEST_S: Final = 3.0
"""Between the pictures of a pair: over a longer time GNSS drifts as far as a slow drone flies."""
POINTS: Final = 40
"""Most points of a pair: more of them share their errors."""
_MOST_PAIRS = 160
_LEAST_SHIFT, _MOST_SHIFT = 0.1, 0.35  # focal lengths; farther apart two pictures have too little in common
_LEAST_TURN, _MOST_TURN = 0.1, 0.7  # radians
_ANCHOR_S = 0.25  # two pairs begin at least so far apart
_STEP_S = 0.05
_SHARP_SHARE = 0.4  # of the pairs: those in which an error of the latency moves the picture most
_SLOT_S = 3.0
_SPEED_SLACK = 1.0  # m/s by which the drone may seem faster than it says: a jump of the position is no motion
_JUMP_SLACK_M = 0.5

WIDTH: Final = 640
"""Pixels of the pictures that are compared."""
_FEATURES = 900
_OUTLIER = 3.0  # pixels, RANSAC (Fischler and Bolles, 1981)
_LEAST = 20  # features that agree
_LEAST_SHARE = 0.25
_WINDOW = (17, 17)
_BORDER = 12  # pixels
_MOVED = 3.0  # pixels that the refinement may move a point


@dataclass(frozen=True, slots=True)
class Pair:
    """Two frames of a flight, the earlier one first."""

    before: Look
    now: Look


@dataclass(frozen=True, slots=True)
class Matches:
    """Points of the ground that both pictures of a pair show: ``first`` and ``second`` (N, 2), focal lengths from the
    optical axis (x right, y down), without the lens's distortion.
    """

    pair: Pair
    first: Floats = field(repr=False)
    second: Floats = field(repr=False)


@dataclass(frozen=True, slots=True)
class _Candidate:
    pair: Pair
    sharpness: float
    """Movement of the picture for a second's error of the latency, focal lengths."""


def choose_pairs(flight: Flight) -> list[Pair]:
    """Return the pairs to compare: most spread over the flight, the others where the drone turns, leans or brakes."""
    found = _candidates(flight)
    sharp: dict[int, _Candidate] = {}
    for each in found:
        slot = int(each.pair.before.captured / _SLOT_S)
        if slot not in sharp or each.sharpness > sharp[slot].sharpness:
            sharp[slot] = each
    best = sorted(sharp.values(), key=lambda each: -each.sharpness)[: int(_SHARP_SHARE * _MOST_PAIRS)]
    chosen = {id(each): each for each in best}
    left = [each for each in found if id(each) not in chosen]
    spread = np.linspace(0, len(left) - 1, min(len(left), _MOST_PAIRS - len(chosen))).round().astype(int)
    pairs = [each.pair for each in (*best, *(left[k] for k in spread))]
    return sorted(pairs, key=lambda pair: pair.before.captured)


def _candidates(flight: Flight) -> list[_Candidate]:
    """Return pairs at least `_ANCHOR_S` apart: each picture with the next one that it can be compared with."""
    looks = [look for look in flight.looks if flight.track.covers(look.captured, MARGIN_S)]
    times = np.array([look.captured for look in looks])
    found: list[Pair] = []
    last = -math.inf
    for k, before in enumerate(looks):
        if before.captured - last < _ANCHOR_S:
            continue
        later = looks[k + 1 : int(np.searchsorted(times, before.captured + LONGEST_S))]
        good = np.flatnonzero(_comparable(flight, before, later)) if later else np.zeros(0, int)
        if len(good):
            found.append(Pair(before, later[good[0]]))
            last = before.captured
    if not found:
        return []
    early, late = (_expected(flight, found, step) for step in (-_STEP_S, _STEP_S))
    sharpness = np.abs(late[0] - early[0]) + np.abs(late[1] - early[1]) / 3
    return [_Candidate(pair, float(its)) for pair, its in zip(found, np.nan_to_num(sharpness), strict=True)]


def _comparable(flight: Flight, before: Look, later: Sequence[Look]) -> NDArray[np.bool_]:
    """Return (N,): True for each picture that has enough, and not too much, in common with the earlier one."""
    seconds = np.array([now.captured for now in later]) - before.captured
    places = np.array([(now.pose.north, now.pose.east) for now in later])
    flown = np.hypot(*(places - (before.pose.north, before.pose.east)).T)
    fastest = np.maximum(before.speed, [now.speed for now in later]) + _SPEED_SLACK
    shift, turn = _expected(flight, [Pair(before, now) for now in later], 0.0)
    far, turned = np.abs(shift), np.abs(turn)
    differs = (far >= _LEAST_SHIFT) | (turned >= _LEAST_TURN)
    alike = (far <= _MOST_SHIFT) & (turned <= _MOST_TURN)  # False for NaN, too
    return np.asarray(differs & alike & (flown <= fastest * seconds + _JUMP_SLACK_M))


def _expected(flight: Flight, pairs: Sequence[Pair], offset_s: float) -> tuple[NDArray[np.complex128], Floats]:
    """Return shift and turn of the second pictures by the poses, with all times moved by ``offset_s``."""
    ground = np.array([pair.before.ground for pair in pairs])
    before, now = (
        flight.track.at(np.array([look.captured for look in looks]) + offset_s)
        for looks in ([pair.before for pair in pairs], [pair.now for pair in pairs])
    )
    before[:, 2] -= ground
    now[:, 2] -= ground
    camera = flight.camera
    return motions(before, now, mounted(np.array([camera.mount_roll, camera.mount_pitch, camera.mount_yaw])))


class Matcher:
    """Finds the points that two pictures of a camera share; keeps each picture while a later pair needs it."""

    def __init__(self, camera: CameraModel) -> None:
        height = max(1, round(camera.height * WIDTH / camera.width))
        self._camera = scaled_camera(camera, WIDTH, height)
        self._orb = cv2.ORB.create(_FEATURES, fastThreshold=10)
        self._kept: dict[int, Grey] = {}

    def keep(self, index: int, jpeg: bytes) -> None:
        """Keep a picture by its number; one that cannot be decoded is left out."""
        try:
            image = decode(jpeg)
        except NoImage:
            return
        size = (self._camera.width, self._camera.height)
        grey = cv2.cvtColor(cv2.resize(image, size, interpolation=cv2.INTER_AREA), cv2.COLOR_BGR2GRAY)
        self._kept[index] = np.asarray(grey, np.uint8)

    def forget(self, index: int) -> None:
        """Forget a picture that no later pair needs."""
        self._kept.pop(index, None)

    def match(self, pair: Pair) -> Matches | None:
        """Return the shared points of a pair; None where pictures are missing or do not agree on one plane."""
        before, now = self._kept.get(pair.before.index), self._kept.get(pair.now.index)
        if before is None or now is None:
            return None
        plane = self._plane(before, now)
        if plane is None:
            return None
        first, second = _refined(before, now, plane)
        if len(first) < _LEAST:
            return None
        chosen = np.linspace(0, len(first) - 1, min(POINTS, len(first))).round().astype(int)
        return Matches(pair, self._rays(first[chosen]), self._rays(second[chosen]))

    def _plane(self, before: Grey, now: Grey) -> Floats | None:
        """Return the homography (3, 3) from one picture to the other that most ORB features agree on."""
        keys, first = self._orb.detectAndCompute(before, None)
        others, second = self._orb.detectAndCompute(now, None)
        if first is None or second is None or min(len(keys), len(others)) < _LEAST:
            return None
        found = cv2.BFMatcher(cv2.NORM_HAMMING, crossCheck=True).match(first, second)
        if len(found) < _LEAST:
            return None
        here = np.array([keys[each.queryIdx].pt for each in found], np.float32)
        there = np.array([others[each.trainIdx].pt for each in found], np.float32)
        plane, agree = cv2.findHomography(here, there, cv2.RANSAC, _OUTLIER)
        if plane is None or np.count_nonzero(agree) < max(_LEAST, _LEAST_SHARE * len(found)):
            return None
        return np.asarray(plane, float)

    def _rays(self, points: Floats) -> Floats:
        distortion = np.array(self._camera.distortion or (0.0,) * 5)
        rays = cv2.undistortPoints(points.reshape(-1, 1, 2), intrinsics(self._camera), distortion)
        return np.asarray(rays.reshape(-1, 2), float)


def match_pairs(flight: Flight, pairs: Sequence[Pair]) -> list[Matches]:
    """Return the shared points of the pairs that agree; reads the recording once more. Raises RecordingError."""
    matcher = Matcher(flight.camera)
    last_use: dict[int, int] = {}
    for pair in pairs:
        for index in (pair.before.index, pair.now.index):
            last_use[index] = max(last_use.get(index, 0), pair.now.index)
    by_second: dict[int, list[Pair]] = {}
    for pair in pairs:
        by_second.setdefault(pair.now.index, []).append(pair)
    found: list[Matches] = []
    for index, jpeg in pictures(flight.path, frozenset(last_use)):
        matcher.keep(index, jpeg)
        for pair in by_second.get(index, []):
            matches = matcher.match(pair)
            if matches is not None:
                found.append(matches)
        for old in [each for each, last in last_use.items() if last <= index]:
            matcher.forget(old)
    return found


def _refined(before: Grey, now: Grey, plane: Floats) -> tuple[Floats, Floats]:
    """Return points (N, 2) of the first picture and where the second shows them, pixels.

    The first picture is projected into the second by their plane: the method of Lucas and Kanade (1981) has to find the
    last pixels only, without a turn.
    """
    size = (now.shape[1], now.shape[0])
    corners: Any = cv2.goodFeaturesToTrack(before, 6 * POINTS, 0.01, 10)
    if corners is None:
        return np.zeros((0, 2)), np.zeros((0, 2))
    projected = cv2.warpPerspective(before, plane, size, flags=cv2.INTER_LINEAR)
    start = cv2.perspectiveTransform(corners, plane)
    begin = np.asarray(start, np.float32)
    end, status, _ = cv2.calcOpticalFlowPyrLK(projected, now, begin, begin.copy(), winSize=_WINDOW, maxLevel=1)
    first, from_, to = (np.asarray(each, float).reshape(-1, 2) for each in (corners, start, end))
    inside = ((to > _BORDER) & (to < np.array(size) - _BORDER)).all(1)
    good = (status.ravel() > 0) & inside & (np.hypot(*(to - from_).T) < _MOVED)
    return first[good], to[good]
