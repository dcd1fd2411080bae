"""Geometry of plans: the stalls of a row from its front and depth, and the overlap of rectangles.

A shape is (north, east, angle, width, length): the middle in metres, radians clockwise from north, metres.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import shapely

from hawk.lots.plan.values import Floats
from hawk.model.sentences import say

Point = tuple[float, float]
_LEAST_FRONT_M: Final = 0.5
_GRID_M: Final = 1e-6
"""Without a grid GEOS 3.14.1 returns the whole of one of two rectangles that touch, for 0.7 % of such pairs."""


class ShapeError(ValueError):
    """A row or outline cannot be drawn so; ``field`` names what to change."""

    def __init__(self, field: str, reason: str) -> None:
        super().__init__(reason)
        self.field = field


@dataclass(frozen=True, slots=True)
class Row:
    """A row to draw: ``count`` stalls along the line from ``start`` to ``end``, on the side of ``far``.

    ``lean``: radians by which the stalls lean from square to the front towards its end.
    """

    start: Point
    end: Point
    far: Point
    count: int
    lean: float = 0.0
    is_double: bool = False


def front_length(start: Point, end: Point) -> float:
    """Return the length of a row's front, metres. Raises ShapeError for one without length."""
    found = math.dist(start, end)
    if found < _LEAST_FRONT_M:
        raise ShapeError(
            "front",
            say("is {length:.2f} m long: place its ends {least:g} m apart or more", length=found, least=_LEAST_FRONT_M),
        )
    return found


def row_shapes(row: Row) -> Floats:
    """Return the stalls of a row in order, (N, 5); of a double row those of the near side first.

    Their front corners stand on the front, their far corners on the line through ``far``, and neighbours touch. The
    second side of a double row is the first one turned by half a turn about the middle: its stalls have the same lean.
    The far side is measured square to the front. Raises ShapeError for a far side on the front, and for stalls that
    have no length.
    """
    length = front_length(row.start, row.end)
    along = (np.array(row.end) - row.start) / length
    across = np.array([-along[1], along[0]])
    reach = float((np.array(row.far) - row.start) @ across)
    if reach < 0:
        across, reach = -across, -reach
    depth = reach / 2 if row.is_double else reach
    pitch = length / row.count
    cosine, sine = math.cos(row.lean), math.sin(row.lean)
    width = pitch * cosine
    long = (depth - width * abs(sine)) / cosine
    if long < _LEAST_FRONT_M:
        raise ShapeError("far", say("leaves the stalls no length: place it farther from the front"))
    direction = cosine * across + sine * along
    steps = (np.arange(row.count) + 0.5)[:, None] * pitch
    middles = np.array(row.start) + steps * along + math.tan(row.lean) * depth / 2 * along + depth / 2 * across
    if row.is_double:
        centre = (np.array(row.start) + row.end) / 2 + reach / 2 * across
        middles = np.concatenate([middles, (2 * centre - middles)[::-1]])
    angle = math.atan2(float(direction[1]), float(direction[0]))
    return normal(np.column_stack([middles, np.tile((angle, width, long), (len(middles), 1))]))


def normal(shapes: Floats) -> Floats:
    """Return shapes whose length is the longer side and whose angle is in [0, pi)."""
    found = shapes.copy()
    is_wide = found[:, 3] > found[:, 4]
    found[is_wide, 3:5] = found[is_wide, 4:2:-1]
    found[:, 2] = (found[:, 2] + np.where(is_wide, np.pi / 2, 0.0)) % np.pi
    return found


def turned(shapes: Floats, by: float, *, about_each: bool) -> Floats:
    """Return shapes after a turn, radians clockwise, about the middle of all or each about its own."""
    found = shapes.copy()
    found[:, 2] = (found[:, 2] + by) % np.pi
    if not about_each:
        middle = shapes[:, :2].mean(axis=0)
        cosine, sine = math.cos(by), math.sin(by)
        found[:, :2] = middle + (shapes[:, :2] - middle) @ np.array([[cosine, sine], [-sine, cosine]])
    return found


