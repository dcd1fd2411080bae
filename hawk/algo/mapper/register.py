"""Takes out the pose's error before a frame is fused: the frame is laid so that its stalls meet the known ones.

The secret is what is trusted how far. Rows repeat every pitch, so that a shift is only sought within less than half a
pitch of the last one. New ground is laid with the shift of the old, so that a wrong compass would bend the map without
end, and a wrong height stretch it: over fresh ground the shift leaks back to what GNSS says, and what keeps growing to
one side of the way is the compass's error, what grows along it the height's. Stalls of an earlier pass hold it firmly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from hawk.algo.mapper.geometry import transform_points
from hawk.algo.vision import quads

Floats = NDArray[np.float64]

_REACH_M = 1.1  # less than half of the narrowest pitch, 2.3 m
_LEAST_PAIRS = 4
_SPREAD_M = 0.45  # median absolute deviation above which the pairs do not agree on one shift
_SMOOTHING = 0.2  # share of the remaining error that one frame takes out
_LEAK_PER_M = 0.2  # share of the shift that a metre of way forgets: a map that is 0.7 m off in places helps nobody
_GAIN = 0.0025  # radians of turn, and share of scale, per metre of error to the side or along the way, a frame
_TURN_LIMIT = math.radians(6)
_SCALE_LIMIT = 0.04
_STILL_M = 0.05


@dataclass(frozen=True, slots=True)
class Shift:
    """Correction of a pose: turn (radians, clockwise) and scale about the drone, then metres north and east."""

    north: float = 0.0
    east: float = 0.0
    turn: float = 0.0
    scale: float = 1.0

    def about(self, north: float, east: float) -> Floats:
        """Return the (2, 3) map-to-map affine for a drone at that place."""
        c, s = self.scale * math.cos(self.turn), self.scale * math.sin(self.turn)
        rotation = np.array([[c, -s], [s, c]])
        centre = np.array([north, east])
        offset = centre - rotation @ centre + np.array([self.north, self.east])
        return np.column_stack([rotation, offset])


class Registration:
    """Follows the slow error of the pose from frame to frame."""

    def __init__(self, limit_m: float) -> None:
        self._limit_m = limit_m
        self._last: tuple[float, float] | None = None
        self.shift = Shift()

    def restore(self, shift: Shift) -> None:
        """Take up the shift of an earlier run: the map is laid in it."""
        self.shift = shift

    def update(
        self, known: Floats, found: Floats, drone: tuple[float, float], anchored: NDArray[np.bool_] | None = None
    ) -> Shift:
        """Return the shift for this frame, after it learned from the frame's stalls.

        ``known`` and ``found`` are (N, 3): north, east, angle; ``anchored`` which of the known are of an earlier pass
        (none when not given). ``drone`` is the place in the pose's own words. Nothing is learned when fewer than four
        stalls agree.
        """
        last, self._last = self._last or drone, drone
        way = drone[0] - last[0], drone[1] - last[1]
        affine = self.shift.about(*drone)
        places = transform_points(affine, found[:, :2])
        k, f = _mutual_nearest(known, places, found[:, 2] + self.shift.turn)
        firm = float(anchored[k].mean()) if anchored is not None and len(k) >= _LEAST_PAIRS else 0.0
        self._leak(way, 1 - firm)
        if len(k) < _LEAST_PAIRS:
            return self.shift
        residual = known[k, :2] - places[f]
        step = np.median(residual, 0)
        if np.median(np.abs(residual - step)) > _SPREAD_M:
            return self.shift
        self._learn(step, way, _GAIN * (1 - firm))
        return self.shift

    def _leak(self, way: tuple[float, float], share: float) -> None:
        keep = max(0.0, 1 - _LEAK_PER_M * share * math.hypot(*way))
        self.shift = replace(self.shift, north=self.shift.north * keep, east=self.shift.east * keep)

    def _learn(self, step: Floats, way: tuple[float, float], gain: float) -> None:
        length = math.hypot(*way)
        along = aside = 0.0
        if length > _STILL_M:
            along = float(way[0] * step[0] + way[1] * step[1]) / length
            aside = float(way[0] * step[1] - way[1] * step[0]) / length
        turn = float(np.clip(self.shift.turn - gain * aside, -_TURN_LIMIT, _TURN_LIMIT))
        scale = float(np.clip(self.shift.scale - gain * along, 1 - _SCALE_LIMIT, 1 + _SCALE_LIMIT))
        north, east = self.shift.north + _SMOOTHING * step[0], self.shift.east + _SMOOTHING * step[1]
        limit = self._limit_m
        self.shift = Shift(float(np.clip(north, -limit, limit)), float(np.clip(east, -limit, limit)), turn, scale)


def _mutual_nearest(known: Floats, places: Floats, angles: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    if len(known) == 0 or len(places) == 0:
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    _, there = cKDTree(known[:, :2]).query(places, distance_upper_bound=_REACH_M)
    _, back = cKDTree(places).query(known[:, :2], distance_upper_bound=_REACH_M)
    f = np.flatnonzero(there < len(known))
    f = f[back[there[f]] == f]
    k = there[f]
    good = quads.angle_between(known[k, 2], angles[f]) < 0.2
    return k[good], f[good]
