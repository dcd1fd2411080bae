"""A fence as GeoJSON (RFC 7946): one Polygon, WGS-84, longitude before latitude."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from shapely import Polygon

from hawk.comm.fence_messages import LEAST_CORNERS, MOST_CORNERS
from hawk.ddc.geofence import FenceError, Ring


def read_geojson(path: Path) -> Ring:
    """Return the one polygon of a GeoJSON file as (latitude, longitude) vertices, not closed. Raises FenceError."""
    return read_outline(path)[0]


def read_outline(path: Path) -> tuple[Ring, float | None]:
    """Return the polygon of a GeoJSON file and its property ``ceiling_m``, if it has one. Raises FenceError."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise FenceError(f"fence file {path}: cannot be read: {error}") from error
    polygon, properties = _single_polygon(content, path)
    rings = polygon.get("coordinates")
    if not isinstance(rings, list) or len(rings) != 1:
        raise FenceError(f"fence file {path}: coordinates: draw one ring without holes")
    ceiling = properties.get("ceiling_m")
    if ceiling is not None and not (_is_finite_number(ceiling) and ceiling > 0):
        raise FenceError(f"fence file {path}: ceiling_m: must be metres above 0, not {ceiling!r}")
    return _checked_ring(rings[0], path), None if ceiling is None else float(ceiling)


def outline_geojson(ring: Ring, ceiling: float) -> str:
    """Return (latitude, longitude) vertices and a ceiling (metres above the arm place) as a GeoJSON Feature."""
    positions = [[longitude, latitude] for latitude, longitude in (*ring, ring[0])]
    if _turns_clockwise(ring):
        positions.reverse()  # RFC 7946: an outer ring runs counterclockwise
    feature = {
        "type": "Feature",
        "properties": {"name": "fence", "ceiling_m": ceiling},
        "geometry": {"type": "Polygon", "coordinates": [positions]},
    }
    return json.dumps(feature, indent=1) + "\n"


def _turns_clockwise(ring: Ring) -> bool:
    pairs = zip(ring, (*ring[1:], ring[0]), strict=True)
    return sum((there[1] - here[1]) * (there[0] + here[0]) for here, there in pairs) > 0


def _single_polygon(content: Any, path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    features = content.get("features") if isinstance(content, dict) else None
    found = features if isinstance(features, list) and features else [content]
    if len(found) == 1 and isinstance(found[0], dict):
        geometry = found[0].get("geometry", found[0])
        if isinstance(geometry, dict) and geometry.get("type") == "Polygon":
            properties = found[0].get("properties")
            return geometry, properties if isinstance(properties, dict) else {}
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
    if not LEAST_CORNERS <= len(vertices) <= MOST_CORNERS:
        raise FenceError(f"fence file {path}: has {len(vertices)} corners; draw {LEAST_CORNERS} to {MOST_CORNERS}")
    if not Polygon(vertices).is_valid:
        raise FenceError(f"fence file {path}: its sides cross or touch each other; draw a simple polygon")
    return tuple(vertices)


def _is_finite_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