def parts(shape: Floats, count: int) -> Floats:
    """Return a shape (5,) split along its width, (count, 5), in the order of clockwise from its angle."""
    north, east, angle, width, length = shape.tolist()
    steps = ((np.arange(count) + 0.5) / count - 0.5) * width
    middles = np.array([north, east]) + steps[:, None] * np.array([-math.sin(angle), math.cos(angle)])
    return np.column_stack([middles, np.tile((angle, width / count, length), (count, 1))])


def corners(shapes: Floats) -> Floats:
    """Return the corners of shapes, (N, 4, 2) of (north, east), counter-clockwise as seen from above."""
    along = np.column_stack([np.cos(shapes[:, 2]), np.sin(shapes[:, 2])]) * shapes[:, 4:5] / 2
    across = np.column_stack([-np.sin(shapes[:, 2]), np.cos(shapes[:, 2])]) * shapes[:, 3:4] / 2
    middle = shapes[:, :2]
    around = (middle - along - across, middle - along + across, middle + along + across, middle + along - across)
    return np.stack(around, axis=1)


def polygons(shapes: Floats) -> Floats:
    """Return the rectangles of shapes as an array (N,) of polygons in (north, east)."""
    return shapely.polygons(corners(shapes))  # type: ignore[no-any-return]


def overlaps(moved: Floats, kept: Floats, most: float) -> list[tuple[int, int, float]]:
    """Return pairs of rectangles that overlap by more than a share of the smaller one.

    Each pair is (number, number, share): a moved rectangle, and another one in the order of the moved and then the
    kept ones. The largest share comes first.
    """
    if not len(moved):
        return []
    shapes = np.concatenate([moved, kept])
    found = polygons(shapes)
    tree = shapely.STRtree(found)
    first, second = tree.query(found[: len(moved)], predicate="intersects")
    is_pair = second > first
    first, second = first[is_pair], second[is_pair]
    areas = shapes[:, 3] * shapes[:, 4]
    shared = shapely.intersection(found[first], found[second], grid_size=_GRID_M)
    shares = shapely.area(shared) / np.minimum(areas[first], areas[second])
    bad = np.flatnonzero(shares > most)
    ordered = bad[np.argsort(-shares[bad], kind="stable")]
    return [(int(first[n]), int(second[n]), float(shares[n])) for n in ordered]


def overlaps_between(shapes: Floats, others: Floats, most: float) -> list[tuple[int, int, float]]:
    """Return pairs (number, number of the other, share) that overlap by more than a share of the smaller one."""
    if not len(shapes) or not len(others):
        return []
    found, beside = polygons(shapes), polygons(others)
    first, second = shapely.STRtree(beside).query(found, predicate="intersects")
    smaller = np.minimum(shapes[first, 3] * shapes[first, 4], others[second, 3] * others[second, 4])
    shares = shapely.area(shapely.intersection(found[first], beside[second], grid_size=_GRID_M)) / smaller
    return [(int(first[n]), int(second[n]), float(shares[n])) for n in np.flatnonzero(shares > most)]


def checked_ring(ring: list[Point]) -> list[Point]:
    """Return the corners of an area that does not cross itself. Raises ShapeError."""
    area = shapely.Polygon(ring)
    if not area.is_valid:
        raise ShapeError("outline", say("crosses or touches itself: place the corners in their order around the area"))
    if area.area < 1.0:
        raise ShapeError("outline", say("has {area:.2f} m²: draw an area of 1 m² or more", area=area.area))
    return ring


def within(ring: tuple[Point, ...], places: Floats) -> list[bool]:
    """Return which places (N, 2) are in an area."""
    return shapely.contains_xy(shapely.Polygon(ring), places).tolist()  # type: ignore[no-any-return]
