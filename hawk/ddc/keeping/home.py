"""Keeps the autopilot's home at the arm place: sets it back when somebody moved it, and reports it."""

from __future__ import annotations

import math

from hawk.ddc.acts import Acts, Ask, Log, Record, SetHome
from hawk.ddc.facts import Facts
from hawk.ddc.keeping.effort import Fight
from hawk.ddc.orders import Rank
from hawk.ddc.readings.home import HOME_WAIT_S, HomeFacts, home_words
from hawk.ddc.states.base import State
from hawk.model.poses import GlobalPose
from hawk.model.sentences import joined, say

SET_AGAIN_S = 1.0


LOST_S = 10.0
"""Home that is not back within this time cannot be put back, seconds: the flight ends."""


class KeptHome:
    """Sets home back to the arm place when somebody moved it, and reports it.

    Who moves it once too often (`hawk.ddc.keeping.effort`) moves it for ever: the flight ends, and home is set back all
    the same.
    """

    def __init__(self) -> None:
        self._is_moved = False
        self._gave_up = False
        self._asked = -math.inf
        self._fight = Fight()
        self._is_away = False
        self._is_fought_over = False

    def lost(self, facts: Facts) -> tuple[str, ...]:
        """Return that home cannot be put back; empty while it may be."""
        home = facts.position.autopilot_home
        stays = home.is_moved and home.moved_s is not None and home.moved_s >= LOST_S
        return (say("its home"),) if stays or self._is_fought_over else ()

    def tick(self, facts: Facts, state: State) -> Acts:
        """Return the acts of this tick."""
        home, sets = facts.position.autopilot_home, may_set(facts, state)
        self._count(facts, sets=sets)
        if home.moved_s is None:
            return self._settle(home)
        acts: Acts = ()
        if not self._is_moved:
            self._is_moved = True
            words = joined(say("Home was moved."), home_words(home), say("Setting it back.") if sets else "")
            acts = (Log("warning", words), Record("home moved", (("away", home.away),)))
        if home.is_moved and sets and facts.now - self._asked >= SET_AGAIN_S:
            acts += self._set(facts)
        if home.is_moved and home.moved_s >= HOME_WAIT_S and not self._gave_up:
            self._gave_up = True
            there = say("Home stays moved: the drone would return there.")
            here = say("Home stays moved: the drone lands where it would return by itself.")
            acts += (Log("error", there if home.is_inside else here, home_words(home)),)
        return acts

    def _count(self, facts: Facts, *, sets: bool) -> None:
        """Count the times that home was moved and set back. Motors that are off end the count."""
        if not facts.vehicle.armed:
            self._fight = Fight()
            self._is_away = self._is_fought_over = False
            return
        is_moved = facts.position.autopilot_home.is_moved
        if sets and is_moved and not self._is_away:
            self._is_fought_over |= self._fight.is_over(facts.now)
            self._fight.note(facts.now)
        if sets or not is_moved:  # one that is away while nothing may be set is the same move when it may again
            self._is_away = is_moved

    def _set(self, facts: Facts) -> Acts:
        place = facts.position.arm_place
        if place is None:
            return ()
        self._asked = facts.now
        return (Ask(SetHome(GlobalPose(place.latitude, place.longitude, place.altitude)), facts.now),)

    def _settle(self, home: HomeFacts) -> Acts:
        was_moved, self._is_moved, self._gave_up = self._is_moved, False, False
        if not was_moved or home.away is None:
            return ()
        return (Log("ok", say("Home is at the arm place again.")),)


def may_set(facts: Facts, state: State) -> bool:
    """Return True while home may be set back: armed, heard, and no pilot flies."""
    return facts.link.is_up and facts.vehicle.armed and state.rank < Rank.PILOT
