"""Messages that say a thing once: on the survey, on the ground below, on doubts and compasses."""

from __future__ import annotations

import math
from typing import Final

from hawk.config.sections import OBSTACLE_MARGIN_M
from hawk.ddc.acts import Acts, Log
from hawk.ddc.battery.survey import tens
from hawk.ddc.facts import Facts
from hawk.ddc.states.base import State
from hawk.ddc.witnesses.witness import ALONE, COMPASS_LOST
from hawk.ddc.words import metres
from hawk.model.operation import StateName
from hawk.model.sentences import say

SHORT_CONFIRM_S: Final = 10.0
"""Seconds for which the battery must be too low for the rest of the survey: plans and drain waver."""


class SurveyNotices:
    """Says each once: the earlier survey once a run of the program, the battery once a flight."""

    def __init__(self, *, continues_survey: bool) -> None:
        """``continues_survey``: the map of an earlier run was restored."""
        self._earlier_is_due = continues_survey
        self._is_short_reported = False

    def tick(self, facts: Facts, state: State) -> Acts:
        """Return the messages of this tick."""
        if not facts.vehicle.armed:
            self._is_short_reported = False
            return self._earlier(facts)
        if state.identity is StateName.AUTONOMOUS_EXPLORE:
            return self._short(facts)
        return ()

    def _earlier(self, facts: Facts) -> Acts:
        sight = facts.sight
        if not self._earlier_is_due or sight.lot_area <= 0.0:
            return ()
        self._earlier_is_due = False
        need = facts.battery.survey
        is_done = need is not None and need.basis == "map" and need.seconds <= 0.0
        rest = say("It was seen whole.") if is_done else say("Explore flies the rest.")
        total = sight.counts.total
        text = say("An earlier survey goes on: {total} stalls are on its map. {rest}", total=total, rest=rest)
        return (Log("info", text),)

    def _short(self, facts: Facts) -> Acts:
        battery = facts.battery
        is_certain = battery.short_s is not None and battery.short_s >= SHORT_CONFIRM_S
        if self._is_short_reported or battery.survey is None or not is_certain:
            return ()
        self._is_short_reported = True
        share = tens(battery.survey.whole_share)
        text = say("The battery will not last for the whole survey: about {share} % of it.", share=share)
        return (
            Log("warning", text, say("It explores on and returns in time. Explore continues after a battery swap.")),
        )


REPORTED_SHARE = 1 / 3
"""Ground that is this share of Min above or below the arm place is reported."""
AGAIN_SHARE = 0.5
"""It is reported again only after it was this share of that closer to the arm place's height."""


class GroundNotices:
    """Reports each side once, until the ground is near the arm place's height again."""

    def __init__(self, obstacle: float | None) -> None:
        """``obstacle``: the highest declared one, metres; None when none is declared."""
        self._obstacle = obstacle
        self._reported = 0.0
        """1 when risen ground was reported, -1 when sunken ground was."""

    def tick(self, facts: Facts) -> Acts:
        """Return the message of the tick in which the ground rose or sank by more than the limit."""
        ground = facts.position.below.ground
        if not facts.is_airborne:
            self._reported = 0.0
            return ()
        if ground is None:
            return ()
        limit = REPORTED_SHARE * facts.limits.heights.minimum
        if abs(ground) < AGAIN_SHARE * limit:
            self._reported = 0.0
        if abs(ground) <= limit or self._reported == math.copysign(1.0, ground):
            return ()
        self._reported = math.copysign(1.0, ground)
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


class WitnessNotices:
    """Reports each doubt once, a position without a second witness, and compasses that fail."""

    _alone = False  # of the class: memories from before it go on

    def __init__(self) -> None:
        self._doubted = False
        self._compass_lost = False

    def tick(self, facts: Facts, state: State) -> Acts:
        """Return the messages of the tick in which something begins or ends. A task that a doubt ends reports it."""
        return self._doubt(facts, state) + self._witness(facts) + self._compass(facts)

    def _doubt(self, facts: Facts, state: State) -> Acts:
        was, self._doubted = self._doubted, bool(facts.witness.doubt)
        if self._doubted and not was and not state.is_task:
            return (Log("warning", facts.witness.doubt),)
        if was and not self._doubted and facts.is_airborne:
            return (Log("ok", say("The position agrees with its witnesses again.")),)
        return ()

    def _witness(self, facts: Facts) -> Acts:
        if self._alone == facts.witness.is_alone:
            return ()
        self._alone = facts.witness.is_alone
        if self._alone:
            return (Log("warning", ALONE),)
        return (Log("ok", say("The position has a second witness again.")),) if facts.is_airborne else ()

    def _compass(self, facts: Facts) -> Acts:
        was, self._compass_lost = self._compass_lost, facts.diagnostics.compass_ok is False
        if self._compass_lost and not was:
            return (Log("warning", COMPASS_LOST),)
        if was and not self._compass_lost:
            return (Log("ok", say("A compass works again.")),)
        return ()
