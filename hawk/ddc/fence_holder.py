"""Sees to it that the autopilot holds the fence of this flight, also when another station armed the drone.

Our own Arm uploads its fence. A flight that was armed by somebody else, or that a restarted program finds in the air,
gets the fence of its arm place: first the autopilot's is read and compared, and only another one is replaced.
"""

from __future__ import annotations

from hawk.ddc.acts import Acts, Ask, CompareFence, Log, PutFenceInForce, UploadFence
from hawk.ddc.facts import Facts
from hawk.ddc.geofence import FenceError, contains, is_about_same, to_map
from hawk.ddc.settings import DdcSettings
from hawk.ddc.states.base import State
from hawk.ddc.words import sentence
from hawk.model.limits import Fence
from hawk.model.operation import StateName
from hawk.model.poses import ArmPlace, GlobalPose, MapPoint

SAME_M = 3.0
"""A fence built for a place this near, metres, is the fence of this arm place: the position wanders that far."""
ARM_PLACE_M = 10.0
"""A drone on the ground that is farther than this from the arm place stands at another one, metres."""
RETRY_S = 5.0
"""Pause after the fence was not taken, seconds."""
_WAIT = "The fence of this flight is being set: wait a moment."


class FenceHolder:
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
        self.problem = _WAIT
        """Reason why the autopilot is not known to hold the fence of this flight; empty when it is known to."""

    def tick(self, facts: Facts, state: State) -> Acts:
        """Return the acts that bring our fence and the autopilot's in line with this flight."""
        if not facts.vehicle.armed or (state.identity is StateName.ARM and not state.may_take_off):
            self._reset()  # Arm uploads its fence itself
            return ()
        acts = self._follow_arm_place(facts)
        if self._fence is None:
            return acts
        if facts.limits.held == self._fence:
            self.problem, self._ask, self._is_compared = "", None, False
            return acts
        self.problem = self.problem or _WAIT
        if facts.link.is_up and not state.is_left_alone:
            acts += self._seat(self._fence, facts)
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
            self.problem = sentence(str(error))
            return ()
        if force is not None and is_about_same(force, wanted, SAME_M):
            self._fence = force
            return ()
        self._fence = wanted
        return (PutFenceInForce(wanted),)

    def _seat(self, fence: Fence, facts: Facts) -> Acts:
        """Compare, then upload; again after a pause when it was not taken."""
        if self._ask is not None:
            answer = self._ask.answer(facts)
            if answer.is_pending:
                return ()
            uploaded = isinstance(self._ask.request, UploadFence)
            self._ask = None
            if answer.has_failed and uploaded:
                self._not_before = facts.now + RETRY_S
                text = "The fence of this flight was not taken by the autopilot."
                acts = (Log("error", text, answer.reason),) if not self.problem.startswith(text) else ()
                self.problem = f"{text} {sentence(answer.reason)}"
                return acts
        if facts.now < self._not_before:
            return ()
        return self._next(fence, facts)

    def _next(self, fence: Fence, facts: Facts) -> Acts:
        if facts.limits.plan_problem:
            self.problem = sentence(facts.limits.plan_problem)
            return ()
        if not self._is_compared:
            self._is_compared = True
            self._ask = Ask(CompareFence(fence), facts.now)
            return (self._ask,)
        if facts.place is None or not contains(fence, facts.place.point) or facts.place.height > fence.ceiling:
            self.problem = "Outside the fence of this flight: Return To Launch, or Land."
            return ()  # the autopilot would act on the breach at once
        self.problem = _WAIT
        self._ask = Ask(UploadFence(fence), facts.now)
        return (self._ask,)


def _stands_there(facts: Facts, place: ArmPlace) -> bool:
    """Return False when the drone stands on the ground away from the arm place: that one is of an earlier flight."""
    if not facts.is_on_ground:
        return True
    here = facts.global_place
    if here is None:
        return False
    return to_map(here, place.latitude, place.longitude).distance(MapPoint(0.0, 0.0)) <= ARM_PLACE_M
