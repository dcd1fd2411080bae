"""The states that stay at one place: Hover, CommunicationLost and, in someone else's hands, Manual."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

from hawk.comm.protocol.commands import Resume
from hawk.ddc.acts import STAY, Acts, SendTarget, Step
from hawk.ddc.facts import Facts
from hawk.ddc.fence import geometry
from hawk.ddc.motion import Carrot, Goal, distance, maximum_target_distance, stopping_point
from hawk.ddc.orders import Cause, CauseKind, Order, Rank, ToHover, ToLand, ToReturn
from hawk.ddc.settings import DdcSettings
from hawk.ddc.states.base import AirborneState, ModeKeeper, cause_here
from hawk.ddc.stopwatch import Stopwatch
from hawk.ddc.words import metres, seconds
from hawk.model.operation import StateName
from hawk.model.plans import Fence
from hawk.model.poses import MapPoint, MapPose
from hawk.model.sentences import joined, say
from hawk.model.vehicle import CopterMode

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
    if not geometry.contains(fence, true):
        true = geometry.inside_point(fence, true)
    target = MapPoint(true.north + place.off[0], true.east + place.off[1])
    return replace(goal, north=target.north, east=target.east) if geometry.contains(fence, target) else None


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


LOW_SHARE = 0.9
"""From this share of Min upwards a drone just below Min holds at Min; lower it brakes where it is."""
SHORTER_M = 1.0
"""A drone that drifts outside the fence is led to another place inside when that is nearer by this, metres."""
GUIDED_ATTEMPTS = 3
"""After this number of refusals of GUIDED no target can be formed: BRAKE."""

FOLLOWS_M_S = 1.5
"""The target follows what the camera sees at this pace, m/s: GNSS walks slower, a car in a low picture is faster."""
STRAYS_S = 3.0
"""A drone whose position is doubted lands when the camera could not hold it for this time, seconds."""
NOT_OFF = (0.0, 0.0)


class Holding:
    """Holds a GUIDED target at the stopping point; BRAKE where no target can be formed; never LOITER.

    ``passive``: the autopilot holds already and nothing is sent until the fence must be kept.
    """

    def __init__(self, settings: DdcSettings, goal: Goal | None = None, passive: bool = False) -> None:
        self._speed = settings.flight.speed_m_s
        self._goal = goal
        self._passive = passive
        self._guided = ModeKeeper(CopterMode.GUIDED)
        self._brake: ModeKeeper | None = None
        self._carrot = Carrot(self._speed)
        self._off, self._rise = NOT_OFF, 0.0
        self._led_at: float | None = None
        self._held: Goal | None = None
        self._strays = Stopwatch()
        self.is_recovering = False
        """True while the drone returns into the fence."""
        self.is_by_camera = False
        """True while the camera holds the place in spite of the reported position."""

    def strays_s(self, facts: Facts) -> float:
        """Return for how long the position has been doubted while the camera could not hold the drone, seconds."""
        return self._strays.read(facts.now) or 0.0

    def restart(self) -> None:
        """Hold where the drone is by its new position."""
        self._goal = self._held = self._led_at = None
        self.is_recovering = False

    def process(self, facts: Facts) -> Acts:
        """Form the goal if need be and return this tick's target."""
        self._keep_inside(facts)
        self._look(facts)
        if self._passive:
            return ()
        if self._brake is not None:
            return self._brake.reach(facts)
        goal = self._goal or self._formed(facts)
        if goal is None:
            self._brake = ModeKeeper(CopterMode.BRAKE)
            return self._brake.reach(facts)
        acts = self._guided.reach(facts)
        if self._guided.is_reached:
            self._goal = goal
            self._held = self._paced(facts, goal) or self._held or goal  # a goal of before the error lies far away
            return self._target(facts, self._held)
        if self._guided.attempts > GUIDED_ATTEMPTS:
            self._brake = ModeKeeper(CopterMode.BRAKE)
        return acts

    def _formed(self, facts: Facts) -> Goal | None:
        self._off, self._rise = facts.witness.place.off, facts.witness.height.off
        return _form_goal(facts)

    def _kept(self, facts: Facts, goal: Goal) -> Goal | None:
        """Return the goal as the witnesses of a doubted position keep the drone there; None where they cannot."""
        witness = facts.witness
        if self.is_recovering or not witness.is_displaced:
            return goal
        kept = held(facts, goal, self._off) if witness.place.is_doubted else goal
        return None if kept is None else raised(facts, kept, self._rise)

    def _paced(self, facts: Facts, goal: Goal) -> Goal | None:
        """Return the goal as it is kept. While the camera leads it, it moves no faster than `FOLLOWS_M_S`.

        The fence comes first: where the slower target would leave the drone outside, it is not slowed.
        """
        kept, led_at, self._led_at = self._kept(facts, goal), self._led_at, None
        if kept is None or self.is_recovering or not facts.witness.place.is_doubted:
            return kept
        self._led_at = facts.now
        if led_at is None or self._held is None:
            return kept  # what the position had gone before it was doubted is taken back at once
        share = min(1.0, FOLLOWS_M_S * (facts.now - led_at) / max(self._held.point.distance(kept.point), 1e-9))
        slower, off, fence = self._held.point.towards(kept.point, share), facts.witness.place.off, facts.limits.fence
        is_inside = fence is not None and geometry.contains(
            fence, MapPoint(slower.north - off[0], slower.east - off[1])
        )
        return replace(kept, north=slower.north, east=slower.east) if is_inside else kept

    def _look(self, facts: Facts) -> None:
        """Note whether the witnesses keep a drone whose position is doubted. Then it is led, whatever its mode."""
        is_doubted = facts.witness.is_displaced
        self._passive = self._passive and not is_doubted
        is_kept = self._goal is not None and self._kept(facts, self._goal) is not None
        self.is_by_camera = is_kept and facts.witness.place.is_doubted and not self.is_recovering
        self._strays.update(is_doubted and not (is_kept or self.is_recovering), facts.now)

    def _keep_inside(self, facts: Facts) -> None:
        if not facts.is_breached:
            self.is_recovering = False
            return
        here, fence = facts.place, facts.limits.fence
        if here is None or fence is None:
            return
        place = geometry.inside_point(fence, here.point)
        if self.is_recovering and self._goal is not None and not _is_nearer(here.point, place, self._goal.point):
            return
        height = min(here.height, fence.ceiling - geometry.RECOVERY_DEPTH_M)
        self._goal = Goal(place.north, place.east, height, here.yaw)
        if self.is_recovering:
            return
        self._passive = False
        self._brake = None
        self._guided = ModeKeeper(CopterMode.GUIDED)
        self.is_recovering = True

    def _target(self, facts: Facts, goal: Goal) -> Acts:
        here = facts.place
        if here is None:
            return ()
        lowest = facts.limits.heights.minimum
        near = distance(here, goal) <= maximum_target_distance(self._speed)
        if not near and self.is_recovering and _takes_no_step(facts, here):
            return (SendTarget(replace(goal, height=_reachable_height(goal, here, self._speed))),)
        if near and here.height >= LOW_SHARE * lowest:
            return (SendTarget(goal),)
        highest = facts.ceiling(on_ground=False)
        return (SendTarget(self._carrot.step(goal, here, facts.now, lowest, highest)),)


