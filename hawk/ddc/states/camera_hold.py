"""Holding a place by the camera while the reported position walks away from the true one: within limits.

The reported place of a target goes along with the error, and so does its height. It stays inside the fence by the
report, which is what the autopilot's own fence judges by, and the place itself stays inside by the camera.
"""

from __future__ import annotations

from dataclasses import replace

from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import contains, inside_point
from hawk.ddc.motion import Goal
from hawk.model.poses import MapPoint

FARTHEST_M = 30.0
"""A position that has gone farther is followed no more: what the camera adds up is then off by some metres."""


def held(facts: Facts, goal: Goal, off_then: tuple[float, float]) -> Goal | None:
    """Return the target that keeps the drone where it is by the camera; None where the camera cannot hold it.

    Args:
        facts: The facts of this moment; the position is doubted.
        goal: The place to hold as it was reported when it was chosen.
        off_then: How far the reported position was off at that moment, metres north and east.
    """
    place, fence = facts.witness.place, facts.limits.fence
    if fence is None or not place.is_followed or place.off_m > FARTHEST_M:
        return None
    true = MapPoint(goal.north - off_then[0], goal.east - off_then[1])
    if not contains(fence, true):
        true = inside_point(fence, true)
    target = MapPoint(true.north + place.off[0], true.east + place.off[1])
    return replace(goal, north=target.north, east=target.east) if contains(fence, target) else None


def raised(facts: Facts, goal: Goal, off_then: float) -> Goal | None:
    """Return the target that keeps the drone at its true height; None above our ceiling.

    Args:
        facts: The facts of this moment; place or height is doubted.
        goal: The place to hold, its height as it was reported when it was chosen.
        off_then: How far the reported height was above the true one at that moment, metres.
    """
    height = max(goal.height + facts.witness.height.off - off_then, facts.limits.heights.minimum)
    if height > facts.ceiling(on_ground=False):
        return None
    return replace(goal, height=height)
