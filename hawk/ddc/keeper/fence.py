"""Keeps the fence of this flight in the autopilot, also when another station armed, or cleared it, or replaced it.

Our own Arm uploads its fence. A flight that was armed by somebody else, or that a restarted program finds in the air,
gets the fence of its arm place: first the autopilot's is read and compared, and only another one is replaced. From then
on it is read and compared again and again: a fence that was replaced is one that was cleared.
"""

from __future__ import annotations

import math

from hawk.comm.autopilot.vehicle import OTHER_FENCE
from hawk.comm.mavlink.foreign_writes import FENCE
from hawk.ddc.acts import Acts, Ask, CompareFence, EnableFence, Log, PutFenceInForce, UploadFence
from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import FenceError, contains, is_about_same, to_map
from hawk.ddc.keeper.effort import LATER, Effort, changed_by
from hawk.ddc.orders import Rank
from hawk.ddc.parameters.failsafes import CORNERS_NAME, FENCE_ENABLE
from hawk.ddc.parameters.values import Values
from hawk.ddc.settings import DdcSettings
from hawk.ddc.states.base import State
from hawk.ddc.stopwatch import Stopwatch
from hawk.ddc.words import seconds, sentence
from hawk.model.operation import StateName
from hawk.model.plans import Fence
from hawk.model.poses import ArmPlace, GlobalPose, MapPoint
from hawk.model.sentences import joined, say, words_of

SAME_M = 3.0
"""A fence built for a place this near, metres, is the fence of this arm place: the position wanders that far."""
ARM_PLACE_M = 10.0
"""A drone on the ground that is farther than this from the arm place stands at another one, metres."""
RETRY_S = 5.0
"""Pause after the fence was not taken, or could not be read, seconds."""
COMPARE_S = 8.0
"""The fence is read again after this time, seconds: it is compared within ten.

A circle of 48 corners is 48 requests of 20 and answers of 50 bytes, 3.4 kB: 420 bytes a second, 7 % of a radio of
57,600 baud.
"""
STALE_S = 45.0
"""A fence that was read longer ago is not known to be held, seconds."""
PATIENCE_S = 90.0
"""An upload takes up to 45 s on a link that loses datagrams."""
SWITCH_CONFIRM_S = 1.5
"""SYS_STATUS follows a change of the fence by up to a second."""
SWITCH_PATIENCE_S = 15.0
_WAIT = say("The fence of this flight is being set: wait a moment.")


