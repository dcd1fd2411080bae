"""Compares the picture's motion with the drone's: a frozen picture, a turned or a mirrored camera.

A camera that is turned or mirrored gives good pictures of the wrong place; a frozen one gives the same picture with new
time stamps. Only the comparison with the drone's own motion shows it.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from hawk.algo.frame import FrameInput
from hawk.algo.vision.odometry import Features, Motion, expected_motion, find_features, measured_motion
from hawk.model.operation import GROUND_STATES, Health, HealthStatus
from hawk.model.pictures import CameraModel
from hawk.model.poses import MapPose
from hawk.model.sentences import say

COMPARED_SHIFT = 0.1
"""Two pictures are compared when the picture has moved so far between them, focal lengths: 3.5 m at 35 m."""
_COMPARED_TURN = 0.15  # or turned so far, radians
_FARTHEST = 0.45  # more than this apart, two pictures have too little in common
_LONGEST_S = 3.0  # over a longer time GNSS drifts as far as a slow drone flies
_SPEED_SLACK = 1.0  # m/s by which the drone may seem faster than it says: a jump of the position is not its motion
_JUMP_SLACK_M = 0.5
_KEPT = 8
_LEAST_PAIRS = 4
_STILL_PAIRS = _TURN_PAIRS = 3
_STILL_SHARE = 0.2
_AGREEMENT = 0.85  # cosine between what is expected and what is measured
_CLEARER = 0.15  # by so much the one agrees better than the other
_LEAST_TURN = 0.2  # radians, root of the sum of squares, after which the sense of turning is known
_SENSE = 0.5
TURN_LIMIT = math.radians(25)
"""A camera is turned when its picture moves by more than this beside the drone's motion."""

SAME_MOVE_M = 1.0
"""A drone in the air that moved so far while the picture stayed the same has a frozen camera."""
_SAME_TURN = math.radians(15)
_SAME_WORD_S = 5.0


class View(StrEnum):
    """State of the camera, as the pictures of a flight show it."""

    UNKNOWN = "unknown"
    RIGHT = "right"
    FROZEN = "frozen"
    TURNED = "turned"
    MIRRORED = "mirrored"


@dataclass(frozen=True, slots=True)
class Finding:
    """A verdict on the camera. ``angle``: by how much it is turned clockwise, seen from above, radians."""

    view: View
    angle: float = 0.0


@dataclass(frozen=True, slots=True)
class Pair:
    """The picture's movement between two frames as the poses make it, and as the pictures show it."""

    expected: Motion
    measured: Motion

    @property
    def moves(self) -> bool:
        """True when the drone's flight moves the picture."""
        return abs(self.expected.shift) >= COMPARED_SHIFT / 2

    @property
    def turns(self) -> bool:
        """True when the drone turns."""
        return abs(self.expected.turn) >= _COMPARED_TURN / 2

    @property
    def stands(self) -> bool:
        """True when the picture stands still while the drone moves or turns."""
        moved = not self.moves or abs(self.measured.shift) < _STILL_SHARE * abs(self.expected.shift)
        return moved and (not self.turns or abs(self.measured.turn) < _STILL_SHARE * abs(self.expected.turn))


@dataclass(frozen=True, slots=True)
class Evidence:
    """The latest pairs of a flight: of all kinds, those in which the drone moved, and those in which it turned."""

    latest: tuple[Pair, ...] = ()
    moves: tuple[Pair, ...] = ()
    turns: tuple[Pair, ...] = ()

    def with_pair(self, pair: Pair) -> Evidence:
        """Return the evidence with one more pair; the oldest of its kind is forgotten."""
        return Evidence(
            (*self.latest, pair)[-_STILL_PAIRS:],
            (*self.moves, pair)[-_KEPT:] if pair.moves else self.moves,
            (*self.turns, pair)[-_KEPT:] if pair.turns else self.turns,
        )

    def finding(self) -> Finding:
        """Return the verdict on the camera.

        With movements as complex numbers a turned camera measures m = e^{it} e where e is expected, a mirrored one
        m = e^{it} conj(e). Along a single line the two are the same; movements in several directions
        distinguish them, and so does a turn of the drone: a mirrored picture turns against it.
        """
        shifts = [(pair.expected.shift, pair.measured.shift) for pair in self.moves]
        if len(self.latest) == _STILL_PAIRS and all(pair.stands for pair in self.latest):
            return Finding(View.FROZEN)
        turned = _agreement(shifts)
        mirrored = _agreement([(expected.conjugate(), measured) for expected, measured in shifts])
        clear = abs(turned) - abs(mirrored)
        sense = self._sense() or (0 if abs(clear) < _CLEARER else math.copysign(1, clear))
        if sense < 0 and (len(shifts) < _LEAST_PAIRS or abs(mirrored) >= _AGREEMENT):
            return Finding(View.MIRRORED)
        if len(shifts) < _LEAST_PAIRS or sense < 0 or abs(turned) < _AGREEMENT:
            return Finding(View.UNKNOWN)
        angle = -cmath.phase(turned)  # the picture turns against the camera
        if abs(angle) > TURN_LIMIT:
            return Finding(View.TURNED, angle)
        return Finding(View.RIGHT if sense else View.UNKNOWN, angle)

    def _sense(self) -> float:
        """Return 1 where the picture turns as the drone does, -1 where it turns against it, 0 where that is open."""
        size = sum(pair.expected.turn**2 for pair in self.turns)
        if len(self.turns) < _TURN_PAIRS or size < _LEAST_TURN**2:
            return 0
        share = sum(pair.expected.turn * pair.measured.turn for pair in self.turns) / size
        return 0 if abs(share) < _SENSE else math.copysign(1, share)


