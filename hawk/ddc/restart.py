"""What a daemon does that finds itself started in the air."""

from __future__ import annotations

from enum import Enum

RESTART_WINDOW_S = 60.0
"""Starts in the air are counted over so many seconds."""


class RestartRule(Enum):
    """What to do at a start in the air."""

    TAKE_UP = "take up"
    """Take the state from the mapping."""
    RETURN_HOME = "return home"
    """Something is wrong with us: Return To Launch before anything else (not in Manual, RTL, Land)."""
    STAY_AWAY = "stay away"
    """Do not open MAVLink until disarmed: the autopilot's own failsafe has the drone."""


def restart_rule(starts_in_the_air: int) -> RestartRule:
    """Return what to do at this start, counted with those of the last RESTART_WINDOW_S before it (1: the first)."""
    if starts_in_the_air >= 3:
        return RestartRule.STAY_AWAY
    return RestartRule.RETURN_HOME if starts_in_the_air == 2 else RestartRule.TAKE_UP
