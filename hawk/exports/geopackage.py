"""Surveys as GeoPackage (OGC 12-128r18), written by SQLite itself: a layer of the lot, one of stalls, one of
sections where there are some, and a table of the survey.
"""

from __future__ import annotations

import sqlite3
import struct
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import shapely
from numpy.typing import NDArray

from hawk.exports.section_files import COLUMNS, section_values
from hawk.exports.shapes import lot_shape, stall_shapes
from hawk.exports.text_files import about_survey
from hawk.exports.values import ExportRecord, Observation, SeenSection
from hawk.lots.values import utc

_WGS84: Final = 4326
_APPLICATION_ID: Final = 0x47504B47
"""SQLite's application_id of a GeoPackage: "GPKG"."""
_VERSION: Final = 10300
_SCHEMA: Final = """
CREATE TABLE gpkg_spatial_ref_sys (srs_name TEXT NOT NULL, srs_id INTEGER PRIMARY KEY, organization TEXT NOT NULL,
  organization_coordsys_id INTEGER NOT NULL, definition TEXT NOT NULL, description TEXT);
CREATE TABLE gpkg_contents (table_name TEXT NOT NULL PRIMARY KEY, data_type TEXT NOT NULL, identifier TEXT UNIQUE,
  description TEXT DEFAULT '', last_change DATETIME NOT NULL, min_x DOUBLE, min_y DOUBLE, max_x DOUBLE, max_y DOUBLE,
  srs_id INTEGER REFERENCES gpkg_spatial_ref_sys(srs_id));
CREATE TABLE gpkg_geometry_columns (table_name TEXT NOT NULL REFERENCES gpkg_contents(table_name),
  column_name TEXT NOT NULL, geometry_type_name TEXT NOT NULL, srs_id INTEGER NOT NULL, z TINYINT NOT NULL,
  m TINYINT NOT NULL, PRIMARY KEY (table_name, column_name));
"""
_SYSTEMS: Final = (
    ("Undefined Cartesian", -1, "NONE", -1, "undefined", None),
    ("Undefined geographic", 0, "NONE", 0, "undefined", None),
    (
        "WGS 84", _WGS84, "EPSG", _WGS84,
        'GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563,AUTHORITY["EPSG","7030"]],'
        'AUTHORITY["EPSG","6326"]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433],'
        'AXIS["Latitude",NORTH],AXIS["Longitude",EAST],AUTHORITY["EPSG","4326"]]',
        None,
    ),
)  # fmt: skip
_STALL_COLUMNS: Final = {
    "stall_id": "TEXT", "lot_id": "TEXT", "survey_id": "TEXT", "label": "TEXT", "kind": "TEXT", "state": "TEXT",
    "taken_probability": "REAL", "observed": "DATETIME", "picture_count": "INTEGER", "width_m": "REAL",
    "length_m": "REAL", "direction_deg": "REAL", "confirmed": "BOOLEAN",
}  # fmt: skip
_LOT_COLUMNS: Final = {"lot_id": "TEXT", "name": "TEXT"}
_SURVEY_TYPES: Final = {bool: "BOOLEAN", int: "INTEGER", float: "REAL"}


def surveys_gpkg(surveys: Sequence[ExportRecord]) -> bytes:
    """Return surveys as one GeoPackage: the layers ``lots`` and ``stalls``, ``sections`` where the lots have some, and
    the table ``surveys``.

    The stalls of all surveys are in one layer, distinguished by ``survey_id``; a lot is there once.
    """
    with tempfile.TemporaryDirectory(prefix="hawk-gpkg-") as folder:
        path = Path(folder) / "survey.gpkg"
        connection = sqlite3.connect(path)
        try:
            with connection:
                _write(connection, surveys)
        finally:
            connection.close()
        return path.read_bytes()


def _write(connection: sqlite3.Connection, surveys: Sequence[ExportRecord]) -> None:
    connection.execute(f"PRAGMA application_id = {_APPLICATION_ID}")
    connection.execute(f"PRAGMA user_version = {_VERSION}")
    for statement in _SCHEMA.split(";"):
        connection.execute(statement)
    connection.executemany("INSERT INTO gpkg_spatial_ref_sys VALUES (?,?,?,?,?,?)", _SYSTEMS)
    changed = utc(max((survey.ended for survey in surveys), default=0.0)).replace("Z", ".000Z")
    lots = {survey.lot_id: survey for survey in surveys}
    grounds = np.array([lot_shape(survey.outline) for survey in lots.values()], np.object_)
    named = [[survey.lot_id, survey.lot] for survey in lots.values()]
    _layer(connection, "lots", "MULTIPOLYGON", _LOT_COLUMNS, grounds, named, changed)
    every = [stall for survey in surveys for stall in survey.stalls]
    once = {id(stall.corners): stall for stall in every}  # surveys of a layout share its stalls
    number = dict(zip(once, range(len(once)), strict=True))
    stalls = stall_shapes([*once.values()])
    at = [number[id(stall.corners)] for stall in every]
    rows = [_row(survey, stall) for survey in surveys for stall in survey.stalls]
    _layer(connection, "stalls", "POLYGON", _STALL_COLUMNS, stalls, rows, changed, at)
    sections = [(survey, each) for survey in surveys for each in survey.sections]
    if sections:
        rings = [[(longitude, latitude) for latitude, longitude in each.ring] for _, each in sections]
        grounds = np.array([shapely.Polygon(ring) for ring in rings], np.object_)
        values = [_section_row(*each) for each in sections]
        _layer(connection, "sections", "POLYGON", COLUMNS, grounds, values, changed)
    _table(connection, [about_survey(survey) for survey in surveys], changed)


