"""The shortest round found over several known lots: their order, then a tour over each from where the last one ends.

The order is the shortest closed path over the lots inside the fence, by dynamic programming (Held and Karp 1962). Lots
that come first are all flown before the others.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final

import numpy as np
import shapely

from hawk.algo.frame import Steps
from hawk.algo.ground import Floats, Place
from hawk.algo.known_lot import tour_rectangles
from hawk.algo.path_plan.known_tour import lot_tour, path_inside
from hawk.algo.path_plan.lot_ground import FenceGuard
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.model.known_lot import KnownLot, LotTour
from hawk.model.pictures import CameraModel
from hawk.model.plans import Fence, HeightParameters

START: Final = -1
"""Number of the start among the lots of `paths_between`."""
PathLengths = Mapping[tuple[int, int], float]
"""Metres from one lot to another along the path inside the fence, by their numbers."""


@dataclass(frozen=True, slots=True)
class RoundScene:
    """Surroundings of a round: the drone's ``start``, metres (north, east), its camera, heights and fence."""

    start: Place
    camera: CameraModel
    heights: HeightParameters
    fence: Fence | None
    settings: PathPlanSettings = field(default_factory=PathPlanSettings)


def round_tour(known: Sequence[KnownLot], first: frozenset[str], scene: RoundScene) -> Steps[tuple[LotTour, ...]]:
    """Plan in steps the tours over known lots, in the order of the flight.

    Args:
        known: The lots, with stalls.
        first: Ids of those that are flown before the others.
        scene: Where the drone is, and what it flies with.
    """
    guard, shapes = FenceGuard(scene.fence), [_hull(lot) for lot in known]
    lengths = yield from paths_between(shapes, guard, scene.start)
    numbers = best_order(lengths, is_first := [lot.id in first for lot in known])
    if len(set(is_first)) == 1 and lengths[START, numbers[-1]] < lengths[START, numbers[0]]:
        numbers.reverse()  # as long: a battery that does not last leaves the far lots
    order = [known[number] for number in numbers]
    hulls = {lot.id: shape for lot, shape in zip(known, shapes, strict=True)}
    place, tours = scene.start, list[LotTour]()
    for lot, after in zip(order, [*order[1:], None], strict=True):
        here = shapely.Point(place) if after is None else hulls[lot.id]
        toward = None if after is None else _nearest(here, hulls[after.id])[1]
        tour = yield from lot_tour(lot, scene.camera, scene.heights, scene.fence, place, scene.settings, toward)
        tours.append(tour)
        place = (tour.points[-1].north, tour.points[-1].east)
    return tuple(tours)


def paths_between(shapes: Sequence[shapely.Geometry], guard: FenceGuard, start: Place) -> Steps[PathLengths]:
    """Return in steps the length of the path inside the fence between each two of the shapes, and from the start."""
    lengths = {}
    ends = {START: shapely.Point(start), **dict(enumerate(shapes))}
    for one in ends:
        for other in range(one + 1, len(shapes)):
            a, b = _nearest(ends[one], ends[other])
            path = [a, *path_inside(guard, a, b)]
            lengths[one, other] = lengths[other, one] = sum(math.dist(*leg) for leg in pairwise(path))
            yield
    return lengths


def best_order(lengths: PathLengths, is_first: Sequence[bool]) -> list[int]:
    """Return the numbers of the lots in the order of the shortest closed path; those that are first before the others.

    The cost grows as 2^N N^2 with the number of lots, N.
    """
    firsts = sum(1 << number for number, yes in enumerate(is_first) if yes)
    best = {(0, START): (0.0, START)}
    for flown in range(1 << len(is_first)):
        for last in range(len(is_first)):
            before = flown & ~(1 << last)
            if before == flown or (not is_first[last] and before & firsts != firsts):
                continue
            ends = [START] if before == 0 else [end for end in range(len(is_first)) if (before, end) in best]
            found = [(best[before, end][0] + lengths[end, last], end) for end in ends]
            if found:
                best[flown, last] = min(found)
    whole, order = (1 << len(is_first)) - 1, list[int]()
    if not whole:
        return order
    last = min(range(len(is_first)), key=lambda end: _whole_path(best, lengths, whole, end))
    while last != START:
        order.append(last)
        whole, last = whole & ~(1 << last), best[whole, last][1]
    return order[::-1]


def _whole_path(best: Mapping[tuple[int, int], tuple[float, int]], lengths: PathLengths, whole: int, end: int) -> float:
    return best[whole, end][0] + lengths[START, end] if (whole, end) in best else math.inf


def _hull(lot: KnownLot) -> shapely.Geometry:
    places: Floats = tour_rectangles(lot).centres
    return shapely.MultiPoint(np.asarray(places)).convex_hull


def _nearest(one: shapely.Geometry, other: shapely.Geometry) -> tuple[Place, Place]:
    """Return the places of two shapes that are nearest to each other, (north, east)."""
    a, b = shapely.get_coordinates(shapely.shortest_line(one, other)).tolist()
    return (a[0], a[1]), (b[0], b[1])
