"""GUIDED: flies where the companion computer says."""

from __future__ import annotations

import math

from hawk.sim.control import Setpoint
from hawk.sim.modes import Mode, ModeNumber, Phase, View
from hawk.sim.vector import Flat, Vector

SPOOL_UP_S = 1.0
"""Motors come up to speed before they lift."""
YAW_LOOK_M = 2.0
"""Without a yaw of its own a target farther than this is looked at (WP_YAW_BEHAVIOR 2)."""


class Guided(Mode):
    """Holds its place until told otherwise."""

    number = ModeNumber.GUIDED
    arms = True

    def __init__(self, view: View) -> None:
        super().__init__(view)
        self._yaw: float | None = None
        self._velocity: Vector | None = None
        self._velocity_time = 0.0
        self._climbing_to: float | None = None
        self._lift_time = 0.0
        self.speed: float | None = None

    def take_off(self, view: View, down: float) -> None:
        """Climb straight up to a height (down, metres in the world)."""
        self._velocity = None
        self._climbing_to = down
        self._lift_time = view.time + SPOOL_UP_S
        self._place, self._down = view.flat, down

    def go(self, place: Flat, down: float, yaw: float | None, view: View) -> None:
        """Fly to a place. Without a yaw the vehicle looks where it goes."""
        self._velocity = None
        self._climbing_to = None
        if yaw is None and math.dist(place, view.flat) > YAW_LOOK_M:
            yaw = math.atan2(place[1] - view.flat[1], place[0] - view.flat[0])
        self._place, self._down, self._yaw = place, down, yaw

    def move(self, velocity: Vector, yaw: float | None, view: View) -> None:
        """Fly with a velocity (NED, m/s); it ends GUID_TIMEOUT after the last one."""
        self._velocity, self._velocity_time = velocity, view.time
        self._climbing_to = None
        self._yaw = yaw

    def turn(self, yaw: float) -> None:
        """Turn to a heading."""
        self._yaw = yaw

    @property
    def target(self) -> Vector:
        """Where it flies or stays."""
        return *self._place, self._down

    def run(self, view: View) -> Setpoint:
        """Return the target; on the ground nothing but a take-off lifts."""
        if view.landed and (self._climbing_to is None or view.time < self._lift_time):
            if self._climbing_to is not None:
                return Setpoint(idle=True)
            self._place, self._down = view.flat, view.estimate.position[2]
            return Setpoint(idle=True)
        self._arrive(view)
        if self._velocity is not None:
            north, east, down = self._velocity
            return Setpoint(velocity=(north, east), climb=-down, yaw=self._yaw, speed=self.speed)
        return Setpoint(self._place, down=self._down, yaw=self._yaw, speed=self.speed)

    def _arrive(self, view: View) -> None:
        if self._climbing_to is not None and view.estimate.position[2] <= self._climbing_to + 0.2:
            self._climbing_to = None
        if self._velocity is not None and view.time - self._velocity_time > view.parameters["GUID_TIMEOUT"]:
            self._velocity = None
            self._place, self._down = view.stopping_point(), view.stopping_down()

    @property
    def phase(self) -> Phase:
        """Taking off until the height is reached."""
        return Phase.TAKING_OFF if self._climbing_to is not None else Phase.FLYING
