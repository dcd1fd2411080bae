"""A known lot that is surveyed again: which one it is, and why it cannot be."""

from __future__ import annotations

from dataclasses import replace

from hawk.comm.protocol import commands
from hawk.ddc.facts import Facts
from hawk.ddc.fence.outline import OutlineError, check_rings, ground_of
from hawk.model.known_lot import LotAhead
from hawk.model.plans import Fence, Outline
from hawk.model.poses import GlobalPose
from hawk.model.sentences import say, words_of


def lot_of(command: commands.SurveyAgain, facts: Facts) -> LotAhead | None:
    """Return the lot of a command; None where the store has none with its id."""
    return next((lot for lot in facts.lots.lots if lot.id == command.lot), None)


def again_refusal(command: commands.SurveyAgain, facts: Facts, ahead: tuple[GlobalPose, Fence] | None) -> str:
    """Return why a lot cannot be surveyed again, with the field and the remedy; empty when it can.

    ``ahead``: datum and fence of the flight, None while they are not known; the fence is asked for again by Explore.
    """
    if facts.lots.problem:
        return say("Lot: the lots cannot be read: {problem}", problem=facts.lots.problem)
    lot = lot_of(command, facts)
    if lot is None:
        if facts.global_place is None:
            return say("Lot: the position is not known well enough to find the lot: wait for it.")
        return say("Lot: no lot has this id: open the list of lots, then choose one.")
    if lot.stalls == 0:
        return say("Lot: {name} has no stalls: survey it first, or draw them in its plan.", name=lot.name)
    if not lot.outline.polygons:
        return say(
            "Lot: {name} is {away:.0f} m away: bring the drone within 300 m of it.", name=lot.name, away=lot.away_m
        )
    try:
        check_rings(lot.outline)
    except OutlineError as error:
        return say("Lot: the outline of {name} cannot be used: {error}", name=lot.name, error=words_of(error))
    if ahead is not None and ground_of(lot.outline, *ahead).area <= 0.0:
        return say("Lot: nothing of {name} lies inside the fence: set another fence.", name=lot.name)
    if needs_empty_map(lot, facts):
        return say("Lot: the map holds an earlier survey: begin a new survey first; the earlier one stays stored.")
    return ""


def needs_empty_map(lot: LotAhead, facts: Facts) -> bool:
    """Return True when the map holds an earlier survey: what it saw would not be looked at again.

    One of the same lot that is not over goes on, after a battery swap.
    """
    outline, plan, need = facts.limits.outline, facts.sight.plan, facts.battery.survey
    is_same = outline is not None and outline.again == lot.id
    is_done = plan is not None and plan.explore.done
    is_over = is_done or (need is not None and need.basis == "map" and not need.seconds)
    is_empty = facts.sight.lot_area <= 0.0 and facts.sight.counts.total == 0
    return not facts.vehicle.armed and not is_empty and (is_over or not is_same)


def again_outline(lot: LotAhead) -> Outline:
    """Return the lot's ground as the outline of its survey."""
    return replace(lot.outline, again=lot.id)
