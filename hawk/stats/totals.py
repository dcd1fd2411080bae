"""Total of figures of several lots, with its interval.

How the errors of lots go together is not measured: one network looks at all, and a dark day turns several alike.
So a total has two intervals, as the sum of a city has (`hawk.picture.lot_report`), and the truth lies between them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from hawk.stats.values import NOTHING, Estimate


@dataclass(frozen=True, slots=True)
class Total:
    """Sum of figures, null without any: ``alike`` as if all erred alike, which adds the ends of all; ``apart`` as if
    each erred for itself, which adds the squares of their distances to the ends.
    """

    alike: Estimate
    apart: Estimate


def total_of(figures: Sequence[Estimate]) -> Total:
    """Return the total of figures; one without a value is left out."""
    known = [(each.value, each.low, each.high) for each in figures]
    ends = [(value, low, high) for value, low, high in known if None not in (value, low, high)]
    if not ends:
        return Total(NOTHING, NOTHING)
    values, lows, highs = ([float(each or 0.0) for each in column] for column in zip(*ends, strict=True))
    value, surveys = sum(values), sum(each.surveys for each in figures)
    below = math.hypot(*(value - low for value, low in zip(values, lows, strict=True)))
    above = math.hypot(*(high - value for value, high in zip(values, highs, strict=True)))
    return Total(
        Estimate(value, sum(lows), sum(highs), surveys), Estimate(value, value - below, value + above, surveys)
    )  # fmt: skip
