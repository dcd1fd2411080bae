"""Known lots that are surveyed again: which ones they are, and why they cannot be."""

from __future__ import annotations

from collections.abc import Sequence

from hawk.comm.protocol import commands
from hawk.ddc.facts import Facts
from hawk.ddc.fence.outline import (
    LEAST_OUTLINE_M2,
    OutlineError,
    area_words,
    check_rings,
    ground_of,
    is_left,
    overlap,
)
from hawk.model.known_lot import LotAhead
from hawk.model.plans import Fence, Outline, RoundLot
from hawk.model.poses import GlobalPose
from hawk.model.sentences import say, words_of

Ahead = tuple[GlobalPose, Fence] | None
"""Datum and fence of the flight; None while they are not known: the fence is asked for again by Explore."""


def lots_of(command: commands.SurveyAgain, facts: Facts, ahead: Ahead) -> tuple[LotAhead, ...]:
    """Return the lots of a command that the store has; of those that are due the ones that can be flown."""
    if command.due:
        due = [lot for lot in facts.lots.lots if lot.is_due and not _lot_refusal(lot, ahead, is_alone=False)]
        return tuple(due[: commands.MOST_LOTS])
    known = {lot.id: lot for lot in facts.lots.lots}
    return tuple(known[each] for each in dict.fromkeys(command.lots) if each in known)


def again_refusal(command: commands.SurveyAgain, facts: Facts, ahead: Ahead) -> str:
    """Return why lots cannot be surveyed again, with the field and the remedy; empty when they can."""
    if facts.lots.problem:
        return say("Lots: the lots cannot be read: {problem}", problem=facts.lots.problem)
    lots = lots_of(command, facts, ahead)
    if command.due and not lots:
        return _none_due(facts, ahead)
    if len(lots) < len(set(command.lots)):
        if facts.global_place is None:
            return say("Lots: the position is not known well enough to find the lot: wait for it.")
        return say("Lots: no lot has this id: open the list of lots, then choose one.")
    is_alone, judged = len(lots) == 1, () if command.due else lots
    refusal = next((words for lot in judged if (words := _lot_refusal(lot, ahead, is_alone=is_alone))), "")
    refusal = refusal or (_together_refusal(lots) if not is_alone else "")
    if not refusal and needs_empty_map(lots, facts):
        return say("Lots: the map holds an earlier survey: begin a new survey first; the earlier one stays stored.")
    return refusal


def _none_due(facts: Facts, ahead: Ahead) -> str:
    due = [lot for lot in facts.lots.lots if lot.is_due]
    if not due:
        return say("Due: no survey of a lot is due now: choose the lots.")
    return say("Due: no lot that is due can be flown to. {reason}", reason=_lot_refusal(due[0], ahead, is_alone=False))


def _lot_refusal(lot: LotAhead, ahead: Ahead, *, is_alone: bool) -> str:
    """Return why a lot cannot be surveyed. One of several lots must lie inside the fence as a whole."""
    if not lot.has_plan:
        return say("Lots: {name} has no stalls: survey it first, or draw them in its plan.", name=lot.name)
    if not lot.outline.polygons:
        return say(
            "Lots: {name} is {away:.0f} m away: bring the drone within 300 m of it.", name=lot.name, away=lot.away_m
        )
    try:
        check_rings(lot.outline)
    except OutlineError as error:
        return say("Lots: the outline of {name} cannot be used: {error}", name=lot.name, error=words_of(error))
    if ahead is None:
        return ""
    ground = ground_of(lot.outline, *ahead)
    if ground.area <= 0.0:
        return say("Lots: nothing of {name} lies inside the fence: set another fence.", name=lot.name)
    if not is_alone and ground.outside >= LEAST_OUTLINE_M2:
        return say(
            "Lots: {area} of {name} lie outside the fence: set another fence, or survey it alone.",
            area=area_words(ground.outside),
            name=lot.name,
        )
    return ""


def _together_refusal(lots: Sequence[LotAhead]) -> str:
    """Return why lots cannot be one round: a stall on the ground of two would be stored twice."""
    try:
        shared = overlap([lot.outline for lot in lots])
    except OutlineError as error:
        return say("Lots: they are no round: {error}", error=words_of(error))
    if shared is None:
        return ""
    one, other, area = shared
    return say(
        "Lots: {one} and {other} overlap by {area}: merge them, or survey them one by one.",
        one=lots[one].name,
        other=lots[other].name,
        area=area_words(area),
    )


def needs_empty_map(lots: Sequence[LotAhead], facts: Facts) -> bool:
    """Return True when the map holds an earlier survey: what it saw would not be looked at again.

    A round of the same lots that is not over goes on, after a battery swap.
    """
    outline, plan, need = facts.limits.outline, facts.sight.plan, facts.battery.survey
    is_same = outline is not None and {lot.id for lot in outline.lots} == {lot.id for lot in lots}
    is_done = plan is not None and plan.explore.done
    is_over = is_done or (need is not None and need.basis == "map" and not need.seconds)
    return not facts.vehicle.armed and not _is_map_empty(facts) and (is_over or not is_same)


def again_outline(lots: Sequence[LotAhead], facts: Facts) -> Outline:
    """Return the ground of lots as the outline of their survey.

    Lots that are due are first, and those that the round before could not finish. What a round with the same map has
    looked at stays over.
    """
    before = () if facts.limits.outline is None else facts.limits.outline.lots
    left = {lot.id for lot in before if is_left(lot, before)}
    over = set[str]() if _is_map_empty(facts) else {lot.id for lot in before if lot.is_over}
    return Outline(
        tuple(ring for lot in lots for ring in lot.outline.polygons),
        tuple(ring for lot in lots for ring in lot.outline.holes),
        tuple(
            RoundLot(
                lot.id,
                lot.name,
                len(lot.outline.polygons),
                len(lot.outline.holes),
                is_first=lot.is_due or lot.id in left,
                is_over=lot.id in over,
            )
            for lot in lots
        ),
    )


def _is_map_empty(facts: Facts) -> bool:
    return facts.sight.lot_area <= 0.0 and facts.sight.counts.total == 0
