"""Layers of polygons and lines by GDAL's vector drivers (`pyogrio`): GeoPackage, KML; arcs are chains of corners.

It is called within the box alone (`hawk.formats.box`): GDAL reads a copy of the file under a name of its kind.
"""

from __future__ import annotations

import json
import re
import tempfile
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
import shapely
from shapely import LineString, MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from hawk.formats import gdal
from hawk.formats.kind import HEAD_BYTES, kind_of
from hawk.lots.plan_files.features import FeatureReader
from hawk.lots.plan_files.geojson import crs_name
from hawk.lots.plan_files.section_facts import is_line
from hawk.lots.plan_files.values import MOST_FEATURES, Asked, Drawing, Facts, Floats, Notes, text_of
from hawk.lots.values import LotInputError
from hawk.runtime.late import load

AREAS: Final = "hawk.lots.plan_files.layers:areas"
"""Name of the reader of lots' outlines, for the box."""
ENDINGS: Final = {"GeoPackage": ".gpkg", "KML": ".kml"}
"""Kinds of `hawk.formats.kind` that are read here."""
_SURFACES: Final = frozenset(
    {"POLYGON", "MULTIPOLYGON", "CURVEPOLYGON", "SURFACE", "MULTISURFACE", "GEOMETRY", "UNKNOWN", "GEOMETRYCOLLECTION"}
)
"""Types of geometry that may be polygons; the last ones are any."""
_LINES: Final = frozenset({"LINESTRING", "MULTILINESTRING", "CURVE", "COMPOUNDCURVE", "MULTICURVE"})
"""Types of geometry that may be kerbs; a layer of others, as rivers, is not read."""
_DIMENSIONS: Final = re.compile(r"(?i)^(2\.5D |Measured |3D )+|(?<=[a-z]) ?(25D|ZM|Z|M)$")
_BROKEN: Final = ("DataSourceError", "DataLayerError", "FeatureError", "FieldError")
"""Names of pyogrio's errors at a file that is damaged."""
_MISSING: Final = (
    '{} is read with pyogrio, which is not installed here: pip install "hawk-drone[plans]", or save it as GeoJSON'
)
_MOST_BROKEN: Final = 100
"""Shapes that cannot be read, up to which a file is read without them."""
_SAVE: Final = "it is cut or damaged, export it again"


@dataclass(frozen=True, slots=True)
class Layer:
    """A layer as GDAL reads it. ``kind``: its type of geometry, in capitals; ``crs``: AUTHORITY:CODE, WKT, or ""."""

    name: str
    kind: str
    crs: str = ""
    facts: tuple[Facts, ...] = field(default=(), repr=False)
    shapes: tuple[BaseGeometry | None, ...] = field(default=(), repr=False)


def read(data: bytes, asked: Asked, notes: Notes, log: bytes = b"") -> Drawing:
    """Return the outlines of a file. Raises LotInputError for one that is none, is cut, or has no layer of polygons.

    ``log``: the write-ahead log of a GeoPackage that a program has open, whose newest stalls are in it.
    """
    kind = kind_of(data[:HEAD_BYTES]).name
    every = _layers(data, kind, log)
    layers = [each for each in every if each.kind in _SURFACES or each.facts]
    if not layers:
        there = ", ".join(f"{each.name} ({each.kind})" for each in every[:10]) or "none at all"
        raise LotInputError("file", f"has no layer of polygons, but {there}: export the layer with the stalls")
    if asked.layer:
        named = [each for each in layers if each.name == asked.layer]
        if not named:
            words = f"must be one of the layers of polygons: {_names(layers)}"
            raise LotInputError("layer", words)
        layers = named
    systems = {each.crs for each in layers}
    if len(systems) > 1:
        said = ", ".join(sorted(each[:40] for each in systems))
        raise LotInputError("layer", f"must be named, their systems differ ({said}): {_names(layers)}")
    reader = FeatureReader(asked, notes)
    counts = tuple((each.name[:80], _add(each, reader, notes)) for each in layers)
    return reader.drawing(kind, systems.pop(), counts)


def _names(layers: Sequence[Layer]) -> str:
    return ", ".join(each.name for each in layers[:20])


def areas(data: bytes, asked: dict[str, Any]) -> bytes:
    """Return the areas of a file on the disk (``path``) as lines of JSON: facts, number, system, and WKB in hex.

    A row of a layer of areas that has none is an empty one. It is called by the box. Raises LotInputError.
    """
    path = Path(asked["path"])
    data = path.read_bytes()
    lines = []
    for layer in _layers(data, kind_of(data[:HEAD_BYTES]).name, log_beside(path)):
        for number, (facts, shape) in enumerate(zip(layer.facts, layer.shapes, strict=True), 1):
            area = Polygon() if shape is None else shape
            if isinstance(area, Polygon | MultiPolygon):
                lines.append(json.dumps([facts, number, layer.crs, shapely.to_wkb(area, hex=True)]))
    return "\n".join(lines).encode()


def log_beside(path: Path) -> bytes:
    """Return the log beside a database that a program has open; b"" for others. Raises OSError."""
    beside = path.with_name(f"{path.name}-wal")
    return beside.read_bytes() if beside.is_file() else b""


def _checked(data: bytes, kind: str) -> bytes:
    """Return a KML in UTF-8, without definitions of its own that could grow. Raises LotInputError."""
    if kind != "KML":
        return data
    text = text_of(data)
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise LotInputError("file", "has definitions of its own (DOCTYPE), which are not read: save it as KML again")
    return re.sub(r"^\s*<\?xml[^>]*\?>", "", text, count=1).encode()


