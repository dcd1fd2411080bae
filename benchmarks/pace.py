"""Speed of simulated flights: as fast as figures are valid, and slower where the machine drew the pictures late.

Only lateness decides whether a flight is flown again, never what it found: the figures of those that remain are not
chosen.
"""

from __future__ import annotations

import sys
from collections.abc import Awaitable, Callable
from itertools import pairwise
from typing import Final, TypeVar

from hawk.survey.run import LATE_FRAMES_LIMIT

SPEEDS: Final = (2.0, 1.0, 0.5)
"""Simulated seconds per second, tried in this order: perception figures are valid at 2 and less."""

Flight = TypeVar("Flight")


async def in_time(name: str, fly: Callable[[float], Awaitable[Flight]], late: Callable[[Flight], float]) -> Flight:
    """Fly at ever lower speeds until few enough pictures were late; return the last flight.

    ``fly`` gets the speed; ``late`` returns the share (0..1) of a flight's pictures that were late. The slowest flight
    is returned also when it was late: its figures are void.
    """
    for speed, slower in pairwise(SPEEDS):
        flight = await fly(speed)
        if late(flight) <= LATE_FRAMES_LIMIT:
            return flight
        words = f"{name}: {late(flight):.0%} of the pictures came late at speed {speed:g}; flown again at {slower:g}"
        print(words, file=sys.stderr, flush=True)
    return await fly(SPEEDS[-1])
