"""A return that cannot wait: to home, or to the ground where the autopilot's RTL would not end at home."""

from __future__ import annotations

from hawk.ddc.facts import Facts
from hawk.ddc.orders import Cause, ToLand, ToReturn
from hawk.ddc.readings.home import home_words
from hawk.model.sentences import joined, say


def returning(facts: Facts, cause: Cause) -> ToReturn | ToLand:
    """Return the transition of a return that cannot wait, nor fly a path.

    Land where RTL would not end at home, and where the drone's own place is doubted.
    """
    if facts.witness.misleads_home:
        return ToLand(cause_here(facts, cause))
    return (
        ToLand(astray(facts, cause)) if leaves(facts) else ToReturn(cause, straight=say("the program cannot lead it"))
    )


def cause_here(facts: Facts, cause: Cause) -> Cause:
    """Return the cause of a landing in place of a return that would fly to a place that is doubted."""
    return Cause(joined(cause.text, facts.witness.doubt), cause.kind, cause.details)


def leaves(facts: Facts) -> bool:
    """Return True while RTL would not end at home, nor at a home that somebody moved inside the fence."""
    home = facts.position.autopilot_home
    return home.misleads or (bool(facts.kept.astray) and not home.is_moved)


def astray(facts: Facts, cause: Cause | None) -> Cause | None:
    """Return the cause of a landing in place of a return; None keeps a landing that nobody caused."""
    if cause is None:
        return None
    return Cause(joined(cause.text, astray_words(facts)), cause.kind, cause.details)


def astray_words(facts: Facts) -> str:
    """Return in words why RTL would not end at home."""
    home = facts.position.autopilot_home
    return home_words(home) if home.is_moved else facts.kept.astray
