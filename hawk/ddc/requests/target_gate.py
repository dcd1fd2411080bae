"""Limits of a target: fence, heights and distance, from the place of the drone. Functions that change nothing."""

from __future__ import annotations

from dataclasses import dataclass

from hawk.ddc.fence.geometry import contains, inside_point, leads_inside, outside_by, path_words, place_words
from hawk.ddc.motion import Goal, maximum_target_distance
from hawk.model.limits import Fence, HeightParameters
from hawk.model.poses import MapPose
from hawk.model.sentences import say

ABOVE_M = 2.0
"""A target is straight above or below the drone when it is no farther aside than this, metres."""
ENTRANCE_M = 1.0
"""A target for a drone outside may lie this much farther than the nearest place well inside, metres."""


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of a target: fence in force, travel heights (m), travel speed (m/s).

    ``holds``: the sender holds its place. It may stay above Max, and it leads a drone outside the fence back.
    """

    fence: Fence
    heights: HeightParameters
    speed: float
    holds: bool


def target_refusal(target: Goal, pose: MapPose, limits: Limits) -> str:
    """Return why the target must not be sent to a drone at this pose; empty when it may."""
    away = outside_by(limits.fence, pose.point) if limits.holds else 0.0
    return (
        _fence_refusal(target, pose, limits, away)
        or _height_refusal(target, pose, limits)
        or _distance_refusal(target, pose, limits, away)
    )


def _fence_refusal(target: Goal, pose: MapPose, limits: Limits, away: float) -> str:
    """Check the target and the straight path to it.

    A drone outside that is led back (``away`` metres) goes by steps, none farther out than the one before, and then by
    any path that ends inside.
    """
    if not contains(limits.fence, target.point):
        nearer = 0.0 < outside_by(limits.fence, target.point) <= away
        return "" if nearer else say("the target is {where}", where=place_words(limits.fence, target.point))
    if away > 0.0 or leads_inside(limits.fence, pose.point, target.point):
        return ""
    return say("the straight way to the target {leaves}", leaves=path_words(limits.fence))


def _height_refusal(target: Goal, pose: MapPose, limits: Limits) -> str:
    """Check the height against Min, Max and ceiling; outside them only the straight path back is free."""
    ceiling, lowest = limits.fence.ceiling, limits.heights.minimum
    highest = ceiling if limits.holds else min(limits.heights.maximum, ceiling)
    straight = _aside(target, pose) <= ABOVE_M
    descends = straight and target.height <= pose.height
    if target.height > ceiling and not (limits.holds and descends):
        return say("the target is above the ceiling of {ceiling:g} m", ceiling=ceiling)
    if target.height < lowest and not (straight and target.height >= pose.height):
        return say("the target is below Min, {lowest:g} m", lowest=lowest)
    return (
        say("the target is above Max, {highest:g} m", highest=highest)
        if target.height > highest and not descends
        else ""
    )


def _distance_refusal(target: Goal, pose: MapPose, limits: Limits, away: float) -> str:
    """Check the distance; a drone outside may be sent to the nearest place well inside, however far that is."""
    limit = maximum_target_distance(limits.speed)
    across, up = _aside(target, pose), abs(target.height - pose.height)
    if max(across, up) <= limit:
        return ""
    if away > 0.0 and up <= limit and contains(limits.fence, target.point):
        nearest = inside_point(limits.fence, pose.point)
        if across <= pose.point.distance(nearest) + ENTRANCE_M:
            return ""
    return say("the target is {across:.1f} m away, more than {limit:.1f} m", across=max(across, up), limit=limit)


def _aside(target: Goal, pose: MapPose) -> float:
    return pose.point.distance(target.point)
