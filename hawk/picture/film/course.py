"""A drone's path by captions or log: its places, heights and attitudes by time."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
import pymap3d
from numpy.typing import NDArray

from hawk.picture.photographs.places import unwrap_longitudes, wrap_longitudes

FloatArray = NDArray[np.float64]
LONGEST_GAP_S: Final = 3.0
"""Between two samples nothing is known of a path beyond this."""
_BEYOND_S: Final = 0.1
"""Beyond its first and last sample a path is known for as long: a metre of flight at most."""
_AROUND_S: Final = 0.25
"""Speeds are those of this much path on each side."""
_GROUND_M: Final = 3.0
"""Within this of a log's least height, a drone that does not move may stand on the ground."""
_MOVING_M_S: Final = 1.0
"""Above the speed of a place that wanders though the drone stands."""


@dataclass(frozen=True, slots=True)
class Course:
    """Samples (N,) of a flight in order of time.

    ``time``: seconds, by the film's clock (0 at its first frame) or the log's. ``latitude``, ``longitude``: degrees.
    ``altitude`` above the sea, ``height`` above the take-off place: metres, NaN where they are not known.
    ``attitude`` (N, 3): the camera's roll, pitch, yaw as `hawk.picture.values.Shot` has them, NaN where not known.
    ``sigma``: standard deviation of a place, metres. ``epoch``: Unix time of ``time`` 0, None where it is not known.
    """

    time: FloatArray
    latitude: FloatArray = field(repr=False)
    longitude: FloatArray = field(repr=False)
    altitude: FloatArray = field(repr=False)
    height: FloatArray = field(repr=False)
    attitude: FloatArray = field(repr=False)
    sigma: tuple[float, float] = (2.0, 3.0)
    epoch: float | None = None

    @classmethod
    def of_rows(cls, rows: FloatArray, attitude: FloatArray, sigma: tuple[float, float], epoch: float | None) -> Course:
        """Return the course of rows (N, 5): time, latitude, longitude, altitude, height."""
        time, latitude, longitude, altitude, height = rows.T
        return cls(time, latitude, longitude, altitude, height, attitude, sigma, epoch)

    def shifted(self, seconds: float) -> Course:
        """Return the same flight by a clock that shows ``seconds`` more."""
        return replace(self, time=self.time + seconds, epoch=None if self.epoch is None else self.epoch - seconds)

    def levelled(self) -> Course:
        """Return the same flight with a camera that is held straight down and turns with the drone."""
        return replace(self, attitude=self.attitude * (0.0, 0.0, 1.0))

    def with_heights(self, height_m: float | None) -> Course:
        """Return the same flight with the middle of its heights in the air at ``height_m``; None changes nothing."""
        if height_m is None:
            return self
        known = self.height if np.isfinite(self.height).any() else self.altitude
        if not np.isfinite(known).any():
            return replace(self, height=np.full(len(self.time), height_m))
        filled = np.where(np.isfinite(known), known, np.nanmedian(known))
        return replace(self, height=filled - np.median(filled[self._is_aloft(filled)]) + height_m)

    def _is_aloft(self, levels: FloatArray) -> NDArray[np.bool_]:
        """Return which samples (N,) of these levels were taken in flight: above the least, or moving; all, if none."""
        is_moving = np.hypot(*self.velocity().T) > _MOVING_M_S
        is_aloft = (levels > levels.min() + _GROUND_M) | is_moving
        return np.asarray(is_aloft if is_aloft.any() else np.ones(len(levels)), np.bool_)

    def covers(self, times: FloatArray) -> NDArray[np.bool_]:
        """Return which times (N,) lie between samples that are near enough to each other."""
        after = np.clip(np.searchsorted(self.time, times), 1, len(self.time) - 1)
        gap = self.time[after] - self.time[after - 1]
        within = (times >= self.time[0] - _BEYOND_S) & (times <= self.time[-1] + _BEYOND_S)
        return np.asarray(within & (gap <= LONGEST_GAP_S), np.bool_)

    def at(self, times: FloatArray) -> Course:
        """Return the samples between, at times (N,); angles take the shorter side."""
        columns = [self.latitude, unwrap_longitudes(self.longitude), self.altitude, self.height]
        latitude, longitude, altitude, height = (np.interp(times, self.time, each) for each in columns)
        return replace(
            self, time=times, latitude=latitude, longitude=wrap_longitudes(longitude), altitude=altitude, height=height,
            attitude=turning_between(times, self.time, self.attitude),
        )  # fmt: skip

    def metres(self, origin: tuple[float, float] | None = None) -> FloatArray:
        """Return the places (N, 2) north and east of ``origin`` (latitude, longitude), else of the first one."""
        latitude, longitude = origin or (float(self.latitude[0]), float(self.longitude[0]))
        east, north, _ = pymap3d.geodetic2enu(self.latitude, self.longitude, 0.0, latitude, longitude, 0.0)
        return np.column_stack([north, east])

    def velocity(self) -> FloatArray:
        """Return metres a second north and east (N, 2)."""
        places = self.metres()
        before, after = (
            np.column_stack([np.interp(self.time + off, self.time, places[:, k]) for k in (0, 1)])
            for off in (-_AROUND_S, _AROUND_S)
        )
        within = np.minimum(self.time + _AROUND_S, self.time[-1]) - np.maximum(self.time - _AROUND_S, self.time[0])
        return np.asarray((after - before) / np.maximum(within, 1e-3)[:, None])

    def turning(self) -> FloatArray:
        """Return how fast the camera's yaw turns (N,), radians a second; 0 where it is not known."""
        yaw = turning_between(self.time - _AROUND_S, self.time, self.attitude)[:, 2]
        later = turning_between(self.time + _AROUND_S, self.time, self.attitude)[:, 2]
        turned = np.abs(np.angle(np.exp(1j * (later - yaw))))
        return np.asarray(np.nan_to_num(turned / (2 * _AROUND_S)))

    def tilt(self) -> FloatArray:
        """Return the angles (N,) between the camera's axis and straight down, radians; 0 where they are not known."""
        roll, pitch = self.attitude[:, 0], self.attitude[:, 1]
        down = np.nan_to_num(np.cos(roll) * np.cos(pitch), nan=1.0)
        return np.asarray(np.arccos(np.clip(down, -1.0, 1.0)))


def turning_between(times: FloatArray, known: FloatArray, angles: FloatArray) -> FloatArray:
    """Return angles (N, K) at ``times`` (N,) between those (M, K) at ``known`` times, by the shorter side."""
    whole = np.isfinite(angles).all(axis=1)
    if not whole.any():
        return np.full((len(times), angles.shape[1]), math.nan)
    straight = np.unwrap(angles[whole], axis=0)
    between = [np.interp(times, known[whole], straight[:, k]) for k in range(angles.shape[1])]
    return np.column_stack([np.angle(np.exp(1j * each)) for each in between])
