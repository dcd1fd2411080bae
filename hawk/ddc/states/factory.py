"""Makes the state of a transition, and the message that reports it: the one place that knows all states."""

from __future__ import annotations

from typing import Final

from hawk.comm.mavlink.foreign_writes import MODE, mode_subject
from hawk.ddc import orders
from hawk.ddc.acts import Acts, Log
from hawk.ddc.facts import Facts
from hawk.ddc.settings import DdcSettings
from hawk.ddc.states.base import State
from hawk.ddc.states.explore import AutonomousExploreState
from hawk.ddc.states.ground import ArmState, ConfigureFenceState, ConfigureState, IdleState, TakeoffState
from hawk.ddc.states.hover import PAGE_HIDDEN, CommunicationLostState, HoverState, ManualState
from hawk.ddc.states.moves import AutonomousMoveState, CompulsiveMoveState
from hawk.ddc.states.rtl_and_land import HomingState, LandState, ReturnToLaunchState
from hawk.ddc.words import direction, metres, seconds
from hawk.model.operation import StateName
from hawk.model.sentences import joined, say
from hawk.model.vehicle import ForeignWrite

ASKED_S: Final = 3.0
"""A mode shows at once: a station that asked for it longer ago did not cause it, seconds."""


def make_state(transition: orders.Transition, facts: Facts, settings: DdcSettings) -> tuple[State, Acts]:
    """Return the state that a transition leads to, and the messages for the operator."""
    state, acts = _make(transition, facts, settings)
    if isinstance(transition, orders.ToArm | orders.ToHover | orders.ToReturn | orders.ToLand):
        state.asked_by = transition.by
    return state, acts


def _make(transition: orders.Transition, facts: Facts, settings: DdcSettings) -> tuple[State, Acts]:
    now = facts.now
    match transition:
        case orders.ToIdle(reason):
            return IdleState(now, reason), ()
        case orders.ToConfigure(order):
            if isinstance(order, orders.FenceOrder):
                return ConfigureFenceState(now, order.plan), ()
            return ConfigureState(now, order.heights, settings), ()
        case orders.ToArm(armed, reason, checks):
            return ArmState(now, settings, armed, reason, checks), ()
        case orders.ToTakeoff():
            return TakeoffState(now), ()
        case orders.ToHover(reason, goal, passive, level):
            return HoverState(now, settings, reason, goal, passive), (Log(level, joined(reason, say("Holding."))),)
        case orders.ToExplore():
            begun = say("Lot found. Exploring.") if facts.limits.outline is None else say("Exploring the outline.")
            return AutonomousExploreState(now, settings), (Log("info", begun),)
        case orders.ToMove(move):
            kind = AutonomousMoveState if move.autonomous else CompulsiveMoveState
            return kind(now, move, settings), _move_messages(move, facts)
        case orders.ToReturn(cause, by_autopilot, straight):
            state = ReturnToLaunchState(now, settings, cause, by_autopilot, straight)
            return _home(state, transition.by, say("The autopilot returns home by itself."))
        case orders.ToLand(cause, by_autopilot):
            land = LandState(now, cause, by_autopilot)
            return _home(land, transition.by, say("The autopilot lands by itself."))
        case orders.ToCommunicationLost(passive, given_back_by, is_hidden):
            lost = CommunicationLostState(now, settings, passive, given_back_by)
            hold = seconds(settings.operator.operator_hold_s)
            then = say("Holds for {hold}, then returns home.", hold=hold)
            return lost, (Log("warning", joined(PAGE_HIDDEN if is_hidden else lost.reason, then)),)
        case orders.ToManual():  # pragma: no branch - the last kind of transition
            text = say("Someone else flies, in {mode}.", mode=facts.vehicle.mode or say("an unknown mode"))
            who = "" if _asking_station(facts) is None else _begun_by(facts)
            return ManualState(now), (Log("warning", text, joined(who, facts.link.words)),)


def adopted(name: StateName, facts: Facts) -> orders.Transition:
    """Return the transition to the state that stands for the autopilot's activity: adopting it sends nothing."""
    own = orders.Cause(_begun_by(facts), orders.CauseKind.ALWAYS, facts.link.words)
    match name:
        case StateName.RETURN_TO_LAUNCH:
            return orders.ToReturn(own, by_autopilot=True)
        case StateName.LAND:
            return orders.ToLand(own, by_autopilot=True)
        case StateName.MANUAL:
            return orders.ToManual()
        case StateName.HOVER:
            mode = facts.vehicle.mode or say("an unknown mode")
            by_itself = say("The autopilot went to {mode} by itself.", mode=mode)
            return orders.ToHover(_begun_by(facts) or by_itself, passive=True, level="warning")
        case StateName.COMMUNICATION_LOST:
            return orders.ToCommunicationLost(passive=True)
        case StateName.ARM:
            return orders.ToArm(armed=True)
        case _:
            return orders.ToIdle()


def _begun_by(facts: Facts) -> str:
    """Return who asked for the mode that nobody here asked for; empty where the autopilot itself says why."""
    if (station := _asking_station(facts)) is not None:
        return say(
            "Station {system} (component {component}) asked for it.",
            system=station.system,
            component=station.component,
        )
    return "" if facts.link.words else say("Another station asked for it, or the autopilot itself began it.")


def _asking_station(facts: Facts) -> ForeignWrite | None:
    """Return the station that asked for the present mode a moment ago; most links bring no word of it."""
    named = (MODE, mode_subject(facts.vehicle.custom_mode or 0))
    writes = (write for write in reversed(facts.link.foreign_writes) if facts.now - write.time <= ASKED_S)
    return next((write for write in writes if write.subject in named), None)


def _home(state: HomingState, by: str, by_itself: str) -> tuple[State, Acts]:
    cause, text = state.cause, state.doing.asked(by) if by else state.doing.plain
    if state.by_autopilot:
        words = joined(text, cause.text) if cause is not None and cause.text else by_itself
        return state, (Log("warning", words, "" if cause is None else cause.details),)
    if cause is None:
        return state, (Log("info", text),)
    return state, (Log("warning", joined(cause.text, text)),)


def _move_messages(order: orders.MoveOrder, facts: Facts) -> Acts:
    place = facts.last_place
    if place is None:
        return ()
    where = direction(order.place.north - place.north, order.place.east - place.east)
    distance = metres(place.point.distance(order.place))
    return (Log("info", say("Moving {distance} {where}.", distance=distance, where=where)),)
