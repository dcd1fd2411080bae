"""Takes the pose's error out before a frame is fused: the frame is moved so that its stalls meet the known ones.

Rows repeat at every pitch, so that a shift is only sought within less than half a pitch of the last one. New ground is
mapped with the shift of the known ground: an error of the compass would bend the map without end, so it is learned from
the movement of the ground between two frames. Over fresh ground the shift leaks slowly back to the GNSS position;
stalls of an earlier pass hold it firmly. Over a battery swap the position moves by more:
`hawk.algo.registration.after_swap` finds that, and from then on it counts as the GNSS position.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from hawk.algo.mapper.evidence import transform_points
from hawk.algo.vision import quads
from hawk.model.poses import MapPose

Floats = NDArray[np.float64]

_LEAST_PAIRS = 4
_SPREAD_M = 0.45  # median absolute deviation above which the pairs do not agree on one shift
_SMOOTHING = 0.2  # share of the remaining error that one frame takes out
_LEAK_PER_M = 0.02  # share of the shift that a metre of flight forgets over fresh ground
_UNSURE_LEAK_PER_M = 0.2  # until enough frames were compared

REACH_M = 1.1
"""Less than half of the narrowest pitch, 2.3 m."""
_BASE_M = 3.0  # flown between the two frames that are compared
_STILL_M = 0.03
_LEAST_COMPARED = 6
_SIGMA = 0.06  # of one comparison: share of the height
_FIRST_SIGMA = 0.03  # of most flights
_WANDER = 0.001  # standard deviation by square root of metre: the ground is not level, barometers drift
_LEAST_SIGMA = 0.006
_SURE = 0.02
_PLAUSIBLE = (0.7, 1.4)  # scales between two frames; anything else is a wrong match

_COMPASS_SIGMA = math.radians(2.0)  # compasses of most flights
_KNOWN_COMPASS_SIGMA = math.radians(0.4)  # of an earlier flight's result
_COMPASS_WANDER = 0.0005  # radians by square root of metre: a compass's error changes with the heading
_DRIFT_SIGMA = 0.03  # m/s, each axis: GNSS that is off by 1 m
_DRIFT_S = 10.0
_TURN_SIGMA = 0.02  # of one comparison, radians: .014 as measured over worlds 1-20, and some outliers
_TURN_LIMIT = math.radians(6)


@dataclass(frozen=True, slots=True)
class Shift:
    """Correction of a pose: turn about the drone (radians, clockwise), then metres north and east."""

    north: float = 0.0
    east: float = 0.0
    turn: float = 0.0

    def about(self, north: float, east: float) -> Floats:
        """Return the (2, 3) map-to-map affine for a drone at that place."""
        c, s = math.cos(self.turn), math.sin(self.turn)
        rotation = np.array([[c, -s], [s, c]])
        centre = np.array([north, east])
        offset = centre - rotation @ centre + np.array([self.north, self.east])
        return np.column_stack([rotation, offset])

    def applied(self, pose: MapPose) -> MapPose:
        """Return the corrected pose."""
        north, east = pose.north + self.north, pose.east + self.east
        return MapPose(north, east, pose.height, pose.roll, pose.pitch, pose.yaw + self.turn)


class Registration:
    """Follows the slow error of the pose from frame to frame."""

    def __init__(self, limit_m: float) -> None:
        """``limit_m`` bounds the shift along each axis, about the one between this flight and the map's."""
        self._limit_m = limit_m
        self._between = np.zeros(2)
        self._last: tuple[float, float] | None = None
        self.slip = Slip()
        self.shift = Shift()

    def restore(self, shift: Shift) -> None:
        """Restore the shift of an earlier run."""
        self.shift = shift
        self.slip.heading.restore(shift.turn)

    def relocate(self, step: Floats) -> None:
        """Move the shift by metres north and east: the drone was found elsewhere on the map."""
        self._between = np.array([self.shift.north, self.shift.east]) + step
        self.shift = replace(self.shift, north=float(self._between[0]), east=float(self._between[1]))

    def update(
        self,
        known: Floats,
        found: Floats,
        drone: tuple[float, float],
        time: float,
        anchored: NDArray[np.bool_] | None = None,
    ) -> Shift:
        """Learn from a frame's stalls and return the shift for it. Fewer than four pairs that agree change no shift.

        Args:
            known: Known stalls (N, 3): north, east (metres), angle (radians).
            found: The frame's stalls (M, 3), placed by the pose as reported.
            drone: The drone's place as reported, (north, east) metres.
            time: When the frame was taken, seconds.
            anchored: True for the known stalls (N,) of an earlier pass; None: none of them.
        """
        last, self._last = self._last or drone, drone
        self.slip.move(found, drone, time)
        self.shift = replace(self.shift, turn=self.slip.heading.turn)
        places = transform_points(self.shift.about(*drone), found[:, :2])
        k, f = mutual_nearest(known, places, found[:, 2] + self.shift.turn)
        firm = float(anchored[k].mean()) if anchored is not None and len(k) >= _LEAST_PAIRS else 0.0
        self._leak(math.hypot(drone[0] - last[0], drone[1] - last[1]), 1 - firm)
        step = _agreed(known[k, :2] - places[f], _LEAST_PAIRS)
        if step is not None:
            self._follow(step)
        return self.shift

    def _leak(self, flown_m: float, share: float) -> None:
        leak = _LEAK_PER_M if self.slip.is_sure else _UNSURE_LEAK_PER_M
        keep = max(0.0, 1 - leak * share * flown_m)
        north, east = self._between + keep * (np.array([self.shift.north, self.shift.east]) - self._between)
        self.shift = replace(self.shift, north=float(north), east=float(east))

    def _follow(self, step: Floats) -> None:
        shift = np.array([self.shift.north, self.shift.east]) + _SMOOTHING * step
        north, east = np.clip(shift, self._between - self._limit_m, self._between + self._limit_m)
        self.shift = replace(self.shift, north=float(north), east=float(east))


