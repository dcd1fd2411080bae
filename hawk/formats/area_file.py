"""The one reader of files with areas: GeoJSON as QGIS and others write it, KML and KMZ as Google Earth does.

It takes what has one clear meaning: polygons in WGS-84, wherever they are in the file. Points and lines beside them are
left out, and so are heights, repeated corners and the difference between a ring's last corner and its first. It refuses
what is ambiguous, with words that say how to save the file. Which polygon is a fence is not its business.
"""

from __future__ import annotations

import io
import json
import math
import re
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final
from xml.etree.ElementTree import Element, ParseError

from defusedxml import DefusedXmlException
from defusedxml.ElementTree import fromstring

from hawk.formats.text import decoded, json_of
from hawk.model.sentences import say, series

Ring = tuple[tuple[float, float], ...]
"""Corners as (latitude, longitude), degrees of WGS-84, not closed."""

LARGEST_BYTES: Final = 4_000_000
"""A fence is a few kilobytes; an area among other layers may have more."""
SAME_DEG: Final = 1e-8
"""Degrees, a millimetre, within which two corners are one: QGIS closes a ring up to the last digits."""
_DEEPEST: Final = 32
_WGS_84: Final = re.compile(r"(?i)(?:CRS84h?|WGS[ _]?84|EPSG:{1,2}(?:[\d.]*:)?(?:4326|4979))$")
_KINDS: Final = re.compile(r"(?i)^(multi)?polygon[ ]?(?:z|m|zm)?$")
_TRUE: Final = frozenset({"true", "yes", "1", "t", "y"})
_TOO_LARGE: Final = say("is too large for areas: at most {most} MB are read", most=LARGEST_BYTES // 1_000_000)
_SAVE: Final = say("save it in WGS-84 (EPSG:4326), longitude before latitude")


class AreaError(ValueError):
    """A file holds no areas that can be used; the text says what is wrong and how to save it, without its name."""


@dataclass(frozen=True, slots=True)
class Area:
    """One polygon. ``name``: where it stands in the file. ``ceiling``: its property ``ceiling_m``, as it is written.

    ``facts``: of a placemark in KML, its name, id and data; ``feature``: its number in the file, from 1, which the
    polygons of a MultiGeometry share. GeoJSON has neither here.
    """

    name: str
    outer: Ring
    holes: tuple[Ring, ...]
    is_exclusion: bool
    ceiling: object = None
    facts: Mapping[str, str] = field(default_factory=dict)
    feature: int = 0


@dataclass(frozen=True, slots=True)
class Areas:
    """The polygons of a file, in its order. ``others``: the kinds of what else it holds, in words, else empty."""

    areas: tuple[Area, ...]
    others: str = ""


def read_areas(data: bytes) -> Areas:
    """Return the polygons of a file; there may be none.

    Raises:
        AreaError: It is no such file, or holds a polygon that is none on Earth.
    """
    if len(data) > LARGEST_BYTES:
        raise AreaError(
            say(
                "is too large: at most {most} MB are read; leave other layers out",
                most=LARGEST_BYTES // 1_000_000,
            )
        )
    if data.startswith(b"PK\x03\x04"):
        return Areas(tuple(_kml_areas(_unpacked(data))))
    text = _text(data)
    if text.lstrip().startswith("<"):
        return Areas(tuple(_kml_areas(text)))
    try:
        content = json_of(text)
    except (json.JSONDecodeError, RecursionError) as error:
        raise AreaError(say("cannot be read: neither GeoJSON nor KML ({error})", error=str(error))) from error
    others: list[str] = []
    found = tuple(_geojson_areas(content, others))
    return Areas(found, series(*sorted(set(others))))


def checked_place(longitude: object, latitude: object, name: str) -> tuple[float, float]:
    """Return (latitude, longitude) of a place on Earth. Raises AreaError with the corner's name."""
    if not (_is_finite_number(longitude) and _is_finite_number(latitude)):
        raise AreaError(say("{name}: must be [longitude, latitude]", name=name))
    east, north = float(longitude), float(latitude)  # type: ignore[arg-type]
    if abs(east) > 180 or abs(north) > 90:
        raise AreaError(
            say("{name}: not degrees: {east}, {north}; {save}", name=name, east=east, north=north, save=_SAVE)
        )
    return north, east


def open_ring(corners: Sequence[tuple[float, float]], same: float = SAME_DEG) -> Ring:
    """Return corners without those that repeat the one before, and without the last where it is the first again.

    ``same``: the difference of each coordinate up to which two corners are one.
    """
    kept: list[tuple[float, float]] = []
    for corner in corners:
        if not kept or not _is_same(corner, kept[-1], same):
            kept.append(corner)
    while len(kept) > 1 and _is_same(kept[0], kept[-1], same):
        kept.pop()
    return tuple(kept)


def _text(data: bytes) -> str:
    try:
        return decoded(data)
    except UnicodeDecodeError as error:
        raise AreaError(say("cannot be read: it is no text in UTF-8 ({reason})", reason=error.reason)) from error


# -- GeoJSON ----------------------------------------------------------------------------------------------------------


def _geojson_areas(content: Any, others: list[str]) -> Iterator[Area]:
    if not isinstance(content, dict):
        others.append(_kind_of(content))
        return
    _check_crs(content.get("crs"), "crs")
    features = content.get("features")
    if not isinstance(features, list):
        yield from _feature(content, "", others)
        return
    for number, feature in enumerate(features):
        if not isinstance(feature, dict):
            raise AreaError(
                say("features[{number}]: must be a Feature, not {kind}", number=number, kind=_kind_of(feature))
            )
        yield from _feature(feature, f"features[{number}] ", others)


def _feature(feature: dict[str, Any], name: str, others: list[str]) -> Iterator[Area]:
    is_feature = feature.get("type") == "Feature" or "geometry" in feature
    properties = feature.get("properties") if is_feature else None
    known = properties if isinstance(properties, dict) else {}
    geometry = feature.get("geometry") if is_feature else feature
    if geometry is not None:  # QGIS writes a feature without a shape so
        yield from _geometry(geometry, name, known, others, 0)


def _geometry(geometry: Any, name: str, properties: dict[str, Any], others: list[str], depth: int) -> Iterator[Area]:
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    if not isinstance(kind, str) or depth > _DEEPEST:
        others.append(say("a geometry without a type"))
        return
    _check_crs(geometry.get("crs"), f"{name}crs")
    if kind == "GeometryCollection":
        parts = geometry.get("geometries")
        for number, part in enumerate(parts if isinstance(parts, list) else ()):
            yield from _geometry(part, f"{name}geometries[{number}] ", properties, others, depth + 1)
        return
    found = _KINDS.match(kind)
    if found is None:
        others.append(kind)
        return
    coordinates = geometry.get("coordinates")
    if found[1]:
        for number, rings in enumerate(coordinates if isinstance(coordinates, list) else ()):
            yield _area(rings, f"{name}coordinates[{number}]", properties)
    else:
        yield _area(coordinates, f"{name}coordinates", properties)


def _area(rings: Any, name: str, properties: dict[str, Any]) -> Area:
    if not isinstance(rings, list) or not rings:
        raise AreaError(say("{name}: hold no ring: draw the area's outline", name=name))
    outer, *holes = (_ring(ring, f"{name}[{number}]") for number, ring in enumerate(rings))
    known = {key.lower(): value for key, value in properties.items()}
    return Area(name, outer, tuple(holes), _is_true(known.get("exclusion")), known.get("ceiling_m"))


def _ring(ring: Any, name: str) -> Ring:
    places = []
    for number, place in enumerate(ring if isinstance(ring, list) else ()):
        if not (isinstance(place, list) and len(place) >= 2):
            raise AreaError(say("{name}[{number}]: must be [longitude, latitude]", name=name, number=number))
        places.append(checked_place(place[0], place[1], f"{name}[{number}]"))
    return open_ring(places)


def _check_crs(crs: Any, name: str) -> None:
    """Refuse coordinates that a file says to be of another system (GeoJSON of 2008, 3); RFC 7946 has WGS-84 alone."""
    if crs is None:
        return
    properties = crs.get("properties") if isinstance(crs, dict) else None
    said = properties.get("name") if isinstance(properties, dict) else crs
    if not isinstance(said, str) or _WGS_84.search(said.strip()) is None:
        raise AreaError(
            say(
                "{name}: is {system}; {save}",
                name=name,
                system=said if isinstance(said, str) else say("not named"),
                save=_SAVE,
            )
        )


# -- KML --------------------------------------------------------------------------------------------------------------


def _unpacked(data: bytes) -> str:
    """Return the KML of a KMZ: the first one of the archive, as Google Earth reads it."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = [each for each in archive.infolist() if each.filename.lower().endswith(".kml")]
            if not names:
                raise AreaError(say("is an archive without a KML file: save it as KML"))
            if names[0].file_size > LARGEST_BYTES:
                raise AreaError(_TOO_LARGE)
            with archive.open(names[0]) as file:
                content = file.read(LARGEST_BYTES + 1)
    except (zipfile.BadZipFile, OSError, RuntimeError, NotImplementedError, EOFError, ValueError, zlib.error) as error:
        if isinstance(error, AreaError):
            raise
        raise AreaError(say("cannot be unpacked: {error}; save it as KML", error=str(error))) from error
    if len(content) > LARGEST_BYTES:  # the archive's list of sizes lies
        raise AreaError(_TOO_LARGE)
    return _text(content)


def _kml_areas(text: str) -> list[Area]:
    try:
        root = fromstring(re.sub(r"^\s*<\?xml[^>]*\?>", "", text, count=1), forbid_dtd=True)
    except DefusedXmlException as error:
        raise AreaError(
            say("has definitions of its own (DOCTYPE), which are not read: save it as KML again")
        ) from error
    except (ParseError, ValueError, RecursionError) as error:
        raise AreaError(say("cannot be read as KML: {error}", error=str(error))) from error
    if _tag(root) not in ("kml", "Document", "Folder", "Placemark"):
        raise AreaError(say("is XML of another kind ({tag}): save it as KML or GeoJSON", tag=_tag(root)))
    areas: list[Area] = []
    for feature, placemark in enumerate((each for each in root.iter() if _tag(each) == "Placemark"), 1):
        properties = _named(placemark) | _extended(placemark)
        for polygon in (each for each in placemark.iter() if _tag(each) == "Polygon"):
            name = say("Polygon {number}", number=len(areas) + 1)
            areas.append(replace(_kml_area(polygon, name, properties), facts=properties, feature=feature))
    return areas


def _named(placemark: Element) -> dict[str, str]:
    """Return name and id of a placemark, as far as it has them."""
    name = next((each.text or "" for each in placemark if _tag(each) == "name"), "").strip()
    return {key: value for key, value in (("name", name), ("id", placemark.get("id", ""))) if value}


def _kml_area(polygon: Element, name: str, properties: dict[str, str]) -> Area:
    outer: Ring = ()
    holes: list[Ring] = []
    for boundary in polygon:
        for number, ring in enumerate(each for each in boundary.iter() if _tag(each) == "LinearRing"):
            text = next((each.text for each in ring if _tag(each) == "coordinates"), "") or ""
            if _tag(boundary) == "outerBoundaryIs":
                outer = _kml_ring(text, say("{name} outer ring", name=name))
            elif _tag(boundary) == "innerBoundaryIs":
                holes.append(
                    _kml_ring(text, say("{name} inner ring {number}", name=name, number=len(holes) + number + 1))
                )
    if not outer:
        raise AreaError(say("{name}: holds no ring: draw the area's outline", name=name))
    return Area(name, outer, tuple(holes), _is_true(properties.get("exclusion")), properties.get("ceiling_m"))


def _kml_ring(text: str, name: str) -> Ring:
    places = []
    for number, place in enumerate(text.split()):
        parts = place.split(",")
        try:
            longitude, latitude = float(parts[0]), float(parts[1])
        except (ValueError, IndexError):
            raise AreaError(
                say(
                    "{name}[{number}]: must be longitude,latitude,height, not {place}",
                    name=name,
                    number=number,
                    place=repr(place[:40]),
                )
            ) from None
        places.append(checked_place(longitude, latitude, say("{name}[{number}]", name=name, number=number)))
    return open_ring(places)


def _extended(placemark: Element) -> dict[str, str]:
    """Return the data of a placemark by name, small letters: ``Data`` with a ``value``, and ``SimpleData``."""
    found = {}
    for each in placemark.iter():
        name = each.get("name", "").lower()
        if _tag(each) == "SimpleData":
            found[name] = (each.text or "").strip()
        elif _tag(each) == "Data":
            found[name] = next(((value.text or "").strip() for value in each if _tag(value) == "value"), "")
    return found


def _tag(element: Element) -> str:
    return str(element.tag).rpartition("}")[2]


# -- values -----------------------------------------------------------------------------------------------------------


def _is_same(one: tuple[float, float], other: tuple[float, float], same: float) -> bool:
    return abs(one[0] - other[0]) <= same and abs(one[1] - other[1]) <= same


def _is_true(value: object) -> bool:
    return value is True or (isinstance(value, int | str) and str(value).strip().lower() in _TRUE)


def _is_finite_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _kind_of(value: object) -> str:
    return {list: say("a list"), str: say("a text"), type(None): say("nothing")}.get(type(value), say("a number"))
