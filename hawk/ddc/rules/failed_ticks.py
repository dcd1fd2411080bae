"""Failed ticks: when the drone is sent home past the state machine, and which ticks are progress for the watchdog.

A tick fails when gathering, a step of the decider that keeps the drone safe, or an act that reaches the autopilot
raises. The watchdog ends the process a second after the last progress, so the drone is sent home before that.
"""

from __future__ import annotations

from dataclasses import dataclass

from hawk.ddc.rules.follower import state_from_autopilot
from hawk.model.operation import StateName
from hawk.model.vehicle import VehicleState

AIR_S = 0.5
"""After this time of failed ticks in the air the drone is sent home, real seconds."""
GROUND_S = 10.0
"""On the ground failed ticks are progress for this time, real seconds: the operator reads the fault on the page."""
ASK_AGAIN_S = 2.0
"""Return To Launch is asked for again after this time, real seconds."""
RECOVERY = 0.5
"""A sound tick makes up for this share of a failed one: every second tick may not fail for ever."""
LONGEST_TICK_S = 0.2
"""A longer pause between two ticks counts as this, real seconds."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """Outcome of a tick."""

    is_progress: bool
    """The watchdog hears of it."""
    goes_home: bool
    """Return To Launch is asked for now."""


class FailingTicks:
    """Adds up failed ticks. ``speed``: seconds of the clock per real second."""

    def __init__(self, speed: float) -> None:
        self._speed = speed
        self._failed = 0.0
        self._last: float | None = None
        self._asked = float("-inf")
        self._is_given_up = False

    @property
    def is_failing(self) -> bool:
        """True from a failed tick until sound ones have made up for it."""
        return self._failed > 0.0

    def note(self, now: float, *, is_sound: bool, is_airborne: bool) -> Verdict:
        """Note a tick at ``now``, seconds of the clock.

        After it was given up, no tick is progress before sound ones have made up for all failed ones.
        """
        limit = AIR_S if is_airborne else GROUND_S
        passed = 0.0 if self._last is None else min((now - self._last) / self._speed, LONGEST_TICK_S)
        self._last = now
        change = -RECOVERY * passed if is_sound else passed
        self._failed = min(max(0.0, self._failed + change), GROUND_S)
        if self._failed >= limit - 1e-9:
            self._is_given_up = True
        elif self._failed == 0.0:
            self._is_given_up = False
        goes_home = self._is_given_up and is_airborne and (now - self._asked) / self._speed >= ASK_AGAIN_S
        if goes_home:
            self._asked = now
        return Verdict(not self._is_given_up and (is_sound or not is_airborne), goes_home)


def holds_in_air(vehicle: VehicleState) -> bool:
    """Return True for a drone that flies at our word: neither a pilot nor the autopilot itself brings it anywhere."""
    return state_from_autopilot(vehicle.armed, vehicle.landed, vehicle.custom_mode) is StateName.HOVER