class KeptFence:
    """Puts the fence of the arm place in force, compares it with the autopilot's, and uploads it where it differs."""

    def __init__(self, settings: DdcSettings) -> None:
        self._settings = settings
        self._reset()

    def _reset(self) -> None:
        self._armed_at: tuple[GlobalPose, float, float] | None = None
        self._fence: Fence | None = None
        self._ask: Ask | None = None
        self._is_compared = False
        self._not_before = float("-inf")
        self._held_at: float | None = None
        self._corners: float | None = None
        self._has_held = False
        self._first_upload = Effort(math.inf, RETRY_S, tries=None)
        self._upload = Effort(PATIENCE_S, RETRY_S)
        self._was_on = False
        self._off = Stopwatch()
        self._switch = Effort(SWITCH_PATIENCE_S)
        self.problem: str = _WAIT
        """Reason why the autopilot is not known to hold the fence of this flight; empty when it is known to."""
        self.lost: tuple[str, ...] = ()
        """Things that cannot be put back: the fence that was held before, or that it is switched on."""

    def tick(self, facts: Facts, state: State, values: Values) -> Acts:
        """Return the acts that bring our fence and the autopilot's in line with this flight."""
        if not facts.vehicle.armed or (state.identity is StateName.ARM and not state.may_take_off):
            self._reset()  # Arm uploads its fence itself
            return ()
        acts = self._follow_arm_place(facts)
        if self._fence is None:
            return acts
        may_write = facts.link.is_up and state.rank < Rank.PILOT
        if facts.limits.held == self._fence:
            acts += self._watch(self._fence, facts, values)
        else:
            acts += self._seat(self._fence, facts, may_write=may_write)
        acts += self._keep_on(facts, values, may_write=may_write)
        return acts

    def _follow_arm_place(self, facts: Facts) -> Acts:
        """Form the fence of this arm place, once, and put it in force."""
        place, datum, force = facts.position.arm_place, facts.position.datum, facts.limits.fence
        if place is None or datum is None or not _stands_there(facts, place):
            return ()
        armed_at = (datum, place.latitude, place.longitude)
        if self._armed_at == armed_at:
            return ()
        self._reset()
        self._armed_at = armed_at
        try:
            here = GlobalPose(place.latitude, place.longitude, place.altitude)
            wanted = facts.limits.plan.around(datum, here, self._settings.fence)
        except FenceError as error:
            self.problem = sentence(words_of(error))
            return ()
        if force is not None and is_about_same(force, wanted, SAME_M):
            self._fence = force
            return ()
        self._fence = wanted
        return (PutFenceInForce(wanted),)

    # -- held: it is read again ----------------------------------------------------------------------------------

    def _watch(self, fence: Fence, facts: Facts, values: Values) -> Acts:
        """Read and compare the fence that is held, under a pilot as well: nothing is changed."""
        acts: Acts = ()
        if self._held_at is None:
            self._held_at, self._corners = facts.now, values.get(CORNERS_NAME)
            if self._has_held and self._upload.is_wrong:
                acts = (Log("ok", say("The fence of this flight is in the autopilot again.")),)
        self._upload.rest(facts)
        self._end_comparison(facts, values)
        is_stale = facts.now - self._held_at > STALE_S
        self.problem = (
            say("The fence in the autopilot was not read for {time}.", time=seconds(STALE_S)) if is_stale else ""
        )
        self._is_compared = False
        corners = values.get(CORNERS_NAME)
        has_changed = None not in (corners, self._corners) and corners != self._corners
        is_due = has_changed or facts.now - self._held_at >= COMPARE_S
        if is_due and self._ask is None and facts.link.is_up and facts.now >= self._not_before:
            self._ask = Ask(CompareFence(fence), facts.now)
            acts += (self._ask,)
        return acts

    def _end_comparison(self, facts: Facts, values: Values) -> None:
        if self._ask is None or (answer := self._ask.answer(facts)).is_pending:
            return
        self._ask = None
        if answer.is_done:
            self._held_at, self._corners = facts.now, values.get(CORNERS_NAME)
        else:  # it could not be read: one that is another is not held any more
            self._not_before = facts.now + RETRY_S

    # -- not held: it is compared, and uploaded ------------------------------------------------------------------

    def _seat(self, fence: Fence, facts: Facts, *, may_write: bool) -> Acts:
        """Compare, then upload; again after a pause when it was not taken."""
        self.problem = self.problem or _WAIT
        acts: Acts = ()
        if self._held_at is not None:
            self._held_at, self._has_held, self._is_compared = None, True, False
        if self._ask is not None:
            answer = self._ask.answer(facts)
            if answer.is_pending:
                return ()
            self._ask, self._is_compared = None, answer.has_failed
            if self._has_held and OTHER_FENCE in answer.reason:
                acts = (_change(answer.reason, facts, may_write=may_write),)
        if not may_write:
            return acts
        if facts.limits.plan_problem:
            self.problem = sentence(facts.limits.plan_problem)
            return acts
        if self._is_compared:
            return acts + self._put_back(fence, facts)
        self._ask = Ask(CompareFence(fence), facts.now)
        return (*acts, self._ask)

    def _put_back(self, fence: Fence, facts: Facts) -> Acts:
        effort = self._upload if self._has_held else self._first_upload
        if not is_inside(facts):
            effort.rest(facts)
            self.problem = say("Outside the fence of this flight: Return To Launch, or Land.")
            return ()  # the autopilot would act on the breach at once
        acts = effort.put_back(UploadFence(fence), facts)
        text = say("The fence of this flight was not taken by the autopilot.")
        if effort.is_given_up and not self.lost:
            self.lost = (say("the fence"),)
            acts += (Log("error", say("The fence in the autopilot cannot be put back."), effort.reason),)
        elif effort.reason and not self.problem.startswith(text):
            acts += (Log("error", text, effort.reason),)
        self.problem = joined(text, sentence(effort.reason)) if effort.reason else _WAIT
        return acts

    # -- switched off --------------------------------------------------------------------------------------------

    def _keep_on(self, facts: Facts, values: Values, *, may_write: bool) -> Acts:
        """Switch a fence on again that a command or a switch turned off without a change of FENCE_ENABLE."""
        is_on = facts.diagnostics.fence_on
        self._was_on |= is_on is True
        is_off = is_on is False and values.get(FENCE_ENABLE.name) == 1 and facts.limits.held == self._fence
        off_s = self._off.update(is_off, facts.now)
        if off_s is None or off_s < SWITCH_CONFIRM_S or not may_write or not is_inside(facts):
            self._switch.rest(facts)
            return ()
        acts = self._switch.put_back(EnableFence(), facts)
        if acts:
            self._off = Stopwatch()  # SYS_STATUS must be given time to show it, else one change takes every try
            self._off.update(True, facts.now)
        if self._switch.is_given_up and self._was_on and not self.lost:
            self.lost = (say("the fence's switch"),)
            acts += (Log("error", say("The fence in the autopilot cannot be switched on again."), self._switch.reason),)
        return acts


def is_inside(facts: Facts) -> bool:
    """Return False where the autopilot's fence, once it is enabled, would act on a breach at once."""
    place, fence = facts.place, facts.limits.fence
    return place is not None and fence is not None and contains(fence, place.point) and place.height <= fence.ceiling


def _change(reason: str, facts: Facts, *, may_write: bool) -> Log:
    who = changed_by(facts, (FENCE,))
    does = say("Putting it back.") if may_write else LATER
    return Log(
        "warning",
        joined(say("The fence in the autopilot was changed."), who.message, does),
        joined(sentence(reason), who.details),
    )


def _stands_there(facts: Facts, place: ArmPlace) -> bool:
    """Return False when the drone stands on the ground away from the arm place: that one is of an earlier flight."""
    if not facts.is_on_ground:
        return True
    here = facts.global_place
    if here is None:
        return False
    return to_map(here, place.latitude, place.longitude).distance(MapPoint(0.0, 0.0)) <= ARM_PLACE_M
