"""Keeps the operation state in line with the autopilot: found, lost, armed, changed by somebody else, position jumped.

`state_from_autopilot` is the one mapping. It is used at start, after a lost link or reboot, and at every mode change
that we did not ask for. Adopting a state sends nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from enum import Enum

from hawk.ddc.acts import (
    STAY,
    Act,
    Acts,
    Ask,
    CountStart,
    ForgetAskedModes,
    ForgetHeldFence,
    Log,
    Record,
    SetArmed,
    SettleMode,
    Step,
)
from hawk.ddc.facts import Facts
from hawk.ddc.orders import Cause, CauseKind, Rank, ToArm, ToHover, ToIdle, ToReturn, Transition
from hawk.ddc.readings.link import VehicleEvent
from hawk.ddc.states.base import State
from hawk.ddc.states.factory import adopted
from hawk.model.moment import Moment
from hawk.model.operation import FlightSoFar, StateName
from hawk.model.sentences import joined, say
from hawk.model.vehicle import CopterMode, LandedState

RESTART_WINDOW_S = 60.0
"""Starts in the air are counted over this time, seconds."""

FLIGHT_KEPT_S = 120.0
"""A flight whose last record is older has ended, seconds: on its own failsafes the drone is down by then."""


class RestartRule(Enum):
    """The action at a start in the air."""

    ADOPT = "adopt"
    """Adopt the state that stands for the autopilot's activity."""
    RETURN_HOME = "return home"
    """Something is wrong with us: Return To Launch before anything else (not in Manual, RTL, Land)."""
    STAY_AWAY = "stay away"
    """Do not open MAVLink until disarmed: the autopilot's own failsafe has the drone."""


def flight_goes_on(kept: FlightSoFar | None, now: Moment, speed: float) -> tuple[float, float] | None:
    """Return time (seconds) and distance (metres) of the flight in which this program started; None when unknown.

    ``speed``: the daemon's seconds per real second. The wall clock alone ends no flight. A computer that booted a
    moment ago may have done so in the air: the flight goes on until the autopilot is heard to be disarmed. How long the
    computer was down is the wall clock's word then, within what is possible.
    """
    if kept is None:
        return None
    passed = now.since(kept.moment)
    if passed is None:
        passed = max(now.seconds, min(now.utc - kept.moment.utc, FLIGHT_KEPT_S))
    if passed > FLIGHT_KEPT_S:
        return None
    return kept.seconds + passed * speed, kept.distance_m


def starts_before(starts: Iterable[Moment], flight: FlightSoFar | None, now: Moment) -> int:
    """Return the number of starts in the air within the last RESTART_WINDOW_S.

    One of an earlier boot counts when this boot and the end of that one lie within the window: the computer booted in
    the air, and how long it was down is not known. ``flight``: the flight that goes on; its last word is the end.
    """
    return sum(_is_recent(start, flight, now) for start in starts)


def _is_recent(start: Moment, flight: FlightSoFar | None, now: Moment) -> bool:
    passed = now.since(start)
    if passed is not None:
        return passed < RESTART_WINDOW_S
    ran_on = None if flight is None else flight.moment.since(start)
    return ran_on is not None and max(0.0, ran_on) + now.seconds < RESTART_WINDOW_S


def restart_rule(starts_in_the_air: int) -> RestartRule:
    """Return the action at this start, counted with those of the last RESTART_WINDOW_S before it (1: the first)."""
    if starts_in_the_air >= 3:
        return RestartRule.STAY_AWAY
    return RestartRule.RETURN_HOME if starts_in_the_air == 2 else RestartRule.ADOPT


ABANDONED_S = 15.0
"""Within this time after an arming that was given up, "armed" is answered by a disarm, seconds."""
DISARM_RETRY_S = 2.0

FALLEN = Step(ToIdle(say("Motors off in the air.")))
_HOLDING = frozenset({CopterMode.GUIDED, CopterMode.BRAKE})
_RETURNING = frozenset({CopterMode.RTL, CopterMode.SMART_RTL})


def state_from_autopilot(
    armed: bool, landed: LandedState, custom_mode: int | None, at_start: bool = False
) -> StateName:
    """Return the state that stands for the autopilot's activity.

    ``at_start``: the daemon has just begun, so that nobody knows whether an operator is there.
    """
    if not armed:
        return StateName.IDLE
    if landed is LandedState.ON_GROUND:
        return StateName.ARM if custom_mode == CopterMode.GUIDED else StateName.MANUAL
    if custom_mode in _RETURNING:
        return StateName.RETURN_TO_LAUNCH
    if custom_mode == CopterMode.LAND:
        return StateName.LAND
    if custom_mode in _HOLDING:
        return StateName.COMMUNICATION_LOST if at_start else StateName.HOVER
    return StateName.MANUAL


def forgotten(facts: Facts) -> Acts:
    """Return what is not known any more after a new mode, and after the link was lost.

    These acts come before all others of a tick: a mode that the tick asks for stays ours.
    """
    mode = facts.link.new_mode
    settled: Acts = () if mode is None else (SettleMode(mode),)
    return (*settled, ForgetHeldFence()) if VehicleEvent.LINK_LOST in facts.link.events else settled