@dataclass(frozen=True, slots=True)
class _Key:
    """An earlier frame: the drone's place (north + i east), its time (seconds) and its stalls (N, 3)."""

    drone: complex
    time: float
    found: Floats


class Slip:
    """Compares the ground between frames 3 m apart: a map with a wrong heading slips sideways.

    Places of a frame are relative to the drone's own. Turned by ``t`` a frame shows a stall at
    drone + R(t) (stall - drone): while the drone flies by d the stall moves by (1 - e^{it}) d, with directions as
    complex numbers.

    ``leans`` (N,) is the share of the drone's movement by which each stall of the last frame moves against the ground,
    backwards; NaN where it was not compared with an earlier frame.
    """

    def __init__(self) -> None:
        self.leans: Floats = np.zeros(0)
        self.heading = Heading()
        self._sigma = _FIRST_SIGMA
        self._key: _Key | None = None
        self._last: tuple[complex, float] | None = None

    @property
    def is_sure(self) -> bool:
        """True when enough frames were compared lately to trust the map's scale more than GNSS."""
        return self._sigma < _SURE

    def move(self, found: Floats, drone: tuple[float, float], time: float) -> None:
        """Learn from the next frame: its stalls (N, 3: north, east, angle), the drone's place, its time (seconds)."""
        at = complex(*drone)
        self.leans = np.full(len(found), np.nan)
        last, before = self._last or (at, time)
        step = abs(at - last)
        self._last = at, time
        self._sigma = math.hypot(self._sigma, _WANDER * math.sqrt(step))
        self.heading.move(step, max(time - before, 0.0))
        if self._key is None or step < _STILL_M:  # while the drone stands, GNSS drifts on
            self._key = _Key(at, time, found)
        path = at - self._key.drone
        if abs(path) < _BASE_M:
            return
        if abs(path) < 3 * _BASE_M:
            self._compare(self._key, found, path, max(time - self._key.time, 0.0))
        self._key = _Key(at, time, found)

    def _compare(self, key: _Key, found: Floats, path: complex, seconds: float) -> None:
        wrong = complex(math.cos(self.heading.turn), -math.sin(self.heading.turn))
        expected = path * (1 - wrong)
        places = key.found[:, :2] + (expected.real, expected.imag)
        k, f = mutual_nearest(np.column_stack([places, key.found[:, 2]]), found[:, :2], found[:, 2])
        residual = found[f, :2] - places[k]
        step = _agreed(residual, _LEAST_COMPARED)
        if step is None:
            return
        self.leans[f] = (step - residual) @ (path.real, path.imag) / abs(path) ** 2
        measured = 1 - (expected + complex(*step)) / path
        if not _PLAUSIBLE[0] < abs(measured) < _PLAUSIBLE[1]:
            return
        ratio = measured / wrong
        self.heading.learn(self.heading.turn - math.atan2(ratio.imag, ratio.real), path, seconds)
        gain = self._sigma**2 / (self._sigma**2 + _SIGMA**2)
        self._sigma = max(self._sigma * math.sqrt(1 - gain), _LEAST_SIGMA)


