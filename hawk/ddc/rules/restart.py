"""Rules for a daemon that starts while the drone is in the air."""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum

from hawk.model.moment import Moment
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


def flight_goes_on(kept: FlightSoFar | None, now: Moment, speed: float) -> tuple[float, float] | None:
    """Return time (seconds) and distance (metres) of the flight in which this program started; None when unknown.

    ``speed``: the daemon's seconds per real second. The wall clock alone ends no flight. A computer that booted a
    moment ago may have done so in the air: the flight goes on until the autopilot is heard to be disarmed. How long the
    computer was down is the wall clock's word then, within what is possible.
    """
    if kept is None:
        return None
    passed = now.since(kept.moment)
    if passed is None:
        passed = max(now.seconds, min(now.utc - kept.moment.utc, FLIGHT_KEPT_S))
    if passed > FLIGHT_KEPT_S:
        return None
    return kept.seconds + passed * speed, kept.way


def starts_before(starts: Iterable[Moment], flight: FlightSoFar | None, now: Moment) -> int:
    """Return the number of starts in the air within the last RESTART_WINDOW_S.

    One of an earlier boot counts when this boot and the end of that one lie within the window: the computer booted in
    the air, and how long it was down is not known. ``flight``: the flight that goes on; its last word is the end.
    """
    return sum(_is_recent(start, flight, now) for start in starts)


def _is_recent(start: Moment, flight: FlightSoFar | None, now: Moment) -> bool:
    passed = now.since(start)
    if passed is not None:
        return passed < RESTART_WINDOW_S
    ran_on = None if flight is None else flight.moment.since(start)
    return ran_on is not None and max(0.0, ran_on) + now.seconds < RESTART_WINDOW_S


def restart_rule(starts_in_the_air: int) -> RestartRule:
    """Return the action at this start, counted with those of the last RESTART_WINDOW_S before it (1: the first)."""
    if starts_in_the_air >= 3:
        return RestartRule.STAY_AWAY
    return RestartRule.RETURN_HOME if starts_in_the_air == 2 else RestartRule.ADOPT
