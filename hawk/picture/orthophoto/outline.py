"""Outlines of lots that limit the work: GeoJSON, KML, GeoPackage, and OpenStreetMap's XML or JSON.

Where a file says ``amenity``, its areas with ``amenity=parking`` count; lots under the ground, which no picture shows,
do not. Points and lines beside them are left out. Each feature is a lot (`hawk.picture.orthophoto.outline_lots`).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from hawk.formats.area_file import AreaError, read_areas
from hawk.formats.box import RefusedError, read_and_wait
from hawk.formats.kind import HEAD_BYTES, Kind, kind_of, kind_of_file
from hawk.formats.text import features_of, json_of
from hawk.lots.plan_files.crs import to_wgs_84
from hawk.lots.plan_files.formats import ENDS, unpacked
from hawk.lots.plan_files.geojson import WGS_84, crs_name
from hawk.lots.plan_files.layers import AREAS
from hawk.lots.plan_files.osm import OUTLINE, parts_of, place_of, root_of
from hawk.lots.plan_files.values import text_of
from hawk.lots.values import LotInputError
from hawk.model.plans import Outline
from hawk.picture.orthophoto.grid import FloatArray, PixelGrid
from hawk.picture.orthophoto.obstacles import Obstacles, is_obstacle, read_obstacles
from hawk.picture.orthophoto.outline_lots import (
    OutlineFeature,
    OutlineLot,
    closed,
    ground_words,
    lots_of,
    parts_of_shape,
    polygons_of,
)
from hawk.picture.values import PictureError

T = TypeVar("T")
LARGEST_BYTES: Final = 500_000_000
_PARKING: Final = "parking"
_NO_GROUND: Final = {"type": "Polygon", "coordinates": []}
_REMEDY: Final = "name a GeoJSON, GeoPackage or OpenStreetMap file with outlines"
_UNDER: Final = "underground"
_NEAR_DEG: Final = 1e-3
_CROSSED_SHARE: Final = 0.02
"""Share of an area that lies to the other side of its outline, from which its sides cross by more than a sliver."""


@dataclass(frozen=True, slots=True)
class LotOutline:
    """Lots of a file, in the order of their names.

    ``crossed``: those whose sides cross, so that it is not known which ground they mean, with the number of the
    feature; each is in ``lots`` as the areas between its lines. ``notes``: sentences on features that are no lots.
    ``obstacles``: roads and buildings of the same file.
    """

    lots: tuple[OutlineLot, ...] = field(repr=False)
    crossed: tuple[tuple[int, BaseGeometry], ...] = field(default=(), repr=False)
    notes: tuple[str, ...] = ()
    obstacles: Obstacles = field(default=Obstacles(), repr=False)

    @classmethod
    def of(cls, *shapes: BaseGeometry) -> LotOutline:
        """Return outlines without names, (longitude, latitude)."""
        return cls(lots_of([OutlineFeature({}, shape, number) for number, shape in enumerate(shapes, 1)]))

    @property
    def shapes(self) -> tuple[BaseGeometry, ...]:
        """The ground of each lot."""
        return tuple(lot.shape for lot in self.lots)

    def in_metres(self, grid: PixelGrid) -> NDArray[np.object_]:
        """Return the lots in the picture (M,), (column, row) times the metres of a pixel; those near it only."""
        moved = [shapely.transform(lot, lambda places: _in_plane(places, grid)) for lot in self.shapes]
        finite = [lot for lot in moved if np.isfinite(lot.bounds).all()]
        return np.array([shapely.make_valid(lot) for lot in finite], object)

    def near(self, grid: PixelGrid) -> LotOutline:
        """Return the lots that lie in the picture or partly. Raises PictureError when none does, or one is crossed."""
        ends = np.array([(x, y) for x in np.linspace(0, 1, 9) for y in np.linspace(0, 1, 9)])
        around = shapely.MultiPoint(grid.on_earth(ends * (grid.columns, grid.rows))[:, ::-1])
        near = np.sort(shapely.STRtree(self.shapes).query(around.envelope.buffer(_NEAR_DEG))).tolist()
        found = tuple(self.lots[k] for k in near if _is_in(self.lots[k].shape, grid))
        if not found:
            every = shapely.union_all([lot.envelope for lot in self.shapes])
            if _is_in(shapely.transform(every, lambda places: places[:, ::-1]), grid):
                raise PictureError("latitude and longitude are exchanged: write longitude first, as GeoJSON has it")
            raise PictureError(
                f"none of the outlines lies in the picture: it is about {_place(around)}, they are about "
                f"{_place(every)} (latitude, longitude); name outlines of lots that it shows"
            )
        for number, shape in self.crossed:
            if _is_in(shape, grid):
                raise PictureError(
                    f"feature {number}, about {_place(shape)}: its sides cross, so that it is not clear which ground "
                    "it means; put its corners in their order along the lot's edge"
                )
        return LotOutline(found, notes=self.notes, obstacles=self.obstacles)

    def outline(self) -> Outline:
        """Return the lots as the store has them."""
        parts = [part for lot in self.shapes for part in polygons_of(lot)]
        rings = [tuple((float(y), float(x)) for x, y in part.exterior.coords[:-1]) for part in parts]
        holes = [tuple((float(y), float(x)) for x, y in ring.coords[:-1]) for part in parts for ring in part.interiors]
        return Outline(tuple(rings), tuple(holes))


def _in_plane(places: FloatArray, grid: PixelGrid) -> FloatArray:
    return np.asarray(grid.in_picture(places[:, ::-1]) * np.array(grid.metres))


def _is_in(shape: BaseGeometry, grid: PixelGrid) -> bool:
    """Return whether a shape lies in the picture or partly."""
    picture = shapely.box(0, 0, *(np.array([grid.columns, grid.rows]) * grid.metres))
    plane = shapely.transform(shape, lambda places: _in_plane(places, grid))
    return bool(np.isfinite(plane.bounds).all() and picture.intersects(shapely.make_valid(plane)))


def _place(shape: BaseGeometry) -> str:
    """Return latitude and longitude of the middle of a shape, rounded to some ten metres."""
    left, bottom, right, top = shape.bounds
    return f"{(bottom + top) / 2:.4f}, {(left + right) / 2:.4f}"


def read_private(path: Path) -> tuple[Polygon, ...]:
    """Return the areas of a file as ground that nobody may look at, (longitude, latitude).

    Raises PictureError, which names the option: it cannot be read, or holds no area.
    """
    try:
        return _private_areas(path)
    except PictureError as error:
        raise PictureError(f"--private: {error}") from error


def _private_areas(path: Path) -> tuple[Polygon, ...]:
    found = _features_in(path)
    if any(each.facts.get("amenity") == _PARKING for each in found):
        raise PictureError(f"{path}: holds parking lots (amenity=parking); name a file with private ground alone")
    areas = tuple(part for each in found for part in polygons_of(each.shape))
    if not areas:
        raise PictureError(f"{path}: holds no area; draw each garden as a polygon, and save them as GeoJSON")
    return areas


def read_outline(path: Path) -> LotOutline:
    """Return the lots of a file.

    Raises:
        PictureError: It cannot be read, or holds no area that is a lot.
    """
    of_lots = list(_lots(_features_in(path)))
    drawn = [each for each in of_lots if polygons_of(each.shape)]
    empty = tuple(ground_words(each) for each in of_lots if not polygons_of(each.shape))
    if not drawn:
        raise PictureError(f"{path}: holds no area that is a lot, as amenity=parking is; {_REMEDY}")
    try:
        lots = lots_of(drawn)
    except PictureError as error:
        raise PictureError(f"{path}: {error}") from error
    crossed = tuple((each.number, each.shape) for each in drawn if _is_crossed(each.shape))
    return LotOutline(lots, crossed, empty, _read_safely(path, read_obstacles))


def _features_in(path: Path) -> list[OutlineFeature]:
    """Return the areas of a file. Raises PictureError."""
    return _read_safely(path, _areas_in)


def _areas_in(path: Path) -> list[OutlineFeature]:
    kind = kind_of_file(path)
    return _geopackage(path) if kind.name == "GeoPackage" else _read(path.read_bytes(), kind)


def _read_safely(path: Path, read: Callable[[Path], T]) -> T:
    """Return what is read of a stranger's file. Raises PictureError."""
    try:
        if path.stat().st_size > LARGEST_BYTES:
            raise PictureError(f"{path}: is too large for outlines; export the layer with the lots alone")
        return read(path)
    except OSError as error:
        raise PictureError(f"{path}: cannot be read ({error.strerror}); {_REMEDY}") from error
    except (AttributeError, TypeError, KeyError) as error:  # a value of another kind than its format has
        raise PictureError(f"{path}: is damaged ({error}); {_REMEDY}") from error
    except (LotInputError, AreaError, json.JSONDecodeError, RecursionError) as error:
        words = f"{error}; {_REMEDY}"
        if isinstance(error, LotInputError) and error.field == "crs":  # its reason has a remedy of its own
            words = error.reason
        raise PictureError(f"{path}: {words}") from error


