"""Record of the true flight: path, time, height, excursions out of the fence. The estimate plays no part."""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import shapely

from hawk.sim.autopilot.autopilot import Autopilot
from hawk.sim.geometry import Flat, Vector

PERIOD_S = 0.1
DEFAULT_MARGIN_M = 3.0
SHOWN_PARAMETERS = ("BATT_", "FENCE_", "FS_", "RALLY_", "RTL_")
"""Beginnings of the names of parameters that the account shows: those that a daemon may have set."""


@dataclass(frozen=True, slots=True)
class WatchedFence:
    """A fence to watch, grown by its margin: ``area`` in north, east; ``ceiling`` metres above the ground."""

    area: shapely.Geometry
    ceiling: float

    @classmethod
    def of(cls, polygon: Sequence[Flat], ceiling: float, margin: float = DEFAULT_MARGIN_M) -> WatchedFence:
        """Grow a polygon (north, east; metres in the world) and a ceiling by the margin."""
        area = shapely.Polygon(polygon).buffer(margin)
        shapely.prepare(area)
        return cls(area, ceiling + margin)

    def holds(self, place: Vector) -> bool:
        """Return True when a true place (NED metres in the world) is inside."""
        return -place[2] <= self.ceiling and bool(shapely.contains_xy(self.area, place[0], place[1]))


class FlightRecord:
    """Watches the body. ``distance_flown_m``: length of the true path over the ground; ``flown_s``: the air time."""

    def __init__(self, autopilot: Autopilot) -> None:
        self.distance_flown_m = 0.0
        self.flown_s = 0.0
        self.excursions = 0
        self.highest_m = 0.0
        self._autopilot = autopilot
        self._fence: WatchedFence | None = None
        self._outside = False
        self._last: Vector = autopilot.body.position
        self._time = autopilot.time

    def watch(self, fence: WatchedFence | None) -> None:
        """Count excursions out of this fence from here on."""
        self._fence = fence
        self.excursions = 0
        self._outside = False

    def step(self) -> None:
        """Record the body; called after every physics step."""
        elapsed = self._autopilot.time - self._time
        if elapsed < PERIOD_S:
            return
        self._time = self._autopilot.time
        body = self._autopilot.body
        self.distance_flown_m += math.dist(body.position[:2], self._last[:2])
        self._last = body.position
        self.highest_m = max(self.highest_m, body.height)
        if not body.on_ground:
            self.flown_s += elapsed
        outside = self._fence is not None and not self._fence.holds(body.position)
        self.excursions += outside and not self._outside
        self._outside = outside

    def summary(self) -> dict[str, Any]:
        """Return everything as JSON values."""
        autopilot = self._autopilot
        body = autopilot.body
        latitude, longitude, altitude = autopilot.origin.to_geodetic(body.position)
        return {
            "time": round(autopilot.time, 3),
            "time_boot": round(autopilot.time_boot, 3),
            "mode": autopilot.mode.name,
            "position": {
                "x": round(body.position[1], 3),
                "y": round(-body.position[0], 3),
                "height": round(body.height, 3),
                "latitude": latitude,
                "longitude": longitude,
                "altitude": altitude,
                "roll": round(body.roll, 4),
                "pitch": round(body.pitch, 4),
                "yaw": round(body.yaw, 4),
            },
            "velocity": [round(value, 3) for value in body.velocity],
            "landed": body.on_ground,
            "disarmed": not autopilot.armed,
            "crashed": body.crashed,
            "autopilot_stopped": autopilot.stopped,
            "gcs_failsafe": autopilot.failsafes.gcs,
            "parameters": autopilot.parameters.values(SHOWN_PARAMETERS),
            "fence_items": len(autopilot.fence.items),
            "fence_mark": zlib.crc32(repr(autopilot.fence.items).encode()),
            "rally_points": len(autopilot.rally.points),
            "battery": round(autopilot.battery.charge, 4),
            "distance_flown_m": round(self.distance_flown_m, 2),
            "flown_s": round(self.flown_s, 2),
            "highest_m": round(self.highest_m, 2),
            "fence": self._fence is not None,
            "outside": self._outside,
            "excursions": self.excursions,
        }
