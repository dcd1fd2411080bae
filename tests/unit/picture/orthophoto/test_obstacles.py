"""Roads and buildings of a file of outlines: read from each format, and what stands on them is not counted."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from hawk.lots.plan_files.osm import OUTLINE
from hawk.picture.orthophoto.lots import SurveysByLot
from hawk.picture.orthophoto.obstacles import AISLE_M, read_obstacles, road_width
from hawk.picture.orthophoto.outline import LotOutline, read_outline
from hawk.picture.orthophoto.source import Orthophoto
from hawk.picture.orthophoto.survey import Findings, without_obstacles
from hawk.picture.orthophoto.tile_detector import TileVehicles
from hawk.picture.orthophoto.windows import windows_of
from hawk.picture.values import PictureError
from tests.unit.picture.orthophoto.drawn import UTM, opened_blank, placed
from tests.unit.picture.orthophoto.test_lots import COLUMNS, ROWS, part, result

Json = dict[str, Any]


@pytest.fixture
def source(tmp_path: Path) -> Orthophoto:
    return opened_blank(tmp_path, ROWS, COLUMNS, transform=placed(UTM, COLUMNS, ROWS))


def line(source: Orthophoto, *places: tuple[float, float]) -> shapely.LineString:
    return shapely.LineString(source.grid.on_earth(np.array(places))[:, ::-1])


def feature(shape: shapely.Geometry, **facts: str) -> Json:
    return {"type": "Feature", "geometry": json.loads(shapely.to_geojson(shape)), "properties": facts}


def geojson(folder: Path, *features: Json) -> Path:
    path = folder / "lots.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return path


@pytest.mark.parametrize(
    ("facts", "width"),
    [
        ({"highway": "residential"}, 4.75),
        ({"highway": "residential", "oneway": "yes"}, 3.0),
        ({"highway": "primary", "oneway": "yes"}, 6.5),
        ({"highway": "residential", "width": "9", "parking:both": "lane"}, 5.0),
        ({"highway": "residential", "width": "9 m", "parking:left": "half_on_kerb"}, 8.0),
        ({"highway": "residential", "width": "5", "parking:both": "lane"}, 2.5),
        ({"highway": "residential", "width": "wide"}, 4.75),
        ({"highway": "service", "service": "parking_aisle", "width": "12"}, AISLE_M),
        ({"highway": "footway"}, None),
        ({"highway": "residential", "tunnel": "yes"}, None),
        ({"highway": "service", "area": "yes"}, None),
        ({"building": "yes"}, None),
    ],
)
def test_the_width_is_the_road_s_own_without_parked_vehicles_or_that_of_its_class(
    facts: Json, width: float | None
) -> None:
    assert road_width(facts) == width


def osm_xml(source: Orthophoto) -> str:
    nodes, outlines = [], []
    shapes = [
        (part(source, 0, 0, 600, 400), {"amenity": "parking", "name": "Whole"}),
        (line(source, (300, 0), (300, 400)), {"highway": "tertiary"}),
        (part(source, 380, 150, 420, 250), {"building": "retail"}),
        (part(source, 240, 150, 260, 250), {"building": "no"}),
    ]
    for number, (shape, facts) in enumerate(shapes, 1):
        places = [*(shape.exterior if isinstance(shape, shapely.Polygon) else shape).coords]
        ids = [number * 100 + each for each in range(len(places))]
        if isinstance(shape, shapely.Polygon):
            ids[-1] = ids[0]
        nodes += [f'<node id="{k}" lon="{x}" lat="{y}"/>' for k, (x, y) in zip(ids, places, strict=True)]
        inner = "".join(f'<nd ref="{each}"/>' for each in ids)
        inner += "".join(f'<tag k="{key}" v="{value}"/>' for key, value in facts.items())
        outlines.append(f'<{OUTLINE} id="{number}">{inner}</{OUTLINE}>')
    return f'<osm version="0.6">{"".join(nodes)}{"".join(outlines)}</osm>'


def osm_json(source: Orthophoto) -> str:
    shapes = [
        (part(source, 0, 0, 600, 400).exterior, {"amenity": "parking", "name": "Whole"}),
        (line(source, (300, 0), (300, 400)), {"highway": "tertiary"}),
        (part(source, 380, 150, 420, 250).exterior, {"building": "retail"}),
    ]
    elements = [
        {"type": OUTLINE, "id": number, "tags": facts, "geometry": [{"lon": x, "lat": y} for x, y in shape.coords]}
        for number, (shape, facts) in enumerate(shapes, 1)
    ]
    return json.dumps({"elements": elements})


def counted(source: Orthophoto, outline: LotOutline) -> tuple[Findings, tuple[str, ...]]:
    """Stalls at 250, 300, 330 and 400 pixels, a vehicle on each."""
    middles = [(250.0, 200.0), (300.0, 200.0), (330.0, 200.0), (400.0, 200.0)]
    (window,) = windows_of(source)
    findings = Findings.of(source, [result(window, middles, [0.95, 0.9, 0.05, 0.6])])
    corners = findings.stalls.corners
    vehicles = TileVehicles(corners, np.full(4, 0.9), np.zeros(4, np.intp))
    findings = replace(findings, stalls=replace(findings.stalls, vehicles=vehicles))
    return without_obstacles(findings, outline)


@pytest.mark.parametrize("form", ["xml", "json", "geojson"])
def test_what_stands_on_a_road_or_a_building_is_not_counted_and_said_by_cause(
    source: Orthophoto, tmp_path: Path, form: str
) -> None:
    path = tmp_path / f"lots.{form}"
    if form == "geojson":
        path = geojson(
            tmp_path, feature(part(source, 0, 0, 600, 400), amenity="parking", name="Whole"),
            feature(line(source, (300, 0), (300, 400)), highway="tertiary"),
            feature(part(source, 380, 150, 420, 250), building="retail"),
        )  # fmt: skip
    else:
        path.write_text(osm_xml(source) if form == "xml" else osm_json(source))
    outline = read_outline(path).near(source.grid)
    assert [each.facts.name for each in outline.lots] == ["Whole"]
    findings, notes = counted(source, outline)
    left = findings.stalls.corners.mean(axis=1)[:, 0].round().tolist()
    assert left == [250.0], "3.3 m to both sides of the road, and the building"
    assert len(findings.stalls.vehicle_corners) == 1
    assert notes == (
        "On roads, 2 stalls and 2 vehicles of the lots are not counted.",
        "On buildings, 1 stalls and 1 vehicles of the lots are not counted.",
    )
    (survey,) = SurveysByLot(findings, outline)
    assert len(survey.mapped.survey.stalls) == 1


def test_an_aisle_takes_the_middle_alone_and_a_deck_on_a_roof_is_a_lot(source: Orthophoto, tmp_path: Path) -> None:
    path = geojson(
        tmp_path,
        feature(part(source, 320, 100, 600, 300), amenity="parking", parking="rooftop", name="Deck"),
        feature(part(source, 0, 0, 600, 400), building="retail"),
        feature(line(source, (312, 0), (312, 400)), highway="service", service="parking_aisle"),
    )
    outline = read_outline(path).near(source.grid)
    findings, _ = counted(source, outline)
    assert findings.stalls.corners.mean(axis=1)[:, 0].round().tolist() == [330.0, 400.0]


def test_what_is_left_out_beside_the_lots_is_not_reported(source: Orthophoto, tmp_path: Path) -> None:
    path = geojson(
        tmp_path, feature(part(source, 380, 100, 600, 300), amenity="parking"),
        feature(part(source, 240, 150, 260, 250), building="yes"),
    )  # fmt: skip
    findings, notes = counted(source, read_outline(path).near(source.grid))
    assert (len(findings.stalls), notes) == (3, ())


def test_outlines_without_an_amenity_are_lots_and_roads_and_buildings_among_them_are_none(
    source: Orthophoto, tmp_path: Path
) -> None:
    lot = feature(part(source, 0, 0, 300, 400), name="Yard")
    path = geojson(tmp_path, lot, feature(part(source, 300, 0, 600, 400), building="yes"))
    text = json.loads(path.read_text())
    for each in text["features"]:
        each["geometry"]["coordinates"][0].pop()  # rings that nobody closed are read too
    path.write_text(json.dumps(text))
    outline = read_outline(path)
    assert [each.facts.name for each in outline.lots] == ["Yard"]
    assert len(outline.obstacles.buildings) == 1


def test_a_road_that_cannot_be_read_is_named_with_the_remedy(source: Orthophoto, tmp_path: Path) -> None:
    lot = feature(part(source, 0, 0, 300, 400), amenity="parking")
    broken = {**lot, "geometry": {"type": "LineString", "coordinates": "x"}, "properties": {"highway": "road"}}
    with pytest.raises(PictureError, match=r"lots\.geojson: features: hold a road or building that cannot be read"):
        read_outline(geojson(tmp_path, lot, broken))


def test_elements_without_places_are_passed_over(tmp_path: Path) -> None:
    path = tmp_path / "lots.json"
    elements = [
        {"type": OUTLINE, "id": 1, "tags": {"highway": "road"}, "nodes": [1, 2]},
        {"type": OUTLINE, "id": 2, "tags": {"building": "yes"}, "geometry": [None, {"lon": None, "lat": 3}]},
        {"type": OUTLINE, "id": 3, "tags": "none"},
        {"type": "relation", "id": 4},
        7,
    ]
    path.write_text(json.dumps({"elements": elements}))
    found = read_obstacles(path)
    assert (found.roads, found.buildings) == ((), ())
