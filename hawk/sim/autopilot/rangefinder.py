"""The simulated rangefinder that looks down: absent, as on ArduCopter, until RNGFND1_TYPE is set and it boots.

It behaves as `tests/contract/test_rangefinder.py` states of ArduCopter 4.7: centimetres along its own axis, beyond its
limits too.
"""

from __future__ import annotations

import math
from typing import Final

from hawk.sim.autopilot.parameters import Parameters
from hawk.sim.ground import Slope
from hawk.sim.vehicle import Body

SIMULATED: Final = 100
"""RNGFND1_TYPE of ArduPilot's own simulation."""
DOWN: Final = 25
"""RNGFND1_ORIENT of a sensor that looks down (MAV_SENSOR_ROTATION_PITCH_270)."""
STEEPEST: Final = math.radians(75.0)
"""A drone that leans more measures nothing."""
FARTHEST_CM: Final = 65_535


class Rangefinder:
    """One sensor. ``stuck_cm`` is a fault: it measures this whatever is below; None: none."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self.stuck_cm: int | None = None
        self.boot()

    def boot(self) -> None:
        """Take up the sensor that the parameters name."""
        values = self._parameters
        self.is_there = values.flag("RNGFND1_TYPE") == SIMULATED and values.flag("RNGFND1_ORIENT") == DOWN

    @property
    def limits_cm(self) -> tuple[int, int]:
        """Shortest and longest distance."""
        return round(self._parameters["RNGFND1_MIN"] * 100), round(self._parameters["RNGFND1_MAX"] * 100)

    def measure_cm(self, body: Body, slope: Slope) -> int:
        """Return the distance along the sensor's axis."""
        if self.stuck_cm is not None:
            return self.stuck_cm
        north, east, down = body.position
        lean = math.cos(body.roll) * math.cos(body.pitch)
        if lean <= math.cos(STEEPEST):
            return FARTHEST_CM
        height = -down - slope.height(north, east)
        return min(FARTHEST_CM, max(0, round(height / lean * 100)))
