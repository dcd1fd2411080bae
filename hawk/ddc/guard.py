"""Automatic reactions: battery, operator, fence and ceiling, position, perception, in their order of rank."""

from __future__ import annotations

from dataclasses import dataclass

from hawk.ddc.acts import Acts, Log
from hawk.ddc.facts import POSE_TIMEOUT_S, Facts
from hawk.ddc.geofence import recovery_words
from hawk.ddc.orders import Cause, CauseKind, Rank, ToCommunicationLost, ToHover, ToReturn, Transition
from hawk.ddc.states.base import State

BATTERY_UNKNOWN_S = 30.0
"""Seconds without a valid charge after which the drone returns."""
RESERVE_CONFIRM_S = 3.0
"""Seconds for which the reserve must be reached: a dip under load does not count."""
WIND_CONFIRM_S = 10.0
"""Seconds for which the wind must be above the limit: a gust does not count."""
FENCE_RETURN_S = 10.0
"""Seconds outside the fence after which the drone returns."""
FAULT_CONFIRM_S = 1.0
"""Seconds for which a fault of perception must last: one bad picture does not count."""
POSITION_CONFIRM_S = 2.0
"""Seconds for which the autopilot must distrust its position."""


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
    return ()


def _candidates(facts: Facts, state: State) -> list[Reaction]:
    """Return the reactions for a state, highest rank first."""
    found: list[Reaction] = []
    cause = _cause_to_return(facts) if state.is_guarded else None
    if cause is not None:
        found.append(Reaction(Rank.RETURN_TO_LAUNCH, ToReturn(cause)))
    if state.needs_operator and not facts.operator.is_present:
        found.append(Reaction(Rank.COMMUNICATION_LOST, ToCommunicationLost()))
    if state.stops_at_fence and facts.is_breached:
        found.append(Reaction(Rank.FENCE, ToHover("Outside the fence.", level="warning")))
    if state.is_task and _position_is_lost(facts):
        found.append(Reaction(Rank.PERCEPTION, ToHover(_position_words(facts), level="warning")))
    if state.sees and facts.sight.fault and facts.sight.fault_s >= FAULT_CONFIRM_S:
        found.append(Reaction(Rank.PERCEPTION, ToHover(facts.sight.fault, level="warning")))
    return found


def _position_is_lost(facts: Facts) -> bool:
    return facts.position.distrusted_s >= POSITION_CONFIRM_S or facts.position.age > POSE_TIMEOUT_S


def _position_words(facts: Facts) -> str:
    fault = facts.diagnostics.estimator_fault
    return f"The autopilot does not trust its position: {fault}." if fault else "The position was lost."


def _cause_to_return(facts: Facts) -> Cause | None:
    if facts.battery.reached_s is not None and facts.battery.reached_s >= RESERVE_CONFIRM_S:
        return Cause("The battery is needed for the way home.", CauseKind.RESERVE)
    if facts.battery.unknown_s >= BATTERY_UNKNOWN_S:
        return Cause("The battery is not known.", CauseKind.BATTERY_UNKNOWN)
    if facts.wind.strong_s is not None and facts.wind.strong_s >= WIND_CONFIRM_S:
        return Cause("The wind is too strong.", CauseKind.WIND)
    if facts.limits.breached_s is not None and facts.limits.breached_s >= FENCE_RETURN_S:
        return Cause("Still outside the fence.", CauseKind.FENCE)
    return None