class Heading:
    """Learns the error of the compass from the movement of the ground.

    Sideways drift of GNSS looks like a wrong compass, but it grows as the drone slows down, changes sign where it flies
    back, and does not last; the compass's error stays. A Kalman filter of the compass's error and of the drift's
    velocity (north and east) separates the two.
    """

    def __init__(self) -> None:
        self._state = np.zeros(3)
        self._spread = np.diag([_COMPASS_SIGMA**2, _DRIFT_SIGMA**2, _DRIFT_SIGMA**2])

    @property
    def turn(self) -> float:
        """Correction of the heading, radians: the estimate less its uncertain part.

        The positive part of James and Stein's estimator (1961): nothing within one standard deviation, nearly all of
        what is far beyond it. A map is bent by a turn that changes.
        """
        turn, variance = float(self._state[0]), float(self._spread[0, 0])
        if turn**2 <= variance:
            return 0.0
        return min(max(turn - variance / turn, -_TURN_LIMIT), _TURN_LIMIT)

    def restore(self, turn: float) -> None:
        """Restore an earlier flight's `turn`."""
        variance = self._spread[0, 0] = _KNOWN_COMPASS_SIGMA**2
        self._state[0] = (turn + math.copysign(math.sqrt(turn**2 + 4 * variance), turn)) / 2 if turn else 0.0

    def move(self, metres: float, seconds: float) -> None:
        """Predict: the drone flew ``metres`` in ``seconds``."""
        keep = np.array([1.0, *[math.exp(-seconds / _DRIFT_S)] * 2])
        self._state *= keep
        self._spread *= np.outer(keep, keep)
        self._spread[np.diag_indices(3)] += (_COMPASS_WANDER**2 * metres, *_DRIFT_SIGMA**2 * (1 - keep[1:] ** 2))

    def learn(self, measured: float, flown: complex, seconds: float) -> None:
        """Update with one comparison.

        Args:
            measured: Correction of the heading that the comparison shows, radians.
            flown: Movement of the drone between the two frames, metres, north + i east.
            seconds: Time between the two frames.
        """
        lasts = seconds / abs(flown) ** 2
        seen = np.array([1.0, -flown.imag * lasts, flown.real * lasts])
        gain = self._spread @ seen
        gain /= seen @ gain + _TURN_SIGMA**2
        self._state += gain * (measured - seen @ self._state)
        self._spread -= np.outer(gain, seen @ self._spread)


def mutual_nearest(known: Floats, places: Floats, angles: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return pairs of known stalls (N, 3) and places (M, 2) with directions (M,) that are each other's nearest."""
    if len(known) == 0 or len(places) == 0:
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    _, there = cKDTree(known[:, :2]).query(places, distance_upper_bound=REACH_M)
    _, back = cKDTree(places).query(known[:, :2], distance_upper_bound=REACH_M)
    f = np.flatnonzero(there < len(known))
    f = f[back[there[f]] == f]
    k = there[f]
    good = quads.angle_between(known[k, 2], angles[f]) < 0.2
    return k[good], f[good]


def _agreed(residual: Floats, least: int) -> Floats | None:
    """Return the median (2,) of residuals (N, 2), None when they are fewer than ``least`` or do not agree."""
    if len(residual) < least:
        return None
    step = np.median(residual, 0)
    if np.median(np.abs(residual - step)) > _SPREAD_M:
        return None
    return np.asarray(step)
