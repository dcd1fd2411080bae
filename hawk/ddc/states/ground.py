"""The states on the ground, and the one that leaves it: Idle, Configure, Arm and Takeoff."""

from __future__ import annotations

import math
from enum import Enum, auto

from hawk.comm.protocol.commands import Disarm, Takeoff
from hawk.ddc import orders
from hawk.ddc.acts import (
    STAY,
    Acts,
    Log,
    PutFenceInForce,
    SetArmed,
    SetDatum,
    SetReturnAltitude,
    Step,
    StoreFence,
    StoreHeights,
    TakeOff,
    UploadFence,
    UseHeights,
)
from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import FenceError
from hawk.ddc.fence.plan import FencePlan
from hawk.ddc.motion import Goal
from hawk.ddc.readings.operator import SOME_OPERATOR
from hawk.ddc.settings import DdcSettings
from hawk.ddc.states.base import AirborneState, ModeKeeper, PendingRequest, State
from hawk.ddc.words import metres, seconds
from hawk.model.operation import StateName
from hawk.model.plans import Fence, HeightParameters
from hawk.model.sentences import joined, say, words_of
from hawk.model.vehicle import CopterMode

SAVE_HEIGHTS_TIMEOUT_S = 40.0
"""The return altitude takes up to two tries of some real seconds under its two names; simulations run up to 4 times."""
SAVE_FENCE_TIMEOUT_S = 10.0
ARM_TIMEOUT_S = 20.0
"""From the command to "armed", fence upload included, seconds."""
ARMED_WAIT_S = 3.0
""""Armed" follows the acknowledgement by up to 0.9 s."""
AUTO_DISARM_S = 10.0
"""ArduCopter's DISARM_DELAY: motors stop without take-off."""


class IdleState(State):
    """Disarmed, on the ground; the entry state (TRANS_002). Waits for Configure or Arm."""

    identity = StateName.IDLE
    on_ground = True

    def __init__(self, now: float, reason: str = "") -> None:
        super().__init__(now)
        self._reason = reason

    def detail(self, facts: Facts) -> str:
        """Return the reason for the state, else that the drone is on the ground."""
        return self._reason or say("On the ground.")

    def transition_next_state(self, facts: Facts, order: orders.Order | None = None) -> Step:
        """Follow Configure, a fence or Arm."""
        match order:
            case orders.ConfigureOrder() | orders.FenceOrder():
                return Step(orders.ToConfigure(order))
            case orders.ArmOrder(checks, by):
                return Step(orders.ToArm(checks=checks, by=by))
            case _:
                return STAY


class ConfigureState(State):
    """Writes the parameter file (off the loop), then sets the return altitude to Max and reads it back."""

    identity = StateName.CONFIGURE
    on_ground = True

    def __init__(self, now: float, heights: HeightParameters, settings: DdcSettings) -> None:
        super().__init__(now)
        self._heights = heights
        self._sets_altitude = settings.set_rtl_altitude
        self._storing = PendingRequest()
        self._return_altitude = PendingRequest()

    def detail(self, facts: Facts) -> str:
        """Return the present step."""
        return say("Saving the heights.")

    def enter(self, facts: Facts) -> Acts:
        """Begin to store."""
        return (self._storing.ask(StoreHeights(self._heights), facts),)

    def process(self, facts: Facts) -> Acts:
        """When the heights are stored, put them in force and set the return altitude."""
        if not self._storing.is_done(facts) or self._return_altitude.is_open:
            return ()
        if not self._sets_altitude:
            return (UseHeights(self._heights),)
        altitude = self._return_altitude.ask(SetReturnAltitude(self._heights.maximum), facts)
        return UseHeights(self._heights), altitude

    def transition_next_state(self, facts: Facts, order: orders.Order | None = None) -> Step:
        """Return to Idle when it is done, failed, or takes too long."""
        if failed := self._storing.failure(facts):
            return _to_idle(Log("error", say("The heights were not saved."), failed.reason))
        if failed := self._return_altitude.failure(facts):
            return _to_idle(Log("error", say("Heights saved, but the return height was not set."), failed.reason))
        if self._storing.is_done(facts) and (not self._sets_altitude or self._return_altitude.is_done(facts)):
            low, travel, high = self._heights.minimum, self._heights.desired, self._heights.maximum
            words = say(
                "Flies at {travel:g} m, never below {low:g} m or above {high:g} m.", travel=travel, low=low, high=high
            )
            return _to_idle(Log("ok", words))
        if self.age(facts) > SAVE_HEIGHTS_TIMEOUT_S:
            return _to_idle(Log("error", say("Saving the heights took too long.")))
        return STAY


