"""Numbers and directions in the words of the page."""

from __future__ import annotations

import math

from hawk.model.sentences import Sentence, say
from hawk.model.sentences import sentence as sentence

_DIRECTIONS = (
    say("north"),
    say("north-east"),
    say("east"),
    say("south-east"),
    say("south"),
    say("south-west"),
    say("west"),
    say("north-west"),
)


def fault_words(error: Exception) -> Sentence:
    """Return words on an unexpected error."""
    return say("Fault in the program: {name}: {error}", name=type(error).__name__, error=str(error))


def named(name: str, value: str) -> Sentence:
    """Return a check's name with its value, as a sentence."""
    return say("{name}: {value}", name=name, value=sentence(value))


def direction(north: float, east: float) -> Sentence:
    """Return the nearest of eight directions."""
    return _DIRECTIONS[round(math.atan2(east, north) / (math.pi / 4)) % 8]


def metres(value: float) -> Sentence:
    """Return a length in whole metres."""
    return say("{value:z.0f} m", value=value)


def seconds(value: float) -> Sentence:
    """Return a duration in whole seconds, none negative."""
    return say("{value:.0f} s", value=max(0.0, math.ceil(value)))