class VehicleFollower:
    """Decides on the autopilot's changes, from facts and from the armings and starts that it remembers."""

    def __init__(self) -> None:
        self._abandoned: float | None = None
        self._disarm_asked = float("-inf")
        self._awaits_count = False
        self.started_in_air = False
        """True when this program found the drone in the air."""

    def note(self, transition: Transition, now: float) -> None:
        """Take a transition: an "armed" that comes after an arming was given up is answered by a disarm."""
        if isinstance(transition, ToArm):
            self._abandoned = None
        elif isinstance(transition, ToIdle) and transition.gave_up_arming:
            self._abandoned = now

    def answer(self, event: VehicleEvent, facts: Facts, state: State) -> Step:
        """Return the step that an event causes."""
        record = Record("vehicle", (("event", event.name), ("mode", facts.vehicle.mode)))
        match event:
            case VehicleEvent.LINK_LOST:
                return Step(acts=(record, Log("error", say("No word from the autopilot.")), ForgetAskedModes()))
            case VehicleEvent.FOUND:
                return _before(record, Log("ok", say("Autopilot found.")), step=self._begin(facts, state))
            case VehicleEvent.LINK_BACK:
                step = self.adopt(facts, state, keeps_rank=True)
                return _before(record, Log("ok", say("The autopilot is heard again.")), step=step)
            case VehicleEvent.DOUBTED:
                consequence = say("It counts as in the air.") if facts.is_airborne else ""
                return Step(acts=(record, Log("warning", joined(facts.ground.doubt, consequence))))
            case VehicleEvent.FOREIGN_MODE if facts.vehicle.armed:
                return _before(record, ForgetAskedModes(), step=self.adopt(facts, state))
            case _:
                return Step(acts=(record,))

    def follow(self, facts: Facts, state: State) -> Step:
        """Return the step that arming, disarming and the count of starts cause, once a tick."""
        if not facts.link.is_up:
            return STAY
        if self._awaits_count and facts.starts_in_air is not None:
            self._awaits_count = False
            return _restart(facts.starts_in_air, state)
        return self._follow_arming(facts, state)

    def follow_jump(self, facts: Facts, state: State) -> Step:
        """Return the step that a jump of the position causes: tasks end, a state that holds forms its goal again.

        A jump of the estimate moves the drone on the map. Its goal of before is not flown to: the drone did not move.
        """
        jump, estimate = facts.position.jump_m, facts.position.estimate_jump_m
        if max(jump, estimate) <= 0 or state.on_ground:
            return STAY
        message = Log("warning", say("The position jumped by {jump:.1f} m.", jump=jump))
        if estimate > 0:
            message = Log(
                "warning",
                say("The position estimate jumped by {estimate:.0f} m: the map may not fit it.", estimate=estimate),
            )
        if state.is_task:
            return Step(ToHover(say("The position jumped."), level="warning"), (message,))
        return Step(acts=(message,), restarts=state.holds)

    def adopt(self, facts: Facts, state: State, *, at_start: bool = False, keeps_rank: bool = False) -> Step:
        """Return the step to the autopilot's state. ``keeps_rank``: a state that outranks it, and the same, goes on."""
        vehicle, current = facts.vehicle, state.identity
        name = state_from_autopilot(vehicle.armed, vehicle.landed, vehicle.custom_mode, at_start)
        if name is StateName.IDLE:
            if not state.on_ground:
                return _down(facts)
            return Step(ToIdle()) if at_start else STAY
        outranks = name is StateName.HOVER and Rank.COMMUNICATION_LOST <= state.rank <= Rank.LAND
        if keeps_rank and (name is current or outranks):
            return Step(restarts=state.holds or state.is_homing)
        if current is StateName.ARM and name is StateName.ARM:
            return STAY
        return Step(adopted(name, facts))

    def _begin(self, facts: Facts, state: State) -> Step:
        step = self.adopt(facts, state, at_start=True)
        if step.transition is None or not facts.is_airborne:
            return step
        self.started_in_air = self._awaits_count = True
        message = Log("warning", say("The program started while the drone was in the air."))
        return Step(step.transition, (*step.acts, CountStart(), message))

    def _follow_arming(self, facts: Facts, state: State) -> Step:
        if not facts.vehicle.armed:
            return STAY if state.on_ground else _down(facts)
        if facts.is_airborne and state.on_ground:
            return self._leave_ground(facts, state)
        if state.identity is not StateName.IDLE:
            return STAY
        abandoned = self._abandoned is not None and facts.now - self._abandoned <= ABANDONED_S
        if not abandoned:
            return self.adopt(facts, state)
        if facts.now - self._disarm_asked < DISARM_RETRY_S:
            return STAY
        self._disarm_asked = facts.now
        message = Log("warning", say("Armed after it was given up: motors off."))
        return Step(acts=(message, Ask(SetArmed(False), facts.now)))

    def _leave_ground(self, facts: Facts, state: State) -> Step:
        """Return the step to the autopilot's state when a drone on the ground is not believed to stand any more."""
        step = self.adopt(facts, state)
        if not isinstance(step.transition, ToHover):
            return step
        is_unknown = facts.vehicle.landed is LandedState.UNDEFINED
        reason = say("Not known to stand on the ground.") if is_unknown else say("Somebody else took off.")
        return Step(replace(step.transition, reason=reason), step.acts, step.restarts)


def _down(facts: Facts) -> Step:
    """Return the step of a drone that was flying and is disarmed: a fall is no landing (`hawk.ddc.rules.kill`)."""
    if facts.fall is not None:
        return FALLEN
    return Step(ToIdle(say("Landed. Motors off.")), (Log("ok", say("Landed. Motors off.")),))


def _before(*acts: Act, step: Step) -> Step:
    return Step(step.transition, (*acts, *step.acts), step.restarts)


def _restart(starts: int, state: State) -> Step:
    record = Record("start in the air", (("starts", starts),))
    if restart_rule(starts) is RestartRule.ADOPT or state.is_left_alone:
        return Step(acts=(record,))
    cause = Cause(say("The program stopped twice in a minute."), CauseKind.NEVER)
    return Step(ToReturn(cause, straight=say("the program may stop again")), (record,))
