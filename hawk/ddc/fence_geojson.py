"""A fence as GeoJSON (RFC 7946; WGS-84, longitude before latitude).

The fence is a Polygon, its interior rings are the exclusion zones. In a FeatureCollection, further Polygons with the
property ``"exclusion": true`` are zones, too.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from shapely import Polygon

from hawk.comm.messages import LEAST_CORNERS, MOST_CORNERS, zones_problem
from hawk.ddc.geofence import FenceError, Ring

T = TypeVar("T")
_ONE = 'must hold exactly one Polygon (WGS-84, longitude before latitude); others need the property "exclusion": true'


@dataclass(frozen=True, slots=True)
class Outline:
    """Fence and zones, (latitude, longitude) corners; ``ceiling`` in metres above the arm place, None for none."""

    ring: Ring
    zones: tuple[Ring, ...]
    ceiling: float | None


def read_outline(path: Path) -> Outline:
    """Return the fence of a GeoJSON file, with its zones and its property ``ceiling_m``, if it has one.

    Raises:
        FenceError: Names the file, the ring and the fault.
    """
    return read_geojson(path, "fence file", _outline, FenceError)


def read_geojson(path: Path, name: str, parse: Callable[[Any], T], kind: type[FenceError]) -> T:
    """Return what ``parse`` makes of a JSON file; it raises FenceErrors without the file's name.

    Raises:
        FenceError: Of this ``kind``, with the ``name`` of such a file, its path and the fault.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise kind(f"{name} {path}: cannot be read: {error}") from error
    try:
        return parse(content)
    except FenceError as error:
        raise kind(f"{name} {path}: {error}") from error


def outline_geojson(ring: Ring, zones: Sequence[Ring], ceiling: float) -> str:
    """Return (latitude, longitude) corners and a ceiling (metres above the arm place) as a GeoJSON Feature."""
    rings = [_positions(ring, clockwise=False), *(_positions(zone, clockwise=True) for zone in zones)]
    feature = {
        "type": "Feature",
        "properties": {"name": "fence", "ceiling_m": ceiling},
        "geometry": {"type": "Polygon", "coordinates": rings},
    }
    return json.dumps(feature, indent=1) + "\n"


def _positions(ring: Ring, *, clockwise: bool) -> list[list[float]]:
    """Return a closed ring; RFC 7946: an outer ring runs counterclockwise, an inner one clockwise."""
    positions = [[longitude, latitude] for latitude, longitude in (*ring, ring[0])]
    return positions if _turns_clockwise(ring) == clockwise else positions[::-1]


def _turns_clockwise(ring: Ring) -> bool:
    pairs = zip(ring, (*ring[1:], ring[0]), strict=True)
    return sum((there[1] - here[1]) * (there[0] + here[0]) for here, there in pairs) > 0


def _outline(content: Any) -> Outline:
    polygons = _polygons(content)
    fences = [each for each in polygons if each[1].get("exclusion") is not True]
    if len(fences) != 1:
        raise FenceError(_ONE)
    geometry, properties = fences[0]
    rings = _rings(geometry)
    if not rings:
        raise FenceError("coordinates: hold no ring: draw the fence's outline")
    ceiling = properties.get("ceiling_m")
    if ceiling is not None and not (_is_finite_number(ceiling) and ceiling > 0):
        raise FenceError(f"ceiling_m: must be metres above 0, not {ceiling!r}")
    outer, *inner = (checked_ring(ring, f"coordinates[{number}]") for number, ring in enumerate(rings))
    zones = [*inner, *_separate_zones(polygons)]
    problem = zones_problem(len(outer), [len(zone) for zone in zones])
    if problem:
        raise FenceError(problem)
    return Outline(outer, tuple(zones), None if ceiling is None else float(ceiling))


def _separate_zones(polygons: Sequence[tuple[dict[str, Any], dict[str, Any]]]) -> list[Ring]:
    """Return the zones that are features of their own."""
    found = []
    for number, (geometry, properties) in enumerate(polygons):
        if properties.get("exclusion") is True:
            rings = _rings(geometry)
            if len(rings) != 1:
                raise FenceError(f"features[{number}]: an exclusion zone is one ring without holes: draw it so")
            found.append(checked_ring(rings[0], f"features[{number}] coordinates[0]"))
    return found


def _polygons(content: Any) -> list[tuple[dict[str, Any], dict[str, Any]]]:
    """Return geometry and properties of each feature, all of them Polygons."""
    features = content.get("features") if isinstance(content, dict) else None
    found = []
    for each in features if isinstance(features, list) and features else [content]:
        geometry = each.get("geometry", each) if isinstance(each, dict) else None
        if not isinstance(geometry, dict) or geometry.get("type") != "Polygon":
            raise FenceError(_ONE)
        properties = each.get("properties")
        found.append((geometry, properties if isinstance(properties, dict) else {}))
    return found


def _rings(geometry: dict[str, Any]) -> list[Any]:
    rings = geometry.get("coordinates")
    return rings if isinstance(rings, list) else []


def checked_ring(ring: Any, name: str) -> Ring:
    """Return a GeoJSON ring as (latitude, longitude) corners, not closed.

    Raises:
        FenceError: Names the corner and the fault.
    """
    vertices: list[tuple[float, float]] = []
    for number, place in enumerate(ring if isinstance(ring, list) else ()):
        if not (isinstance(place, list) and len(place) >= 2 and all(_is_finite_number(v) for v in place[:2])):
            raise FenceError(f"{name}[{number}]: must be [longitude, latitude]")
        longitude, latitude = float(place[0]), float(place[1])
        if abs(longitude) > 180 or abs(latitude) > 90:
            raise FenceError(f"{name}[{number}]: not degrees: {longitude}, {latitude}")
        vertices.append((latitude, longitude))
    if len(vertices) > 1 and vertices[0] == vertices[-1]:
        vertices.pop()
    if not LEAST_CORNERS <= len(vertices) <= MOST_CORNERS:
        raise FenceError(f"{name}: has {len(vertices)} corners; draw {LEAST_CORNERS} to {MOST_CORNERS}")
    if not Polygon(vertices).is_valid:
        raise FenceError(f"{name}: its sides cross or touch each other; draw a simple polygon")
    return tuple(vertices)


def _is_finite_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
