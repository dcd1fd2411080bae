"""Checks of drawn exclusion zones, in the map frame (metres north and east): each zone, and how zones lie."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import shapely
from shapely import Polygon

from hawk.ddc.fence.geometry import LEAST_SIDE_M, FenceError, Ring, crossing
from hawk.model.sentences import say

_SAME_M = 0.05
"""A corner that is set on a side may lie beyond it by so much: it is kept in degrees, metres."""
LEAST_ZONE_M2 = 1.0
"""A zone around a mast; a smaller one is a slip of the hand, m²."""


def check_zones(outer: Ring, zones: Sequence[Ring]) -> None:
    """Check zones (rings of metres) in the fence ``outer``: sides, area, inside the fence, apart from each other.

    Raises:
        FenceError: Names the zone, the fault and the remedy.
    """
    if not zones:
        return
    fence = Polygon(outer).buffer(_SAME_M)
    shapes = [_checked(say("Zone {number}", number=number), ring) for number, ring in enumerate(zones, 1)]
    for number, shape in enumerate(shapes, 1):
        if not fence.covers(shape):
            where = say("crosses the fence's edge") if fence.intersects(shape) else say("lies outside the fence")
            raise FenceError(
                say("Zone {number}: {where}: move its corners inside the fence.", number=number, where=where)
            )
    first, second = np.triu_indices(len(shapes), 1)
    places = np.array(shapes, dtype=object)
    crossed = np.flatnonzero(shapely.intersects(shapely.buffer(places, -_SAME_M)[second], places[first]))
    if crossed.size:
        pair = int(second[crossed[0]]) + 1, int(first[crossed[0]]) + 1
        remedy = say("move one of them, or draw one zone around both")
        raise FenceError(
            say("Zone {one}: it crosses or holds zone {other}: {remedy}.", one=pair[0], other=pair[1], remedy=remedy)
        )


def _checked(name: str, ring: Ring) -> Polygon:
    """Return a zone's polygon. Raises FenceError when it is no polygon, or too small."""
    for number, (here, there) in enumerate(zip(ring, (*ring[1:], ring[0]), strict=True), start=1):
        if math.dist(here, there) < LEAST_SIDE_M:
            pair = say("corners {number} and {other}", number=number, other=number % len(ring) + 1)
            raise FenceError(say("{name}: {pair} lie at one place: remove one of them.", name=name, pair=pair))
    shape = Polygon(tuple((round(north, 2), round(east, 2)) for north, east in ring))
    if not shape.is_valid:
        raise FenceError(
            say(
                "{name}: {crossing}: move a corner so that no side crosses another.", name=name, crossing=crossing(ring)
            )
        )
    if shape.area < LEAST_ZONE_M2:
        raise FenceError(
            say(
                "{name}: it holds {area:.1f} m², too little to be meant: draw it wider, or remove it.",
                name=name,
                area=shape.area,
            )
        )
    return shape
