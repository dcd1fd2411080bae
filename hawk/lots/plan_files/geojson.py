"""Plans as GeoJSON (RFC 7946, and the ``crs`` of GeoJSON 2008), and as hawk's own JSON of a lot."""

from __future__ import annotations

import json
import math
import re
from typing import Any, Final

import numpy as np

from hawk.formats.text import features_of, json_of
from hawk.lots.plan import geometry
from hawk.lots.plan.values import SHAPE
from hawk.lots.plan_files.facts import kind_of, label_of
from hawk.lots.plan_files.features import FeatureReader
from hawk.lots.plan_files.values import MOST_FEATURES, Asked, Drawing, Drawn, Facts, Floats, Notes, text_of
from hawk.lots.values import LotInputError
from hawk.model.poses import GlobalPose
from hawk.results.survey_map import to_global

FORMAT: Final = "GeoJSON"
LOT_FORMAT: Final = "lot of hawk"
WGS_84: Final = "EPSG:4326"
_CODE: Final = re.compile(r"(?i)^(?:urn:ogc:def:crs:)?(EPSG|OGC|CRS):{1,2}(?:[\d.]*:)?(\w+)$")


class _FeatureError(ValueError):
    """A feature cannot be used; the text names the field within it and the remedy."""


def read(data: bytes, asked: Asked, notes: Notes) -> Drawing:
    """Return the outlines of a file. Raises LotInputError for one that is none, or is cut."""
    try:
        content = json_of(text_of(data))
    except (json.JSONDecodeError, RecursionError) as error:
        words = f"is no whole JSON ({error}): export it again, and copy all of it"
        raise LotInputError("file", words) from None
    if not isinstance(content, dict):
        raise LotInputError("file", "is JSON, but no GeoJSON: save it as a FeatureCollection")
    if "stalls" in content and "datum" in content:
        return _lot(content, asked, notes)
    if "elements" in content:
        raise LotInputError("file", "is JSON of Overpass: ask for [out:xml], or export it as GeoJSON")
    features = features_of(content)
    if features is None:
        raise LotInputError("file", "is no GeoJSON of type FeatureCollection: save the layer with its features")
    return _features(features, _crs(content), asked, notes)


def _features(features: list[Any], crs: str, asked: Asked, notes: Notes) -> Drawing:
    if len(features) > MOST_FEATURES:
        raise LotInputError("file", f"has {len(features)} features, {MOST_FEATURES} are the most: leave other ones out")
    reader = FeatureReader(asked, notes)
    for number, feature in enumerate(features):
        name = f"features[{number}]"
        given = feature.get("properties") if isinstance(feature, dict) else None
        facts: Facts = given if isinstance(given, dict) else {}
        try:
            places, is_line = _shape(feature)
        except _FeatureError as error:
            notes.add(name, str(error))
            continue
        own = feature.get("id")
        reader.add(name, places, facts if own is None else {"id": own, **facts}, is_line=is_line)
    return reader.drawing(FORMAT, crs)


def _shape(feature: Any) -> tuple[Floats, bool]:
    """Return the outer ring of a feature, or its line, and whether it is one. Raises _FeatureError."""
    geometry_ = feature.get("geometry") if isinstance(feature, dict) else None
    if not isinstance(geometry_, dict):
        raise _FeatureError("geometry: is missing: draw the outline of the stall")
    kind, rings = geometry_.get("type"), geometry_.get("coordinates")
    field = "geometry.coordinates"
    if kind in ("MultiPolygon", "MultiLineString") and isinstance(rings, list) and len(rings) == 1:
        rings, field, kind = rings[0], f"{field}[0]", str(kind).removeprefix("Multi")
    if kind == "LineString":
        if not isinstance(rings, list) or len(rings) < 2:
            raise _FeatureError(f"{field}: holds no line: draw it along the kerb")
        return _places(rings, field), True
    if kind != "Polygon":
        count = f" of {len(rings)} parts" if str(kind).startswith("Multi") and isinstance(rings, list) else ""
        raise _FeatureError(f"geometry: is a {str(kind)[:30]}{count}: draw one outline for each stall")
    if not isinstance(rings, list) or not rings or not isinstance(rings[0], list):
        raise _FeatureError(f"{field}: holds no ring: draw the outline of the stall")
    if len(rings) > 1:
        raise _FeatureError(f"{field}: has a hole: draw the outer line alone")
    return _places(rings[0], f"{field}[0]"), False