class ConfigureFenceState(State):
    """Writes the fence file off the loop; until then Arm is refused and the old fence is valid."""

    identity = StateName.CONFIGURE
    on_ground = True

    def __init__(self, now: float, plan: FencePlan | None) -> None:
        """Store ``plan``; None drops the drawn fence, and the configured one is used again."""
        super().__init__(now)
        self._plan = plan
        self._storing = PendingRequest()

    def detail(self, facts: Facts) -> str:
        """Return the present step."""
        return say("Saving the fence.")

    def enter(self, facts: Facts) -> Acts:
        """Begin to store."""
        return (self._storing.ask(StoreFence(self._plan), facts),)

    def transition_next_state(self, facts: Facts, order: orders.Order | None = None) -> Step:
        """Return to Idle when it is stored, failed, or takes too long."""
        if failed := self._storing.failure(facts):
            return _to_idle(Log("error", say("The fence was not saved."), failed.reason))
        if self._storing.is_done(facts):
            gone = say("The drawn fence was removed; the standard one is used.")
            return _to_idle(Log("ok", say("The fence is saved.") if self._plan else gone))
        if self.age(facts) > SAVE_FENCE_TIMEOUT_S:
            return _to_idle(Log("error", say("Saving the fence took too long.")))
        return STAY


def _to_idle(log: Log) -> Step:
    return Step(orders.ToIdle(log.text), (log,))


class _ArmStep(Enum):
    FENCE = auto()
    MODE = auto()
    ARM = auto()
    WAIT = auto()
    ARMED = auto()


