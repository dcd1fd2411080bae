"""An outline of a survey as GeoJSON (RFC 7946; WGS-84, longitude before latitude).

Every Polygon and MultiPolygon of the file belongs to the outline, their interior rings are holes. A Polygon with the
property ``"exclusion": true`` is a hole, as in a fence.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hawk.comm.outline_messages import outline_problem
from hawk.ddc.fence_geojson import checked_ring, read_geojson
from hawk.ddc.geofence import Ring
from hawk.ddc.outline import OutlineError, check_rings
from hawk.model.limits import Outline

_NONE = "must hold Polygons or MultiPolygons (WGS-84, longitude before latitude)"


def read_survey_outline(path: Path) -> Outline:
    """Return the outline of a GeoJSON file, checked.

    Raises:
        OutlineError: Names the file, the ring and the fault.
    """
    return read_geojson(path, "outline file", _checked, OutlineError)


def _checked(content: Any) -> Outline:
    outline = _outline(content)
    check_rings(outline)
    return outline


def _outline(content: Any) -> Outline:
    polygons: list[Ring] = []
    holes: list[Ring] = []
    features = content.get("features") if isinstance(content, dict) else None
    for number, feature in enumerate(features if isinstance(features, list) else [content]):
        name = "coordinates" if features is None else f"features[{number}] coordinates"
        for at, rings in _polygons(feature, name):
            checked = [checked_ring(ring, f"{at}[{index}]") for index, ring in enumerate(rings)]
            (holes if _is_exclusion(feature) else polygons).append(checked[0])
            holes += [] if _is_exclusion(feature) else checked[1:]
    if not polygons:
        raise OutlineError(_NONE)
    problem = outline_problem([len(ring) for ring in polygons], [len(ring) for ring in holes])
    if problem:
        raise OutlineError(problem)
    return Outline(tuple(polygons), tuple(holes))


def _polygons(feature: Any, name: str) -> list[tuple[str, list[Any]]]:
    """Return the rings of each polygon of a feature or geometry, with its name."""
    geometry = feature.get("geometry", feature) if isinstance(feature, dict) else None
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    coordinates = geometry.get("coordinates") if isinstance(geometry, dict) else None
    if kind == "Polygon":
        found = [(name, coordinates)]
    elif kind == "MultiPolygon" and isinstance(coordinates, list):
        found = [(f"{name}[{number}]", rings) for number, rings in enumerate(coordinates)]
    else:
        raise OutlineError(_NONE)
    for at, rings in found:
        if not isinstance(rings, list) or not rings:
            raise OutlineError(f"{at}: hold no ring: draw the polygon's outline")
    return [(at, rings) for at, rings in found if isinstance(rings, list)]


def _is_exclusion(feature: Any) -> bool:
    properties = feature.get("properties") if isinstance(feature, dict) else None
    return isinstance(properties, dict) and properties.get("exclusion") is True
