"""Sections of a survey as files and as curb zones: one set of columns, and no state that is too old."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely

from hawk.exports.feeds import cds_zones, valid_at
from hawk.exports.files import export
from hawk.exports.formats import kind_of
from hawk.exports.geopackage import surveys_gpkg
from hawk.exports.section_files import COLUMNS, sections_csv, sections_geojson
from hawk.exports.values import ExportRecord
from hawk.lots.plan.queries import sections_of
from hawk.lots.plan_files.formats import read_plan
from hawk.lots.plan_files.values import Asked
from hawk.lots.plan_import.choices import asked_of
from hawk.lots.plan_import.previews import preview
from hawk.lots.registration.frames import frame_of
from hawk.lots.survey.pictures import PictureFolder
from tests.unit.exports.stored import Stored
from tests.unit.lots.repaints import flown

KERB = {"do": "draw_section", "kind": "across", "outline": [[-3.0, -1.3], [-3.0, 23.7], [3.0, 23.7], [3.0, -1.3]]}


@pytest.fixture
def survey(stored: Stored) -> ExportRecord:
    stored.edit({**KERB, "name": "Elm Street, north", "capacity": 9, "note": "permit"})
    return stored.read(stored.add(flown(2)).survey)


@pytest.mark.slow
def test_table_and_map_have_the_columns_of_the_geopackage(survey: ExportRecord) -> None:
    (look,) = (each.look for each in survey.sections)
    (row,) = csv.DictReader(io.StringIO(sections_csv(survey).decode()))
    (feature,) = json.loads(sections_geojson(survey))["features"]
    assert [*row] == [*feature["properties"]] == [*COLUMNS]
    assert (row["name"], row["capacity"], row["capacity_given"], row["note"]) == (
        "Elm Street, north", "9", "yes", "permit",
    )  # fmt: skip
    assert (int(row["parked"]), int(row["least"]), int(row["most"])) == (look.parked, look.least, look.most)
    assert feature["properties"]["occupancy"] == look.occupancy
    ring = shapely.geometry.shape(feature["geometry"]).exterior
    assert ring.is_ccw
    assert feature["id"] == row["section_id"]


@pytest.mark.slow
def test_a_survey_without_sections_is_a_head_alone(survey: ExportRecord) -> None:
    none = replace(survey, sections=())
    assert sections_csv(none).decode().strip() == ",".join(COLUMNS)
    assert json.loads(sections_geojson(none))["features"] == []


@pytest.mark.slow
def test_the_name_of_a_file_says_that_it_holds_sections(stored: Stored, survey: ExportRecord, tmp_path: Path) -> None:
    assert [kind_of(name) for name in ("sections.csv", "May.Sections.GeoJSON", "may-sections.csv", "a.tif", "b")] == [
        ".sections.csv", ".sections.geojson", ".csv", ".tif", "",
    ]  # fmt: skip
    with stored.store.reading() as connection:
        (written,) = export(connection, survey.survey, PictureFolder(tmp_path), tmp_path / "sections.csv")
    assert b"Elm Street" in written.read_bytes()


@pytest.mark.slow
def test_a_section_is_a_curb_zone_with_the_room_in_it(survey: ExportRecord) -> None:
    (seen,) = survey.sections
    at = seen.look.observed.timestamp()
    survey = replace(survey, sections=(replace(seen, look=seen.look.model_copy(update={"room": 3})),))
    (zone,) = cds_zones(valid_at(survey, at + 60, 3600))["data"]["zones"]
    required = {"curb_zone_id", "geometry", "curb_policy_ids", "published_date", "last_updated_date", "start_date"}
    assert required <= zone.keys()
    assert (zone["curb_zone_id"], zone["num_spaces"], zone["parking_angle"]) == (seen.section.id, 9, "perpendicular")
    assert zone["available_space_lengths"] == [250, 250, 250]
    assert zone["availability_time"] == round(at * 1000)
    for late in (valid_at(survey, at + 7200, 3600), valid_at(replace(survey, time_is_sure=False), at + 60, 3600)):
        (zone,) = cds_zones(late)["data"]["zones"]
        assert not {"available_space_lengths", "availability_time"} & zone.keys()


@pytest.mark.slow
@pytest.mark.parametrize("form", ["geojson", "gpkg"])
def test_exported_sections_are_imported_as_they_were(stored: Stored, survey: ExportRecord, form: str) -> None:
    """Into the same lot nothing changes; into a new one they are the same but for their ids."""
    bent = {"line": [[-2.0, 0.0], [-1.0, 10.0], [-2.0, 20.0]], "side": "left", "width": 1.1}
    stored.edit({"do": "draw_section", "name": "Élan 7", "kind": "parallel", "place_m": 6.0, **bent})
    stored.edit({"do": "draw_section", "name": "Yard", "outline": [[-2, 1], [-2, 8], [2, 8]], "note": "staff"})
    survey = stored.read(stored.add(flown(2)).survey)
    data = sections_geojson(survey) if form == "geojson" else surveys_gpkg([survey, survey])
    plan = read_plan(data, Asked(layer="" if form == "geojson" else "sections"))
    with stored.store.reading() as connection:
        same = preview(connection, survey.lot_id, plan, asked_of({}, ()), None)
        new = preview(connection, None, plan, asked_of({}, ()), None)
        present = sections_of(connection, survey.lot_id)
    assert same.matched.draft.is_empty
    assert same.matched.same_sections == len(present) == 3
    move = frame_of(survey.origin, new.placement.datum)
    for was, found in zip(present, sorted(new.matched.draft.begun_sections, key=lambda each: each.name), strict=True):
        assert replace(found, id=was.id, key=was.key, outline=was.outline) == was
        there = shapely.Polygon(move.of(np.array(found.outline)))
        assert there.symmetric_difference(shapely.Polygon(was.outline)).area < 0.05
