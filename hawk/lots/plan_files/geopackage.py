"""Plans as GeoPackage (OGC 12-128r19): layers of polygons in an SQLite file.

The file is a stranger's: it is opened for reading alone, and no function or trigger of it is trusted.
"""

from __future__ import annotations

import contextlib
import sqlite3
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final
from urllib.parse import quote

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from hawk.lots.plan_files.facts import kind_of, label_of
from hawk.lots.plan_files.geojson import STALL, WGS_84
from hawk.lots.plan_files.values import MOST_FEATURES, Asked, Drawing, Drawn, Floats, Notes
from hawk.lots.values import LotInputError

FORMAT: Final = "GeoPackage"
MAGIC: Final = b"SQLite format 3\0"
AREAS: Final = frozenset({"POLYGON", "MULTIPOLYGON", "CURVEPOLYGON", "SURFACE", "MULTISURFACE", "GEOMETRY"})
"""Types of geometry that may be polygons; GEOMETRY is any."""
_ENVELOPE_BYTES: Final = {0: 0, 1: 32, 2: 48, 3: 48, 4: 64}
"""Code of the envelope in the flags of a geometry's header -> its size (12-128r19, table 6)."""
LAYERS: Final = """
SELECT c.table_name, g.column_name, upper(g.geometry_type_name), g.srs_id, s.organization, s.organization_coordsys_id,
       s.definition
FROM gpkg_contents c JOIN gpkg_geometry_columns g ON g.table_name = c.table_name
LEFT JOIN gpkg_spatial_ref_sys s ON s.srs_id = g.srs_id
WHERE c.data_type = 'features' ORDER BY c.table_name
"""


class GeometryError(ValueError):
    """A geometry cannot be used; the text names the remedy."""


def read(data: bytes, asked: Asked, notes: Notes) -> Drawing:
    """Return the outlines of a file. Raises LotInputError for one that is none, is cut, or has no layer of polygons."""
    with tempfile.TemporaryDirectory(prefix="hawk-plan-") as folder:
        path = Path(folder) / "plan.gpkg"
        path.write_bytes(data)
        try:
            with contextlib.closing(open_geopackage(path)) as opened:
                return _drawing(opened, asked, notes)
        except (sqlite3.Error, sqlite3.Warning, UnicodeDecodeError) as error:
            words = f"cannot be read as GeoPackage ({error}): it is cut or damaged, export it again"
            raise LotInputError("file", words) from None


def open_geopackage(path: Path) -> sqlite3.Connection:
    """Open a file of a stranger for reading. Raises sqlite3.Error."""
    opened = sqlite3.connect(f"file:{quote(str(path))}?mode=ro&immutable=1", uri=True)
    opened.execute("PRAGMA trusted_schema = OFF")
    opened.execute("PRAGMA cell_size_check = ON")
    opened.text_factory = lambda raw: raw.decode("utf-8", "replace")
    return opened


def _drawing(opened: sqlite3.Connection, asked: Asked, notes: Notes) -> Drawing:
    tables = {str(row[0]) for row in opened.execute("SELECT name FROM sqlite_master")}
    if "gpkg_contents" not in tables:
        raise LotInputError("file", "is an SQLite file, but no GeoPackage: export the layer as GeoPackage")
    rows = opened.execute(LAYERS).fetchall() if "gpkg_geometry_columns" in tables else []
    layers = [row for row in rows if row[2] in AREAS]
    if not layers:
        there = ", ".join(f"{row[0]} ({row[2]})" for row in rows[:10]) or "none at all"
        raise LotInputError("file", f"has no layer of polygons, but {there}: export the layer with the stalls")
    if asked.layer:
        named = [row for row in layers if row[0] == asked.layer]
        if not named:
            words = f"is none of the layers of polygons: {', '.join(str(row[0]) for row in layers[:20])}"
            raise LotInputError("layer", words)
        layers = named
    systems = {system_of(row) for row in layers}
    if len(systems) > 1:
        words = f"must be named, their systems differ ({', '.join(sorted(systems))}): {_names(layers)}"
        raise LotInputError("layer", words)
    drawn: list[Drawn] = []
    counts = []
    for row in layers:
        before = len(drawn)
        drawn += _layer(opened, str(row[0]), str(row[1]), asked, notes)
        counts.append((str(row[0])[:80], len(drawn) - before))
    return Drawing(FORMAT, tuple(drawn), crs=systems.pop(), layers=tuple(counts))


