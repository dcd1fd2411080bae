"""Share of taken stalls of a group at the moment of each survey, with its variance.

A state is wrong with the probability that the look gives. Errors of stalls of one survey are not independent: a shadow
or a dark picture turns several. `hawk.model.lot_map.SPREADS` is by how much they widen the interval of a count; it is
used here for the states and, since unseen stalls lie together, for these as well (docs/statistics.md).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from hawk.model.lot_map import SPREADS
from hawk.stats.values import DEVIATIONS, NOTHING, TAKEN, UNSEEN, Estimate, Floats, Group, Panel, capacity_of, summed

WIDER: Final = (SPREADS / DEVIATIONS) ** 2
"""Variance of a count over that of stalls which err each for itself."""


@dataclass(frozen=True, slots=True)
class Counted:
    """Counts of G groups at S surveys, each (S, G): stalls of the layout, those with a state, and the taken ones.

    ``error``: variance of the number of taken ones among those with a state. ``share``: of taken stalls, NaN where no
    stall has a state; ``variance`` of the share.
    """

    capacity: Floats = field(repr=False)
    seen: Floats = field(repr=False)
    taken: Floats = field(repr=False)
    error: Floats = field(repr=False)
    share: Floats = field(repr=False)
    variance: Floats = field(repr=False)

    def bounds(self) -> tuple[Floats, Floats]:
        """Return the ends of the interval of each share, (S, G): within all unseen stalls free, and all taken.

        They are NaN for a group without stalls.
        """
        off = DEVIATIONS * np.sqrt(self.variance)
        wrong = DEVIATIONS * np.sqrt(self.error)
        unseen = self.capacity - self.seen
        with np.errstate(invalid="ignore"):
            low = np.maximum(self.share - off, (self.taken - wrong) / self.capacity)
            high = np.minimum(self.share + off, (self.taken + unseen + wrong) / self.capacity)
        return np.clip(low, 0.0, 1.0), np.clip(high, 0.0, 1.0)

    def shares(self, group: int = 0) -> list[Estimate]:
        """Return the share of a group at each survey."""
        low, high = self.bounds()
        ends = np.column_stack((self.share[:, group], low[:, group], high[:, group])).tolist()
        seen = (self.seen[:, group] > 0).tolist()
        return [
            Estimate(share, least, most, 1) if is_seen else NOTHING
            for (share, least, most), is_seen in zip(ends, seen, strict=True)
        ]


def count(panel: Panel, groups: Sequence[Group]) -> Counted:
    """Return the counts of groups at every survey of a panel."""
    is_seen = panel.is_there & (panel.state != UNSEEN)
    chance = np.nan_to_num(panel.taken_probability)
    doubt = chance * (1 - chance) * is_seen
    capacity, seen = capacity_of(panel.is_there, groups), summed(is_seen, groups)
    taken = summed(is_seen & (panel.state == TAKEN), groups)
    error = WIDER * summed(doubt, groups)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = taken / seen
        likely = (taken + 1) / (seen + 2)
        unseen = WIDER * (capacity - seen) / capacity * likely * (1 - likely) / seen
        variance = error / seen**2 + unseen
    return Counted(capacity, seen, taken, error, share, variance)
