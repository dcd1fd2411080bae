"""Files as the field writes them (`field_inputs`): every reader of areas takes them, or says what is wrong."""

from __future__ import annotations

import json
import sqlite3
from pathlib import Path

import numpy as np
import pytest
import shapely

from hawk.config.loader import load_config
from hawk.ddc.fence.geojson import read_fence, read_survey_outline
from hawk.formats.area_file import read_areas
from hawk.lots.values import LotInputError
from hawk.picture.orthophoto.outline import read_outline
from tests.unit.lots.plan_files.files import degrees, feature, geopackage, labels, left_out, plan, row

INPUTS = Path(__file__).parent / "field_inputs"
WHERE = {"nearly_closed.geojson": (4.5, 52.0), "collection.geojson": (4.5, 52.0)}


def given(name: str) -> bytes:
    return (INPUTS / name).read_bytes()


@pytest.mark.parametrize("name", WHERE)
def test_what_the_fence_takes_every_reader_of_areas_takes(name: str) -> None:
    assert len(read_fence(INPUTS / name).ring) == 4
    assert len(read_survey_outline(INPUTS / name).polygons[0]) == 4
    (lot,) = read_outline(INPUTS / name).shapes
    assert (lot.centroid.x, lot.centroid.y) == pytest.approx(WHERE[name], abs=1e-3)
    assert lot.area == pytest.approx(4e-6, rel=1e-3)
    with pytest.raises(LotInputError, match=r"features\[0\]: is \d+\.\d+ by \d+\.\d+ m: a stall is"):
        plan(given(name))  # it is read, and far too large for a stall


def _mark(text: str, kind: str) -> bytes:
    return text.encode({"mark": "utf-8-sig", "utf-16": "utf-16", "crlf": "utf-8"}[kind])


STALLS = [feature([degrees(ring)], label=f"P{k}") for k, ring in enumerate(row(3), 1)]


@pytest.mark.parametrize("kind", ["mark", "utf-16", "crlf"])
@pytest.mark.parametrize("form", ["collection", "lines", "sequence"])
def test_marks_and_features_of_a_line_each_are_read_by_every_reader(tmp_path: Path, kind: str, form: str) -> None:
    lines = [json.dumps(each) for each in STALLS]
    whole = json.dumps({"type": "FeatureCollection", "features": STALLS})
    end = "\r\n" if kind == "crlf" else "\n"
    text = {"collection": whole, "lines": end.join(lines) + end, "sequence": "".join(f"\x1e{x}{end}" for x in lines)}
    data = _mark(text[form], kind)
    assert labels(plan(data)) == ["P1", "P2", "P3"]
    path = tmp_path / "areas.geojson"
    path.write_bytes(data)
    assert len(read_outline(path).lots) == 3
    assert [len(area.outer) for area in read_areas(data).areas] == [4, 4, 4]


def test_settings_may_begin_with_a_byte_order_mark() -> None:
    assert load_config(INPUTS / "bom.toml", {}).web.port == 0


def test_stalls_with_arcs_are_read() -> None:
    found = plan(given("arcs.gpkg"))
    assert labels(found) == [str(number) for number in range(1, 11)]
    assert np.ptp(found.shapes()[:, 3:], axis=0).max() < 0.01
    assert found.left_out_count == 0


@pytest.mark.nightly
def test_an_outline_of_a_curves_type_is_read_with_its_straight_sides() -> None:
    (lot,) = read_outline(INPUTS / "curve_outline.gpkg").shapes
    assert (lot.centroid.x, lot.centroid.y) == pytest.approx((-79.9188, 43.2597), abs=1e-3)


@pytest.mark.nightly
def test_what_a_program_has_not_put_into_its_geopackage_yet_is_read(tmp_path: Path) -> None:
    lot, newer = shapely.box(5.199, 52.099, 5.201, 52.101), shapely.box(5.3, 52.0, 5.301, 52.001)
    path = tmp_path / "open.gpkg"
    path.write_bytes(geopackage(tmp_path, [(lot, "parking")], column="amenity"))
    opened = sqlite3.connect(path)
    opened.execute("PRAGMA journal_mode = WAL")
    opened.execute("UPDATE stalls SET geom = ?", (b"GP\x00\x01" + (4326).to_bytes(4, "little") + newer.wkb,))
    opened.commit()
    (found,) = read_outline(path).shapes
    opened.close()
    assert found.equals(newer)


@pytest.mark.slow
def test_layers_that_a_drawing_freezes_or_switches_off_are_none() -> None:
    found = plan(given("frozen_layer.dxf"))
    assert len(found.stalls) == 10
    assert found.layers == (("STALLS", 10),)
    assert left_out(found) == ["layer OLD: 10 polylines on it are frozen or off: thaw it, if they are stalls"]


def test_a_drawing_whose_unit_does_not_fit_its_stalls_asks_for_it() -> None:
    with pytest.raises(LotInputError, match=r"units: .* by m they are stalls: write m$") as refused:
        plan(given("metres_said_inches.dxf"))
    assert refused.value.field == "units"
    assert len(plan(given("metres_said_inches.dxf"), units="m").stalls) == 10


KML = """<?xml version="1.0" encoding="UTF-8"?><kml xmlns="http://www.opengis.net/kml/2.2"><Document><Folder>{}
</Folder></Document></kml>"""
PLACED = (
    "<Placemark><name>{}</name><Polygon><outerBoundaryIs><LinearRing><coordinates>{}</coordinates></LinearRing>"
    "</outerBoundaryIs></Polygon></Placemark>"
)


def test_a_plan_of_google_earth_is_read_with_its_names() -> None:
    rings = [" ".join(f"{x!r},{y!r},0" for x, y in degrees(ring)) for ring in row(3)]
    text = KML.format("".join(PLACED.format(f"A{k}", ring) for k, ring in enumerate(rings)))
    assert labels(plan(text.encode())) == ["A0", "A1", "A2"]
    grown = text.replace("<kml", '<!DOCTYPE kml [<!ENTITY a "aaaa">]><kml', 1).replace("A0", "&a;")
    with pytest.raises(LotInputError, match="has definitions of its own"):
        plan(grown.encode())


def test_what_an_editor_marks_as_deleted_is_neither_stall_nor_lot(tmp_path: Path) -> None:
    nodes = "".join(f'<node id="-{k}" lat="{y!r}" lon="{x!r}"/>' for k, (x, y) in enumerate(degrees(row(1)[0])[:4], 1))
    refs = "".join(f'<nd ref="-{k}"/>' for k in (1, 2, 3, 4, 1))
    tag = '<tag k="amenity" v="{}"/>'
    drawn = '<way id="-{}"{}>' + refs + tag + "</way>"
    both = drawn.format(8, "", "parking") + drawn.format(9, ' action="delete"', "parking")
    path = tmp_path / "josm.osm"
    path.write_text(f'<osm version="0.6">{nodes}{both}</osm>')
    assert len(read_outline(path).lots) == 1
    stalls = both.replace('v="parking"', 'v="parking_space"')
    assert len(plan(f'<osm version="0.6">{nodes}{stalls}</osm>'.encode()).stalls) == 1
