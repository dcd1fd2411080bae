"""GNSS that is off, on a real ArduCopter's simulation: SIM_GPS1_GLTCH_X and _Y in degrees, _Z in metres."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Mapping
from typing import Any, Final

from proving.faults.observer import M_PER_DEG

_STEP_S: Final = 0.2
FIELDS: Final = frozenset({"gps_glitch", "gps_walk"})
"""Faults of hawk-sim that this stands for."""


class GnssError:
    """A glitch and a walk (metres, m/s), which a task lets grow. ``put`` sets a parameter, at once and unconfirmed."""

    def __init__(self, put: Callable[[str, float], None]) -> None:
        self._put = put
        self._glitch = (0.0, 0.0, 0.0)
        self._walked = (0.0, 0.0)
        self._task: asyncio.Task[None] | None = None

    def take(self, fault: Mapping[str, Any], latitude: float) -> None:
        """Take the fields of a fault of hawk-sim; ``latitude`` of the place, degrees. Needs a running loop."""
        if "gps_glitch" in fault:
            north, east, down = (float(value) for value in fault["gps_glitch"])
            self._glitch = (north, east, down)
        if "gps_walk" in fault:
            self.stop()
            north, east = (float(value) for value in fault["gps_walk"])
            if north or east:
                self._task = asyncio.create_task(self._walk((north, east), latitude), name="GNSS walks")
        self._send(latitude)

    def stop(self) -> None:
        """End the walk; the error stays."""
        if self._task is not None:
            self._task.cancel()
            self._task = None

    async def _walk(self, speed: tuple[float, float], latitude: float) -> None:
        clock = asyncio.get_running_loop().time
        began, (north, east) = clock(), self._walked
        while True:
            passed = clock() - began
            self._walked = north + speed[0] * passed, east + speed[1] * passed
            self._send(latitude)
            await asyncio.sleep(_STEP_S)

    def _send(self, latitude: float) -> None:
        north, east = self._walked[0] + self._glitch[0], self._walked[1] + self._glitch[1]
        self._put("SIM_GPS1_GLTCH_X", north / M_PER_DEG)
        self._put("SIM_GPS1_GLTCH_Y", east / (M_PER_DEG * math.cos(math.radians(latitude))))
        self._put("SIM_GPS1_GLTCH_Z", -self._glitch[2])
