"""The sun's position, and the shadow that it casts: from a moment and a place."""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import datetime

from astral import Observer
from astral.sun import azimuth, elevation


@dataclass(frozen=True, slots=True)
class SunPosition:
    """Direction of the sun, degrees: ``azimuth`` clockwise from true north, ``elevation`` above the horizon.

    The elevation is the geometric one, without the air's refraction (half a degree at the horizon, .02 at 45 degrees).
    """

    azimuth: float
    elevation: float

    @property
    def is_up(self) -> bool:
        """True while it casts shadows."""
        return self.elevation > 0

    def shadow(self) -> tuple[float, float] | None:
        """Return the shadow on level ground of one metre of height, metres (north, east); None while it is down."""
        if not self.is_up:
            return None
        reach = 1 / math.tan(math.radians(self.elevation))
        toward = math.radians(self.azimuth)
        return -math.cos(toward) * reach, -math.sin(toward) * reach


def sun_position(at: datetime, latitude: float, longitude: float) -> SunPosition:
    """Return the sun's position at an aware moment, for a place in WGS-84 degrees.

    Source: NOAA's solar calculator (Meeus, Astronomical Algorithms), within .01 degrees from 1900 to 2100.

    Raises:
        ValueError: The moment has no time zone, or the place is not on Earth.
    """
    if at.tzinfo is None:
        raise ValueError(f"{at} has no time zone: name one, as in 2026-05-04T10:30+02:00")
    if not (-90 <= latitude <= 90 and -180 <= longitude <= 180):
        raise ValueError(f"latitude {latitude}, longitude {longitude}: not degrees of a place on Earth")
    place = Observer(latitude, longitude)
    return SunPosition(azimuth(place, at), elevation(place, at, with_refraction=False))
