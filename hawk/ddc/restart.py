"""What a daemon does that finds itself started in the air."""

from __future__ import annotations

from enum import Enum

from hawk.model import FlightSoFar

RESTART_WINDOW_S = 60.0
"""Starts in the air are counted over so many seconds."""


FLIGHT_KEPT_S = 120.0
"""A flight that was last heard of longer ago has ended: on its own failsafes the drone is down by then."""


class RestartRule(Enum):
    """What to do at a start in the air."""

    TAKE_UP = "take up"
    """Take the state from the mapping."""
    RETURN_HOME = "return home"
    """Something is wrong with us: Return To Launch before anything else (not in Manual, RTL, Land)."""
    STAY_AWAY = "stay away"
    """Do not open MAVLink until disarmed: the autopilot's own failsafe has the drone."""


def flight_goes_on(kept: FlightSoFar | None, utc: float, speed: float) -> tuple[float, float] | None:
    """Return flight time (seconds) and way (metres) of the flight in which this program started; None: not known.

    ``utc`` is the wall clock, ``speed`` the daemon's seconds per real second. A wall clock that was set back while
    the program was down counts as no time.
    """
    if kept is None or utc - kept.at > FLIGHT_KEPT_S:
        return None
    return kept.seconds + max(0.0, utc - kept.at) * speed, kept.way


def restart_rule(starts_in_the_air: int) -> RestartRule:
    """Return what to do at this start, counted with those of the last RESTART_WINDOW_S before it (1: the first)."""
    if starts_in_the_air >= 3:
        return RestartRule.STAY_AWAY
    return RestartRule.RETURN_HOME if starts_in_the_air == 2 else RestartRule.TAKE_UP
