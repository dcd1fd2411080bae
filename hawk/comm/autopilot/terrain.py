"""The ground's height against the arm place, from the rangefinder and the height above the arm place.

A reading gives the height of whatever is below: ground, a car, a crown, a roof. What stands on the ground is higher
than it, and ground rises slowly, so the ground is the lower envelope over the path flown: it is nowhere higher than at
an earlier place by more than `STEEPEST` times the distance from there. A median takes out single readings that are too
long, the third lowest value of the envelope two wrong medians.

Range and barometer are witnesses of each other. The range is doubted when it does not follow a climb or a descent, or
when the ground that it gives is farther from the arm place than any lot's.
"""

from __future__ import annotations

import heapq
import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, replace
from statistics import median
from typing import Any, Final

from hawk.model.frames import Attitude

DOWN: Final = 25
"""MAV_SENSOR_ROTATION_PITCH_270."""
QUALITY_INVALID: Final = 1
"""``signal_quality``: 0 is unknown, 1 is invalid, 100 is perfect."""
LARGEST_TILT: Final = math.radians(30.0)
"""A drone that leans more measures something aside."""
_CM: Final = 0.01


@dataclass(frozen=True, slots=True)
class RangeReading:
    """One message. ``time`` of the measurement, seconds of our clock; ``least`` and ``most`` limit the sensor, metres.

    ``distance`` is straight down to what is below, metres; None for a message that holds no reading.
    """

    time: float
    distance: float | None
    least: float
    most: float


def looks_down(fields: Mapping[str, Any]) -> bool:
    """Return True for a DISTANCE_SENSOR message of a sensor that looks down."""
    return fields.get("orientation") == DOWN


def read_distance(fields: Mapping[str, Any], time: float, attitude: Attitude | None) -> RangeReading:
    """Return what a DISTANCE_SENSOR message holds.

    At or beyond the sensor's limits, with an invalid signal, at a strong or an unknown tilt there is no reading.

    Args:
        fields: The message.
        time: Its time stamp on our clock, seconds.
        attitude: The drone's attitude at that time; None when it is not known.

    Raises:
        KeyError, TypeError, ValueError: A field is missing or no number.
    """
    least, most, slant = (int(fields[name]) * _CM for name in ("min_distance", "max_distance", "current_distance"))
    is_valid = least < slant < most and int(fields.get("signal_quality") or 0) != QUALITY_INVALID
    if not is_valid or attitude is None:
        return RangeReading(time, None, least, most)
    share = math.cos(attitude.roll) * math.cos(attitude.pitch)
    return RangeReading(time, slant * share if share >= math.cos(LARGEST_TILT) else None, least, most)


STEEPEST: Final = 0.15
"""Steepest ground that is followed upwards: ramps of car parks rise by up to 15 %."""
MEMORY_S: Final = 30.0
"""Older readings are forgotten: a barometer drifts, seconds."""
MEMORY_M: Final = 60.0
"""Readings of places farther away say nothing about the ground here, metres."""
SMOOTHED: Final = 5
"""Readings of one median."""
SMOOTHED_S: Final = 1.5
"""Longest time that they may take, seconds."""
LOWEST: Final = 3
"""The ground is this lowest value of the envelope: two wrong medians do not count."""
FRESH_S: Final = 3.0
"""An older estimate is none, seconds."""
PLUMB_M: Final = 5.0
"""Within this distance aside a climb is straight, metres."""
CLIMB_M: Final = 5.0
"""A shorter climb or descent says nothing about the range, metres."""
DISAGREE: Final = 0.4
"""The range must follow a climb to within this share of it."""
DISAGREE_M: Final = 15.0
"""Ground farther above or below the arm place than this, and than `DISAGREE` of the height, is not believed, metres."""
DOUBT_S: Final = 2.0
"""A ground that is not believable must stay so for this time, seconds."""