def _is_nearer(here: MapPoint, place: MapPoint, goal: MapPoint) -> bool:
    """Return True when the place is the nearer one by so much that the wind, not noise, moved the drone."""
    return here.distance(place) < here.distance(goal) - SHORTER_M


def _takes_no_step(facts: Facts, here: MapPose) -> bool:
    """Return True outside the autopilot's own fence while it is on: no target out there is taken, only one inside."""
    fence = facts.limits.fence
    if fence is None or not facts.diagnostics.fence_on or here.height > fence.autopilot_ceiling:
        return False
    return not geometry.contains(geometry.autopilot_fence(fence), here.point)


def _reachable_height(goal: Goal, here: MapPose, speed: float) -> float:
    reach = maximum_target_distance(speed)
    return min(max(goal.height, here.height - reach), here.height + reach)


def _form_goal(facts: Facts) -> Goal | None:
    """Return the goal of a drone that holds where it is; None where no target can be formed, and below Min."""
    pose, place, fence, heights = facts.pose, facts.place, facts.limits.fence, facts.limits.heights
    goal = None if pose is None else stopping_point(pose)
    if goal is None or place is None or fence is None or place.height < LOW_SHARE * heights.minimum:
        return None
    stop = _reachable(fence, place.point, goal.point)
    highest = max(heights.maximum, math.floor(place.height))
    height = min(max(goal.height, heights.minimum), highest, fence.ceiling)
    return replace(goal, north=stop.north, east=stop.east, height=height)


def _reachable(fence: Fence, start: MapPoint, stop: MapPoint) -> MapPoint:
    """Return the stopping point, or the nearest place to it inside the fence on this side of its edge."""
    inside = stop if geometry.contains(fence, stop) else geometry.inside_point(fence, stop, geometry.EDGE_MARGIN_M)
    if not geometry.contains(fence, start) or geometry.path_is_inside(fence, start, inside):
        return inside
    return geometry.last_inside(fence, start, stop)


