"""Rally points: RTL goes to the nearest one where that is nearer than home (AP_Rally of ArduPilot)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from hawk.sim.autopilot.parameters import Parameters
from hawk.sim.geometry import Flat

COMMAND: Final = 5100
"""MAV_CMD_NAV_RALLY_POINT."""
STORAGE_BYTES: Final = 300
_POINT_BYTES: Final = 15
MAX_POINTS: Final = STORAGE_BYTES // _POINT_BYTES


@dataclass(frozen=True, slots=True)
class RallyPoint:
    """One item of the upload: degrees, and ``altitude`` metres above home."""

    latitude: float
    longitude: float
    altitude: float


@dataclass(frozen=True, slots=True)
class RallyPlace:
    """A rally point in the world: north and east, metres; ``height`` above home."""

    place: Flat
    height: float


class Rally:
    """The vehicle's rally points."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self.points: tuple[RallyPoint, ...] = ()
        self.places: tuple[RallyPlace, ...] = ()

    def load(self, points: Sequence[RallyPoint], places: Sequence[Flat]) -> None:
        """Replace all points; ``places`` are the same in the world (north, east)."""
        self.points = tuple(points)
        self.places = tuple(RallyPlace(place, point.altitude) for place, point in zip(places, points, strict=True))
        self._parameters.set("RALLY_TOTAL", len(points))

    def nearest(self, here: Flat, home: Flat, allowed: Callable[[RallyPlace], bool]) -> RallyPlace | None:
        """Return the nearest of the ``allowed`` points; None where home is to be taken.

        RALLY_LIMIT_KM bounds its distance; with RALLY_INCL_HOME home is taken where that is nearer.
        """
        near = min(
            (each for each in self.places if allowed(each)), key=lambda each: math.dist(here, each.place), default=None
        )
        if near is None:
            return None
        away = math.dist(here, near.place)
        limit = self._parameters["RALLY_LIMIT_KM"] * 1000.0
        if limit > 0.0 and away > limit:
            return None
        if self._parameters.flag("RALLY_INCL_HOME") and math.dist(here, home) <= away:
            return None
        return near
