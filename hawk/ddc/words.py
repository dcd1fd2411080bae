"""Numbers and directions in the words of the page."""

from __future__ import annotations

import math

_DIRECTIONS = ("north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west")


def direction(north: float, east: float) -> str:
    """Return the nearest of eight directions."""
    return _DIRECTIONS[round(math.atan2(east, north) / (math.pi / 4)) % 8]


def metres(value: float) -> str:
    """Return a length in whole metres."""
    return f"{value:z.0f} m"


def seconds(value: float) -> str:
    """Return a duration in whole seconds, none negative."""
    return f"{max(0.0, math.ceil(value)):.0f} s"


def sentence(text: str) -> str:
    """Return the text as a sentence: one full stop at its end."""
    stripped = text.strip()
    return stripped if not stripped or stripped[-1] in ".!?" else f"{stripped}."