def _astray(facts: Facts, holding: Holding) -> Step | None:
    """Return the landing of a drone whose position is doubted and that the camera cannot hold: RTL is no better."""
    if holding.strays_s(facts) < STRAYS_S:
        return None
    if facts.witness.place.is_doubted:
        text = say("{doubt} The camera cannot hold it here.", doubt=facts.witness.doubt)
    else:
        text = say("{doubt} It cannot be held below the ceiling.", doubt=facts.witness.doubt)
    return Step(ToLand(Cause(text, CauseKind.NEVER)))


class HoverState(AirborneState):
    """Holds ``goal``, else the stopping point, and waits for the operator."""

    identity = StateName.HOVER
    is_guarded = needs_operator = may_send_targets = holds = True

    def __init__(
        self, now: float, settings: DdcSettings, reason: str = "", goal: Goal | None = None, passive: bool = False
    ) -> None:
        super().__init__(now)
        self._reason = reason
        self._holding = Holding(settings, goal, passive)

    @property
    def rank(self) -> Rank:
        """Rank of the fence while the drone returns into it."""
        return Rank.FENCE if self._holding.is_recovering else Rank.TASK

    def detail(self, facts: Facts) -> str:
        """Return the reason and the height."""
        if self._holding.is_recovering:
            return geometry.recovery_words(facts.limits.fence, facts.place)
        height = facts.height
        if height is not None and self._holding.is_by_camera:
            held = say("Holding at {height} by the camera.", height=metres(height))
        else:
            held = say("Holding.") if height is None else say("Holding at {height}.", height=metres(height))
        return joined(self._reason, held)

    def restart(self) -> None:
        """Hold where the drone is by its new position."""
        self._holding.restart()

    def process(self, facts: Facts) -> Acts:
        """Hold."""
        return self._holding.process(facts)

    def _decide(self, facts: Facts) -> Step:
        return _astray(facts, self._holding) or STAY


PAGE_HIDDEN: Final = say("The page of the operator in control is hidden.")


class CommunicationLostState(AirborneState):
    """Holds for ``operator_hold_s``, then returns home; nothing resumes by itself when the operator is back."""

    identity = StateName.COMMUNICATION_LOST
    is_guarded = may_send_targets = holds = True

    def __init__(self, now: float, settings: DdcSettings, passive: bool = False, given_back_by: str = "") -> None:
        super().__init__(now)
        self._given_back_by = given_back_by
        self._hold_s = settings.operator.operator_hold_s
        self._passive = passive
        self._holding = Holding(settings, passive=passive)

    @property
    def reason(self) -> str:
        """One sentence: why nobody commands the drone."""
        by = self._given_back_by
        return say("Control was given back by {by}.", by=by) if by else say("No word from the operator.")

    @property
    def rank(self) -> Rank:
        """Above fence and task."""
        return Rank.COMMUNICATION_LOST

    def return_in(self, facts: Facts) -> float:
        """Return the seconds until the drone returns home."""
        return max(0.0, self._hold_s - self.age(facts))

    def detail(self, facts: Facts) -> str:
        """Return the time until the drone returns home."""
        reason = PAGE_HIDDEN if facts.operator.is_present and facts.operator.is_away else self.reason
        return say("{reason} Returns home in {return_in}.", reason=reason, return_in=seconds(self.return_in(facts)))

    def restart(self) -> None:
        """Hold where the drone is by its new position."""
        self._holding.restart()

    def process(self, facts: Facts) -> Acts:
        """Hold."""
        return self._holding.process(facts)

    def _decide(self, facts: Facts) -> Step:
        if facts.operator.is_present and not facts.operator.is_away:
            return Step(ToHover(self._words_of_return(facts), passive=self._passive))
        if self.return_in(facts) <= 0:
            text = say("Nobody took control.") if self._given_back_by else say("The operator is lost.")
            cause, misleads = Cause(text, CauseKind.OPERATOR), facts.witness.misleads_home
            return Step(ToLand(cause_here(facts, cause)) if misleads else ToReturn(cause))
        return _astray(facts, self._holding) or STAY

    def _words_of_return(self, facts: Facts) -> str:
        if not self._given_back_by:
            return say("The operator is back.")
        return say("{controller} has taken control.", controller=facts.operator.controller or say("Someone"))


class ManualState(AirborneState):
    """Someone else flies: nothing is commanded, everything is shown.

    It ends when the pilot gives back, or when the operator takes the drone by a confirmed command.
    """

    identity = StateName.MANUAL
    is_left_alone = True

    @property
    def rank(self) -> Rank:
        """Nothing automatic acts here."""
        return Rank.PILOT

    def detail(self, facts: Facts) -> str:
        """Return the pilot's mode."""
        return say("Someone else flies, in {mode}.", mode=facts.vehicle.mode or say("an unknown mode"))

    def _follow(self, facts: Facts, order: Order) -> Step:
        if isinstance(order, Resume):
            return Step(ToHover(say("Taken back.")))
        return super()._follow(facts, order)
