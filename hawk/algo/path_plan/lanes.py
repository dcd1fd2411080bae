"""Lanes to and fro over wanted ground: a beginning for the search of a tour over ground that is known and wide.

A tour that grows waypoint by waypoint is good over a few pictures' ground; over more it is caught in poor orders.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from hawk.algo.ground import Floats, Place
from hawk.algo.path_plan.footprint import Footprint, Singles

_OVERHANG: Final = 0.1
"""Share of a lane's width by which the ground may be wider than its lanes together."""


def to_and_fro(cells: Singles, footprint: Footprint, start: Place, heading: float) -> Floats:
    """Return waypoints (K, 2) of (north, east): the start, then lanes along ``heading`` (radians) that show all cells.

    A lane is flown over gaps in the ground; it begins and ends where its pictures show the last of its cells. Of both
    orders and both directions the ones with the shortest path are returned. ``cells`` (N, 2) are at least one.
    """
    c, s = math.cos(heading), math.sin(heading)
    to_lanes = np.array([[c, -s], [s, c]])
    turned = cells.astype(np.float64) @ to_lanes  # along, across
    lanes = _lanes(turned, footprint)
    begin = np.array(start) @ to_lanes
    orders = [_joined(lanes[::step], first) for step in (1, -1) for first in (0, 1)]
    tours = [np.vstack([begin, order]) for order in orders]
    shortest = min(tours, key=lambda tour: float(np.hypot(*np.diff(tour, axis=0).T).sum()))
    places: Floats = shortest @ to_lanes.T
    places[0] = start
    return places


def _lanes(turned: Floats, footprint: Footprint) -> Floats:
    """Return the ends (L, 2, 2) of lanes as (along, across), in order across."""
    low, high = float(turned[:, 1].min()), float(turned[:, 1].max())
    count = max(1, math.ceil((high - low) / footprint.width - _OVERHANG))
    pitch = max((high - low) / count, 1e-6)
    number = np.minimum(((turned[:, 1] - low) / pitch).astype(int), count - 1)
    lanes = []
    for lane in range(count):
        along = turned[number == lane, 0]
        if len(along) == 0:
            continue
        first, last = float(along.min()) + footprint.depth / 2, float(along.max()) - footprint.depth / 2
        if first > last:
            first = last = (first + last) / 2
        across = low + (lane + 0.5) * pitch
        lanes.append(((first, across), (last, across)))
    return np.array(lanes)


def _joined(lanes: Floats, first: int) -> Floats:
    """Return the waypoints of lanes (L, 2, 2) flown to and fro, the first one from its end ``first``."""
    flown = lanes.copy()
    flown[1 - first :: 2] = flown[1 - first :: 2, ::-1]
    places = flown.reshape(-1, 2)
    moved = np.any(np.diff(places, axis=0) != 0, axis=1)
    kept: Floats = places[np.concatenate([[True], moved])]
    return kept
