"""The route of an Autonomous Move: the shortest path over known lot, pulled straight, with corners that may be cut.

The route is sought in a band about the straight line first, then in ever wider ones, so that the cost depends on the
route and not on the map; the whole map is looked at only where the first band held no path. A route in a band is taken
when none that leaves the band could be shorter. One with a cell to spare on either side comes before one that squeezes
through. The route is then kept from frame to frame.
"""

from __future__ import annotations

import math
from itertools import pairwise

import cv2
import numpy as np
import shapely

from hawk.algo.ground import COARSE_M, LotMap, Mask, Place, Window
from hawk.algo.path_plan.grid_search import is_clear, is_clear_triangle, is_connected, shortest_path
from hawk.algo.path_plan.lot_ground import FenceGuard, LotGround, disc_about, without_border
from hawk.model.plans import DesiredPose, Route
from hawk.model.poses import MapPoint
from hawk.model.sentences import say

_BANDS_M = (40.0, 120.0, 360.0)
_FREE_ENDS_M = 6.0  # about the ends no cell is kept free to either side
_GOAL_M = 3.0  # from known lot cells to a goal that was judged inside: the cells are coarser than the verdict
_CUTS_M = (8.0, 4.0, 2.5)  # a corner that cannot be cut by the least of these is one to stop at
_ASIDE_M = 8.0  # farther from the route than a cut corner and wind explain
_ON_ROUTE_M = 2.0  # nearer to it the drone is as good as on it

NO_LOT_HERE = say("the drone is too far from the known lot")
NO_LOT_THERE = say("the place is not on known lot inside the fence")
NO_ROUTE = say("no route over known lot inside the fence leads there")


class RouteKeeper:
    """Keeps the route to one desired place from frame to frame; another number is another place.

    The route is planned once and checked with every frame. It is planned again when it is no longer over known lot,
    or the drone is no longer on it.
    """

    def __init__(self, near_lot_m: float) -> None:
        """``near_lot_m`` is the largest distance from known lot at which the drone may set out."""
        self._near_lot_m = near_lot_m
        self._number: int | None = None
        self._leg = 0
        self._route = Route()

    def route(self, known: LotMap, guard: FenceGuard, place: Place, desired: DesiredPose) -> Route:
        """Return the route for a drone at a place; the same object as for the last frame while it is valid."""
        if desired.number != self._number or not self._holds(known, guard, place):
            goal = (desired.north, desired.east)
            self._number, self._leg = desired.number, 0
            self._route = lot_route(known, guard, place, goal, self._near_lot_m)
        return self._route

    def _holds(self, known: LotMap, guard: FenceGuard, place: Place) -> bool:
        """Return True when the rest of the route is over known lot, and the drone on it."""
        points = [(point.north, point.east) for point in self._route.points]
        if not points:
            return False
        self._leg, at, aside = _nearest(points, self._leg, place)
        ends = [LotGround(known, guard).reached_from(points[-1], _GOAL_M)]
        if self._leg == 0:
            ends.append(LotGround(known, guard).reached_from(points[0], self._near_lot_m))
        if aside > _ASIDE_M or None in ends:
            return False
        ground = LotGround(known, guard, tuple(end for end in ends if end is not None))
        left = points[self._leg + 1 :]
        to_next = ground.is_clear_line(place, left[0]) or (aside <= _ON_ROUTE_M and ground.is_clear_line(at, left[0]))
        return to_next and all(ground.is_clear_line(a, b) for a, b in pairwise(left))


def lot_route(known: LotMap, guard: FenceGuard, start: Place, goal: Place, near_lot_m: float) -> Route:
    """Return the route from start to goal, or the reason why there is none; ``near_lot_m`` as in `RouteKeeper`."""
    ground = LotGround(known, guard)
    begin, end = ground.reached_from(start, near_lot_m), ground.reached_from(goal, _GOAL_M)
    if end is None:
        return Route(refused=NO_LOT_THERE)
    if begin is None:
        return Route(refused=NO_LOT_HERE)
    ground = LotGround(known, guard, (begin, end))
    for band in (*_BANDS_M, math.inf):
        if band == _BANDS_M[1] and not _is_connected(ground, start, goal):
            break
        window = _window(known, start, goal, band)
        mask = ground.mask(window)
        for allowed in (_spacious(mask, window, start, goal), mask):
            found = _path(_banded(allowed, window, start, goal, band), window, start, goal)
            if found is not None and _length(found) <= math.hypot(math.dist(start, goal), 2 * band):
                return _route(found, mask, window)
    return Route(refused=NO_ROUTE)


