"""All that is read of drawn files of every kind: stalls, what is left out and why, place, units and layers."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from hawk.lots.plan import geometry
from hawk.lots.values import LotInputError
from tests.golden import check_values
from tests.unit.lots.plan_files.files import (
    Json,
    archive,
    closed,
    degrees,
    dxf,
    feature,
    geojson,
    geopackage,
    numbered,
    osm,
    outline,
    plan,
    row,
)

HERE = Path(__file__).parent / "drawn"


def found(data: bytes, **asked: str) -> Any:
    """Return a plan, or the words of its refusal; numbers to the millimetre, angles modulo half a turn."""
    try:
        read = asdict(plan(data, **asked))
    except LotInputError as refused:
        return f"{refused.field}: {refused.reason}"
    shapes = [[each.pop(name) for name in ("north", "east", "angle", "width", "length")] for each in read["stalls"]]
    for each, (north, east, angle, *sizes) in zip(read["stalls"], shapes, strict=True):
        turned = round(angle, 3) % round(math.pi, 3)
        each["shape"] = [round(north, 3) + 0.0, round(east, 3) + 0.0, turned, *(round(size, 3) for size in sizes)]
    return _plain(read)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    return round(value, 8) if isinstance(value, float) else value


def stall(width: float, length: float, east: float, angle: float = 0.0, **facts: object) -> Json:
    """Return the feature of a rectangle whose middle lies east of the datum."""
    (shape,) = geometry.polygons(np.array([(0.0, east, angle, width, length)]))
    return feature([degrees(list(shape.exterior.coords))], **facts)


def leaning(shear: float, east: float, **facts: object) -> Json:
    ring = [(0.0, east), (0.0, east + 2.5), (5.0, east + 2.5 + shear), (5.0, east + shear), (0.0, east)]
    return feature([degrees(ring)], **facts)


SIZES = [(0.49, 5.0), (0.51, 5.0), (9.99, 24.0), (10.01, 24.0), (2.5, 24.99), (2.5, 25.01), (0.51, 0.6), (3.0, 2.0)]
FACTS: list[Json] = [
    {"label": " A  1 "}, {"ref": "7"}, {"name": "x" * 21}, {"label": "A 1"}, {"label": 7}, {"label": None, "ref": "B"},
    {"parking_space": "disabled"}, {"parking_space": "rocket"}, {"amenity": "parking_space", "ref": "C"},
    {"amenity": "bench"}, {"kind": "staff"}, {"label": "a\u0007b"},
]  # fmt: skip


def test_sizes_shapes_and_overlaps() -> None:
    features = [stall(*size, east=30.0 * number) for number, size in enumerate(SIZES)]
    features += [leaning(shear, 300.0 + 20 * number) for number, shear in enumerate((0.01, 1.0, 2.5, 6.0))]
    features += [stall(2.5, 5.0, 400.0 + east, label=f"O{east}") for east in (0.0, 2.24, 4.51, 6.77)]
    features += [stall(2.5, 5.0, 500.0 + 6 * k, angle=0.4 * k, label=f"T{k}") for k in range(8)]
    features += [stall(2.5, 5.0, 20_400.0), stall(2.5, 5.0, 20_100.0)]
    check_values(HERE / "sizes.json", found(geojson(features)), digits=None)


def test_labels_kinds_and_features() -> None:
    features = [stall(2.5, 5.0, 3.0 * number, **facts) for number, facts in enumerate(FACTS)]
    files = {
        "as they are": found(geojson(features)),
        "by a property": found(geojson(features), label="kind"),
        "by one that none has": found(geojson(features), label="nowhere"),
        "system": found(geojson(numbered(2), crs={"properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}})),
        "another system": found(geojson(numbered(2)), crs="EPSG:28992"),
        "zip": found(archive(plan__geojson=geojson(numbered(3)), readme__txt=b"hello")),
    }  # fmt: skip
    check_values(HERE / "labels.json", files, digits=None)


@pytest.mark.slow
def test_drawings_of_every_kind(tmp_path: Path) -> None:
    def draw(document: Any, space: Any) -> None:
        document.layers.add("STALLS")
        document.layers.add("Trees")
        for number, ring in enumerate(row(4)):
            space.add_lwpolyline(closed(ring), close=True, dxfattribs={"layer": "STALLS"})
            space.add_text(f"N {number}", dxfattribs={"insert": (2.5 * number, 0.0), "layer": "STALLS"})
        space.add_lwpolyline([(0, 20), (9, 20), (9, 29)], close=True, dxfattribs={"layer": "Trees"})
        space.add_lwpolyline([(0, 40), (2.5, 40), (2.5, 45), (0, 45)], dxfattribs={"layer": "Trees"})
        space.add_circle((50, 50), 3.0)

    shapes = [(shapely.Polygon(np.array(degrees(ring))), f"G{k}") for k, ring in enumerate(row(3))]
    facts = {"amenity": "parking_space", "name": "x"}
    drawn = [outline(k, ring, ref=f"W {k}", **facts) for k, ring in enumerate(row(3, north=8.0), 1)]
    files = {
        "dxf": found(dxf(draw)),
        "dxf, a layer": found(dxf(draw), layer="STALLS"),
        "dxf, no such layer": found(dxf(draw), layer="Stalls"),
        "dxf in feet": found(dxf(draw, units=2)),
        "dxf without units": found(dxf(draw, units=0)),
        "dxf in named units": found(dxf(draw, units=0), units="m"),
        "osm": found(osm(*drawn)),
        "gpkg": found(geopackage(tmp_path, shapes)),
        "gpkg, another layer": found(geopackage(tmp_path, shapes), layer="roads"),
        "gpkg of metres": found(geopackage(tmp_path, shapes, srs=28992)),
    }  # fmt: skip
    check_values(HERE / "kinds.json", files, digits=None)
