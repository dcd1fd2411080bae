"""Files with plans, as others write them, for the tests."""

from __future__ import annotations

import io
import json
import sqlite3
import struct
import zipfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from hawk.lots.plan import geometry
from hawk.lots.plan_files.formats import read_plan
from hawk.lots.plan_files.values import Asked, PlanFile
from hawk.model.poses import GlobalPose
from hawk.results.survey_map import to_global

DATUM = GlobalPose(52.0, 5.0, 0.0)
Ring = Sequence[tuple[float, float]]
Json = dict[str, Any]


def row(count: int, pitch: float = 2.5, north: float = 0.0, east: float = 0.0) -> list[list[tuple[float, float]]]:
    """Return the corners (north, east) of a row of stalls from west to east, the first middle at a place."""
    shapes = np.array([(north, east + k * pitch, 0.0, pitch, 5.0) for k in range(count)])
    return [list(polygon.exterior.coords) for polygon in geometry.polygons(shapes)]


def degrees(ring: Ring) -> list[list[float]]:
    """Return corners (north, east) about the datum as [longitude, latitude]."""
    return [[longitude, latitude] for latitude, longitude in to_global(DATUM, np.array(ring, float)).tolist()]


def feature(coordinates: Any, kind: str | None = "Polygon", /, **properties: object) -> Json:
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": coordinates}}


def geojson(features: Iterable[Json], **members: object) -> bytes:
    return json.dumps({"type": "FeatureCollection", **members, "features": list(features)}).encode()


def numbered(count: int, **properties: object) -> list[Json]:
    """Return a row of stalls with the labels P1, P2 and so on."""
    rings = row(count)
    return [feature([degrees(ring)], label=f"P{k}", **properties) for k, ring in enumerate(rings, 1)]


def osm(*elements: str) -> bytes:
    return f'<?xml version="1.0" encoding="UTF-8"?>\n<osm version="0.6">{"".join(elements)}</osm>'.encode()


def outline(number: int, ring: Ring, **tags: str) -> str:
    """Return the nodes of a ring (north, east) and the element that joins them."""
    corners = degrees(ring)[:-1]
    ids = [number * 10 + k for k in range(len(corners))]
    nodes = [f'<node id="{i}" lat="{y!r}" lon="{x!r}"/>' for i, (x, y) in zip(ids, corners, strict=True)]
    refs = "".join(f'<nd ref="{i}"/>' for i in [*ids, ids[0]])
    said = "".join(f'<tag k="{key.replace("__", ":")}" v="{value}"/>' for key, value in tags.items())
    return f'{"".join(nodes)}<way id="{number}">{refs}{said}</way>'


def geopackage(
    folder: Path,
    rows: Sequence[tuple[object, str]],
    kind: str = "POLYGON",
    srs: int = 4326,
    table: str = "stalls",
    column: str = "ref",
) -> bytes:
    """Return a GeoPackage of one layer: shapes of shapely or raw values, each with its label."""
    path = folder / "plan.gpkg"
    path.unlink(missing_ok=True)
    opened = sqlite3.connect(path)
    opened.executescript(
        f"""
        PRAGMA application_id = 0x47504B47;
        PRAGMA user_version = 10300;
        CREATE TABLE gpkg_spatial_ref_sys (srs_name TEXT NOT NULL, srs_id INTEGER PRIMARY KEY,
            organization TEXT NOT NULL, organization_coordsys_id INTEGER NOT NULL, definition TEXT NOT NULL,
            description TEXT);
        CREATE TABLE gpkg_contents (table_name TEXT PRIMARY KEY, data_type TEXT NOT NULL, identifier TEXT,
            description TEXT, last_change TEXT, min_x DOUBLE, min_y DOUBLE, max_x DOUBLE, max_y DOUBLE, srs_id INTEGER);
        CREATE TABLE gpkg_geometry_columns (table_name TEXT, column_name TEXT, geometry_type_name TEXT, srs_id INTEGER,
            z TINYINT, m TINYINT, PRIMARY KEY (table_name, column_name));
        CREATE TABLE "{table}" (fid INTEGER PRIMARY KEY, geom BLOB, {column} TEXT);
        INSERT INTO gpkg_contents (table_name, data_type, identifier, srs_id)
            VALUES ('{table}', 'features', 'x', {srs});
        INSERT INTO gpkg_geometry_columns VALUES ('{table}', 'geom', '{kind}', {srs}, 2, 2);
        INSERT INTO gpkg_spatial_ref_sys VALUES ('x', {srs}, 'EPSG', {srs}, 'undefined', '');
        """  # noqa: S608 - our own names
    )
    values = [(blob(shape, srs) if hasattr(shape, "wkb") else shape, label) for shape, label in rows]
    opened.executemany(f'INSERT INTO "{table}" (geom, {column}) VALUES (?, ?)', values)  # noqa: S608 - our own name
    opened.commit()
    opened.close()
    return path.read_bytes()


def blob(shape: Any, srs: int) -> bytes:
    """Return a geometry as GeoPackage keeps it, with an envelope."""
    west, south, east, north = shape.bounds
    header = b"GP\x00\x03" + struct.pack("<i4d", srs, west, east, south, north)
    return header + bytes(shapely.to_wkb(shape, byte_order=1))


def dxf(draw: Callable[[Any, Any], object], units: int = 6) -> bytes:
    """Return a DXF that a function draws into: document and model space."""
    from ezdxf.filemanagement import new

    document = new("R2010")
    document.header["$INSUNITS"] = units
    draw(document, document.modelspace())
    text = io.StringIO()
    document.write(text)
    return text.getvalue().encode()


def closed(ring: Ring, scale: float = 1.0) -> list[tuple[float, float]]:
    """Return corners (north, east) as x and y of a drawing, not closed."""
    return [(east * scale, north * scale) for north, east in ring[:-1]]


def archive(**files: bytes) -> bytes:
    """Return a ZIP of files, "__" for the point in a name."""
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, data in files.items():
            packed.writestr(zipfile.ZipInfo(name.replace("__", ".")), data, zipfile.ZIP_DEFLATED)
    return made.getvalue()


def plan(data: bytes, **asked: str) -> PlanFile:
    return read_plan(data, Asked(**asked))


def labels(found: PlanFile) -> list[str]:
    return [stall.label for stall in found.stalls]


def left_out(found: PlanFile) -> list[str]:
    return [f"{each.name}: {each.reason}" for each in found.left_out]