def _row(survey: ExportRecord, stall: Observation) -> list[Any]:
    looked = None if stall.looked_at is None else utc(stall.looked_at).replace("Z", ".000Z")
    return [
        stall.id, survey.lot_id, survey.survey, stall.label, stall.kind or "normal", stall.state,
        stall.taken_probability, looked, stall.picture_count, stall.width, stall.length,
        stall.direction, stall.is_confirmed,
    ]  # fmt: skip


def _section_row(survey: ExportRecord, seen: SeenSection) -> list[Any]:
    values = section_values(survey, seen)
    return [*{**values, "observed": values["observed"].replace("Z", ".000Z")}.values()]


def _layer(
    connection: sqlite3.Connection,
    name: str,
    kind: str,
    columns: dict[str, str],
    shapes: NDArray[np.object_],
    rows: Sequence[Sequence[Any]],
    changed: str,
    at: Sequence[int] | None = None,
) -> None:
    """Write a layer of features: ``columns`` with their types, geometries, and their values.

    ``at``: number of the geometry of each row; each one has its own where none are given.
    """
    declared = ", ".join(f"{column} {kind}" for column, kind in columns.items())
    connection.execute(f"CREATE TABLE {name} (fid INTEGER PRIMARY KEY AUTOINCREMENT, geom {kind} NOT NULL, {declared})")
    marks = ",".join("?" * (len(columns) + 1))
    blobs = _blobs(shapes)
    values = ((blobs[k], *row) for k, row in zip(range(len(rows)) if at is None else at, rows, strict=True))
    named = ", ".join(columns)
    connection.executemany(f"INSERT INTO {name} (geom, {named}) VALUES ({marks})", values)  # noqa: S608 - our names
    bounds = shapely.total_bounds(shapes).tolist() if len(shapes) else [None] * 4
    bounds = [None if value != value else value for value in bounds]
    connection.execute(
        "INSERT INTO gpkg_contents VALUES (?, 'features', ?, '', ?, ?, ?, ?, ?, ?)",
        (name, name, changed, *bounds, _WGS84),
    )
    connection.execute("INSERT INTO gpkg_geometry_columns VALUES (?, 'geom', ?, ?, 0, 0)", (name, kind, _WGS84))


def _table(connection: sqlite3.Connection, surveys: Sequence[dict[str, Any]], changed: str) -> None:
    """Write the table of surveys."""
    if not surveys:
        return
    types = {
        name: next((_SURVEY_TYPES[type(v)] for each in surveys if type(v := each[name]) in _SURVEY_TYPES), "TEXT")
        for name in surveys[0]
    }
    declared = ", ".join(f"{name} {kind}" for name, kind in types.items())
    connection.execute(f"CREATE TABLE surveys (fid INTEGER PRIMARY KEY AUTOINCREMENT, {declared})")
    marks = ",".join("?" * len(types))
    rows = [tuple(each.values()) for each in surveys]
    named = ", ".join(types)
    connection.executemany(f"INSERT INTO surveys ({named}) VALUES ({marks})", rows)  # noqa: S608 - our names
    connection.execute(
        "INSERT INTO gpkg_contents (table_name, data_type, identifier, last_change, srs_id) "
        "VALUES ('surveys', 'attributes', 'surveys', ?, 0)",
        (changed,),
    )


def _blobs(shapes: NDArray[np.object_]) -> list[bytes]:
    """Return geometries as the standard's blobs: header without envelope, then well-known binary."""
    empty = shapely.is_empty(shapes).tolist()
    heads = [b"GP" + struct.pack("<BBi", 0, 0b00000001 | (0b00010000 if each else 0), _WGS84) for each in (False, True)]
    return [heads[is_empty] + data for is_empty, data in zip(empty, shapely.to_wkb(shapes, byte_order=1), strict=True)]
