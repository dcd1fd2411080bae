"""Takeoff: climbs to the desired height."""

from __future__ import annotations

import math

from hawk.ddc.acts import STAY, Acts, Log, Step, TakeOff
from hawk.ddc.facts import Facts
from hawk.ddc.motion import Goal
from hawk.ddc.orders import ToArm, ToCommunicationLost, ToHover, ToIdle
from hawk.ddc.states.base import AirborneState, Inquiry
from hawk.ddc.words import metres
from hawk.model.operation import StateName
from hawk.model.sentences import say

REACHED_SHARE = 0.95
"""The climb is done at this share of the desired height."""
GROUND_S = 8.0
"""Seconds on the ground after which the take-off has failed."""
NO_CLIMB_S = 5.0
CLIMB_STEP_M = 0.5
"""A gain below this in NO_CLIMB_S is no climb."""


class TakeoffState(AirborneState):
    """The autopilot's take-off, watched."""

    identity = StateName.TAKEOFF
    is_guarded = stops_at_fence = True

    def __init__(self, now: float) -> None:
        super().__init__(now)
        self._inquiry = Inquiry()
        self._airborne = False
        self._best = -math.inf
        self._best_at = now

    def detail(self, facts: Facts) -> str:
        """Return the height of the climb."""
        return say("Climbing to {desired}.", desired=metres(facts.limits.heights.desired))

    def enter(self, facts: Facts) -> Acts:
        """Ask for the take-off."""
        return (self._inquiry.ask(TakeOff(facts.limits.heights.desired), facts),)

    def process(self, facts: Facts) -> Acts:
        """Note when the drone leaves the ground, and its climb."""
        acts: Acts = ()
        if not self._airborne and not facts.is_on_ground:
            self._airborne = True
            self._best_at = facts.now
            acts = (Log("info", say("Took off.")),)
        if facts.height is not None and facts.height >= self._best + CLIMB_STEP_M:
            self._best, self._best_at = facts.height, facts.now
        return acts

    def _decide(self, facts: Facts) -> Step:
        height, wanted = facts.height, facts.limits.heights.desired
        if not self._airborne:
            return self._decide_on_ground(facts)
        if height is not None and height >= REACHED_SHARE * wanted:
            if not facts.operator.is_present:
                return Step(ToCommunicationLost(given_back_by=facts.operator.given_back_by))
            return Step(ToHover(say("At {wanted}.", wanted=metres(wanted)), _above(facts, wanted)))
        if facts.now - self._best_at > NO_CLIMB_S:
            return Step(ToHover(say("The climb stopped."), level="warning"))
        return STAY

    def _decide_on_ground(self, facts: Facts) -> Step:
        if failed := self._inquiry.failure(facts):
            return _refuse(facts, say("Take-off was refused."), failed.reason)
        if self.age(facts) > GROUND_S:
            return _refuse(facts, say("It did not take off."), facts.link.words)
        return STAY


def _refuse(facts: Facts, text: str, details: str) -> Step:
    following = ToArm(armed=True, reason=text) if facts.vehicle.armed else ToIdle(text)
    return Step(following, (Log("error", text, details),))


def _above(facts: Facts, height: float) -> Goal | None:
    place = facts.place
    return None if place is None else Goal(place.north, place.east, height, place.yaw)
