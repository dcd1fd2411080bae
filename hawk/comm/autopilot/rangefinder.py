"""The rangefinder that looks down: DISTANCE_SENSOR turned into metres straight down to what is below.

Facts of ArduCopter 4.7 (`tests/contract/test_rangefinder.py`): distances in centimetres along the sensor's axis, not
corrected for the drone's tilt; ``orientation`` 25 (MAV_SENSOR_ROTATION_PITCH_270) looks down; the message comes once
its rate is asked for, and without a sensor never.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
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
