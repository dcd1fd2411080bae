"""Geometry of the fence in the map frame (metres north and east): no clock, no autopilot."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import pymap3d
import shapely
from shapely import LineString, Point, Polygon

from hawk.comm.frames import offset_ned
from hawk.model import Fence, GlobalPose, MapPoint

BREACH_TOLERANCE_M = 0.5
"""Position noise and overshoot: a breach begins this far outside our fence, metres."""
RECOVERY_DEPTH_M = 2.0
"""A drone beyond our fence is sent this far inside it, metres."""
CIRCLE_VERTICES = 48
"""Corners of a circular fence; ArduPilot takes up to some 70."""
LEAST_SIDE_M = 0.5
"""Corners nearer to each other are one corner set twice, metres."""
LEAST_AREA_M2 = 400.0
"""20 x 20 m: with the margin taken off both sides something is left to fly in."""
MOST_EXTENT_M = 4000.0
"""As wide as the widest circle that can be configured."""
EDGE_MARGIN_M = 0.5
"""A stop before the edge is this far before it, metres."""
_ARC_SEGMENTS = 16

Ring = tuple[tuple[float, float], ...]


class FenceError(ValueError):
    """A fence that cannot be used; the text names the file or the field, what is wrong and the remedy."""


def to_map(datum: GlobalPose, latitude: float, longitude: float) -> MapPoint:
    """Return a WGS-84 place (degrees) on the tangent plane at the datum."""
    north, east, _ = offset_ned(GlobalPose(latitude, longitude, datum.altitude), datum)
    return MapPoint(north, east)


def ring_to_map(datum: GlobalPose, ring: Ring) -> Ring:
    """Return (latitude, longitude) corners as (north, east) metres on the tangent plane at the datum."""
    latitudes, longitudes = np.array(ring, dtype=float).T
    north, east, _ = pymap3d.geodetic2ned(
        latitudes, longitudes, datum.altitude, datum.latitude, datum.longitude, datum.altitude
    )
    return tuple(zip(north.tolist(), east.tolist(), strict=True))


def ring_from_map(datum: GlobalPose, ring: Ring) -> Ring:
    """Return (north, east) corners on the tangent plane at the datum as (latitude, longitude) degrees."""
    north, east = np.array(ring, dtype=float).T
    latitudes, longitudes, _ = pymap3d.ned2geodetic(
        north, east, np.zeros_like(north), datum.latitude, datum.longitude, datum.altitude
    )
    return tuple(zip(latitudes.tolist(), longitudes.tolist(), strict=True))


def check_outline(ring: Ring) -> None:
    """Check a ring of (north, east) metres: sides, extent, no crossing, area. Raises FenceError naming the corners."""
    for number, (here, there) in enumerate(zip(ring, (*ring[1:], ring[0]), strict=True), start=1):
        if math.dist(here, there) < LEAST_SIDE_M:
            raise FenceError(f"Corners: {number} and {number % len(ring) + 1} lie at one place: remove one of them.")
    ring = tuple((round(north, 2), round(east, 2)) for north, east in ring)  # sides that touch do so to the centimetre
    shape = Polygon(ring)
    south, west, north, east = shape.bounds
    widest = max(north - south, east - west)
    if widest > MOST_EXTENT_M:
        raise FenceError(f"Corners: the fence is {widest:.0f} m wide: draw it at most {MOST_EXTENT_M:.0f} m wide.")
    if not shape.is_valid:
        raise FenceError(f"Corners: {_crossing(ring)}: move a corner so that no side crosses another.")
    if shape.area < LEAST_AREA_M2:
        raise FenceError(f"Corners: the fence holds {shape.area:.0f} m², too little to fly in: draw it wider.")


def _crossing(ring: Ring) -> str:
    """Return in words which two sides cross or touch."""
    sides = shapely.linestrings([(here, there) for here, there in zip(ring, (*ring[1:], ring[0]), strict=True)])
    first, second = np.triu_indices(len(ring), 2)
    apart = (second - first) % len(ring) < len(ring) - 1  # the last side is the first one's neighbour
    first, second = first[apart], second[apart]
    crossed = np.flatnonzero(shapely.intersects(sides[first], sides[second]))
    if not crossed.size:
        return "a side lies on its neighbour"
    a, b = int(first[crossed[0]]), int(second[crossed[0]])
    return f"the sides {a + 1}-{a + 2} and {b + 1}-{(b + 1) % len(ring) + 1} cross"


def polygon_fence(outer: Sequence[tuple[float, float]], margin: float, ceiling: float, ceiling_margin: float) -> Fence:
    """Return the fence whose outer limit, the autopilot's, is this (north, east) ring; ours lies inside by the margins.

    Raises FenceError when nothing, or more than one piece, is left inside.
    """
    inner = shapely.buffer(Polygon(outer), -margin, join_style="mitre", mitre_limit=5.0)
    if inner.is_empty or not isinstance(inner, Polygon) or inner.interiors:
        raise FenceError(f"Corners: the fence is too narrow: nothing whole is left {margin:g} m inside: draw it wider.")
    return Fence(
        polygon=_open_ring(inner),
        autopilot_polygon=tuple((float(n), float(e)) for n, e in outer),
        ceiling=ceiling - ceiling_margin,
        autopilot_ceiling=ceiling,
    )


def circle(centre: MapPoint, radius: float) -> Ring:
    """Return the corners of a circle, (north, east) metres."""
    steps = (2 * math.pi * k / CIRCLE_VERTICES for k in range(CIRCLE_VERTICES))
    return tuple((centre.north + radius * math.cos(a), centre.east + radius * math.sin(a)) for a in steps)


def contains(fence: Fence, place: MapPoint) -> bool:
    """Return True when the place lies inside our fence or on its edge."""
    return _is_finite(place) and bool(shapely.intersects_xy(_shape(fence.polygon), place.north, place.east))


def outside_by(fence: Fence, place: MapPoint) -> float:
    """Return how far the place lies outside our fence, metres; 0 inside."""
    if contains(fence, place):
        return 0.0
    return float(_shape(fence.polygon).distance(Point(place.north, place.east)))


def path_is_inside(fence: Fence, start: MapPoint, end: MapPoint) -> bool:
    """Return True when the straight path lies inside our fence from end to end."""
    if not (_is_finite(start) and _is_finite(end)):
        return False
    if start == end:
        return contains(fence, start)
    return bool(_shape(fence.polygon).covers(LineString([(start.north, start.east), (end.north, end.east)])))


def leads_inside(fence: Fence, start: MapPoint, end: MapPoint) -> bool:
    """Return True when the straight path ends inside our fence and never leaves it once it is inside.

    From a start inside this is `path_is_inside`; from one outside it is a path back that enters once.
    """
    if path_is_inside(fence, start, end):
        return True
    if not _is_finite(start) or not contains(fence, end) or contains(fence, start):
        return False
    inside = _shape(fence.polygon).intersection(LineString([(start.north, start.east), (end.north, end.east)]))
    return isinstance(inside, Point | LineString)


def last_inside(fence: Fence, start: MapPoint, end: MapPoint) -> MapPoint:
    """Return the end of a straight path that begins inside and leaves our fence: `EDGE_MARGIN_M` before it leaves."""
    inside = _shape(fence.polygon).intersection(LineString([(start.north, start.east), (end.north, end.east)]))
    first = min(shapely.get_parts(inside), key=lambda part: part.distance(Point(start.north, start.east)), default=None)
    if first is None:
        return start
    length = max(math.dist((start.north, start.east), corner) for corner in first.coords)
    share = max(length - EDGE_MARGIN_M, 0.0) / max(start.distance(end), 1e-9)
    return MapPoint(start.north + (end.north - start.north) * share, start.east + (end.east - start.east) * share)


def sees_all(fence: Fence, place: MapPoint) -> bool:
    """Return True when the straight path from everywhere inside our fence to this place stays inside.

    A simple polygon is seen whole from where all its corners are seen.
    """
    ways = shapely.linestrings([((place.north, place.east), corner) for corner in fence.polygon])
    return contains(fence, place) and bool(np.all(_shape(fence.polygon).covers(ways)))


def inside_point(fence: Fence, place: MapPoint, depth: float = RECOVERY_DEPTH_M) -> MapPoint:
    """Return the place nearest to this one (within half a percent of the depth) that lies ``depth`` metres inside.

    In a fence too narrow for that depth it is the place farthest from all sides.
    """
    shape = _shape(fence.polygon)
    # around a corner that points inwards the edge is an arc, drawn by chords that would come too near to the corner
    core = shapely.buffer(shape, -depth / math.cos(math.pi / 4 / _ARC_SEGMENTS), quad_segs=_ARC_SEGMENTS)
    if core.is_empty:
        best = shapely.maximum_inscribed_circle(shape).coords[0]
        return MapPoint(float(best[0]), float(best[1]))
    point = Point(place.north, place.east)
    if shape.covers(point) and shape.boundary.distance(point) >= depth:
        return place
    north, east = shapely.shortest_line(core, point).coords[0]
    return MapPoint(float(north), float(east))


def is_about_same(one: Fence, other: Fence, tolerance: float) -> bool:
    """Return True when the autopilot's limits of two fences differ nowhere by more than the tolerance, metres."""
    if len(one.autopilot_polygon) != len(other.autopilot_polygon):
        return False
    pairs = zip(one.autopilot_polygon, other.autopilot_polygon, strict=True)
    near = all(math.dist(here, there) <= tolerance for here, there in pairs)
    return near and abs(one.autopilot_ceiling - other.autopilot_ceiling) <= tolerance


def extent(fence: Fence) -> tuple[float, float]:
    """Return the fence's extent north-south and east-west, metres."""
    south, west, north, east = _shape(fence.polygon).bounds
    return float(north - south), float(east - west)


def area(ring: Ring) -> float:
    """Return the area inside a ring of metres, m²."""
    return float(_shape(ring).area)


def shape(fence: Fence) -> Polygon:
    """Return the ground inside our fence, prepared: (north, east) metres. The same object for the same fence."""
    return _shape(fence.polygon)


@lru_cache(maxsize=8)
def _shape(ring: Ring) -> Polygon:
    shape = Polygon(ring)
    shapely.prepare(shape)
    return shape


def _open_ring(polygon: Polygon) -> Ring:
    return tuple((float(n), float(e)) for n, e in list(polygon.exterior.coords)[:-1])


def _is_finite(place: MapPoint) -> bool:
    return math.isfinite(place.north) and math.isfinite(place.east)
