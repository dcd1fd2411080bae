"""Flying along a route: which of its points is led to, and when the next one's turn comes.

The secret is the corner. One that may be cut is left aside within the metres that the planner found free; until the
drone is on the next leg it is not led farther along it than that, so that it stays within the triangle that was looked
at. At any other corner it stops first.
"""

from __future__ import annotations

import math

from hawk.model import MapPoint, Route

_ON_LEG_M = 1.0
"""From this distance to a leg the drone is on it, metres."""


class RouteFollower:
    """Follows one route."""

    def __init__(self, route: Route, arrival_m: float) -> None:
        """``arrival_m``: so near a corner the drone has stopped there. Raises ValueError for less than two points."""
        if len(route.points) < 2:
            raise ValueError("a route has at least two points")
        self.route = route
        self._arrival_m = arrival_m
        self._leg = 1

    def aim(self, place: MapPoint) -> MapPoint:
        """Return where a drone at a place is to be led, straight."""
        points, turns = self.route.points, self.route.turns
        while self._leg < len(points) - 1:
            if place.distance(points[self._leg]) > max(turns[self._leg], self._arrival_m):
                break
            self._leg += 1
        start, end = points[self._leg - 1], points[self._leg]
        cut = turns[self._leg - 1]
        if cut == 0 or _aside(place, start, end) <= _ON_LEG_M:
            return end
        return _on_leg(start, end, cut)

    @property
    def heading_for(self) -> MapPoint:
        """The point of the route that is next."""
        return self.route.points[self._leg]

    def left(self, place: MapPoint) -> tuple[MapPoint, ...]:
        """Return the way that is left: from the drone's place through the points that are still to come."""
        return (place, *self.route.points[self._leg :])


def _on_leg(start: MapPoint, end: MapPoint, way: float) -> MapPoint:
    share = min(1.0, way / start.distance(end))
    return MapPoint(start.north + (end.north - start.north) * share, start.east + (end.east - start.east) * share)


def _aside(place: MapPoint, start: MapPoint, end: MapPoint) -> float:
    """Return the distance to the straight line through a leg, metres."""
    north, east = end.north - start.north, end.east - start.east
    length = math.hypot(north, east)
    if length == 0:
        return place.distance(end)
    return abs((place.north - start.north) * east - (place.east - start.east) * north) / length
