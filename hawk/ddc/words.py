"""Numbers and directions in the words of the page."""

from __future__ import annotations

import math

from hawk.model.sentences import Sentence, say
from hawk.model.sentences import sentence as sentence

_DIRECTIONS = (
    say("north", "north"),
    say("north-east", "north-east"),
    say("east", "east"),
    say("south-east", "south-east"),
    say("south", "south"),
    say("south-west", "south-west"),
    say("west", "west"),
    say("north-west", "north-west"),
)


def direction(north: float, east: float) -> Sentence:
    """Return the nearest of eight directions."""
    return _DIRECTIONS[round(math.atan2(east, north) / (math.pi / 4)) % 8]


def metres(value: float) -> Sentence:
    """Return a length in whole metres."""
    return say("metres", "{value:z.0f} m", value=value)


def seconds(value: float) -> Sentence:
    """Return a duration in whole seconds, none negative."""
    return say("seconds", "{value:.0f} s", value=max(0.0, math.ceil(value)))