def _names(layers: Sequence[Any]) -> str:
    return ", ".join(str(row[0]) for row in layers[:20])


def system_of(row: Sequence[Any]) -> str:
    """Return the system of a layer's coordinates: AUTHORITY:CODE, else its definition; "" for the undefined ones."""
    srs, authority, code, definition = row[3:7]
    if srs in (-1, 0):
        return ""
    if authority and str(authority).upper() in ("EPSG", "ESRI", "OGC"):
        name = f"{str(authority).upper()}:{code}"
        return WGS_84 if name in (WGS_84, "OGC:CRS84") else name
    return str(definition or srs)


def _layer(opened: sqlite3.Connection, table: str, column: str, asked: Asked, notes: Notes) -> Iterator[Drawn]:
    found = opened.execute(f"SELECT * FROM {quoted(table)} LIMIT {MOST_FEATURES + 1}")  # noqa: S608 - it is quoted
    names = [each[0] for each in found.description]
    at = names.index(column) if column in names else -1
    if at < 0:
        raise LotInputError("file", f"has a layer {table} without its column {column}: export it again")
    for number, row in enumerate(found, 1):
        if number > MOST_FEATURES:
            raise LotInputError("file", f"has more than {MOST_FEATURES} features: export the layer with the stalls")
        name = f"{table}, row {number}"
        facts = {each: value for each, value in zip(names, row, strict=True) if each != column}
        if facts.get("amenity") not in (None, "", STALL):
            notes.add(name, f"amenity: is {str(facts['amenity'])[:40]}, no {STALL}")
            continue
        try:
            ring = _ring(geometry_of(row[at]))
        except GeometryError as error:
            notes.add(name, f"{column}: {error}")
            continue
        yield Drawn(name, ring, label_of(facts, asked.label, name, notes), kind_of(facts, name, notes))


def quoted(name: str) -> str:
    """Return a name as SQL writes it."""
    return '"' + name.replace('"', '""') + '"'


def geometry_of(blob: object) -> BaseGeometry:
    """Return the geometry of a column's value: a header of 8 bytes, an envelope, and WKB (12-128r19, 2.1.3).

    Raises GeometryError.
    """
    if not isinstance(blob, bytes) or len(blob) < 8 or blob[:2] != b"GP":
        raise GeometryError("holds no geometry: draw the outline of the stall")
    flags = blob[3]
    envelope = _ENVELOPE_BYTES.get((flags >> 1) & 0b111)
    if envelope is None or flags & 0b100000:
        raise GeometryError("holds a geometry of another kind: export it again as polygons")
    try:
        with np.errstate(invalid="ignore"):  # of coordinates that are no numbers, which are refused by themselves
            return shapely.from_wkb(blob[8 + envelope :])
    except (shapely.errors.ShapelyError, ValueError, TypeError):
        raise GeometryError("holds a geometry that cannot be read: export it again") from None


def _ring(shape: BaseGeometry) -> Floats:
    if isinstance(shape, MultiPolygon) and len(shape.geoms) == 1:
        shape = shape.geoms[0]
    if not isinstance(shape, Polygon):
        raise GeometryError(f"is a {shape.geom_type}: draw one outline for each stall")
    if shape.is_empty:
        raise GeometryError("is empty: draw the outline of the stall")
    if shape.interiors:
        raise GeometryError("has a hole: draw the outer line alone")
    ring = np.array(shape.exterior.coords, np.float64)[:, :2]
    if not np.isfinite(ring).all():
        raise GeometryError("must have finite numbers as coordinates")
    return ring