@dataclass(frozen=True, slots=True)
class Terrain:
    """The ground below as the rangefinder shows it, at ``time`` (seconds of our clock)."""

    time: float
    distance: float | None = None
    """Metres straight down to what is below; None outside the sensor's range."""
    ground: float | None = None
    """The ground's height, metres above the arm place; None while it is not known."""
    most: float = 0.0
    """The sensor's longest distance, metres."""
    doubt: str = ""
    """Why the rangefinder is not believed; empty when it is."""

    @property
    def believed_ground(self) -> float | None:
        """``ground``, None when the rangefinder is not believed."""
        return None if self.doubt else self.ground


@dataclass(frozen=True, slots=True)
class _Sample:
    """A reading at a place. ``top`` (what is below) and ``height`` (the drone) are metres above the arm place."""

    time: float
    north: float
    east: float
    height: float
    top: float

    def aside(self, other: _Sample) -> float:
        return math.hypot(self.north - other.north, self.east - other.east)


class TerrainEstimator:
    """Estimates the ground from readings and the drone's place at each of them."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget everything: another arm place, or heights that jumped."""
        self._raw: deque[_Sample] = deque(maxlen=SMOOTHED)
        self._samples: deque[_Sample] = deque()
        self._ground: tuple[float, float] | None = None  # time, height
        self._stuck = False
        self._odd_since: float | None = None

    def take(self, reading: RangeReading, place: tuple[float, float, float] | None) -> Terrain:
        """Take a reading and return what is known now.

        Args:
            reading: The rangefinder's.
            place: The drone's place at that time: metres north and east of the arm place, and above it; None when it
                is not known.
        """
        if reading.distance is not None and place is not None:
            north, east, height = place
            self._raw.append(_Sample(reading.time, north, east, height, height - reading.distance))
            self._smooth()
        return Terrain(
            reading.time, reading.distance, self._fresh_ground(reading.time), reading.most, self._doubt(reading.time)
        )

    def _fresh_ground(self, now: float) -> float | None:
        known = self._ground
        return None if known is None or now - known[0] > FRESH_S else known[1]

    def _smooth(self) -> None:
        """Take the median of the last readings as a sample, in the place of the middle one."""
        raw = self._raw
        if len(raw) < SMOOTHED or raw[-1].time - raw[0].time > SMOOTHED_S:
            return
        sample = replace(raw[SMOOTHED // 2], top=median(each.top for each in raw))
        self._compare_climb(sample)
        self._samples.append(sample)
        while sample.time - self._samples[0].time > MEMORY_S:
            self._samples.popleft()
        envelope = (each.top + STEEPEST * aside for each in self._samples if (aside := each.aside(sample)) <= MEMORY_M)
        lowest = heapq.nsmallest(LOWEST, envelope)
        if len(lowest) < LOWEST:
            return
        self._ground = (raw[-1].time, lowest[-1])
        beyond = abs(lowest[-1]) > max(DISAGREE_M, DISAGREE * abs(sample.height))
        if not beyond:
            self._odd_since = None
        elif self._odd_since is None:
            self._odd_since = sample.time

    def _compare_climb(self, sample: _Sample) -> None:
        """Compare what is below at the two ends of a straight climb or descent: some of it must be the same."""
        climbed = [
            each
            for each in self._samples
            if each.aside(sample) <= PLUMB_M and abs(each.height - sample.height) >= CLIMB_M
        ]
        if climbed:
            self._stuck = all(
                abs(each.top - sample.top) > DISAGREE * abs(each.height - sample.height) for each in climbed
            )

    def _doubt(self, now: float) -> str:
        if self._stuck:
            return "its distance does not follow the height"
        if self._odd_since is not None and now - self._odd_since >= DOUBT_S:
            last = self._samples[-1]
            distance = last.height - last.top
            return f"it measures {distance:.0f} m at {last.height:z.0f} m above the arm place"
        return ""


def ground_below(terrain: Terrain | None) -> float:
    """Return the ground's height, metres above the arm place; 0 where it is not measured or not believed."""
    ground = None if terrain is None else terrain.believed_ground
    return 0.0 if ground is None else ground
