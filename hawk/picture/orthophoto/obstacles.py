"""Roads and buildings of a file of outlines: what stands on them is no parked vehicle and no stall of a lot.

OpenStreetMap's tags say them: ``highway`` lines with their ``width``, and areas with ``building``. A deck on a building
(``parking=rooftop`` or ``multi-storey``) is a lot.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from hawk.formats.kind import kind_of_file
from hawk.formats.text import features_of, json_of
from hawk.lots.plan_files.osm import OUTLINE, parts_of, place_of, root_of
from hawk.lots.plan_files.section_facts import DRIVEN_M
from hawk.lots.plan_files.values import text_of
from hawk.lots.values import LotInputError
from hawk.picture.orthophoto.grid import FloatArray, PixelGrid
from hawk.picture.orthophoto.outline_lots import closed, polygons_of

CARRIAGEWAYS_M: Final = {
    "motorway": 7.5, "trunk": 7.0, "primary": 6.5, "secondary": 6.5, "tertiary": 6.5, "unclassified": DRIVEN_M[0],
    "residential": DRIVEN_M[0], "living_street": DRIVEN_M[0], "road": DRIVEN_M[0], "service": DRIVEN_M[1],
    "busway": 3.5, "motorway_link": 3.5, "trunk_link": 3.5, "primary_link": 3.5, "secondary_link": 3.5,
    "tertiary_link": 3.5,
}  # fmt: skip
"""Width of a carriageway that says none, by its class. It is assumed: `DRIVEN_M`; 6.5 m where buses meet, as Germany's
RASt 06 (FGSV, 2006) has it; two lanes of 3.5 to 3.75 m of fast roads, one of a ramp. Vehicles at the kerb stand beside.
"""
AISLE_M: Final = 3.0
"""Width of an aisle of a lot (``service=parking_aisle``), whatever its ``width`` says: stalls begin beside it."""
PARKED_M: Final = {"lane": 2.0, "yes": 2.0, "half_on_kerb": 1.0}
"""Width that a lane of parked vehicles takes from the carriageway, by its position."""
_LEAST_M: Final = 2.5
_MOST_M: Final = 40.0
_UNDER: Final = ("yes", "building_passage", "culvert", "covered")
_DECKS: Final = ("rooftop", "multi-storey")
_ONE_DIRECTION: Final = ("yes", "-1", "true", "1")
_NONE: Final = ("", "no")


@dataclass(frozen=True, slots=True)
class Obstacles:
    """Roads and buildings of a file, (longitude, latitude). ``widths``: of the roads, metres."""

    roads: tuple[BaseGeometry, ...] = field(default=(), repr=False)
    widths: tuple[float, ...] = field(default=(), repr=False)
    buildings: tuple[BaseGeometry, ...] = field(default=(), repr=False)

    def in_metres(self, grid: PixelGrid) -> Mapping[str, NDArray[np.object_]]:
        """Return the grounds of roads, and of buildings, in a picture: (column, row) times the metres of a pixel."""
        metres = np.array(grid.metres)

        def moved(places: FloatArray) -> FloatArray:
            return np.asarray(grid.in_picture(places[:, ::-1]) * metres)

        lines = [shapely.transform(road, moved) for road in self.roads]
        roads = [
            line.buffer(width / 2, cap_style="flat")
            for line, width in zip(lines, self.widths, strict=True)
            if np.isfinite(line.bounds).all()
        ]
        areas = [shapely.transform(area, moved) for area in self.buildings]
        buildings = [shapely.make_valid(area) for area in areas if np.isfinite(area.bounds).all()]
        return {"roads": np.array(roads, object), "buildings": np.array(buildings, object)}


def standing_on(quads: FloatArray, metres: tuple[float, float], grounds: NDArray[np.object_]) -> NDArray[np.bool_]:
    """Return which quads (N, 4, 2) of (column, row) have their middle on one of some grounds in metres."""
    stands = np.zeros(len(quads), np.bool_)
    middles = shapely.points(quads.mean(axis=1) * np.array(metres))
    stands[shapely.STRtree(grounds).query(middles, predicate="intersects")[0]] = True
    return stands


def read_obstacles(path: Path) -> Obstacles:
    """Return the roads and buildings of a file that `read_outline` can read: GeoJSON, OpenStreetMap's XML or JSON; none
    of other formats. Raises LotInputError, OSError.
    """
    kind = kind_of_file(path).name
    if kind in ("OSM", "XML"):
        return _of(_xml(text_of(path.read_bytes())))
    if kind != "JSON":
        return Obstacles()
    content = json_of(text_of(path.read_bytes()))
    if not isinstance(content, dict):
        return Obstacles()
    return _of(_overpass(content["elements"]) if "elements" in content else _geojson(features_of(content) or ()))


_Element = tuple[Mapping[str, Any], BaseGeometry]
"""Tags of an element, and its shape: a line, or an area."""


def _of(elements: Iterable[_Element]) -> Obstacles:
    roads, widths, buildings, decks = [], [], [], []
    for facts, shape in elements:
        is_deck = str(facts.get("parking", "")) in _DECKS
        width = road_width(facts)
        if width is not None and shape.geom_type in ("LineString", "MultiLineString"):
            roads.append(shape)
            widths.append(width)
        elif (areas := polygons_of(shape)) and is_deck:
            decks += areas
        elif areas and str(facts.get("building", "")).lower() not in _NONE:
            buildings += areas
    if decks:
        on_deck = shapely.union_all(decks)
        buildings = [part for area in buildings for part in polygons_of(area.difference(on_deck))]
    return Obstacles(tuple(roads), tuple(widths), tuple(buildings))


def road_width(facts: Mapping[str, Any]) -> float | None:
    """Return the width on which vehicles drive, metres; None for what is no carriageway, or lies under the ground."""
    known = CARRIAGEWAYS_M.get(str(facts.get("highway", "")))
    if known is None or str(facts.get("tunnel", "")) in _UNDER or facts.get("area") == "yes":
        return None
    if facts.get("service") == "parking_aisle":
        return AISLE_M
    said = _metres(facts.get("width"))
    if said is None:
        return (
            min(known, DRIVEN_M[1])
            if str(facts.get("oneway", "")) in _ONE_DIRECTION and known <= DRIVEN_M[0]
            else known
        )
    both = facts.get("parking:both", "")
    positions = [str(facts.get(f"parking:{side}", both)) for side in ("left", "right")]
    return max(said - sum(PARKED_M.get(position, 0.0) for position in positions), _LEAST_M)


def _metres(said: object) -> float | None:
    """Return a width as OpenStreetMap writes it, ``6``, ``6.5`` or ``6 m``; None for another one."""
    try:
        found = float(str(said).removesuffix("m").strip())
    except ValueError:
        return None
    return found if math.isfinite(found) and _LEAST_M <= found <= _MOST_M else None


def is_obstacle(facts: Mapping[str, Any]) -> bool:
    """Return whether a feature says that it is a road or a building."""
    return any(str(facts.get(key) or "").lower() not in _NONE for key in ("highway", "building"))


def _is_asked(facts: Mapping[str, Any]) -> bool:
    return is_obstacle(facts) or facts.get("amenity") == "parking"


def _shape(line: Iterable[tuple[Any, Any]], facts: Mapping[str, Any]) -> BaseGeometry | None:
    """Return the shape of an outline: an area where it is closed and no road."""
    try:
        places = np.array([*line], np.float64).reshape(-1, 2)
    except (TypeError, ValueError):
        return None
    if len(places) < 2 or not np.isfinite(places).all():
        return None
    is_area = len(places) > 3 and bool((places[0] == places[-1]).all()) and "highway" not in facts
    return shapely.Polygon(places) if is_area else shapely.LineString(places)


def _xml(text: str) -> Iterator[_Element]:
    there = parts_of(root_of(text))
    nodes = {each.get("id", ""): place_of(each) for each in there if each.tag == "node"}
    for each in there:
        facts = {tag.get("k", ""): tag.get("v", "") for tag in each.iter("tag")}
        if each.tag != OUTLINE or not _is_asked(facts):
            continue
        shape = _shape((nodes.get(node.get("ref", ""), (np.nan, np.nan)) for node in each.iter("nd")), facts)
        if shape is not None:
            yield facts, shape


def _overpass(elements: Any) -> Iterator[_Element]:
    there = [each for each in elements or () if isinstance(each, dict)]
    nodes = {each.get("id"): (each.get("lon"), each.get("lat")) for each in there if each.get("type") == "node"}
    for each in there:
        facts = each.get("tags")
        if each.get("type") != OUTLINE or not isinstance(facts, dict) or not _is_asked(facts):
            continue
        if each.get("geometry"):
            line = [(place.get("lon"), place.get("lat")) for place in each["geometry"] if isinstance(place, dict)]
        else:
            line = [nodes.get(number, (None, None)) for number in each.get("nodes") or ()]
        if (shape := _shape(line, facts)) is not None:
            yield facts, shape


def _geojson(features: Iterable[Any]) -> Iterator[_Element]:
    for each in features:
        facts = each.get("properties") if isinstance(each, dict) else None
        if not isinstance(facts, dict) or not _is_asked(facts) or not isinstance(each.get("geometry"), dict):
            continue
        try:
            geometry = each["geometry"]
            if str(geometry.get("type", "")).endswith("Polygon"):
                geometry = closed(geometry)
            yield facts, shapely.force_2d(shapely.from_geojson(json.dumps(geometry)))
        except (shapely.errors.ShapelyError, ValueError) as error:
            raise LotInputError("features", f"hold a road or building that cannot be read ({error})") from error