@dataclass(frozen=True, slots=True)
class _Key:
    """An earlier picture that later ones are compared with."""

    frame: FrameInput = field(repr=False)
    pose: MapPose
    features: Features


@dataclass(frozen=True, slots=True)
class _Same:
    """Pictures without any difference: the first of them, and the drone's place then."""

    frame: FrameInput = field(repr=False)
    pose: MapPose | None


class CameraCheck:
    """Judges the camera from frame to frame. Worker thread only."""

    def __init__(self, minimum_height_m: float = 6.0) -> None:
        """Below ``minimum_height_m`` metres above the arm place pictures are not compared."""
        self._minimum_height_m = minimum_height_m
        self._camera: CameraModel | None = None
        self._key: _Key | None = None
        self._same: _Same | None = None
        self.evidence = Evidence()
        self.finding = Finding(View.UNKNOWN)
        """The last verdict; one that is open leaves it as it is."""

    def look(self, frame: FrameInput, image: NDArray[np.uint8] | None) -> Health:
        """Return the camera's health after a frame; ``image`` is its picture, BGR, None when it cannot be decoded."""
        # on the ground somebody may turn the camera, and nothing shows whether a picture still stands
        landed = frame.state in GROUND_STATES and self.finding.view not in (View.TURNED, View.MIRRORED)
        if frame.camera != self._camera or landed:
            self._camera, self._key = frame.camera, None
            self.evidence, self.finding = Evidence(), Finding(View.UNKNOWN)
        self._note_same(frame)
        if image is not None:
            self._compare(frame, image)
        finding = self.evidence.finding()
        if finding.view is not View.UNKNOWN or self.finding.view is View.FROZEN:
            self.finding = finding
        frozen = self._frozen_for(frame)
        return frozen if frozen is not None else _health(self.finding, frame.camera)

    def _note_same(self, frame: FrameInput) -> None:
        same = self._same
        if same is None or not frame.jpeg or same.frame.jpeg != frame.jpeg:
            self._same = _Same(frame, frame.pose)
        elif same.pose is None:
            self._same = replace(same, pose=frame.pose)

    def _frozen_for(self, frame: FrameInput) -> Health | None:
        """Return a health for a picture that stays the same; None for one that has not done so for long enough."""
        same = self._same
        if same is None or same.frame is frame:
            return None
        if frame.state not in GROUND_STATES and same.pose is not None and frame.pose is not None:
            turned = abs(math.remainder(frame.pose.yaw - same.pose.yaw, math.tau))
            if same.pose.distance(frame.pose) > SAME_MOVE_M or turned > _SAME_TURN:
                return _FROZEN
        seconds = frame.captured - same.frame.captured
        if seconds <= _SAME_WORD_S:
            return None
        return Health(HealthStatus.HEALTHY, say("the same picture for {seconds:.0f} s", seconds=seconds))

    def _compare(self, frame: FrameInput, image: NDArray[np.uint8]) -> None:
        pose, key = frame.over_ground, self._key
        if pose is None or not pose.is_finite() or pose.height < self._minimum_height_m or frame.map_problem:
            self._key = None  # a position that is doubted is no measure of the camera
            return
        expected = None if key is None else _comparable(key, frame, pose)
        if expected is not None and abs(expected.shift) < COMPARED_SHIFT and abs(expected.turn) < _COMPARED_TURN:
            return
        features = find_features(image, frame.camera)
        self._key = _Key(frame, pose, features)
        if key is None or expected is None:
            return
        measured = measured_motion(key.features, features)
        if measured is not None:
            self.evidence = self.evidence.with_pair(Pair(expected, measured))


_FROZEN = Health.bad(say("the picture stands still while the drone moves. Check the camera."))


def _health(finding: Finding, camera: CameraModel) -> Health:
    match finding.view:
        case View.FROZEN:
            return _FROZEN
        case View.MIRRORED:
            return Health.bad(say("the picture is mirrored. Switch mirroring off in the camera and start hawk again."))
        case View.TURNED:
            angle = _about(finding.angle)
            return Health.bad(
                say(
                    "the picture moves as if the camera were turned by about {angle}°. Turn the camera or set "
                    "camera.mount_yaw_deg to {wanted} (it is {degrees:.0f}) and start hawk again. If it sits right, "
                    "look at the compass.",
                    angle=angle,
                    wanted=_about(camera.mount_yaw + finding.angle),
                    degrees=math.degrees(camera.mount_yaw),
                )
            )
    return Health()


def _comparable(key: _Key, frame: FrameInput, pose: MapPose) -> Motion | None:
    """Return the expected movement since the key's picture; None when the two cannot be compared."""
    seconds = frame.captured - key.frame.captured
    fastest = max(key.frame.speed, frame.speed) + _SPEED_SLACK
    if not 0 < seconds <= _LONGEST_S:
        return None
    if math.dist((key.pose.north, key.pose.east), (pose.north, pose.east)) > fastest * seconds + _JUMP_SLACK_M:
        return None
    expected = expected_motion(frame.camera, key.pose, pose)
    return None if expected is None or abs(expected.shift) > _FARTHEST else expected


def _agreement(pairs: Sequence[tuple[complex, complex]]) -> complex:
    """Return the correlation of two movements: size 1 where one is the other turned and scaled; its phase: the turn."""
    expected, measured = (math.sqrt(sum(abs(pair[k]) ** 2 for pair in pairs)) for k in (0, 1))
    if expected == 0 or measured == 0:
        return 0j
    return sum((m * e.conjugate() for e, m in pairs), 0j) / (expected * measured)


def _about(angle: float) -> int:
    """Return an angle (radians) in degrees, to the nearest 5, from -175 to 180."""
    degrees = 5 * round(math.degrees(angle) / 5) % 360
    return degrees - 360 if degrees > 180 else degrees
