"""The route of an Autonomous Move: the shortest way over known lot, pulled straight, with corners that may be cut.

The secret is where it is sought. First in a band about the straight way, then in ever wider ones, so that the cost is
the way's and not the map's; the whole map is looked at only where the first band held no way. A route in a band is
taken when none that leaves the band could be shorter. One with a cell to spare on either side goes before one that
squeezes through.
"""

from __future__ import annotations

import math
from itertools import pairwise

import cv2
import numpy as np

from hawk.algo.mapper.grid import COARSE_M
from hawk.algo.mapper.window import Window
from hawk.algo.path_plan.fence import FenceGuard
from hawk.algo.path_plan.grid_search import is_connected, shortest_path
from hawk.algo.path_plan.lot_ground import KnowsLot, LotGround, Mask, cleared, disc_about
from hawk.algo.path_plan.sight import is_clear, is_clear_triangle
from hawk.algo.path_plan.turned import Place
from hawk.model import MapPoint, Route

_BANDS_M = (40.0, 120.0, 360.0)
_FREE_ENDS_M = 6.0  # about the ends no cell is kept free to either side
GOAL_M = 3.0
"""How far from known lot cells a place may be that was judged to lie inside: the cells are coarser than the verdict."""
_CUTS_M = (8.0, 4.0, 2.5)  # a corner that is not to be cut by the least of these is one to stop at

NO_LOT_HERE = "the drone is too far from the known lot"
NO_LOT_THERE = "the place is not on known lot inside the fence"
NO_WAY = "no way over known lot inside the fence leads there"


def lot_route(known: KnowsLot, guard: FenceGuard, start: Place, goal: Place, near_lot_m: float) -> Route:
    """Return the route from start to goal, or why there is none.

    ``near_lot_m`` is how far from known lot the drone may be when it sets out.
    """
    ground = LotGround(known, guard)
    begin, end = ground.reached_from(start, near_lot_m), ground.reached_from(goal, GOAL_M)
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
            found = _way(_banded(allowed, window, start, goal, band), window, start, goal)
            if found is not None and _length(found) <= math.hypot(math.dist(start, goal), 2 * band):
                return _route(found, mask, window)
    return Route(refused=NO_WAY)


def _is_connected(ground: LotGround, start: Place, goal: Place) -> bool:
    window = _window(ground.known, start, goal, math.inf)
    return is_connected(ground.mask(window), _cell(window, start), _cell(window, goal))


def _window(known: KnowsLot, start: Place, goal: Place, band: float) -> Window:
    """Return the window of a band; an endless one covers everything known and both ends."""
    if math.isfinite(band):
        return Window.around(np.array([start, goal]), COARSE_M, band + 2 * COARSE_M)
    extent = known.known_extent()
    corners = np.array([start, goal]) if extent is None else np.vstack([extent, [start, goal]])
    return Window.around(corners, COARSE_M, 2 * COARSE_M)


def _spacious(mask: Mask, window: Window, start: Place, goal: Place) -> Mask:
    spacious = cleared(mask)
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


def _way(mask: Mask, window: Window, start: Place, goal: Place) -> list[Place] | None:
    """Return the places of the shortest way over the mask, pulled straight."""
    cells = shortest_path(mask, _cell(window, start), _cell(window, goal))
    if cells is None:
        return None
    north, east = -(window.row + cells[:, 0] + 0.5) * window.cell_m, (window.column + cells[:, 1] + 0.5) * window.cell_m
    middles = list(zip(north.tolist(), east.tolist(), strict=True))
    places: list[Place] = [start, *middles[1:-1], goal] if len(middles) > 1 else [start, goal]
    return _pulled(_pulled(places, mask, window), mask, window)


def _cell(window: Window, place: Place) -> tuple[int, int]:
    return math.floor(-place[0] / window.cell_m) - window.row, math.floor(place[1] / window.cell_m) - window.column


def _pulled(places: list[Place], mask: Mask, window: Window) -> list[Place]:
    """Leave out the places between two that see each other.

    How far each sees is sought by doubling and halving: sight along a way mostly ends once.
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
    """Return how far before and behind a corner (its neighbours first and last) the way may leave it aside."""
    before, at, after = corner
    most = min(math.dist(before, at), math.dist(at, after)) / 2
    for cut in _CUTS_M:
        ends = (_towards(at, before, cut), at, _towards(at, after, cut))
        if cut <= most and is_clear_triangle(mask, window, ends):
            return cut
    return 0.0


def _towards(place: Place, other: Place, way: float) -> Place:
    share = way / math.dist(place, other)
    return place[0] + (other[0] - place[0]) * share, place[1] + (other[1] - place[1]) * share


def _length(places: list[Place]) -> float:
    return sum(math.dist(a, b) for a, b in pairwise(places))