def _lots(found: list[OutlineFeature]) -> Iterator[OutlineFeature]:
    """Yield the features that are lots."""
    is_of_all_kinds = any(each.facts.get("amenity") for each in found)
    for each in found:
        is_lot = each.facts.get("amenity") == _PARKING or not (is_of_all_kinds or is_obstacle(each.facts))
        if is_lot and each.facts.get("parking") != _UNDER:
            yield each


def _is_crossed(shape: BaseGeometry) -> bool:
    """Return whether the sides of an outline cross: parts of it, which run about backwards, count as less area."""
    if shape.is_valid:
        return False
    rings = [Polygon(ring) for part in parts_of_shape(shape) for ring in (part.exterior, *part.interiors)]
    return any(ring.area < (1 - _CROSSED_SHARE) * shapely.make_valid(ring).area for ring in rings)


def _read(data: bytes, kind: Kind) -> list[OutlineFeature]:
    if kind.name == "zip":
        data = unpacked(data, ENDS)
        kind = kind_of(data[:HEAD_BYTES])
    if kind.name == "KML":
        return _kml(data)
    if kind.name in ("OSM", "XML"):
        return list(_osm_xml(text_of(data)))
    if kind.name != "JSON":
        raise LotInputError("file", str(kind))
    content = json_of(text_of(data))
    if not isinstance(content, dict):
        raise LotInputError("file", "is JSON, but no GeoJSON")
    if "elements" not in content:
        return _geojson(content)
    try:
        return list(_osm_json(content))
    except ValueError as error:  # a coordinate that is no number
        raise LotInputError("elements", f"are damaged ({error})") from error