def _places(ring: list[Any], field: str) -> Floats:
    try:
        given = np.array([(place[0], place[1]) for place in ring])
        places = given.astype(np.float64).reshape(-1, 2) if given.dtype.kind in "fi" else np.full((1, 2), np.nan)
    except (TypeError, ValueError, IndexError, KeyError, OverflowError):
        places = np.full((1, 2), np.nan)
    if np.isfinite(places).all():
        return places
    for number, place in enumerate(ring):
        is_pair = isinstance(place, list) and len(place) >= 2 and all(type(each) in (int, float) for each in place[:2])
        if not is_pair or not all(math.isfinite(each) for each in place[:2]):
            raise _FeatureError(f"{field}[{number}]: must be [longitude, latitude], two finite numbers")
    raise _FeatureError(f"{field}: must be finite numbers of degrees or metres")


def _crs(content: dict[str, Any]) -> str:
    """Return the name of the system that a file says, "" where it says none. Raises LotInputError."""
    crs = content.get("crs")
    if crs is None:
        return ""
    properties = crs.get("properties") if isinstance(crs, dict) else None
    name = properties.get("name") if isinstance(properties, dict) else None
    if not isinstance(name, str):
        raise LotInputError("crs", "of the file is not named: save it in WGS 84 (EPSG:4326), or name its system")
    return crs_name(name)


def crs_name(name: str) -> str:
    """Return the name of a system of coordinates as AUTHORITY:CODE where it is written so, else as it is."""
    found = _CODE.match(name.strip())
    if found is None:
        return name.strip()[:120]
    authority, code = found[1].upper(), found[2].upper()
    return WGS_84 if code in ("CRS84", "84", "4326") else f"{authority}:{code}"


def _lot(content: dict[str, Any], asked: Asked, notes: Notes) -> Drawing:
    """Return the stalls and sections of a lot as ``/api/v1/lots/LOT/plan`` shows it: metres about its ``datum``."""
    datum, stalls = content["datum"], content["stalls"]
    is_place = isinstance(datum, list) and len(datum) == 2 and all(_is_finite(each) for each in datum)
    if not is_place or not isinstance(stalls, list):
        raise LotInputError("file", "is no JSON of a lot: it needs datum, [latitude, longitude], and a list of stalls")
    names, shapes = [], []
    for number, stall in enumerate(stalls):
        shape = [stall.get(each) for each in SHAPE] if isinstance(stall, dict) else [None]
        missing = next((each for each, value in zip(SHAPE, shape, strict=False) if not _is_finite(value)), None)
        if missing is None:
            names.append((f"stalls[{number}]", stall))
            shapes.append(shape)
        else:
            notes.add(f"stalls[{number}]", f"{missing}: must be a finite number")
    found = geometry.polygons(np.array(shapes, np.float64).reshape(-1, 5))
    pose = GlobalPose(float(datum[0]), float(datum[1]), 0.0)
    drawn = []
    for (name, stall), polygon in zip(names, found, strict=True):
        places = to_global(pose, np.array(polygon.exterior.coords, np.float64))[:, ::-1]
        drawn.append(Drawn(name, places, label_of(stall, "label", name, notes), kind_of(stall, name, notes) or ""))
    reader = FeatureReader(asked, notes, is_of_sections=True)
    sections = content.get("sections")
    for number, section in enumerate(sections if isinstance(sections, list) else ()):
        name = f"sections[{number}]"
        try:
            ring = _places(section["outline"], f"{name}.outline")
        except (_FeatureError, TypeError, KeyError):
            notes.add(name, "outline: must be corners, [north, east], metres about the datum")
            continue
        reader.add(name, to_global(pose, ring)[:, ::-1], section)
    return Drawing(LOT_FORMAT, tuple(drawn), crs=WGS_84, sections=tuple(reader.sections))


def _is_finite(value: object) -> bool:
    return type(value) in (int, float) and math.isfinite(value)  # type: ignore[arg-type]
