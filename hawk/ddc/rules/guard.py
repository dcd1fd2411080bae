"""Automatic reactions: battery, operator, fence and ceiling, clearance, position, perception, in their order."""

from __future__ import annotations

from dataclasses import dataclass

from hawk.ddc.acts import Acts, Log
from hawk.ddc.battery.battery import BATTERY_UNKNOWN_S, RESERVE_CONFIRM_S
from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import recovery_words
from hawk.ddc.motion import Goal
from hawk.ddc.orders import Cause, CauseKind, Rank, ToCommunicationLost, ToHover, ToLand, ToReturn, Transition
from hawk.ddc.readings.clearance import LOW_S
from hawk.ddc.readings.operator import HIDDEN_S
from hawk.ddc.readings.position import POSITION_CONFIRM_S
from hawk.ddc.readings.sight import FAULT_CONFIRM_S
from hawk.ddc.readings.topic_interface import POSE_TIMEOUT_S
from hawk.ddc.states.base import State, cause_here
from hawk.ddc.words import metres
from hawk.model.sentences import say

WIND_CONFIRM_S = 10.0
"""Seconds for which the wind must be above the limit: a gust does not count."""
FENCE_RETURN_S = 10.0
"""Seconds outside the fence after which the drone returns."""
RADIO_LOST_DETAILS = say("The flight goes on; the autopilot's own failsafe (FS_THR_ENABLE) decides.")


@dataclass(frozen=True, slots=True)
class Reaction:
    """A transition that the guard wants, and its rank."""

    rank: Rank
    transition: Transition


def reaction(facts: Facts, state: State) -> Reaction | None:
    """Return the highest reaction that outranks the state; None when there is none."""
    return next((found for found in _candidates(facts, state) if found.rank > state.rank), None)


def notices(facts: Facts) -> Acts:
    """Return the messages that a condition causes in the tick in which it begins."""
    if facts.limits.breached_s == 0.0:
        return (Log("warning", recovery_words(facts.limits.fence, facts.place)),)
    charge = facts.battery.charge
    if 0.0 in (charge.low_s, charge.critical_s):
        return (Log("warning", say("The battery's voltage sags: {words}", words=charge.words)),)
    if charge.doubt and charge.doubted_s == 0.0 and facts.is_airborne:
        words = say(
            "The battery's counter is not believed: {doubt}. The charge is counted by voltage and time.",
            doubt=charge.doubt,
        )
        return (Log("warning", words, charge.words),)
    if facts.remote_control.lost_s == 0.0:
        return (Log("warning", say("The remote control is lost: nobody can take over by hand."), RADIO_LOST_DETAILS),)
    return ()


def _candidates(facts: Facts, state: State) -> list[Reaction]:
    """Return the reactions for a state, highest rank first."""
    found: list[Reaction] = []
    charge = facts.battery.charge
    if charge.is_critical and not state.on_ground:
        empty = Cause(say("The battery's voltage is nearly gone."), CauseKind.VOLTAGE)
        found.append(Reaction(Rank.LAND, ToLand(empty)))
    cause = _cause_to_return(facts) if state.is_guarded else None
    if cause is not None and facts.witness.misleads_home:
        found.append(Reaction(Rank.LAND, ToLand(cause_here(facts, cause))))
    elif cause is not None:
        found.append(Reaction(Rank.RETURN_TO_LAUNCH, ToReturn(cause)))
    if state.needs_operator and not facts.operator.is_present:
        found.append(Reaction(Rank.COMMUNICATION_LOST, ToCommunicationLost(given_back_by=facts.operator.given_back_by)))
    elif state.is_task and facts.operator.is_away and state.age(facts) >= HIDDEN_S:
        found.append(Reaction(Rank.COMMUNICATION_LOST, ToCommunicationLost(is_hidden=True)))
    if state.stops_at_fence and facts.is_breached:
        found.append(Reaction(Rank.FENCE, ToHover(say("Beyond the fence."), level="warning")))
    low_s = facts.position.below.low_s
    if state.is_task and low_s is not None and low_s >= LOW_S:
        found.append(Reaction(Rank.FENCE, _climb(facts)))
    is_lost = facts.position.distrusted_s >= POSITION_CONFIRM_S or facts.position.age > POSE_TIMEOUT_S
    if state.is_task and is_lost:
        found.append(Reaction(Rank.PERCEPTION, ToHover(_position_words(facts), level="warning")))
    if state.is_task and facts.witness.doubt:
        found.append(Reaction(Rank.PERCEPTION, ToHover(facts.witness.doubt, level="warning")))
    if state.sees and facts.sight.fault and facts.sight.fault_s >= FAULT_CONFIRM_S:
        found.append(Reaction(Rank.PERCEPTION, ToHover(facts.sight.fault, level="warning")))
    return found


def _climb(facts: Facts) -> ToHover:
    """Hold here, Min above what is below, as far as the ceiling allows."""
    here, distance = facts.place, facts.position.below.low_m
    if here is None or distance is None:
        return ToHover(say("Too close to what is below."), level="warning")
    wanted = here.height + facts.limits.heights.minimum - distance
    height = max(here.height, min(wanted, facts.ceiling(on_ground=False)))
    text = say(
        "Only {distance:.1f} m above what is below: up to {height}. Raise the heights, or fly around it.",
        distance=distance,
        height=metres(height),
    )
    return ToHover(text, Goal(here.north, here.east, height, here.yaw), level="warning")


def _position_words(facts: Facts) -> str:
    fault = facts.diagnostics.estimator_fault
    if fault:
        return say("The autopilot does not trust its position: {fault}.", fault=fault)
    return say("The position was lost.")


def _cause_to_return(facts: Facts) -> Cause | None:
    if facts.battery.reached_s is not None and facts.battery.reached_s >= RESERVE_CONFIRM_S:
        return Cause(say("The battery is needed for the flight home."), CauseKind.RESERVE)
    if facts.battery.charge.is_low:
        return Cause(say("The battery's voltage is too low."), CauseKind.VOLTAGE)
    if facts.battery.unknown_s >= BATTERY_UNKNOWN_S:
        return Cause(say("The battery is not known."), CauseKind.BATTERY_UNKNOWN)
    if facts.wind.strong_s is not None and facts.wind.strong_s >= WIND_CONFIRM_S:
        return Cause(say("The wind is too strong."), CauseKind.WIND)
    if facts.limits.breached_s is not None and facts.limits.breached_s >= FENCE_RETURN_S:
        return Cause(say("Still outside the fence."), CauseKind.FENCE)
    if facts.kept.lost:
        return Cause(facts.kept.lost_words, CauseKind.KEPT)
    return None
