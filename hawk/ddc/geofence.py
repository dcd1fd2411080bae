"""Where the drone may be: pure geometry in the map frame (metres north and east), no clock, no autopilot."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import shapely
from shapely import LineString, Point, Polygon

from hawk.comm.frames import offset_ned
from hawk.model import Fence, GlobalPose, MapPoint

BREACH_TOLERANCE_M = 0.5
"""Position noise and overshoot: a breach begins so far outside our fence, metres."""
RECOVERY_DEPTH_M = 2.0
"""A drone beyond our fence is sent so far inside it, metres."""
CIRCLE_VERTICES = 48
"""Corners of a circular fence; ArduPilot takes up to some 70."""
MAXIMUM_VERTICES = 70
_ARC_SEGMENTS = 16

Ring = tuple[tuple[float, float], ...]


class FenceError(ValueError):
    """A fence that cannot be used; the text names the file, what is wrong and the remedy."""


def to_map(datum: GlobalPose, latitude: float, longitude: float) -> MapPoint:
    """Return a WGS-84 place (degrees) on the tangent plane at the datum."""
    north, east, _ = offset_ned(GlobalPose(latitude, longitude, datum.altitude), datum)
    return MapPoint(north, east)


def read_geojson(path: Path) -> Ring:
    """Return the one polygon of a GeoJSON file as (latitude, longitude) vertices, not closed. Raises FenceError."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, json.JSONDecodeError) as error:
        raise FenceError(f"fence file {path}: cannot be read: {error}") from error
    polygon = _single_polygon(content, path)
    rings = polygon.get("coordinates")
    if not isinstance(rings, list) or len(rings) != 1:
        raise FenceError(f"fence file {path}: coordinates: draw one ring without holes")
    return _checked_ring(rings[0], path)


def _single_polygon(content: Any, path: Path) -> dict[str, Any]:
    features = content.get("features") if isinstance(content, dict) else None
    geometries = [f.get("geometry") if isinstance(f, dict) else None for f in features] if features else [content]
    if len(geometries) == 1 and isinstance(geometries[0], dict):
        found = geometries[0].get("geometry", geometries[0])
        if isinstance(found, dict) and found.get("type") == "Polygon":
            return found
    raise FenceError(f"fence file {path}: must hold exactly one Polygon (WGS-84, longitude before latitude)")


def _checked_ring(ring: Any, path: Path) -> Ring:
    vertices: list[tuple[float, float]] = []
    for number, place in enumerate(ring if isinstance(ring, list) else ()):
        if not (isinstance(place, list) and len(place) >= 2 and all(_is_finite_number(v) for v in place[:2])):
            raise FenceError(f"fence file {path}: coordinates[0][{number}]: must be [longitude, latitude]")
        longitude, latitude = float(place[0]), float(place[1])
        if abs(longitude) > 180 or abs(latitude) > 90:
            raise FenceError(f"fence file {path}: coordinates[0][{number}]: not degrees: {longitude}, {latitude}")
        vertices.append((latitude, longitude))
    if len(vertices) > 1 and vertices[0] == vertices[-1]:
        vertices.pop()
    if not 3 <= len(vertices) <= MAXIMUM_VERTICES:
        raise FenceError(f"fence file {path}: has {len(vertices)} corners; draw 3 to {MAXIMUM_VERTICES}")
    if not Polygon(vertices).is_valid:
        raise FenceError(f"fence file {path}: its sides cross or touch each other; draw a simple polygon")
    return tuple(vertices)


def _is_finite_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def polygon_fence(outer: Sequence[tuple[float, float]], margin: float, ceiling: float, ceiling_margin: float) -> Fence:
    """Return the fence whose outer limit, the autopilot's, is this (north, east) ring; ours lies inside by the margins.

    Raises FenceError when nothing, or more than one piece, is left inside.
    """
    inner = shapely.buffer(Polygon(outer), -margin, join_style="mitre", mitre_limit=5.0)
    if inner.is_empty or not isinstance(inner, Polygon) or inner.interiors:
        raise FenceError(f"fence: too narrow: nothing whole is left {margin:g} m inside; draw it wider")
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
    """Whether the place lies inside our fence, its edge included."""
    return _is_finite(place) and bool(_shape(fence.polygon).covers(Point(place.north, place.east)))


def outside_by(fence: Fence, place: MapPoint) -> float:
    """Return how far the place lies outside our fence, metres; 0 inside."""
    return float(_shape(fence.polygon).distance(Point(place.north, place.east)))


def way_is_inside(fence: Fence, start: MapPoint, end: MapPoint) -> bool:
    """Whether the straight way lies inside our fence from end to end."""
    if not (_is_finite(start) and _is_finite(end)):
        return False
    if start == end:
        return contains(fence, start)
    return bool(_shape(fence.polygon).covers(LineString([(start.north, start.east), (end.north, end.east)])))


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


def extent(fence: Fence) -> tuple[float, float]:
    """Return the fence's extent north-south and east-west, metres."""
    south, west, north, east = _shape(fence.polygon).bounds
    return float(north - south), float(east - west)


@lru_cache(maxsize=8)
def _shape(ring: Ring) -> Polygon:
    shape = Polygon(ring)
    shapely.prepare(shape)
    return shape


def _open_ring(polygon: Polygon) -> Ring:
    return tuple((float(n), float(e)) for n, e in list(polygon.exterior.coords)[:-1])


def _is_finite(place: MapPoint) -> bool:
    return math.isfinite(place.north) and math.isfinite(place.east)