def _layers(data: bytes, kind: str, log: bytes) -> list[Layer]:
    """Return the layers of a file: those that are no areas without their features. Raises LotInputError."""
    if kind not in ENDINGS:
        raise LotInputError("file", str(kind_of(data[:HEAD_BYTES])))
    gdal.prepare()
    try:
        pyogrio = load("pyogrio", "errors")
    except ImportError:
        raise LotInputError("file", _MISSING.format(kind)) from None
    broken = tuple(getattr(pyogrio.errors, name) for name in _BROKEN)
    with tempfile.TemporaryDirectory(prefix="hawk-plan-") as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of heights and measures that are left out
        path = Path(folder) / f"plan{ENDINGS[kind]}"
        path.write_bytes(_checked(data, kind))
        if log:
            path.with_name(f"{path.name}-wal").write_bytes(log)
        try:
            named = [(str(name), geometry) for name, geometry in pyogrio.list_layers(path).tolist()]
            return [
                _layer(pyogrio, path, name, _DIMENSIONS.sub("", str(geometry)).upper())
                for name, geometry in named
                if geometry is not None
            ]
        except LotInputError:
            raise
        except (*broken, ValueError, RuntimeError) as error:
            reason = " ".join(str(error).replace(str(path), "it").split())[:160]
            raise LotInputError("file", f"cannot be read as {kind} ({reason}): {_SAVE}") from None


def _layer(pyogrio: Any, path: Path, name: str, kind: str) -> Layer:
    if kind not in _SURFACES and not (kind in _LINES and is_line(_columns(pyogrio, path, name))):
        return Layer(name, kind)
    found, fids, _, columns = pyogrio.raw.read(
        path, layer=name, read_geometry=False, return_fids=True, max_features=MOST_FEATURES + 1
    )
    if len(fids) > MOST_FEATURES:
        raise LotInputError("file", f"has more than {MOST_FEATURES} features: export the layer with the stalls")
    shapes = _shapes(pyogrio, path, name, fids)
    names = [str(each) for each in found["fields"]]
    values = [[_plain(each) for each in column] for column in columns]
    facts = tuple(dict(zip(names, row, strict=True)) for row in zip(*values, strict=True)) if names else ()
    with np.errstate(invalid="ignore"):  # of coordinates that are no numbers, which are refused by themselves
        read_shapes = shapely.from_wkb(np.array(shapes, object), on_invalid="ignore")
    said = pyogrio.read_info(path, layer=name)["crs"]
    return Layer(name, kind, crs_name(said) if said else "", facts or ({},) * len(shapes), tuple(read_shapes))


def _columns(pyogrio: Any, path: Path, layer: str) -> Facts:
    """Return the columns of a layer, without values."""
    return dict.fromkeys(map(str, pyogrio.read_info(path, layer=layer)["fields"]))


def _shapes(pyogrio: Any, path: Path, layer: str, fids: Any) -> list[bytes | None]:
    """Return the shapes of features as WKB, None for those that cannot be read, of which GDAL reads no other either."""
    waiting, broken = [fids], 0
    found: list[bytes | None] = []
    while waiting:
        part = waiting.pop()
        if not len(part):
            continue
        try:
            _, _, shapes, _ = pyogrio.raw.read(path, layer=layer, columns=[], fids=part, force_2d=True)
            found += [bytes(each) if each is not None and len(each) else None for each in shapes]
        except (ValueError, RuntimeError):
            broken += len(part) == 1
            if broken > _MOST_BROKEN:
                raise
            half = len(part) // 2
            found += [None] if len(part) == 1 else []
            waiting += [part[half:], part[:half]] if len(part) > 1 else []
    return found


def _plain(value: Any) -> Any:
    """Return a value of a column as JSON has it; None for dates and bytes, which are no labels."""
    found = value.item() if isinstance(value, np.generic) else value
    if isinstance(found, float) and not np.isfinite(found):
        return None
    return found if isinstance(found, str | int | float | bool) else None


def _add(layer: Layer, reader: FeatureReader, notes: Notes) -> int:
    """Add the rows of a layer to a reader; return the number of those that are neither noted nor left out."""
    count = 0
    for number, (facts, shape) in enumerate(zip(layer.facts, layer.shapes, strict=True), 1):
        name = f"{layer.name}, row {number}"
        reason, places, is_road = _course(shape)
        if reason:
            notes.add(name, f"geometry: {reason}")
        else:
            before = len(reader.drawn) + len(reader.sections)
            reader.add(name, places, facts, is_line=is_road, layer=layer.name)
            count += len(reader.drawn) + len(reader.sections) > before
    return count


def _course(shape: BaseGeometry | None) -> tuple[str, Floats, bool]:
    """Return the reason why a shape is neither outline nor line, else "", its corners, and whether it is a line."""
    none: Floats = np.empty((0, 2))
    while isinstance(shape, shapely.geometry.base.BaseMultipartGeometry) and len(shape.geoms) == 1:
        shape = shape.geoms[0]
    if shape is None:
        return "holds none that can be read: draw the outline of the stall", none, False
    if not isinstance(shape, Polygon | LineString):
        return f"is a {shape.geom_type}: draw one outline for each stall", none, False
    if shape.is_empty:
        return "is empty: draw the outline of the stall", none, False
    if isinstance(shape, Polygon) and shape.interiors:
        return "has a hole: draw the outer line alone", none, False
    course = shape.exterior if isinstance(shape, Polygon) else shape
    places = np.array(course.coords, np.float64)[:, :2]
    words = "" if np.isfinite(places).all() else "must have finite numbers as coordinates"
    return words, places, isinstance(shape, LineString)
