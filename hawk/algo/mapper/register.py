"""Takes out the pose's error before a frame is fused: the frame is laid so that its stalls meet the known ones.

The secret is how the error is told from a slip along a row: rows repeat every pitch, so that a shift is only ever
sought within less than half a pitch of the last one, and only as fast as a GNSS solution drifts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from hawk.algo.mapper.geometry import transform_points
from hawk.algo.vision import quads

Floats = NDArray[np.float64]

_REACH_M = 1.1  # less than half of the narrowest pitch, 2.3 m
_LEAST_PAIRS = 4
_SPREAD_M = 0.45  # median absolute deviation above which the pairs do not agree on one shift
_ROTATION_PAIRS = 8
_ROTATION_SPREAD_M = 5.0  # root mean square distance of the stalls from their middle
_MAX_ROTATION = math.radians(6)
_SMOOTHING = 0.4  # share of the remaining error that one frame takes out


@dataclass(frozen=True, slots=True)
class Shift:
    """Correction of a pose: turn (radians, clockwise) about the drone, then metres north and east."""

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


class Registration:
    """Follows the slow error of the pose from frame to frame."""

    def __init__(self, limit_m: float) -> None:
        self._limit_m = limit_m
        self.shift = Shift()
        self.pairs = 0

    def restore(self, shift: Shift) -> None:
        """Take up the shift of an earlier run: the map is laid in it."""
        self.shift = shift

    def update(self, known: Floats, found: Floats, drone: tuple[float, float]) -> Shift:
        """Return the shift for this frame, after it learned from the frame's stalls.

        ``known`` and ``found`` are (N, 3): north, east, angle. ``drone`` is the place in the pose's own words. The last
        shift stays when fewer than four stalls agree.
        """
        affine = self.shift.about(*drone)
        places = transform_points(affine, found[:, :2]) if len(found) else np.zeros((0, 2))
        k, f = _mutual_nearest(known, places, (found[:, 2] + self.shift.turn) if len(found) else np.zeros(0))
        self.pairs = len(k)
        if len(k) < _LEAST_PAIRS:
            return self.shift
        residual = known[k, :2] - places[f]
        turn = _fit_turn(residual, places[f])
        turned = residual - _turned(places[f], turn, drone)
        step = np.median(turned, 0)
        if np.median(np.abs(turned - step)) > _SPREAD_M:
            return self.shift
        self.shift = self._limited(step * _SMOOTHING, turn * _SMOOTHING)
        return self.shift

    def _limited(self, step: Floats, turn: float) -> Shift:
        north = float(np.clip(self.shift.north + step[0], -self._limit_m, self._limit_m))
        east = float(np.clip(self.shift.east + step[1], -self._limit_m, self._limit_m))
        return Shift(north, east, float(np.clip(self.shift.turn + turn, -_MAX_ROTATION, _MAX_ROTATION)))


def _fit_turn(residual: Floats, places: Floats) -> float:
    """Return the least-squares turn of the pairs, 0 with too few or too narrow a spread."""
    if len(residual) < _ROTATION_PAIRS:
        return 0.0
    arm = places - places.mean(0)
    spread = float((arm**2).sum())
    if spread < len(arm) * _ROTATION_SPREAD_M**2:
        return 0.0
    centred = residual - np.median(residual, 0)
    return float((arm[:, 0] * centred[:, 1] - arm[:, 1] * centred[:, 0]).sum() / spread)


def _turned(places: Floats, turn: float, drone: tuple[float, float]) -> Floats:
    arm = places - np.array(drone)
    return np.stack([-turn * arm[:, 1], turn * arm[:, 0]], -1)


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