class ArmState(State):
    """Uploads the fence, goes to GUIDED, arms, and waits for take-off.

    With ``armed`` it begins with a drone that is armed on the ground in GUIDED.
    """

    identity = StateName.ARM
    on_ground = True

    def __init__(self, now: float, settings: DdcSettings, armed: bool, reason: str, checks: int) -> None:
        """``checks``: the number of preflight checks that passed."""
        super().__init__(now)
        self._settings = settings
        self._checks = checks
        self._step = _ArmStep.ARMED if armed else _ArmStep.FENCE
        self._step_began = now
        self._reason = reason
        self._no_fence = ""
        self._fence: Fence | None = None
        self._pending = PendingRequest()
        self._disarming = PendingRequest()
        self._guided = ModeKeeper(CopterMode.GUIDED)

    @property
    def may_take_off(self) -> bool:
        """True once "armed" was seen."""
        return self._step is _ArmStep.ARMED

    def detail(self, facts: Facts) -> str:
        """Return the present step; the countdown once armed."""
        if not self.may_take_off:
            return say("Arming.")
        left = seconds(AUTO_DISARM_S - (facts.now - self._step_began))
        return joined(self._reason or say("Armed."), say("Motors stop in {left} without take-off.", left=left))

    def enter(self, facts: Facts) -> Acts:
        """Begin with the fence, unless the drone is armed already."""
        if self._step is not _ArmStep.FENCE:
            return ()
        return self._begin_fence(facts)

    def process(self, facts: Facts) -> Acts:
        """Take the next step when the one before is done."""
        acts: list[Acts] = []
        if self._step is _ArmStep.FENCE and self._pending.is_done(facts) and self._fence is not None:
            acts.append((PutFenceInForce(self._fence),))
            self._next(_ArmStep.MODE, facts)
        if self._step is _ArmStep.MODE:
            acts.append(self._guided.reach(facts))
            if self._guided.is_reached:
                self._next(_ArmStep.ARM, facts)
                acts.append((self._pending.ask(SetArmed(True), facts),))
        if self._step is _ArmStep.ARM and self._pending.is_done(facts):
            self._next(_ArmStep.WAIT, facts)
        if self._step in (_ArmStep.ARM, _ArmStep.WAIT) and facts.vehicle.armed:
            self._next(_ArmStep.ARMED, facts)
            by = self.asked_by or SOME_OPERATOR
            acts.append((Log("ok", say("Armed by {by}. {checks} checks passed.", by=by, checks=self._checks)),))
        return sum(acts, ())

    def transition_next_state(self, facts: Facts, order: orders.Order | None = None) -> Step:
        """Follow Takeoff and Disarm; give up when refused, timed out or without an operator."""
        if isinstance(order, Takeoff):
            return Step(orders.ToTakeoff())
        if isinstance(order, Disarm):
            return self._disarm(facts)
        if not facts.operator.is_present:
            return _give_up(say("The operator was lost: motors off."))
        return self._watch_armed(facts) if self.may_take_off else self._watch_arming(facts)

    def _watch_armed(self, facts: Facts) -> Step:
        if not facts.vehicle.armed:
            return Step(orders.ToIdle(say("Motors off.")))
        if not facts.is_guided:
            return Step(orders.ToManual())
        if failed := self._disarming.failure(facts):
            self._disarming.clear()
            return Step(acts=(Log("error", say("Disarm was refused."), failed.reason),))
        return STAY

    def _watch_arming(self, facts: Facts) -> Step:
        if self._no_fence:
            return _give_up(say("There is no fence to fly in."), self._no_fence)
        if failed := self._pending.failure(facts):
            what = say("The fence was not taken.") if self._step is _ArmStep.FENCE else say("Arm was refused.")
            return _give_up(what, failed.reason)
        if self._step is _ArmStep.WAIT and facts.now - self._step_began > ARMED_WAIT_S:
            return _give_up(say("Arm was taken, but the drone does not arm."), facts.link.words)
        if self.age(facts) > ARM_TIMEOUT_S:
            return _give_up(say("Arming took too long."), self._guided.reason or facts.link.words)
        return STAY

    def _begin_fence(self, facts: Facts) -> Acts:
        place, datum = facts.global_place, facts.position.datum
        if place is None:
            self._no_fence = say("the position is not known")
            return ()
        if facts.limits.plan_problem:
            self._no_fence = facts.limits.plan_problem
            return ()
        try:
            self._fence = facts.limits.plan.around(datum or place, place, self._settings.fence)
        except FenceError as error:
            self._no_fence = words_of(error)
            return ()
        upload = self._pending.ask(UploadFence(self._fence), facts)
        return (upload,) if datum is not None else (SetDatum(place), upload)

    def _disarm(self, facts: Facts) -> Step:
        if not self.may_take_off:
            return _give_up(say("Arming was stopped by {name}.", name=facts.operator.controller or SOME_OPERATOR))
        if not facts.is_on_ground:
            return STAY  # the motors of a drone in the air are cut by Kill alone
        return Step(acts=(self._disarming.ask(SetArmed(False), facts),))

    def _next(self, step: _ArmStep, facts: Facts) -> None:
        self._step, self._step_began = step, facts.now


def _give_up(text: str, details: str = "") -> Step:
    return Step(orders.ToIdle(joined(text, details), gave_up_arming=True), (Log("error", text, details),))


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
        self._pending = PendingRequest()
        self._airborne = False
        self._best = -math.inf
        self._best_at = now

    def detail(self, facts: Facts) -> str:
        """Return the height of the climb."""
        return say("Climbing to {desired}.", desired=metres(facts.limits.heights.desired))

    def enter(self, facts: Facts) -> Acts:
        """Ask for the take-off."""
        return (self._pending.ask(TakeOff(facts.limits.heights.desired), facts),)

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
                return Step(orders.ToCommunicationLost(given_back_by=facts.operator.given_back_by))
            return Step(orders.ToHover(say("At {wanted}.", wanted=metres(wanted)), _above(facts, wanted)))
        if facts.now - self._best_at > NO_CLIMB_S:
            return Step(orders.ToHover(say("The climb stopped."), level="warning"))
        return STAY

    def _decide_on_ground(self, facts: Facts) -> Step:
        if failed := self._pending.failure(facts):
            return _refuse(facts, say("Take-off was refused."), failed.reason)
        if self.age(facts) > GROUND_S:
            return _refuse(facts, say("It did not take off."), facts.link.words)
        return STAY


def _refuse(facts: Facts, text: str, details: str) -> Step:
    following = orders.ToArm(armed=True, reason=text) if facts.vehicle.armed else orders.ToIdle(text)
    return Step(following, (Log("error", text, details),))


def _above(facts: Facts, height: float) -> Goal | None:
    place = facts.place
    return None if place is None else Goal(place.north, place.east, height, place.yaw)
