"""Ground and places on Earth in metres about a place, and back."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Final

import numpy as np
import pymap3d
from numpy.typing import NDArray
from shapely import BufferCapStyle, Polygon, get_parts, intersection, make_valid, transform, union_all
from shapely.geometry.base import BaseGeometry

from hawk.lots.plan.geometry import corners
from hawk.model.plans import Outline
from hawk.model.poses import GlobalPose, Ring
from hawk.results.survey_map import to_global

_FAR_M: Final = 20_000.0
"""Ground farther off than this is left out: a tangent plane folds the other side of the Earth onto this one."""
LEAST_PIECE_M2: Final = 50.0
"""A smaller piece of ground is no part of a lot: four stalls."""
_GRID_M: Final = 1e-3
"""Without a grid GEOS 3.14.1 returns, for some areas that touch, the whole of one of them."""


def shared_area(ground: BaseGeometry, other: BaseGeometry) -> float:
    """Return the area that both have, m2."""
    return float(intersection(ground, other, grid_size=_GRID_M).area)


def ground_about(centre: tuple[float, float], outline: Outline) -> BaseGeometry:
    """Return an outline in metres (north, east) about a place (latitude, longitude); empty when it is far off.

    Rings that cross themselves are made valid, spikes and holes are cut off.
    """
    pieces = [polygon for ring in outline.polygons if (polygon := _polygon(centre, ring)) is not None]
    holes = [polygon for ring in outline.holes if (polygon := _polygon(centre, ring)) is not None]
    return union_all(pieces).difference(union_all(holes))


def about(centre: tuple[float, float], corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return WGS-84 corners (N, 2) of (latitude, longitude) as (north, east, down) metres about a place, (N, 3)."""
    return np.column_stack(pymap3d.geodetic2ned(corners[:, 0], corners[:, 1], 0.0, centre[0], centre[1], 0.0))


def on_earth(datum: tuple[float, float], places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return places (N, 2) of (north, east), metres about a datum (latitude, longitude), as WGS-84 (N, 2)."""
    return to_global(GlobalPose(*datum, 0.0), places)


def ring_on_earth(datum: tuple[float, float], places: NDArray[np.float64]) -> Ring:
    """Return the corners of a ring as `on_earth` returns places."""
    return tuple((float(latitude), float(longitude)) for latitude, longitude in on_earth(datum, places))


def corners_on_earth(datum: tuple[float, float], shapes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the corners of rectangles (N, 5), as `hawk.lots.plan.geometry.corners` has them, on Earth, (N, 4, 2)."""
    return on_earth(datum, corners(shapes).reshape(-1, 2)).reshape(-1, 4, 2)


def _polygon(centre: tuple[float, float], ring: Sequence[tuple[float, float]]) -> BaseGeometry | None:
    if len(ring) < 3:
        return None
    points = about(centre, np.asarray(ring, float))
    if not np.isfinite(points).all() or np.abs(points).max() > _FAR_M:
        return None
    # a spike of no width is a line, with which GEOS refuses to overlay
    return union_all([part for part in get_parts(make_valid(Polygon(points[:, :2]))) if part.area > 0])


def joined(outlines: Sequence[Outline]) -> Outline:
    """Return one outline of the ground of several, WGS-84. Parts that touch become one."""
    corners = [corner for outline in outlines for ring in outline.polygons for corner in ring]
    if not corners:
        return Outline()
    centre = corners[0]
    return _outline(centre, union_all([ground_about(centre, outline) for outline in outlines]))


def without(outline: Outline, part: Outline) -> Outline:
    """Return an outline without the ground of another one, WGS-84. What is left in slivers is no part of a lot."""
    corners = [corner for ring in outline.polygons for corner in ring]
    if not corners:
        return Outline()
    centre = corners[0]
    left = ground_about(centre, outline).difference(ground_about(centre, part))
    large = [each for each in get_parts(left) if each.area >= LEAST_PIECE_M2]
    return _outline(centre, union_all(large) if large else left)


def _outline(centre: tuple[float, float], ground: BaseGeometry) -> Outline:
    tidy = ground.buffer(0.0, cap_style=BufferCapStyle.flat)

    parts = [part for part in get_parts(transform(tidy, partial(on_earth, centre))) if part.area > 0]
    rings = [tuple((float(a), float(b)) for a, b in part.exterior.coords[:-1]) for part in parts]
    holes = [tuple((float(a), float(b)) for a, b in ring.coords[:-1]) for part in parts for ring in part.interiors]
    return Outline(tuple(rings), tuple(holes))