def _kml(data: bytes) -> list[OutlineFeature]:
    """Return the placemarks with areas: those of one placemark are one."""
    found = []
    for number, group in groupby(read_areas(data).areas, lambda area: area.feature):
        areas = list(group)
        parts = [
            Polygon([(x, y) for y, x in area.outer], [[(x, y) for y, x in ring] for ring in area.holes])
            for area in areas
            if len(area.outer) > 2
        ]
        shape = parts[0] if len(parts) == 1 else MultiPolygon(parts)
        found.append(OutlineFeature(areas[0].facts, shape, number))
    return found


def _geojson(content: dict[str, Any]) -> list[OutlineFeature]:
    found: list[OutlineFeature] = []
    crs = _system_of(content.get("crs"))
    for number, feature in enumerate(features_of(content) or (), 1):
        if not isinstance(feature, dict):
            continue
        geometry = feature["geometry"]
        if geometry is None:  # QGIS writes a feature without a shape so
            geometry = _NO_GROUND
        if not isinstance(geometry, dict) or geometry.get("type") not in ("Polygon", "MultiPolygon"):
            continue
        try:
            shape = shapely.force_2d(shapely.from_geojson(json.dumps(closed(geometry))))
        except shapely.errors.ShapelyError as error:
            reason = str(error).strip()[:120]
            raise LotInputError("features", f"hold an area that cannot be read ({reason})") from error
        facts, own = feature.get("properties"), feature.get("id")
        named = str(own) if isinstance(own, str | int) else ""
        found.append(OutlineFeature(facts if isinstance(facts, dict) else {}, shape, number, named))
    return _on_earth(found, crs)


def _system_of(crs: object) -> str:
    """Return the system that GeoJSON of 2008 names; WGS-84 without one. Raises LotInputError."""
    if crs is None:
        return WGS_84
    facts = crs.get("properties") if isinstance(crs, dict) else {"name": crs}
    named = facts.get("name") if isinstance(facts, dict) else None
    if not isinstance(named, str):
        raise LotInputError("crs", f"its system of coordinates has no name: write EPSG:4326, or no crs; {_REMEDY}")
    return crs_name(named) if named else WGS_84


