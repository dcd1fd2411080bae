"""Outlines of lots from files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, Polygon

from hawk.picture.orthophoto.outline import LotOutline, read_outline
from hawk.picture.orthophoto.source import open_orthophoto
from hawk.picture.values import PictureError
from tests.unit.lots.plan_files.files import geopackage
from tests.unit.picture.orthophoto.drawn import HERE, blank

LOT = shapely.box(5.199, 52.099, 5.201, 52.101)
"""A square about `HERE`, (longitude, latitude)."""
HOLE = shapely.box(5.1998, 52.0998, 5.2002, 52.1002)
OTHER = shapely.box(6.0, 51.0, 6.001, 51.001)


def features(*given: tuple[shapely.Geometry, dict[str, Any]], **more: Any) -> str:
    found = [
        {"type": "Feature", "geometry": json.loads(shapely.to_geojson(shape)), "properties": facts}
        for shape, facts in given
    ]
    return json.dumps({"type": "FeatureCollection", "features": found, **more})


def same(outline: LotOutline, *expected: Polygon) -> bool:
    pairs = zip(outline.shapes, expected, strict=True)
    return all(one.symmetric_difference(other).area < 1e-12 for one, other in pairs)


@pytest.mark.parametrize(
    "content",
    [
        features((LOT, {}), crs="EPSG:4326"),
        features((LOT, {}), crs=None),
        features((LOT, {})).replace('"properties": {}', '"properties": null'),
        json.dumps({"elements": [
            {"type": "way", "id": 1, "tags": None, "geometry": None, "members": None, "nodes": None},
            {"type": "way", "id": 2, "tags": {"amenity": "parking"},
             "geometry": [{"lon": x, "lat": y} for x, y in LOT.exterior.coords]},
        ]}),
    ],
)  # fmt: skip
def test_what_is_left_empty_or_written_shortly_is_read(tmp_path: Path, content: str) -> None:
    path = tmp_path / "lots.json"
    path.write_text(content)
    assert same(read_outline(path), LOT)


@pytest.mark.parametrize(
    "content",
    [
        features((LOT, {}), crs={"type": "name", "properties": None}),
        features((LOT, {}), crs={"type": "name", "properties": {"name": 4326}}),
        features((LOT, {}), crs=4326),
        '{"elements": null}',
        '{"elements": 7}',
        '{"elements": [{"type": "way", "id": 1, "tags": 3, "geometry": [{"lon": 1}]}]}',
    ],
)
def test_a_value_of_another_kind_is_refused_with_the_file_and_the_remedy(tmp_path: Path, content: str) -> None:
    path = tmp_path / "lots.json"
    path.write_text(content)
    with pytest.raises(PictureError, match=r"lots\.json: .*(damaged|holds no area|has no name)"):
        read_outline(path)


def test_areas_of_geojson_are_lots_and_other_shapes_are_not(tmp_path: Path) -> None:
    path = tmp_path / "lots.geojson"
    path.write_text(features((LOT.difference(HOLE), {}), (shapely.Point(5, 52), {}), (MultiPolygon([OTHER]), {})))
    assert same(read_outline(path), LOT.difference(HOLE), OTHER)


def test_of_many_amenities_parking_above_the_ground_counts(tmp_path: Path) -> None:
    path = tmp_path / "osm.geojson"
    path.write_text(
        features(
            (OTHER, {"amenity": "school"}),
            (LOT, {"amenity": "parking"}),
            (HOLE, {"amenity": "parking", "parking": "underground"}),
            (HOLE, {}),
        )
    )
    assert same(read_outline(path), LOT)


def test_another_system_of_geojson_is_brought_to_wgs_84(tmp_path: Path) -> None:
    path = tmp_path / "rd.geojson"
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::28992"}}
    path.write_text(features((shapely.box(155_000, 463_000, 155_100, 463_100), {}), crs=crs))
    (lot,) = read_outline(path).shapes
    assert (lot.centroid.x, lot.centroid.y) == pytest.approx((5.3879, 52.1556), abs=1e-3)


@pytest.mark.slow
def test_a_geopackage_is_read_by_its_layers(tmp_path: Path) -> None:
    rows = [(LOT, "parking"), (OTHER, "school"), (None, "parking")]
    path = tmp_path / "lots.gpkg"
    path.write_bytes(geopackage(tmp_path, rows, column="amenity"))
    assert same(read_outline(path), LOT)


def ring_of(shape: Polygon, first: int) -> dict[int, tuple[float, float]]:
    return {first + k: (x, y) for k, (x, y) in enumerate(shape.exterior.coords[:-1])}


def test_openstreetmap_has_outlines_and_relations_with_holes(tmp_path: Path) -> None:
    outer, inner, other = ring_of(LOT, 1), ring_of(HOLE, 11), ring_of(OTHER, 21)
    nodes = {**outer, **inner, **other}
    lines = {31: [1, 2, 3], 32: [3, 4, 1], 33: [11, 12, 13, 14, 11], 34: [21, 22, 23, 24, 21]}
    members = [(31, "outer"), (32, "outer"), (33, "inner")]
    tag = '<tag k="amenity" v="parking"/>'
    xml = "".join(f'<node id="{number}" lon="{x!r}" lat="{y!r}"/>' for number, (x, y) in nodes.items())
    for number, refs in lines.items():
        xml += f'<way id="{number}">{"".join(f"""<nd ref="{ref}"/>""" for ref in refs)}{tag * (number == 34)}</way>'
    xml += '<relation id="41">' + "".join(f'<member type="way" ref="{ref}" role="{role}"/>' for ref, role in members)
    path = tmp_path / "map.osm"
    path.write_text(f"<?xml version='1.0'?><osm version=\"0.6\">{xml}{tag}</relation></osm>")
    assert same(read_outline(path), OTHER, LOT.difference(HOLE))
    tags = {"amenity": "parking"}
    elements = [
        *({"type": "node", "id": number, "lon": x, "lat": y} for number, (x, y) in nodes.items()),
        *({"type": "way", "id": n, "nodes": refs, "tags": tags if n == 34 else {}} for n, refs in lines.items()),
        {"type": "relation", "id": 41, "tags": tags,
         "members": [{"type": "way", "ref": ref, "role": role} for ref, role in members]},
    ]  # fmt: skip
    path.write_text(json.dumps({"elements": elements}))
    assert same(read_outline(path), OTHER, LOT.difference(HOLE))
    with_geometry = [
        {"type": "way", "id": 34, "tags": tags, "geometry": [{"lon": x, "lat": y} for x, y in OTHER.exterior.coords]},
        {"type": "relation", "id": 41, "tags": tags, "members": [
            {"type": "way", "ref": ref, "role": role,
             "geometry": [{"lon": nodes[n][0], "lat": nodes[n][1]} for n in lines[ref]]} for ref, role in members]},
    ]  # fmt: skip
    path.write_text(json.dumps({"elements": with_geometry}))
    assert same(read_outline(path), OTHER, LOT.difference(HOLE))


def test_kml_is_read_too(tmp_path: Path) -> None:
    places = " ".join(f"{x!r},{y!r},0" for x, y in LOT.exterior.coords)
    path = tmp_path / "lot.kml"
    path.write_text(
        f"<kml><Placemark><Polygon><outerBoundaryIs><LinearRing><coordinates>{places}</coordinates></LinearRing>"
        "</outerBoundaryIs></Polygon></Placemark></kml>"
    )
    assert same(read_outline(path), LOT)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", r"is empty"),
        ("{", r"Expecting property name"),
        ("<html/>", r"is a page of the web: download the file itself"),
        ("<rss/>", r"XML of another kind"),
        (features((OTHER, {"amenity": "school"})), r"holds no area that is a lot"),
        (features((shapely.Point(5, 52), {})), r"holds no area that is a lot"),
        ('{"type":"Polygon","coordinates":[[[1,2]]]}', r"an area that cannot be read"),
        ("SQLite format 3\0 and no more", r"database|SQLite"),
    ],
)
def test_a_file_without_lots_is_refused_with_the_remedy(tmp_path: Path, content: str, words: str) -> None:
    path = tmp_path / "lots.txt"
    path.write_text(content)
    with pytest.raises(
        PictureError, match=rf"lots\.txt: .*({words}).*name a GeoJSON, GeoPackage or OpenStreetMap file"
    ):
        read_outline(path)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(PictureError, match=r"none\.geojson: cannot be read \(No such file"):
        read_outline(tmp_path / "none.geojson")


BOW_TIE = Polygon([(5.199, 52.099), (5.201, 52.101), (5.201, 52.099), (5.199, 52.101)])
"""The corners of `LOT` in an order in which two sides cross."""


def test_an_outline_whose_sides_cross_is_refused_where_the_picture_shows_it(tmp_path: Path) -> None:
    grid, path = open_orthophoto(blank(tmp_path)).grid, tmp_path / "lots.geojson"
    path.write_text(features((shapely.Point(5, 52), {}), (LOT, {}), (BOW_TIE, {})))
    with pytest.raises(PictureError, match=r"feature 3, about 52\.1000, 5\.2000: its sides cross.*put its corners in"):
        read_outline(path).near(grid)
    far = shapely.transform(BOW_TIE, lambda places: places + 1)
    path.write_text(features((LOT, {}), (far, {})))
    assert same(read_outline(path).near(grid), LOT)


def test_a_sliver_of_a_digitized_outline_is_no_crossing(tmp_path: Path) -> None:
    path = tmp_path / "lots.geojson"
    sliver = Polygon([(5.199, 52.099), (5.201, 52.099), (5.201, 52.101), (5.199, 52.101), (5.19902, 52.09898)])
    assert not sliver.is_valid
    path.write_text(features((sliver, {})))
    assert read_outline(path).crossed == ()


def test_coordinates_that_are_no_degrees_are_refused_with_what_to_save(tmp_path: Path) -> None:
    path = tmp_path / "lots.geojson"
    path.write_text(features((shapely.box(0, 0, 900, 900), {})))
    with pytest.raises(PictureError, match=r"lots\.geojson: the coordinates are no degrees \(900, 0\): save the file"):
        read_outline(path)


def test_latitude_and_longitude_that_are_exchanged_are_called_so(tmp_path: Path) -> None:
    path = tmp_path / "lots.geojson"
    path.write_text(features((shapely.box(49.2498, -122.95, 49.2508, -122.94), {})))
    with pytest.raises(
        PictureError, match=r"lots\.geojson: latitude and longitude are exchanged \(49\.2508, -122\.95\):"
    ):
        read_outline(path)
    path.write_text(features((shapely.transform(LOT, lambda places: places[:, ::-1]), {})))
    with pytest.raises(PictureError, match="latitude and longitude are exchanged"):
        read_outline(path).near(open_orthophoto(blank(tmp_path)).grid)


def test_only_lots_in_the_picture_are_kept(tmp_path: Path) -> None:
    grid = open_orthophoto(blank(tmp_path)).grid
    assert LotOutline.of(OTHER, LOT).near(grid).shapes == (LOT,)
    with pytest.raises(PictureError, match=r"it is about 52\.1000, 5\.2000, they are about 51\.0005, 6\.0005 \("):
        LotOutline.of(OTHER).near(grid)
    (plane,) = LotOutline.of(LOT).in_metres(grid)
    assert plane.area == pytest.approx(137.0 * 222.5, rel=0.01)
    assert plane.contains(shapely.Point(*np.multiply((30, 20), grid.metres)))


def test_the_store_gets_rings_of_latitude_and_longitude() -> None:
    outline = LotOutline.of(LOT.difference(HOLE)).outline()
    assert (len(outline.polygons), len(outline.holes)) == (1, 1)
    assert np.mean(outline.polygons[0], axis=0) == pytest.approx(HERE)


def test_a_coordinate_of_openstreetmap_that_is_no_number_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "osm.json"
    way = {"type": "way", "id": 1, "tags": {"amenity": "parking"}, "geometry": [{"lon": 5.2, "lat": "north"}]}
    path.write_text(json.dumps({"elements": [way]}))
    with pytest.raises(PictureError, match=r"osm\.json: elements: are damaged .*'north'.*; name a GeoJSON"):
        read_outline(path)


def facts(path: Path) -> list[tuple[str, str, dict[str, str]]]:
    """Return id, name and tags of each lot of a file."""
    return [(lot.facts.id, lot.facts.name, dict(lot.facts.tags)) for lot in read_outline(path).lots]


@pytest.mark.nightly
def test_names_ids_and_tags_are_read_of_every_format(tmp_path: Path) -> None:
    ring = [{"lon": x, "lat": y} for x, y in LOT.exterior.coords]
    tags = {"amenity": "parking", "ref": "P 7", "capacity": "20"}
    path = tmp_path / "lots.json"
    path.write_text(json.dumps({"elements": [{"type": "way", "id": 12, "tags": tags, "geometry": ring}]}))
    assert facts(path) == [("way/12", "P 7", tags)]
    path.write_text(features((LOT, {"Name": "North", "id": 7.0, "fee": True, "of": None, "list": [1]})))
    assert facts(path) == [("7", "North", {"fee": "yes"})]
    polygons = "".join(
        "<Polygon><outerBoundaryIs><LinearRing><coordinates>"
        + " ".join(f"{x!r},{y!r}" for x, y in shape.exterior.coords)
        + "</coordinates></LinearRing></outerBoundaryIs></Polygon>"
        for shape in (LOT, OTHER)
    )
    data = '<ExtendedData><Data name="Access"><value>permit</value></Data></ExtendedData>'
    path = tmp_path / "lots.kml"
    path.write_text(
        f'<kml><Placemark id="k1"><name>Both</name>{data}<MultiGeometry>{polygons}</MultiGeometry></Placemark></kml>'
    )
    assert facts(path) == [("k1", "Both", {"access": "permit"})]
    assert same(LotOutline.of(*read_outline(path).shapes[0].geoms), LOT, OTHER)
    path = tmp_path / "lots.gpkg"
    path.write_bytes(geopackage(tmp_path, [(LOT, "North"), (None, "Gone")], column="name"))
    assert [name for _, name, _ in facts(path)] == ["North"]
    assert read_outline(path).notes == ("Feature 2 (Gone) has no ground, and is no lot: draw it, or delete it.",)


def test_a_lot_without_an_id_has_one_by_its_name_and_place_in_any_file(tmp_path: Path) -> None:
    one, other = tmp_path / "one.geojson", tmp_path / "other.geojson"
    one.write_text(features((LOT, {"name": "A"}), (OTHER, {}), (HOLE, {"name": "A"})))
    moved = shapely.transform(LOT, lambda places: places + 1e-8)
    other.write_text(features((HOLE, {"name": "A"}), (OTHER, {"fee": "no"}), (moved, {"name": "A"})))
    assert sorted(known for known, *_ in facts(one)) == sorted(known for known, *_ in facts(other))
    assert len({known for known, *_ in facts(one)}) == 3
    assert [name for _, name, _ in facts(one)] == ["A", "A", "Lot 2"]
