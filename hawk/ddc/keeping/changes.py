"""The station that changed something in the autopilot, as far as the link shows it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hawk.ddc.facts import Facts
from hawk.model.sentences import say

RECENT_S = 30.0
"""A message of another station explains a change that is seen within this time, seconds."""
UNKNOWN = say("Who changed it is not known: no message of another station reached this link.")
LATER = say("It is put back when the drone is taken from the pilot.")
"""Words on a change that is seen while a pilot flies."""


@dataclass(frozen=True, slots=True)
class Author:
    """Words for who changed something: ``told`` in the message, ``details`` beside it."""

    told: str = ""
    details: str = ""


def changed_by(facts: Facts, subjects: Sequence[str]) -> Author:
    """Return who wrote one of these last: subjects of `hawk.comm.mavlink.foreign_writes`.

    Most links carry only what the autopilot says, so that mostly nobody is known.
    """
    for write in reversed(facts.link.foreign_writes):
        if write.subject in subjects and facts.now - write.time <= RECENT_S:
            return Author(
                say(
                    "Station {system} (component {component}) changed it.",
                    system=write.system,
                    component=write.component,
                )
            )
    return Author(details=UNKNOWN)
