"""A pilot who knows the lots' border and flies to and fro over them, one Compulsive Move after the other."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable
from itertools import pairwise
from typing import Final

import numpy as np
import shapely
import shapely.affinity
import shapely.ops

from benchmarks.figures import BenchmarkError
from hawk.algo.path_plan.footprint import Swath
from hawk.comm.protocol.commands import CompulsiveMove
from hawk.comm.protocol.heartbeat import Heartbeat
from hawk.model.operation import StateName
from hawk.survey.handset import Drone, Progress
from hawk.survey.operator import SurveyOperator, SurveyPlan

Place = tuple[float, float]
Route = Callable[[Heartbeat], list[Place]]

OVERLAP: Final = 0.9
"""Distance of two lanes, in widths of the ground that a picture shows well."""
_INSIDE_M: Final = 2.5  # from the fence
_LEAST_M: Final = 2.0  # a shorter move is none


class LawnmowerOperator(SurveyOperator):
    """Flies a route in place of an exploration."""

    def __init__(self, drone: Drone, plan: SurveyPlan, progress: Progress, route: Route) -> None:
        """``route`` gives the places (north, east, map frame) for the heartbeat with which the work begins."""
        super().__init__(drone, plan, progress)
        self._route = route

    async def _survey(self) -> None:
        self._hand.phase = "Mowing"
        for north, east in self._route(await self._hand.beat()):
            await self._hand.order(CompulsiveMove(x=north, y=east, frame="Map"))
            await self._hand.until(
                lambda beat: beat.state == StateName.HOVER, self._limits.move_s, "A lane was not flown to its end"
            )


def lanes(shape: shapely.Geometry, fence: shapely.Polygon, yaw: float, swath: Swath, start: Place) -> list[Place]:
    """Return places (north, east) to and fro over a shape, along ``yaw``: the drone keeps it in its moves, and the
    picture's wide side lies across.

    Raises BenchmarkError when the fence leaves no path between two of them.
    """
    inside = fence.buffer(-_INSIDE_M, join_style="mitre")
    flat = shapely.affinity.rotate(shape, -yaw, origin=(0, 0), use_radians=True)  # x along, y across
    _, low, _, high = flat.bounds
    count = max(1, math.ceil((high - low) / (swath.width * OVERLAP)))
    pitch = (high - low) / count
    ends: list[Place] = []
    for number in range(count):
        band = flat.intersection(shapely.box(-1e5, low + number * pitch, 1e5, low + (number + 1) * pitch))
        reach = min(swath.depth / 2, (band.bounds[2] - band.bounds[0]) / 2)
        middle = low + (number + 0.5) * pitch
        along = [band.bounds[0] + reach, band.bounds[2] - reach]
        ends += [_turned((one, middle), yaw) for one in (along if number % 2 == 0 else along[::-1])]
    if math.dist(ends[-1], start) < math.dist(ends[0], start):
        ends.reverse()
    return _joined([start, *(_within(place, inside) for place in ends)], inside)


def _joined(places: list[Place], inside: shapely.Polygon) -> list[Place]:
    """Return the places after the first, with corners of the fence between two that do not see each other."""
    if not isinstance(inside, shapely.Polygon) or inside.is_empty:
        raise BenchmarkError("the fence leaves no path from one part of it to another")
    rings = [inside.exterior, *inside.interiors]
    corners = [(float(x), float(y)) for ring in rings for x, y in ring.simplify(0.5).coords[:-1]]
    inside = inside.buffer(0.6)
    found = [place for one, other in pairwise(places) for place in _round(one, other, corners, inside)]
    kept = [place for before, place in pairwise([places[0], *found]) if math.dist(before, place) >= _LEAST_M]
    return kept or [places[-1]]


def _round(start: Place, end: Place, corners: list[Place], inside: shapely.Polygon) -> list[Place]:
    """Return the places of the shortest path from start to end by corners (Dijkstra), the start left out."""
    waiting: list[tuple[float, Place, list[Place]]] = [(0.0, start, [])]
    done: set[Place] = set()
    while waiting:
        distance, at, places = heapq.heappop(waiting)
        if at == end:
            return places
        if at in done:
            continue
        done.add(at)
        for place in (end, *corners):
            if place not in done and inside.covers(shapely.LineString([at, place])):
                heapq.heappush(waiting, (distance + math.dist(at, place), place, [*places, place]))
    raise BenchmarkError(f"the fence leaves no path from {start} to {end}")


def _within(place: Place, inside: shapely.Polygon) -> Place:
    point = shapely.ops.nearest_points(inside, shapely.Point(place))[0]
    return float(point.x), float(point.y)


def _turned(place: Place, yaw: float) -> Place:
    c, s = np.cos(yaw), np.sin(yaw)
    return float(c * place[0] - s * place[1]), float(s * place[0] + c * place[1])
