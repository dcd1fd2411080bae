"""Rules for commands about the outline: which fence it is judged by, and why it is refused."""

from __future__ import annotations

from hawk.comm.protocol.commands import SetOutline
from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import FenceError
from hawk.ddc.fence.outline import OutlineError, check_rings, ground_of, outline_of, size_words
from hawk.ddc.settings import DdcSettings
from hawk.model.limits import Fence, Outline
from hawk.model.poses import GlobalPose
from hawk.model.sentences import say, words_of

NOTHING_INSIDE = say("Nothing of the outline lies inside the fence: set another outline, or clear it.")


def fence_ahead(facts: Facts, settings: DdcSettings) -> tuple[GlobalPose, Fence] | None:
    """Return datum and fence of the flight: those in force while armed, else those that Arm here would put in force.

    None while they cannot be known.
    """
    place, datum = facts.global_place, facts.position.datum
    if facts.vehicle.armed:
        fence = facts.limits.fence
        return None if datum is None or fence is None else (datum, fence)
    if place is None or facts.limits.plan_problem:
        return None
    datum = datum or place
    try:
        return datum, facts.limits.plan.around(datum, place, settings.fence)
    except FenceError:
        return None


def outline_refusal(command: SetOutline, facts: Facts, settings: DdcSettings) -> str:
    """Return the reason why the outline of a command cannot be taken; empty when it can.

    While no fence is known it is judged by the fence when Explore is asked for.
    """
    outline, ahead = outline_of(command), fence_ahead(facts, settings)
    try:
        check_rings(outline)
    except OutlineError as error:
        return words_of(error)
    if ahead is not None and ground_of(outline, *ahead).area <= 0.0:
        return say("Polygons: nothing of the outline lies inside the fence: draw it inside, or set another fence.")
    return ""


def taken_words(outline: Outline, facts: Facts, settings: DdcSettings) -> str:
    """Return the message about an outline that was taken: its size inside the fence, and what the fence leaves out."""
    ahead = fence_ahead(facts, settings)
    if ahead is None:
        return say("The outline is taken: {size}.", size=size_words(check_rings(outline)))
    ground = ground_of(outline, *ahead)
    return say("The outline is taken: {size}.", size=size_words(ground.area, ground.outside))
