"""Totals of a count by a stratified sample that was checked by eye: the difference estimator.

The program's total is known; the sample says by how much its windows differ from the truth. W. G. Cochran, Sampling
Techniques, 3rd edition, 1977: stratified means and their variance (5.3, 5.4), degrees of freedom (5.4, after
Satterthwaite, 1946), allocation of the sample (5.5), differences in place of the values (7.10).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from hawk.model.lot_map import HELD_SHARE

Floats = NDArray[np.float64]
_DOUBT: Final = 0.25
"""Squared difference of a window, half a stall, that each stratum is taken to have besides those that were checked."""
LEAST_DRAWN: Final = 3
"""Windows that are drawn of a stratum at least, where it has as many."""


@dataclass(frozen=True, slots=True)
class CheckedStratum:
    """A stratum of ``size`` windows; ``differences`` (n,) of those that were checked: by eye less by the program."""

    size: int
    differences: Floats = field(repr=False)


@dataclass(frozen=True, slots=True)
class CheckedTotal:
    """A total with its interval: in nine of ten samples ``least`` to ``most`` holds the true one."""

    total: float
    least: int
    most: int


def checked_total(found: float, strata: Sequence[CheckedStratum]) -> CheckedTotal:
    """Return the true total where the program found ``found``. Every stratum with windows has a checked one.

    The variance is taken as if one more checked window of each stratum, that is not checked as a whole, differed by a
    half: a few windows without an error do not show that there is none.
    """
    total, variance, weights = found, 0.0, 0.0
    for each in strata:
        count = len(each.differences)
        if each.size == 0:
            continue
        mean = float(each.differences.mean())
        total += each.size * mean
        if count < each.size:
            spread = (float(((each.differences - mean) ** 2).sum()) + _DOUBT) / count
            part = each.size**2 * (1 - count / each.size) * spread / count
            variance += part
            weights += part**2 / count
    if not variance:
        return CheckedTotal(total, round(total), round(total))
    off = float(stdtrit(variance**2 / weights, (1 + HELD_SHARE) / 2)) * math.sqrt(variance)
    return CheckedTotal(total, max(math.floor(total - off), 0), math.ceil(total + off))


def allocated(sizes: Sequence[int], spreads: Sequence[float], count: int) -> list[int]:
    """Return how many windows to draw of each stratum: `LEAST_DRAWN`, the rest by size times ``spreads`` (Neyman).

    ``spreads``: how much the windows of a stratum are expected to differ. The sum is ``count`` where the strata have as
    many windows, and enough are asked for.
    """
    drawn = [min(size, LEAST_DRAWN) for size in sizes]
    wanted = np.array([size * spread for size, spread in zip(sizes, spreads, strict=True)], np.float64)
    for _ in range(max(count - sum(drawn), 0)):
        open_ones = [k for k, size in enumerate(sizes) if drawn[k] < size]
        if not open_ones:
            break
        drawn[max(open_ones, key=lambda k: (wanted[k] / (drawn[k] + 1), -k))] += 1
    return drawn
