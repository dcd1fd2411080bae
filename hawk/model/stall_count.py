"""The number of free stalls as an interval: a found stall may be none or be taken, and a few may be missing.

Nothing is said of a lot of which a part was not seen: neither its size nor its stalls are known.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final

from hawk.model.lot_map import Counts, Stall
from hawk.model.plans import ExploreStatus

SPREADS: Final = 2.7
"""Standard deviations, of stalls that err each for itself, about the count. Stalls err by the row as well, and some are
not found at all: this many held the true number in 29 of the drawn worlds 101 to 132, 90 %."""
HELD_SHARE: Final = 0.9
"""Share of surveys in which the interval must hold the true number."""


def free_variance(score: float, taken: float) -> float:
    """Return the variance of a stall's part in the number of free ones, 0 to 0.25.

    ``score`` is the probability of being a stall, ``taken`` that of being taken.
    """
    free = score * (1 - taken)
    return free * (1 - free)


def variance_of(stalls: Iterable[Stall]) -> float:
    """Return the variance of the number of free stalls among these."""
    return sum(free_variance(stall.score, stall.taken) for stall in stalls)


def free_interval(counts: Counts, explore: ExploreStatus | None) -> tuple[int, int] | None:
    """Return the least and the greatest number of free stalls of the lot found; None until it is seen whole.

    As many stalls as the lot has by area are expected on the few patches that were left out; each may be free or not.

    Args:
        counts: The stalls found, with their variance.
        explore: Progress of the exploration; None before the first plan.
    """
    if explore is None or not explore.is_whole:
        return None
    off = SPREADS * math.sqrt(counts.free_variance)
    unseen = counts.total * (1 / min(explore.seen_share, 1.0) - 1)
    return max(math.floor(counts.free - off), 0), math.ceil(counts.free + off + unseen)
