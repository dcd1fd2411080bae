"""The one order of rank: an automatic reaction never moves down in it."""

from __future__ import annotations

from enum import IntEnum


class Rank(IntEnum):
    """What outranks what; higher numbers win."""

    TASK = 0
    """The operator's task."""
    PERCEPTION = 1
    """Vision, mapper, planner, camera or position failed."""
    FENCE = 2
    """Fence and ceiling."""
    COMMUNICATION_LOST = 3
    RETURN_TO_LAUNCH = 4
    LAND = 5
    AUTOPILOT = 6
    """The autopilot's own failsafe."""
    PILOT = 7
    """Someone else flies."""
    KILL = 8
