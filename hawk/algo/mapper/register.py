"""Takes out the pose's error before a frame is fused: the frame is laid so that its stalls meet the known ones.

The secret is what is trusted how far. Rows repeat every pitch, so that a shift is only sought within less than half a
pitch of the last one. New ground is laid with the shift of the old: what is wrong with compass and height would bend
and stretch the map without end, and is learned from how the ground slips from frame to frame (`hawk.algo.mapper.slip`).
Over fresh ground the shift leaks slowly back to what GNSS says; stalls of an earlier pass hold it firmly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hawk.algo.mapper.geometry import transform_points
from hawk.algo.mapper.slip import Slip, mutual_nearest

Floats = NDArray[np.float64]

_LEAST_PAIRS = 4
_SPREAD_M = 0.45  # median absolute deviation above which the pairs do not agree on one shift
_SMOOTHING = 0.2  # share of the remaining error that one frame takes out
_LEAK_PER_M = 0.02  # share of the shift that a metre of way forgets over fresh ground
_UNSURE_LEAK_PER_M = 0.2  # while the scale is not known well


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

    def __init__(self, limit_m: float, *, learns_height: bool = True) -> None:
        """``limit_m`` bounds the shift; ``learns_height``: whether the height may be wrong."""
        self._limit_m = limit_m
        self._last: tuple[float, float] | None = None
        self._slip = Slip(learns_height=learns_height)
        self.shift = Shift()

    def restore(self, shift: Shift) -> None:
        """Take up the shift of an earlier run: the map is laid in it."""
        self.shift = shift
        self._slip.restore(shift.scale, shift.turn)

    @property
    def leans(self) -> Floats:
        """By what share of the way each stall found last moves against the ground, NaN where that is not known."""
        return self._slip.leans

    def update(
        self,
        known: Floats,
        found: Floats,
        drone: tuple[float, float],
        time: float,
        anchored: NDArray[np.bool_] | None = None,
        size: float | None = None,
    ) -> Shift:
        """Return the shift for this frame, after it learned from the frame's stalls.

        ``known`` and ``found`` are (N, 3): north, east, angle; ``anchored`` which of the known are of an earlier pass
        (none when not given). ``drone`` is the place in the pose's own words, ``time`` when the frame was taken
        (seconds), ``size`` what the found stalls measure by the usual ones, None when too few are seen to tell. No
        shift is learned when fewer than four stalls agree.
        """
        last, self._last = self._last or drone, drone
        way = drone[0] - last[0], drone[1] - last[1]
        if size is not None:
            self._slip.size(size)
        self._slip.move(found, drone, time)
        self.shift = replace(self.shift, turn=self._slip.turn, scale=self._slip.scale)
        if self._slip.is_doubtful:  # what the known stalls were laid by is wrong
            return self.shift
        affine = self.shift.about(*drone)
        places = transform_points(affine, found[:, :2])
        k, f = mutual_nearest(known, places, found[:, 2] + self.shift.turn)
        firm = float(anchored[k].mean()) if anchored is not None and len(k) >= _LEAST_PAIRS else 0.0
        self._leak(way, 1 - firm)
        if len(k) < _LEAST_PAIRS:
            return self.shift
        residual = known[k, :2] - places[f]
        step = np.median(residual, 0)
        if np.median(np.abs(residual - step)) > _SPREAD_M:
            return self.shift
        self._follow(step)
        return self.shift

    def _leak(self, way: tuple[float, float], share: float) -> None:
        leak = _LEAK_PER_M if self._slip.is_sure else _UNSURE_LEAK_PER_M
        keep = max(0.0, 1 - leak * share * math.hypot(*way))
        self.shift = replace(self.shift, north=self.shift.north * keep, east=self.shift.east * keep)

    def _follow(self, step: Floats) -> None:
        north, east = np.array([self.shift.north, self.shift.east]) + _SMOOTHING * step
        limit = self._limit_m
        self.shift = replace(
            self.shift, north=float(np.clip(north, -limit, limit)), east=float(np.clip(east, -limit, limit))
        )
