"""Rules for a daemon that starts while the drone is in the air."""

from __future__ import annotations

from enum import Enum

from hawk.model.operation import FlightSoFar

RESTART_WINDOW_S = 60.0
"""Starts in the air are counted over this time, seconds."""

FLIGHT_KEPT_S = 120.0
"""A flight whose last record is older has ended, seconds: on its own failsafes the drone is down by then."""


class RestartRule(Enum):
    """The action at a start in the air."""

    ADOPT = "adopt"
    """Adopt the state that stands for the autopilot's activity."""
    RETURN_HOME = "return home"
    """Something is wrong with us: Return To Launch before anything else (not in Manual, RTL, Land)."""
    STAY_AWAY = "stay away"
    """Do not open MAVLink until disarmed: the autopilot's own failsafe has the drone."""


def flight_goes_on(kept: FlightSoFar | None, utc: float, speed: float) -> tuple[float, float] | None:
    """Return time (seconds) and distance (metres) of the flight in which this program started; None when unknown.

    ``utc`` is the wall clock, ``speed`` the daemon's seconds per real second. A wall clock that was set back while
    the program was down adds no time.
    """
    if kept is None or utc - kept.at > FLIGHT_KEPT_S:
        return None
    return kept.seconds + max(0.0, utc - kept.at) * speed, kept.way


def restart_rule(starts_in_the_air: int) -> RestartRule:
    """Return the action at this start, counted with those of the last RESTART_WINDOW_S before it (1: the first)."""
    if starts_in_the_air >= 3:
        return RestartRule.STAY_AWAY
    return RestartRule.RETURN_HOME if starts_in_the_air == 2 else RestartRule.ADOPT
