"""Keeps the route to a place from frame to frame: planned once, looked at with every frame, and planned anew when it is
no longer over known lot, or the drone no longer on it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import shapely

from hawk.algo.path_plan.fence import FenceGuard
from hawk.algo.path_plan.lot_ground import KnowsLot, LotGround
from hawk.algo.path_plan.lot_route import GOAL_M, lot_route
from hawk.algo.path_plan.turned import Place
from hawk.model import DesiredPose, Route

_ASIDE_M = 8.0  # farther from the route than a cut corner and wind explain
_ON_ROUTE_M = 2.0  # nearer to it the drone is as good as on it


class RouteKeeper:
    """Follows one desired place; another number is another place."""

    def __init__(self, near_lot_m: float) -> None:
        """``near_lot_m`` is how far from known lot the drone may be when it sets out."""
        self._near_lot_m = near_lot_m
        self._number: int | None = None
        self._leg = 0
        self._route = Route()

    def route(self, known: KnowsLot, guard: FenceGuard, place: Place, desired: DesiredPose) -> Route:
        """Return the route for a drone at a place; the very one of the last frame while it holds."""
        if desired.number != self._number or not self._holds(known, guard, place):
            goal = (desired.north, desired.east)
            self._number, self._leg = desired.number, 0
            self._route = lot_route(known, guard, place, goal, self._near_lot_m)
        return self._route

    def _holds(self, known: KnowsLot, guard: FenceGuard, place: Place) -> bool:
        """Whether what is left of the route is over known lot, and the drone on it."""
        points = [(point.north, point.east) for point in self._route.points]
        if not points:
            return False
        self._leg, at, aside = _nearest(points, self._leg, place)
        ends = [LotGround(known, guard).reached_from(points[-1], GOAL_M)]
        if self._leg == 0:
            ends.append(LotGround(known, guard).reached_from(points[0], self._near_lot_m))
        if aside > _ASIDE_M or None in ends:
            return False
        ground = LotGround(known, guard, tuple(end for end in ends if end is not None))
        left = points[self._leg + 1 :]
        to_next = ground.is_clear_way(place, left[0]) or (aside <= _ON_ROUTE_M and ground.is_clear_way(at, left[0]))
        return to_next and all(ground.is_clear_way(a, b) for a, b in pairwise(left))


def _nearest(points: list[Place], first: int, place: Place) -> tuple[int, Place, float]:
    """Return the leg nearest to a place, from ``first`` on, the place on it, and the metres between."""
    legs = shapely.linestrings(np.stack([points[first:-1], points[first + 1 :]], axis=1))
    away = shapely.distance(legs, shapely.Point(place))
    nearest = int(np.argmin(away))
    at = shapely.line_interpolate_point(legs[nearest], shapely.line_locate_point(legs[nearest], shapely.Point(place)))
    return first + nearest, (float(at.x), float(at.y)), float(away[nearest])