def _is_connected(ground: LotGround, start: Place, goal: Place) -> bool:
    window = _window(ground.known, start, goal, math.inf)
    return is_connected(ground.mask(window), _cell(window, start), _cell(window, goal))


def _window(known: LotMap, start: Place, goal: Place, band: float) -> Window:
    """Return the window of a band; an endless one covers everything known and both ends."""
    if math.isfinite(band):
        return Window.around(np.array([start, goal]), COARSE_M, band + 2 * COARSE_M)
    extent = known.known_extent()
    corners = np.array([start, goal]) if extent is None else np.vstack([extent, [start, goal]])
    return Window.around(corners, COARSE_M, 2 * COARSE_M)


def _spacious(mask: Mask, window: Window, start: Place, goal: Place) -> Mask:
    spacious = without_border(mask)
    for place in (start, goal):
        part, disc = disc_about(window, place, _FREE_ENDS_M)
        spacious[part] |= mask[part] & disc
    return spacious


def _banded(mask: Mask, window: Window, start: Place, goal: Place, band: float) -> Mask:
    if not math.isfinite(band):
        return mask
    ends = np.round(window.cells_of(*np.array([start, goal]).T)).astype(np.int32)
    inside = np.zeros_like(mask)
    cv2.line(inside, tuple(ends[0].tolist()), tuple(ends[1].tolist()), (1.0,), round(2 * band / window.cell_m))
    return mask & inside


def _path(mask: Mask, window: Window, start: Place, goal: Place) -> list[Place] | None:
    """Return the places of the shortest path over the mask, pulled straight."""
    cells = shortest_path(mask, _cell(window, start), _cell(window, goal))
    if cells is None:
        return None
    north, east = window.centres(*cells.T)
    middles = list(zip(north.tolist(), east.tolist(), strict=True))
    places: list[Place] = [start, *middles[1:-1], goal] if len(middles) > 1 else [start, goal]
    return _pulled(_pulled(places, mask, window), mask, window)


def _cell(window: Window, place: Place) -> tuple[int, int]:
    return math.floor(-place[0] / window.cell_m) - window.row, math.floor(place[1] / window.cell_m) - window.column


def _pulled(places: list[Place], mask: Mask, window: Window) -> list[Place]:
    """Leave out the places between two that see each other.

    The farthest one in sight is sought by doubling and halving: sight along a path mostly ends once.
    """
    kept, at = [places[0]], 0
    while at < len(places) - 1:
        reach, step = at + 1, 1
        while step:
            further = min(reach + step, len(places) - 1)
            if further > reach and is_clear(mask, window, places[at], places[further]):
                reach, step = further, 2 * step
            else:
                step //= 2
        kept.append(places[reach])
        at = reach
    return kept


def _route(places: list[Place], mask: Mask, window: Window) -> Route:
    cuts = [_cut(places[i - 1 : i + 2], mask, window) for i in range(1, len(places) - 1)]
    points = tuple(MapPoint(float(north), float(east)) for north, east in places)
    return Route(points, (0.0, *cuts, 0.0))


def _cut(corner: list[Place], mask: Mask, window: Window) -> float:
    """Return the metres before and behind a corner (its neighbours first and last) within which it may be cut."""
    before, at, after = corner
    most = min(math.dist(before, at), math.dist(at, after)) / 2
    for cut in _CUTS_M:
        ends = (_towards(at, before, cut), at, _towards(at, after, cut))
        if cut <= most and is_clear_triangle(mask, window, ends):
            return cut
    return 0.0


def _towards(place: Place, other: Place, metres: float) -> Place:
    share = metres / math.dist(place, other)
    return place[0] + (other[0] - place[0]) * share, place[1] + (other[1] - place[1]) * share


def _length(places: list[Place]) -> float:
    return sum(math.dist(a, b) for a, b in pairwise(places))


def _nearest(points: list[Place], first: int, place: Place) -> tuple[int, Place, float]:
    """Return the leg nearest to a place, from ``first`` on, the place on it, and the metres between."""
    legs = shapely.linestrings(np.stack([points[first:-1], points[first + 1 :]], axis=1))
    away = shapely.distance(legs, shapely.Point(place))
    nearest = int(np.argmin(away))
    at = shapely.line_interpolate_point(legs[nearest], shapely.line_locate_point(legs[nearest], shapely.Point(place)))
    return first + nearest, (float(at.x), float(at.y)), float(away[nearest])
