"""The number of free stalls as an interval: a found stall may be none or be taken, and some ground was not seen."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final

from hawk.model.lot_map import Counts, Stall

SPREADS: Final = 2.7
"""Standard deviations, of stalls that err each for itself, about the count. Stalls err by the row as well, and some are
not found at all: this many held the true number in 29 of the drawn worlds 101 to 132, 90 %."""
HELD_SHARE: Final = 0.9
"""Share of surveys in which the interval must hold the true number."""
LEAST_SEEN: Final = 0.2
"""Share of the lot below which nothing is said of the rest."""


def free_variance(score: float, taken: float) -> float:
    """Return the variance of a stall's part in the number of free ones, 0 to 0.25.

    ``score`` is the probability of being a stall, ``taken`` that of being taken.
    """
    free = score * (1 - taken)
    return free * (1 - free)


def variance_of(stalls: Iterable[Stall]) -> float:
    """Return the variance of the number of free stalls among these."""
    return sum(free_variance(stall.score, stall.taken) for stall in stalls)


def free_interval(counts: Counts, seen: float | None) -> tuple[int, int] | None:
    """Return the least and the greatest number of free stalls of the lot; None while too little of it was seen.

    As many stalls as the lot has by area are expected on ground that was not seen; each of them may be free or not.

    Args:
        counts: The stalls found, with their variance.
        seen: Share of the lot that was seen, 0 to 1; None when it is not known.
    """
    if seen is None or seen < LEAST_SEEN:
        return None
    off = SPREADS * math.sqrt(counts.free_variance)
    unseen = counts.total * (1 / min(seen, 1.0) - 1)
    return max(math.floor(counts.free - off), 0), math.ceil(counts.free + off + unseen)
