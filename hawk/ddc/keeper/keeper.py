"""The one keeper of everything that we set or require in the autopilot: parameters, fence, home.

Each is compared every ten seconds at most, in flight as well. What another station changed to the worse is reported,
put back at once, and keeps new tasks off until it holds. What cannot be put back ends the flight
(`hawk.ddc.rules.guard`). While a pilot flies it is reported, and nothing is written.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence

from hawk.ddc.acts import Acts, Ask, Log, Record, SetHome
from hawk.ddc.facts import Facts, KeptFacts
from hawk.ddc.keeper.effort import Fight
from hawk.ddc.keeper.fence import KeptFence
from hawk.ddc.keeper.parameters import KeptParameters
from hawk.ddc.orders import Rank
from hawk.ddc.parameters.reader import ParameterReader
from hawk.ddc.parameters.values import RETURN_CHECK, RETURN_HEIGHT, FailsafeCheck
from hawk.ddc.readings.home import HOME_WAIT_S, HomeFacts, home_words
from hawk.ddc.rules.preflight import autopilot_view, failsafe_checks
from hawk.ddc.settings import DdcSettings
from hawk.ddc.states.base import State
from hawk.ddc.words import named
from hawk.model.poses import GlobalPose
from hawk.model.sentences import joined, say, series

SET_AGAIN_S = 1.0


LOST_S = 10.0
"""Home that is not back within this time cannot be put back, seconds: the flight ends."""


class KeptHome:
    """Sets home back to the arm place when somebody moved it, and reports it.

    Who moves it once too often (`hawk.ddc.keeper.effort`) moves it for ever: the flight ends, and home is set back all
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


_RETURN_CHECKS = frozenset({RETURN_CHECK, RETURN_HEIGHT})


class Keeper:
    """Reads, compares and puts back; `kept` is its word for guard and states."""

    def __init__(self, settings: DdcSettings, right: Mapping[str, float] | None = None) -> None:
        """Begin; ``right``: the parameters that an earlier run found right in the flight that goes on."""
        self._settings = settings
        self.reader = ParameterReader(settings.system_id, needs_remote_control=settings.remote_control.required)
        self._parameters = KeptParameters(right)
        self._fence = KeptFence(settings)
        self._home = KeptHome()
        self._astray_at = -math.inf

    @property
    def fence_problem(self) -> str:
        """Reason why the autopilot is not known to hold the fence of this flight; empty when it is known to."""
        return self._fence.problem

    @property
    def right_parameters(self) -> Mapping[str, float]:
        """The autopilot's parameters that were right in this flight."""
        return self._parameters.right

    def steps(self) -> Iterator[tuple[bool, Callable[[Facts, State], Acts]]]:
        """Give the steps of a tick in their order, each with True when the drone's safety depends on it."""
        yield False, lambda facts, _: self.reader.tick(facts)
        yield True, self._keep_parameters
        yield True, lambda facts, state: self._fence.tick(facts, state, self.reader.values())
        yield True, self._home.tick

    def kept(self, facts: Facts) -> KeptFacts:
        """Return what cannot be put back, and why RTL would not end at home."""
        lost = (*self._parameters.lost, *self._fence.lost, *self._home.lost(facts))
        checks = failsafe_checks(facts, self.reader.values(), self._settings) if facts.vehicle.armed else ()
        astray = _astray(facts, checks)
        if astray:
            self._astray_at = facts.now
        switched_off = (check.name for check in checks if check.is_switched_off)
        known = self._parameters.known.union(switched_off)  # the fence is switched on again
        restored = tuple(sorted(self._parameters.restored))
        return KeptFacts(series(*lost), astray, facts.now - self._astray_at, restored, tuple(sorted(known)))

    def _keep_parameters(self, facts: Facts, state: State) -> Acts:
        may_write = facts.link.is_up and state.rank < Rank.PILOT
        view = autopilot_view(facts, self._settings)
        return self._parameters.tick(facts, self.reader.values(), view, may_write=may_write)


def _astray(facts: Facts, checks: Sequence[FailsafeCheck]) -> str:
    """Return why RTL would not end at home; ``checks``: those of an armed drone."""
    if not facts.vehicle.armed:
        return ""
    home = facts.position.autopilot_home
    if home.is_moved:
        return home_words(home)
    wrong = (check for check in checks if check.name in _RETURN_CHECKS and check.is_read and not check.passed)
    return next((named(check.name, check.value) for check in wrong), "")
