"""Text of files: UTF-8, with or without a byte order mark, and UTF-16 with one; JSON whole or a value a line."""

from __future__ import annotations

import json
from typing import Any, Final

_MARKS: Final = "\ufeff\x1e\r"
"""A byte order mark, and what begins each text of a sequence (RFC 8142)."""


def decoded(data: bytes) -> str:
    """Return the text of a file. Raises UnicodeDecodeError."""
    encoding = "utf-16" if data.startswith((b"\xff\xfe", b"\xfe\xff")) else "utf-8-sig"
    return data.decode(encoding)


def json_of(text: str) -> Any:
    """Return the value of JSON. Features of GeoJSON that stand a line each (RFC 8142, ndjson) are a FeatureCollection.

    Raises json.JSONDecodeError and RecursionError.
    """
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        lines = [line for each in text.split("\n") if (line := each.strip().strip(_MARKS))]
        if len(lines) < 2 and "\x1e" not in text:
            raise
        try:
            values = [json.loads(line) for line in lines]
        except json.JSONDecodeError:
            raise error from None
    if not all(isinstance(value, dict) and value.get("type") in _FEATURE for value in values):
        raise json.JSONDecodeError("lines of JSON, but not of features", text, 0)
    return {"type": "FeatureCollection", "features": values}


_FEATURE: Final = frozenset({"Feature", "Polygon", "MultiPolygon", "GeometryCollection", "Point", "LineString"})


def features_of(content: dict[str, Any]) -> list[Any] | None:
    """Return the features of GeoJSON: of a collection, a single one, or those that bare geometries make; None for none.

    The parts of a GeometryCollection are features with its properties.
    """
    kind, features = content.get("type"), content.get("features")
    if isinstance(features, list):
        return [part for each in features for part in _parts(each, 0)]
    if kind in _FEATURE or kind in ("MultiPoint", "MultiLineString"):
        return list(_parts(content, 0))
    return None


def _parts(feature: Any, depth: int) -> list[Any]:
    """Return a feature, or a feature for each part of its collection. A bare geometry becomes a feature."""
    if not isinstance(feature, dict):
        return [feature]
    is_feature = feature.get("type") == "Feature" or "geometry" in feature
    geometry = feature.get("geometry") if is_feature else feature
    if isinstance(geometry, dict) and geometry.get("type") == "GeometryCollection" and depth < _DEEPEST:
        parts = geometry.get("geometries")
        facts = feature.get("properties") if is_feature else None
        made = [{"type": "Feature", "properties": facts, "geometry": part} for part in parts or ()]
        return [part for each in made for part in _parts(each, depth + 1)] if isinstance(parts, list) else [feature]
    return [feature if is_feature else {"type": "Feature", "properties": None, "geometry": geometry}]


_DEEPEST: Final = 32
