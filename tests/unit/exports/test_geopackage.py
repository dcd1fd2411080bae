"""A survey as GeoPackage, read back by SQLite."""

from __future__ import annotations

import sqlite3
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import shapely

from hawk.exports.geopackage import surveys_gpkg
from hawk.exports.records import read_surveys
from hawk.exports.values import Observation
from hawk.model.plans import Outline
from tests.unit.exports.stored import NAME, Stored
from tests.unit.lots.repaints import flown


def rows(data: bytes, path: Path, query: str) -> list[Any]:
    path.write_bytes(data)
    connection = sqlite3.connect(path)
    try:
        return connection.execute(query).fetchall()
    finally:
        connection.close()


@pytest.mark.slow
def test_the_file_says_that_it_is_a_geopackage_with_three_tables(stored: Stored, tmp_path: Path) -> None:
    data, file = surveys_gpkg([stored.read()]), tmp_path / "a.gpkg"
    assert rows(data, file, "PRAGMA application_id") == [(0x47504B47,)]
    assert rows(data, file, "PRAGMA user_version") == [(10300,)]
    contents = rows(data, file, "SELECT table_name, data_type, srs_id FROM gpkg_contents")
    assert contents == [("lots", "features", 4326), ("stalls", "features", 4326), ("surveys", "attributes", 0)]
    assert rows(data, file, "PRAGMA integrity_check") == [("ok",)]


@pytest.mark.nightly
def test_geometries_are_the_stalls_of_the_survey(stored: Stored, tmp_path: Path) -> None:
    survey = stored.read()
    found = rows(surveys_gpkg([survey]), tmp_path / "a.gpkg", "SELECT stall_id, kind, state, geom FROM stalls")
    assert len(found) == 60
    for (key, kind, state, blob), stall in zip(found, survey.stalls, strict=True):
        assert (key, kind, state) == (stall.id, stall.kind or "normal", stall.state)
        assert blob[:8] == b"GP\x00\x01" + (4326).to_bytes(4, "little")
        shape = shapely.from_wkb(blob[8:])
        assert shape.exterior.coords[0][::-1] == pytest.approx(stall.corners[0], abs=1e-12)
    low_x, low_y = rows(surveys_gpkg([survey]), tmp_path / "a.gpkg", "SELECT min_x, min_y FROM gpkg_contents")[1]
    assert low_x == pytest.approx(min(b for stall in survey.stalls for _, b in stall.corners))
    assert low_y == pytest.approx(min(a for stall in survey.stalls for a, _ in stall.corners))


@pytest.mark.slow
def test_surveys_of_one_lot_share_it_and_are_distinguished(stored: Stored, tmp_path: Path) -> None:
    both = [replace(stored.read(), lot=NAME), replace(stored.read(stored.add(flown(2)).survey), lot=NAME)]
    data, file = surveys_gpkg(both), tmp_path / "a.gpkg"
    assert rows(data, file, "SELECT name FROM lots") == [(NAME,)]
    assert rows(data, file, "SELECT survey_id, count(*) FROM stalls GROUP BY survey_id") == sorted(
        (survey.survey, 60) for survey in both
    )
    assert [row[0] for row in rows(data, file, "SELECT survey_id FROM surveys")] == [each.survey for each in both]


@pytest.mark.slow
def test_stalls_of_surveys_that_share_a_layout_lie_where_each_survey_has_them(stored: Stored, tmp_path: Path) -> None:
    ids = [stored.first.survey, stored.add(flown(2)).survey, stored.first.survey]
    with stored.store.reading() as connection:
        surveys = read_surveys(connection, ids)
    moved = replace(surveys[2], survey="moved", stalls=tuple(_north(stall) for stall in surveys[2].stalls))
    asked = "SELECT survey_id, stall_id, geom FROM stalls"
    found = rows(surveys_gpkg([*surveys[:2], moved]), tmp_path / "a.gpkg", asked)
    wanted = [(each.survey, stall) for each in (*surveys[:2], moved) for stall in each.stalls]
    assert len(found) == 180
    for (survey, key, blob), (named, stall) in zip(found, wanted, strict=True):
        assert (survey, key) == (named, stall.id)
        assert shapely.from_wkb(blob[8:]).exterior.coords[0][::-1] == pytest.approx(stall.corners[0], abs=1e-12)


def _north(stall: Observation) -> Observation:
    return replace(stall, corners=tuple((latitude + 0.001, longitude) for latitude, longitude in stall.corners))


@pytest.mark.slow
def test_a_lot_without_an_outline_and_a_survey_of_nothing_are_files_too(stored: Stored, tmp_path: Path) -> None:
    empty = replace(stored.read(), outline=Outline(), stalls=())
    data = surveys_gpkg([empty])
    assert rows(data, tmp_path / "a.gpkg", "SELECT min_x FROM gpkg_contents") == [(None,), (None,), (None,)]
    assert rows(surveys_gpkg([]), tmp_path / "b.gpkg", "SELECT count(*) FROM stalls") == [(0,)]


@pytest.mark.slow
def test_sections_are_a_layer_of_their_own_with_the_look_of_each_survey(stored: Stored, tmp_path: Path) -> None:
    assert stored.read().sections == ()
    ring = [[-3.0, -1.3], [-3.0, 23.7], [3.0, 23.7], [3.0, -1.3]]
    section = {"do": "draw_section", "name": NAME, "outline": ring, "kind": "across", "note": "permit"}
    stored.edit(section)
    survey = stored.read()
    (seen,) = survey.sections
    inside = sum(stall.state == "taken" and stall.label.startswith("A ") for stall in survey.stalls[:10])
    asked = (
        "SELECT name, kind, note, capacity, capacity_given, source, parked, occupancy, geom, survey_id FROM sections"
    )
    ((*values, blob, by),) = rows(surveys_gpkg([survey]), tmp_path / "a.gpkg", asked)
    assert values == [NAME, "across", "permit", 10, 0, "stalls", inside, inside / 10]
    assert by == survey.survey
    shape = shapely.from_wkb(blob[8:])
    assert shape.exterior.coords[0][::-1] == pytest.approx(seen.ring[0], abs=1e-12)
