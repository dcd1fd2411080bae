"""Plans as GeoPackage."""

from __future__ import annotations

import math
import struct
from pathlib import Path

import pyproj
import pytest
import shapely
from shapely import MultiPolygon, Point, Polygon

from hawk.lots.values import LotInputError
from tests.unit.lots.plan_files.files import blob, degrees, geopackage, labels, left_out, plan, row

SHAPES = [Polygon(degrees(ring)) for ring in row(3)]
NAN = blob(SHAPES[1], 4326).replace(struct.pack("<d", SHAPES[1].exterior.coords[1][0]), struct.pack("<d", math.nan))
BOWTIE = Polygon([(5.0, 52.0), (5.0001, 52.0001), (5.0001, 52.0), (5.0, 52.0001)])


def test_polygons_of_a_layer_are_stalls(tmp_path: Path) -> None:
    rows = [(SHAPES[0], "12"), (MultiPolygon([SHAPES[1]]), "13"), (shapely.force_3d(SHAPES[2], 7.0), "")]
    found = plan(geopackage(tmp_path, rows, "GEOMETRY"))
    assert labels(found) == ["12", "13", ""]
    assert found.layers == (("stalls", 3),)
    assert found.crs == "EPSG:4326"
    assert found.left_out_count == 0


@pytest.mark.slow
def test_the_system_of_a_layer_is_read(tmp_path: Path) -> None:
    there = pyproj.Transformer.from_crs("EPSG:4326", "EPSG:28992", always_xy=True)
    moved = [Polygon([there.transform(corner[0], corner[1]) for corner in shape.exterior.coords]) for shape in SHAPES]
    found = plan(geopackage(tmp_path, [(shape, "") for shape in moved], srs=28992))
    assert found.crs == "EPSG:28992"
    assert found.datum == pytest.approx((52.0, 5.0), abs=1e-4)


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (Point(5.0, 52.0), "is a Point"),
        (MultiPolygon(SHAPES[1:]), "is a MultiPolygon"),
        (BOWTIE, "crosses itself"),
        (None, "holds none that can be read"),
        (b"GP", "holds none that can be read"),
        (b"GP\x00\x0f" + bytes(40), "holds none that can be read"),
        (blob(SHAPES[1], 4326)[:-20], "holds none that can be read"),
        (NAN, "finite numbers"),
        (Polygon(), "is empty"),
    ],
)
def test_a_row_that_is_no_stall_is_left_out_by_its_number(tmp_path: Path, bad: object, words: str) -> None:
    value = b"GP\x00\x01" + bytes(4) + shapely.to_wkb(bad) if bad in (Polygon(),) else bad
    found = plan(geopackage(tmp_path, [(SHAPES[0], "12"), (value, "13")]))
    assert labels(found) == ["12"]
    assert left_out(found)[0].startswith("stalls, row 2: ")
    assert words in left_out(found)[0]


@pytest.mark.fault("a GeoPackage has no layer of polygons", "it is refused with the layers that it has")
def test_a_file_without_a_layer_of_polygons_is_refused_with_those_that_it_has(tmp_path: Path) -> None:
    data = geopackage(tmp_path, [(Point(5.0, 52.0), "")], "POINT", table="trees")
    with pytest.raises(LotInputError, match=r"has no layer of polygons, but trees \(POINT\)"):
        plan(data)


def test_a_layer_is_chosen_by_its_name(tmp_path: Path) -> None:
    data = geopackage(tmp_path, [(SHAPES[0], "1")])
    assert labels(plan(data, layer="stalls")) == ["1"]
    with pytest.raises(LotInputError, match="layer: must be one of the layers of polygons: stalls"):
        plan(data, layer="trees")


@pytest.mark.fault("a file with a plan is cut, damaged or of another kind")
def test_a_file_that_is_cut_or_no_geopackage_is_refused(tmp_path: Path) -> None:
    data = geopackage(tmp_path, [(SHAPES[0], str(k)) for k in range(200)])
    with pytest.raises(LotInputError, match="cut or damaged"):
        plan(data[: len(data) // 2])
    with pytest.raises(LotInputError, match="cut or damaged"):
        plan(data[:200])
    other = data.replace(b"gpkg_contents", b"xxxx_contents").replace(b"gpkg_contents", b"xxxx_contents")
    with pytest.raises(LotInputError, match="required GeoPackage tables"):
        plan(other)


def test_a_name_of_a_layer_is_no_sql(tmp_path: Path) -> None:
    data = geopackage(tmp_path, [(SHAPES[0], "1")], table="a; drop table x --")
    assert labels(plan(data)) == ["1"]