def _geopackage(path: Path) -> list[OutlineFeature]:
    """Return the areas of a GeoPackage as GDAL reads them in the box. Raises LotInputError."""
    try:
        said = read_and_wait(AREAS, b"", {"path": str(path.resolve())})
    except RefusedError as error:
        raise LotInputError(error.field, error.reason) from None
    by_system: dict[str, list[OutlineFeature]] = {}
    for line in said.splitlines():
        facts, number, crs, shape = json.loads(line)
        by_system.setdefault(crs, []).append(OutlineFeature(facts, shapely.from_wkb(bytes.fromhex(shape)), number))
    return [each for crs, found in by_system.items() for each in _on_earth(found, crs or WGS_84)]


def _osm_xml(text: str) -> Iterator[OutlineFeature]:
    there = parts_of(root_of(text))
    nodes = {each.get("id", ""): place_of(each) for each in there if each.tag == "node"}
    outlines = {
        each.get("id", ""): [nodes.get(node.get("ref", ""), (np.nan, np.nan)) for node in each.iter("nd")]
        for each in there
        if each.tag == OUTLINE
    }
    for order, element in enumerate(there, 1):
        facts = {tag.get("k", ""): tag.get("v", "") for tag in element.iter("tag")}
        members = [(each.get("role", ""), each.get("ref", "")) for each in element.iter("member")]
        for area in _osm_area(element.tag, element.get("id", ""), facts, members, outlines):
            yield area._replace(number=order)


def _osm_json(content: dict[str, Any]) -> Iterator[OutlineFeature]:
    elements = [each for each in content["elements"] or () if isinstance(each, dict)]
    nodes = {each.get("id"): (each.get("lon"), each.get("lat")) for each in elements if each.get("type") == "node"}
    outlines: dict[str, list[tuple[float, float]]] = {}
    for each in elements:
        holders = [each] if each.get("type") == OUTLINE else _members(each)
        for holder in holders:
            line = _line_of(holder, nodes)
            if line:
                outlines[str(holder.get("id", holder.get("ref")))] = line
    for order, each in enumerate(elements, 1):
        members = [(str(member.get("role", "")), str(member.get("ref", ""))) for member in _members(each)]
        named = str(each.get("type")), str(each.get("id"))
        for area in _osm_area(*named, each.get("tags") or {}, members, outlines):
            yield area._replace(number=order)


def _members(element: Mapping[str, Any]) -> list[dict[str, Any]]:
    return [member for member in element.get("members") or () if isinstance(member, dict)]


def _line_of(holder: Mapping[str, Any], nodes: Mapping[Any, tuple[Any, Any]]) -> list[tuple[float, float]]:
    """Return the corners of an outline of Overpass: with ``geometry`` (out geom), or by its nodes."""
    if holder.get("geometry"):
        return [(place["lon"], place["lat"]) for place in holder["geometry"] if place]
    return [nodes.get(number, (np.nan, np.nan)) for number in holder.get("nodes") or ()]


def _osm_area(
    kind: str,
    number: str,
    facts: Mapping[str, Any],
    members: list[tuple[str, str]],
    outlines: Mapping[str, list[tuple[float, float]]],
) -> Iterator[OutlineFeature]:
    """Yield the area of an element, if it is a lot: a closed outline, or a relation of outer and inner ones."""
    if facts.get("amenity") != _PARKING or kind not in (OUTLINE, "relation"):
        return
    parts = [("outer", number)] if kind == OUTLINE else members
    lines: dict[bool, list[Any]] = {True: [], False: []}
    for role, ref in parts:
        line = np.array(outlines.get(ref, []), np.float64).reshape(-1, 2)
        if len(line) > 1 and np.isfinite(line).all():
            lines[role != "inner"].append(shapely.LineString(line))
    outer, inner = (shapely.union_all(shapely.get_parts(shapely.polygonize(lines[key]))) for key in (True, False))
    area = outer.difference(inner)
    if isinstance(area, Polygon | MultiPolygon) and not area.is_empty:
        yield OutlineFeature(facts, area, id=f"{kind}/{number}")


def _on_earth(found: list[OutlineFeature], crs: str) -> list[OutlineFeature]:
    """Return the features in WGS-84, all by one conversion."""
    moved = shapely.transform(np.array([each.shape for each in found], object), lambda at: to_wgs_84(at, crs)[0])
    return [each._replace(shape=shape) for each, shape in zip(found, moved.tolist(), strict=True)]
