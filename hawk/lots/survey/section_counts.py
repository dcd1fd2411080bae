"""Count of a section: how many vehicles are parked in it, between which numbers the true one lies, and the room left.

Values in, values out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final, Literal

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from hawk.lots.plan import geometry
from hawk.lots.plan.sections import PLACES_M, axis_of
from hawk.lots.plan.values import Floats, PlanSection

RECALL: Final = 0.89
"""Share of the vehicles in sections that are found: 480 of 537 in 178 sections of regions that a training left out
(docs/results/cars.md).
"""
HELD_SHARE: Final = 0.9
"""Probability that the interval holds the true number."""
MOST_HIDDEN: Final = 0.3
"""Hidden share of a section from which nothing is said of the room in it."""
AREA_OF_PLACE_M2: Final = 12.5
"""Ground of one place where nobody says a capacity: a stall of 2.5 by 5 m."""
_FAR: Final = 8.0
"""Standard deviations beyond which numbers of misses are left out."""
LEAST_SEEN: Final = 0.05
"""Share of a section below which a survey did not look at it: the edge of a flight."""

Source = Literal["vehicles", "stalls"]


@dataclass(frozen=True, slots=True)
class SeenGround:
    """Vehicles and ground that a survey saw, in its lot's frame.

    ``shapes`` (V, 5): vehicles, or taken stalls, by ``source``; ``probabilities`` and ``moments`` (V,) of each, the
    latter seconds. ``unknown`` (U, 5): stalls whose state is not known.
    """

    source: Source
    shapes: Floats = field(repr=False)
    probabilities: Floats = field(repr=False)
    moments: Floats = field(repr=False)
    unknown: Floats = field(repr=False)
    ground: BaseGeometry = field(repr=False)

    def sight_of(self, section: PlanSection) -> Sight | None:
        """Return the sight at a section with a valid ring; None where next to nothing of it was seen."""
        area = shapely.Polygon(section.outline)
        seen_part = shapely.intersection(area, self.ground)
        seen_share = float(seen_part.area / area.area)
        if seen_share < LEAST_SEEN:
            return None
        hidden = shapely.union_all(geometry.polygons(self.unknown)) if len(self.unknown) else shapely.Polygon()
        hidden_share = float(shapely.intersection(seen_part, hidden).area / area.area)
        is_in = np.array(geometry.within(section.outline, self.shapes[:, :2]), np.bool_)
        looked_at = float(self.moments[is_in].max()) if is_in.any() else None
        return Sight(self.source, self.shapes[is_in], self.probabilities[is_in], hidden_share, seen_share, looked_at)


@dataclass(frozen=True, slots=True)
class Sight:
    """Sight of a survey at one section, in the lot's frame.

    ``shapes`` (V, 5): those of the vehicles, or taken stalls, whose middle is in it; ``probabilities`` (V,): that each
    is one. ``hidden_share``: share of the section's ground whose state is not known, though it was seen;
    ``seen_share``: share that was seen at all. ``looked_at``: last look at one of them, seconds; None without one.
    """

    source: Source
    shapes: Floats = field(repr=False)
    probabilities: Floats = field(repr=False)
    hidden_share: float
    seen_share: float
    looked_at: float | None = None


@dataclass(frozen=True, slots=True)
class SectionCount:
    """Count of a section: ``parked`` vehicles, ``least`` to ``most`` of them, and ``room`` for further ones; None where
    too much of it is hidden.
    """

    parked: int
    least: int
    most: int
    room: int | None


def count_of(section: PlanSection, sight: Sight) -> SectionCount:
    """Return the count of a section with a ring."""
    hidden = min(sight.hidden_share + 1.0 - sight.seen_share, 1.0)
    unseen = hidden * (section.capacity or _places(section))
    least, most = interval(sight.probabilities, unseen)
    parked = len(sight.shapes)
    room = None if hidden > MOST_HIDDEN else room_in(section, sight.shapes)
    return SectionCount(parked, min(least, parked), max(most, parked), room)


def interval(probabilities: Floats, unseen: float = 0.0, recall: float = RECALL) -> tuple[int, int]:
    """Return the least and the greatest true number of vehicles; `HELD_SHARE` of these hold it.

    The true number is a sum of three that are independent: the found ones that are vehicles, a Poisson binomial
    variable of their probabilities, by exact convolution (Y. Hong, On computing the distribution function for the
    Poisson binomial distribution, Computational Statistics & Data Analysis 59, 2013); the missed ones, Poisson with
    the mean (1 - recall) / recall times the number of true finds that is expected; and those on ground that was not
    seen, each number from 0 to ``unseen`` equally likely.
    """
    found = np.ones(1)
    for probability in np.clip(probabilities, 0.0, 1.0).tolist():
        found = np.convolve(found, [1.0 - probability, probability])
    missed = _poisson((1 - recall) / recall * float(np.clip(probabilities, 0.0, 1.0).sum()))
    hidden = np.full(math.ceil(unseen) + 1, 1.0)
    hidden[-1] = 1.0 if unseen == int(unseen) else unseen - int(unseen)
    total = np.cumsum(np.convolve(np.convolve(found, missed), hidden / hidden.sum()))
    total /= total[-1]
    tail = (1 - HELD_SHARE) / 2
    return int(np.searchsorted(total, tail, side="right")), int(np.searchsorted(total, 1 - tail, side="left"))


def _poisson(mean: float) -> NDArray[np.float64]:
    """Return the probabilities of 0, 1 and so on of a Poisson variable, to `_FAR` standard deviations."""
    if mean <= 0:
        return np.ones(1)
    numbers = range(math.ceil(mean + _FAR * math.sqrt(mean + 1)))
    return np.exp([number * math.log(mean) - mean - math.lgamma(number + 1) for number in numbers])


def _places(section: PlanSection) -> float:
    """Return how many vehicles fit where nobody says the capacity."""
    return float(shapely.Polygon(section.outline).area) / AREA_OF_PLACE_M2


def room_in(section: PlanSection, shapes: Floats) -> int | None:
    """Return how many vehicles fit into the gaps along the axis of a section; None where its kind does not say how long
    one is.

    ``shapes`` (V, 5) of those that stand there. Vehicles behind each other across the axis leave one gap.
    """
    each = PLACES_M.get(section.kind)
    if each is None:
        return None
    start, end = axis_of(section.outline)
    length = math.dist(start, end)
    along = np.array([end[0] - start[0], end[1] - start[1]]) / max(length, 1e-9)
    reach = ((geometry.corners(shapes) - np.array(start)) @ along).clip(0.0, length)
    taken = sorted(zip(reach.min(axis=1).tolist(), reach.max(axis=1).tolist(), strict=True)) if len(shapes) else []
    room, free_from = 0, 0.0
    for first, last in (*taken, (length, length)):
        room += max(math.floor((first - free_from) / each + 1e-9), 0)
        free_from = max(free_from, last)
    return room
