"""Reports in flight that the ground is not as high as the arm place: Min counts from there."""

from __future__ import annotations

import math

from hawk.config.sections import OBSTACLE_MARGIN_M
from hawk.ddc.acts import Acts, Log
from hawk.ddc.facts import Facts
from hawk.ddc.words import metres
from hawk.model.sentences import say

TOLD_SHARE = 1 / 3
"""Ground that is this share of Min above or below the arm place is reported."""
AGAIN_SHARE = 0.5
"""It is reported again only after it was this share of that closer to the arm place's height."""


class GroundReports:
    """Reports each side once, until the ground is near the arm place's height again."""

    def __init__(self, obstacle: float | None) -> None:
        """``obstacle``: the highest declared one, metres; None when none is declared."""
        self._obstacle = obstacle
        self._told = 0.0
        """1 when risen ground was reported, -1 when sunken ground was."""

    def tick(self, facts: Facts) -> Acts:
        """Return the message of the tick in which the ground rose or sank by more than the limit."""
        ground = facts.position.below.ground
        if not facts.is_airborne:
            self._told = 0.0
            return ()
        if ground is None:
            return ()
        limit = TOLD_SHARE * facts.limits.heights.minimum
        if abs(ground) < AGAIN_SHARE * limit:
            self._told = 0.0
        if abs(ground) <= limit or self._told == math.copysign(1.0, ground):
            return ()
        self._told = math.copysign(1.0, ground)
        if ground < 0:
            return (Log("info", say("The ground here is {ground} lower than the arm place.", ground=metres(-ground))),)
        words = say(
            "The ground here is {ground} higher than the arm place: {advice}",
            ground=metres(ground),
            advice=self._advice(facts),
        )
        return (Log("warning", words),)

    def _advice(self, facts: Facts) -> str:
        """Return what to do about risen ground."""
        minimum, ground = facts.limits.heights.minimum, facts.position.below.ground or 0.0
        if self._obstacle is None:
            return say("raise Min.")
        wanted = math.ceil(ground + self._obstacle + OBSTACLE_MARGIN_M)
        left = minimum - ground - self._obstacle
        if left >= OBSTACLE_MARGIN_M:
            return say(
                "Min clears an obstacle of {obstacle} on it by {left}.",
                obstacle=metres(self._obstacle),
                left=metres(left),
            )
        return say(
            "raise Min to {wanted}, so that it clears an obstacle of {obstacle} on it.",
            wanted=metres(wanted),
            obstacle=metres(self._obstacle),
        )
