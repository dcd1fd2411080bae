"""Lots of known shape, one a seed: what a planner has to find out.

The secret is how a shape comes from a seed: the seed's own generator draws parts, and the whole is scaled to its area.
Shapely's x is north and its y is east, metres.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
import shapely
import shapely.affinity
from numpy.random import Generator

from hawk.ddc.fence.geometry import polygon_fence
from hawk.model.plans import AskedGround, Fence

FENCE_MARGIN_M: Final = 5.0
"""Our own limit lies inside the autopilot's by this, as config.toml has it."""
_TIGHT_M: Final = 20.0
_WIDE_M: Final = 45.0
_USUAL_SIZE: Final = math.sqrt(2.0)  # root of a drawn shape's area before it is scaled, about
_LANE_M: Final = 7.0
_START_INSIDE_M: Final = 2.0


@dataclass(frozen=True, slots=True)
class Lot:
    """A lot, where the drone begins (north, east) with what heading (radians), and the fence about it."""

    seed: int
    kind: str
    shape: shapely.Geometry
    start: tuple[float, float]
    yaw: float
    fence: Fence

    @property
    def area(self) -> float:
        """Square metres, islands left out."""
        return float(self.shape.area)

    @property
    def outline(self) -> AskedGround:
        """The lot as an owner who knows it draws it; it lies inside every fence here."""
        pieces = [(part.exterior, *part.interiors) for part in shapely.get_parts(self.shape)]
        rings = tuple(
            tuple(tuple((float(n), float(e)) for n, e in ring.coords[:-1]) for ring in piece) for piece in pieces
        )
        return AskedGround(rings, self.area)


def draw_lot(seed: int, area_m2: float, kind: str) -> Lot:
    """Return the lot of a seed: ``kind`` is a key of `KINDS`. Raises KeyError for another."""
    rng = np.random.default_rng([seed, int(area_m2), sorted(KINDS).index(kind)])
    shape = KINDS[kind](rng, _USUAL_SIZE / math.sqrt(area_m2))
    scale = math.sqrt(area_m2 / shape.area)
    shape = shapely.affinity.scale(shape, scale, scale, origin=(0, 0))
    shape = _centred(shapely.affinity.rotate(shape, rng.uniform(0, 360), origin=(0, 0)))
    return Lot(seed, kind, shape, _start(rng, shape), float(rng.uniform(-math.pi, math.pi)), _fence(shape, seed))


def _rectangles(rng: Generator, _: float) -> shapely.Geometry:
    """Two to four rectangles with a common direction that overlap."""
    shape = _box(rng, (0.0, 0.0), 0.6, 1.6)
    for _ in range(int(rng.integers(1, 4))):
        low, high = np.array(shape.bounds[:2]), np.array(shape.bounds[2:])
        for _ in range(20):
            part = _box(rng, tuple(rng.uniform(low, high)), 0.4, 1.1)
            if 0.1 * part.area < part.intersection(shape).area < 0.7 * part.area:
                shape = shapely.union(shape, part)
                break
    return shape


def _l_shape(rng: Generator, _: float) -> shapely.Geometry:
    a, b = rng.uniform(1.0, 2.0, 2)
    c, d = rng.uniform(0.35, 0.6) * a, rng.uniform(0.35, 0.6) * b
    return shapely.union(shapely.box(0, 0, a, d), shapely.box(0, 0, c, b))


def _u_shape(rng: Generator, _: float) -> shapely.Geometry:
    a, b = rng.uniform(1.0, 1.8, 2)
    base = rng.uniform(0.25, 0.4) * a
    left, right = rng.uniform(0.25, 0.36, 2) * b
    parts = [shapely.box(0, 0, base, b), shapely.box(0, 0, a, left)]
    return shapely.union_all([*parts, shapely.box(0, b - right, a * rng.uniform(0.6, 1.0), b)])


def _joined(rng: Generator, metre: float) -> shapely.Geometry:
    """Two lots, and a lane between them that is part of the whole."""
    first, second = _box(rng, (0.0, 0.0), 0.8, 1.4), _box(rng, (0.0, 0.0), 0.6, 1.2)
    north = first.bounds[2] - second.bounds[0] + rng.uniform(0.25, 0.5)
    second = shapely.affinity.translate(second, north, rng.uniform(-0.3, 0.3))
    low = max(first.bounds[1], second.bounds[1])
    high = min(first.bounds[3], second.bounds[3])
    half = _LANE_M / 2 * metre
    east = rng.uniform(low + half, high - half)
    lane = shapely.box(first.bounds[2] - 0.05, east - half, second.bounds[0] + 0.05, east + half)
    return shapely.union_all([first, second, lane])


def _islands(rng: Generator, metre: float) -> shapely.Geometry:
    """Rectangles with one to three buildings in them."""
    shape = _rectangles(rng, metre)
    size = math.sqrt(shape.area)
    for _ in range(int(rng.integers(1, 4))):
        inner = shape.buffer(-0.12 * size)
        if inner.is_empty:
            break
        building = _box(rng, _inside(rng, inner), 0.12 * size, 0.3 * size)
        left = shape.difference(building)
        if isinstance(left, shapely.Polygon):
            shape = left
    return shape


KINDS: Final[dict[str, Callable[[Generator, float], shapely.Geometry]]] = {
    "rectangles": _rectangles,
    "L": _l_shape,
    "U": _u_shape,
    "joined": _joined,
    "islands": _islands,
}


def _box(rng: Generator, middle: tuple[float, ...], least: float, most: float) -> shapely.Polygon:
    a, b = rng.uniform(least, most, 2) / 2
    return shapely.box(middle[0] - a, middle[1] - b, middle[0] + a, middle[1] + b)


def _inside(rng: Generator, shape: shapely.Geometry) -> tuple[float, float]:
    low, high = np.array(shape.bounds[:2]), np.array(shape.bounds[2:])
    while True:
        place = rng.uniform(low, high)
        if shape.contains(shapely.Point(place)):
            return float(place[0]), float(place[1])


def _centred(shape: shapely.Geometry) -> shapely.Geometry:
    return shapely.affinity.translate(shape, -shape.centroid.x, -shape.centroid.y)


def _start(rng: Generator, shape: shapely.Geometry) -> tuple[float, float]:
    """Anywhere in the lot, for half of the seeds near its border: where people stand who send a drone up."""
    inner = shape.buffer(-_START_INSIDE_M)
    if rng.random() < 0.5:
        return _inside(rng, inner)
    rim = shape.difference(shape.buffer(-3 * _START_INSIDE_M))
    return _inside(rng, rim.intersection(inner))


def _fence(shape: shapely.Geometry, seed: int) -> Fence:
    """The lot's own outline drawn by hand for even seeds, a wide hull for odd ones."""
    if seed % 2 == 0:
        outer = shapely.Polygon(shape.buffer(_TIGHT_M, join_style="mitre", mitre_limit=2.0).exterior).simplify(1.0)
    else:
        outer = shape.convex_hull.buffer(_WIDE_M, quad_segs=3)
    ring = [(float(north), float(east)) for north, east in outer.exterior.coords[:-1]]
    return polygon_fence(ring, FENCE_MARGIN_M, 100.0, 3.0)
