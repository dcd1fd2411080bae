"""The autopilot's position estimator: its own report (EKF_STATUS_REPORT), and positions that its velocity denies."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from enum import IntFlag
from typing import Any, Final

from hawk.model.frames import EkfPosition
from hawk.model.sentences import say

Vector = tuple[float, float, float]

VARIANCE_LIMIT: Final = 0.8
"""FS_EKF_THRESH of ArduCopter: a test ratio of the EKF above it is bad."""
REPORT_AGE_S: Final = 5.0
"""An older report says nothing; it comes twice a second."""
LEAP_M: Final = 1.0
"""Two samples that are farther apart than their velocities explain, metres: a reset of the EKF."""
CREEP_M: Final = 3.0
CREEP_WINDOW_S: Final = 2.0
"""A position that moves CREEP_M otherwise than its velocity says within this time creeps."""
_COMPARABLE_S: Final = 1.0
"""Samples farther apart than this are not compared, seconds."""
_ORIGIN: Final = (0.0, 0.0, 0.0)


class EkfFlag(IntFlag):
    """EKF_STATUS_FLAGS that decide (MAVLink ardupilotmega.xml)."""

    POS_HORIZ_ABS = 1 << 4
    CONST_POS_MODE = 1 << 7
    UNINITIALIZED = 1 << 10
    GPS_GLITCHING = 1 << 15


class EstimatorReport:
    """The last EKF_STATUS_REPORT and its age."""

    def __init__(self) -> None:
        self._time = -math.inf
        self._fault = ""

    def take(self, fields: Mapping[str, Any], arrival: float) -> None:
        """Take an EKF_STATUS_REPORT, as ``fields`` by name; ``arrival`` in seconds of our clock.

        Raises:
            KeyError: A field is missing.
        """
        self._fault = _fault(EkfFlag(int(fields["flags"])), fields)
        self._time = arrival

    def fault(self, now: float) -> str:
        """Return why the estimator is not to be trusted; empty when it is. Silence is a fault."""
        if now - self._time > REPORT_AGE_S:
            return say("no report of its estimator")
        return self._fault


def _fault(flags: EkfFlag, fields: Mapping[str, Any]) -> str:
    if flags & EkfFlag.UNINITIALIZED:
        return say("its estimator is not ready")
    if flags & EkfFlag.GPS_GLITCHING:
        return say("GPS glitch")
    if flags & EkfFlag.CONST_POS_MODE or not flags & EkfFlag.POS_HORIZ_ABS:
        return say("no absolute position")
    for what in ("velocity", "pos_horiz", "compass"):
        variance = fields[f"{what}_variance"]
        if variance is None or not variance <= VARIANCE_LIMIT:  # MAVSDK gives None for NaN
            shown = "unknown" if variance is None else f"{variance:.1f}"
            return say(
                "{what} variance {shown}, above {limit:g}",
                what=_WORDS[what],
                shown=shown,
                limit=VARIANCE_LIMIT,
            )
    return ""


_WORDS: Final = {"velocity": say("velocity"), "pos_horiz": say("position"), "compass": say("compass")}


class LeapObserver:
    """Compares successive positions in EKF-local (NED, metres) with their velocities.

    Their times are the autopilot's own: an estimate of its clock on ours moves by tenths of a second when the link's
    delay changes, and at 5 m/s that would be a leap.
    """

    def __init__(self) -> None:
        self._last: EkfPosition | None = None
        self._leap: Vector | None = None
        self._errors: deque[tuple[float, Vector]] = deque()
        self._creep = _ORIGIN

    def look(self, sample: EkfPosition) -> bool:
        """Take the next sample; return True when it leapt from the one before."""
        last = self._last
        if last is not None and sample.time <= last.time:
            return False
        self._last = sample
        if last is None or sample.time - last.time >= _COMPARABLE_S:
            self._errors.clear()
            self._creep = _ORIGIN
            return False
        error = _unexplained(last, sample)
        is_leap = math.hypot(*error) > LEAP_M
        if is_leap or self._leap is not None:
            self._leap = _sum(self._leap or _ORIGIN, error)
        else:
            self._note(sample.time, error)
        return is_leap

    @property
    def creeps(self) -> bool:
        """True while the position moves away from what its velocity says, without a leap."""
        return math.hypot(*self._creep) > CREEP_M

    def settle(self) -> Vector:
        """Return how far the position leapt in all since the last call, (north, east, down) metres."""
        leap, self._leap = self._leap, None
        return leap or _ORIGIN

    def _note(self, time: float, error: Vector) -> None:
        self._errors.append((time, error))
        while time - self._errors[0][0] > CREEP_WINDOW_S:
            self._errors.popleft()
        north, east, down = (math.fsum(error[axis] for _, error in self._errors) for axis in range(3))
        self._creep = (north, east, down)


def _unexplained(last: EkfPosition, sample: EkfPosition) -> Vector:
    """Return the movement between two samples that their mean velocity does not explain, metres."""
    half = (sample.time - last.time) / 2
    return (
        sample.x - last.x - (last.vx + sample.vx) * half,
        sample.y - last.y - (last.vy + sample.vy) * half,
        sample.z - last.z - (last.vz + sample.vz) * half,
    )


def _sum(first: Vector, second: Vector) -> Vector:
    return first[0] + second[0], first[1] + second[1], first[2] + second[2]
