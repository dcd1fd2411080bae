"""The shortest flight found that looks at every stall of a known lot once more.

Its beginnings are strips along and across the rows and in other directions: as few as show every stall as a whole,
their places free. The shortest of them are annealed by the planner's own search (`hawk.algo.path_plan.tour`), which
knows what a turn shows and what a leaning camera does. All is done in steps of a few milliseconds; equal calls give
equal tours.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from hawk.algo.frame import Steps
from hawk.algo.ground import COARSE_M, Bools, Floats, Place, Window
from hawk.algo.known_lot import tour_rectangles
from hawk.algo.path_plan.footprint import Footprint, Singles, Swath, exploring_height
from hawk.algo.path_plan.grid_search import places_on_path
from hawk.algo.path_plan.lot_ground import FenceGuard
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.path_plan.tour import Terms, Tour, Wanted, as_place, length_of
from hawk.algo.rows.fit import Rectangles
from hawk.model.known_lot import KnownLot, LotTour
from hawk.model.pictures import CameraModel
from hawk.model.plans import Fence, HeightParameters
from hawk.model.poses import MapPoint

MARGIN_M: Final = 1.4
"""Distance of a stall from the edge of a picture in a tour: a little more than what counts (`revisit.EDGE_M`)."""
_LOST_M: Final = 1000.0
"""Cost of a stall that is not looked at, metres of path."""
MOST_SEARCHED: Final = 400
"""Stalls of a lot up to which a tour is searched; the strips over a larger one are near the shortest flight."""
_DIRECTIONS: Final = 9
_KEPT: Final = (10, 4, 2)
"""Tours that are searched on, round by round: the shortest ones."""
_HEATS: Final = (
    tuple(np.geomspace(6.0, 0.5, 6).tolist()),
    tuple(np.geomspace(4.0, 0.3, 9).tolist()),
    (*np.geomspace(2.5, 0.1, 14).tolist(), 0.0, 0.0),
)
"""Heat of each sweep of those rounds, metres."""
_STEPS: Final = ((1.5, 8.0), (0.5, 3.0), (0.0, 1.0))
"""Heat from which on waypoints are shifted by so much, metres."""
_AROUND_M: Final = (60.0, 240.0)
"""About the straight line to a waypoint: room for the path around what lies outside the fence, a little first."""
_ROUTE_STEP: Final = 2
_MOST_CORNERS: Final = 12
_LEAST_LEG_M: Final = 0.8
"""A corner nearer than half a cell is where the drone is."""


@dataclass(frozen=True, slots=True)
class KnownTour:
    """Waypoints (K, 2) of (north, east) metres, the start first, and the length of the flight along them.

    ``missed`` is the number of stalls that no place of the tour shows: none where the drone may be everywhere.
    """

    places: Floats = field(repr=False)
    distance_m: float
    missed: int = 0


def lot_tour(
    known: KnownLot,
    camera: CameraModel,
    heights: HeightParameters,
    fence: Fence | None,
    start: Place,
    settings: PathPlanSettings | None = None,
    toward: Place | None = None,
) -> Steps[LotTour]:
    """Plan in steps the flight from a place over a known lot, inside the fence, at the height of an exploration.

    ``toward`` is where the drone flies then: of equal tours the one that ends nearest to it is taken.
    """
    settings = settings or PathPlanSettings()
    height = exploring_height(heights, camera, settings.cm_per_pixel)
    footprint = Footprint.of(Swath.of(camera, height, settings.known_share), settings)
    guard = FenceGuard(fence)
    found = yield from known_tour(boxes_of(tour_rectangles(known)), footprint, start, guard.contain, toward=toward)
    points = [start]
    for end in found.places[1:]:
        points += path_inside(guard, points[-1], as_place(end))
        yield
    distance = length_of(np.array(points))
    return LotTour(known.id, tuple(MapPoint(*point) for point in points), distance, found.missed)


def path_inside(guard: FenceGuard, start: Place, end: Place) -> list[Place]:
    """Return the corners of a path inside the fence, without its start; the end alone where none is found."""
    corners: list[Place] = []
    while len(corners) < _MOST_CORNERS:
        corner = corner_inside(guard, corners[-1] if corners else start, end)
        if corner is None:
            return [end]
        corners.append(corner)
        if corner == end:
            return corners
    return [end]


def corner_inside(guard: FenceGuard, place: Place, end: Place) -> Place | None:
    """Return the end, or the farthest corner on the path to it that a straight line inside the fence reaches; None
    without a path.
    """
    if not guard.contains(*place) or guard.contains_line(place, end):
        return end
    for around in _AROUND_M:
        window = Window.around(np.array([place, end]), COARSE_M, around)
        mask = guard.mask(window)[::_ROUTE_STEP, ::_ROUTE_STEP]
        places = places_on_path(mask, window, _ROUTE_STEP, place, end)
        for corner in () if places is None else map(as_place, places[::-1]):
            if math.dist(corner, place) > _LEAST_LEG_M and guard.contains_line(place, corner):
                return corner
    return None


def boxes_of(stalls: Rectangles) -> Singles:
    """Return stalls (N,) as boxes (N, 6) of `Footprint.shown`."""
    along = np.column_stack([np.cos(stalls.angle), np.sin(stalls.angle)]) * (stalls.length / 2)[:, None]
    aside = np.column_stack([-np.sin(stalls.angle), np.cos(stalls.angle)]) * (stalls.width / 2)[:, None]
    return np.hstack([stalls.centres, along, aside]).astype(np.float32)


def known_tour(
    boxes: Singles,
    footprint: Footprint,
    start: Place,
    allowed: Callable[[Floats], Bools] = lambda places: np.ones(len(places), np.bool_),
    margin_m: float = MARGIN_M,
    toward: Place | None = None,
) -> Steps[KnownTour]:
    """Search in steps for the shortest tour that shows all boxes; return it.

    Args:
        boxes: Stalls (N, 6), see `boxes_of`.
        footprint: Ground in the good part of a picture.
        start: Place of the drone.
        allowed: Returns True for those of places (T, 2) that may be waypoints.
        margin_m: By so much each box is grown on every side.
        toward: Place to which the drone flies after the tour, whose length counts as well; None: none.
    """
    if len(boxes) == 0:
        return KnownTour(np.array([start], np.float64), 0.0)
    wanted = _wanted(grown(boxes, margin_m), footprint)
    terms = Terms(footprint, 1.0, turn_m=0.5, leg_m=0.2, trials=12, turned_first=True, allowed=allowed)
    begun = yield from _beginnings(wanted.cells, footprint, start, allowed)
    begun.sort(key=lambda places: length_of(places) + _on(places, toward))
    searched = len(boxes) <= MOST_SEARCHED
    rng = np.random.default_rng(0)
    tours: list[Tour] = []
    for places in begun[: _KEPT[0] if searched else _KEPT[-1]]:
        tours.append(Tour(terms, wanted, places, None, rng))
        yield
    for kept, heats in zip(_KEPT, _HEATS if searched else [()] * len(_KEPT), strict=True):
        tours = sorted(tours, key=lambda tour: tour.cost + _on(tour.places, toward))[:kept]
        for tour in tours:
            yield from _annealed(tour, heats)
    best = min(tours, key=lambda tour: tour.cost + _on(tour.places, toward))
    missed = round(best.missing / float(wanted.weights[0]))
    return KnownTour(best.places, length_of(best.places), missed)


def _on(places: Floats, toward: Place | None) -> float:
    """Return the distance from the end of a tour (K, 2) to a place, metres; 0 without one."""
    return 0.0 if toward is None else math.dist(places[-1], toward)


def grown(boxes: Singles, margin_m: float) -> Singles:
    """Return boxes (N, 6) that reach farther by a margin on every side, metres."""
    result = boxes.copy()
    for part in (slice(2, 4), slice(4, 6)):
        size = np.maximum(np.hypot(boxes[:, part.start], boxes[:, part.start + 1]), 1e-6)[:, None]
        result[:, part] = boxes[:, part] * (1 + margin_m / size)
    return result


def _wanted(boxes: Singles, footprint: Footprint) -> Wanted:
    """Return the boxes as wanted ground: each is worth so much that none is left out."""
    return Wanted(boxes, np.full(len(boxes), _LOST_M * footprint.width, np.float32), 0.0)


def _annealed(tour: Tour, heats: Sequence[float]) -> Steps[None]:
    """Better a tour, ever cooler."""
    for heat in heats:
        step = next(metres for least, metres in _STEPS if heat >= least)
        for index in range(1, len(tour.places)):
            tour.shift(min(index, len(tour.places) - 1), step, heat)
            yield
        tour.drop(heat)
        tour.add(heat)
        yield
        tour.exchange(heat)
        yield


def _beginnings(
    boxes: Singles, footprint: Footprint, start: Place, allowed: Callable[[Floats], Bools]
) -> Steps[list[Floats]]:
    """Return tours (K, 2) along strips in many directions."""
    first = float(np.median(np.arctan2(boxes[:, 3], boxes[:, 2]) % (math.pi / 2)))
    found: list[Floats] = []
    for number in range(2 * _DIRECTIONS):
        for side in (1, -1):
            heading = first + number * math.pi / (2 * _DIRECTIONS)
            found.append(_to_and_fro(boxes, footprint, start, heading, side, allowed))
            yield
    return found


def _to_and_fro(
    boxes: Singles,
    footprint: Footprint,
    start: Place,
    heading: float,
    side: int,
    allowed: Callable[[Floats], Bools],
) -> Floats:
    """Return the shortest of the tours (K, 2) along the fewest strips in one direction.

    ``side`` is that from which strips are counted: 1 or -1.
    """
    c, s = math.cos(heading), math.sin(heading)
    turned = np.array([[c, -s], [s, c]]) * (1, side)
    corners = corners_of(boxes) @ turned
    strips = _strips(corners.min(1), corners.max(1), footprint)
    begin = np.array(start) @ turned
    orders = []
    for order in (strips, strips[::-1]):
        for first in (0, 1):
            flown = order.copy()
            flown[1 - first :: 2] = flown[1 - first :: 2, ::-1]
            orders.append(np.vstack([begin, flown.reshape(-1, 2)]))
    places = min(orders, key=length_of) @ turned.T
    places[0] = start
    is_kept = allowed(places)
    is_kept[0] = True
    is_kept[1:] &= np.any(np.abs(np.diff(places, axis=0)) > 1e-6, axis=1)
    kept: Floats = places[is_kept]
    return kept


def _strips(low: Floats, high: Floats, footprint: Footprint) -> Floats:
    """Return the ends (L, 2, 2) of strips as (along, across); ``low`` and ``high`` (N, 2) are the boxes' corners."""
    left = np.argsort(low[:, 1], kind="stable")
    strips = []
    while len(left):
        edge = low[left[0], 1] + footprint.width
        shown = high[left, 1] <= edge
        shown[0] = True
        mine, left = left[shown], left[~shown]
        across = (low[mine, 1].min() + high[mine, 1].max()) / 2
        first, last = low[mine, 0].min() + footprint.depth / 2, high[mine, 0].max() - footprint.depth / 2
        if first > last:
            first = last = (first + last) / 2
        strips.append(((first, across), (last, across)))
    return np.array(strips)


def corners_of(boxes: Singles) -> Floats:
    """Return the corners (N, 4, 2) of boxes."""
    middle, along, aside = (boxes[:, None, part : part + 2].astype(np.float64) for part in (0, 2, 4))
    signs = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)], np.float64)
    return np.asarray(middle + signs[None, :, :1] * along + signs[None, :, 1:] * aside)
