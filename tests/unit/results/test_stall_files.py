"""Stalls as files: one table and one GeoJSON, of live maps and of stored surveys."""

from __future__ import annotations

import csv
import io
import json
import math
from dataclasses import replace
from datetime import datetime, timedelta

import pytest
from shapely.geometry import shape

from hawk.exports.text_files import survey_csv, survey_geojson
from hawk.exports.values import ExportRecord, Observation
from hawk.model.plans import Outline
from hawk.results.map_picture import map_picture
from hawk.results.stall_files import CSV_COLUMNS, map_csv, map_geojson
from hawk.results.survey_map import Made, SurveyMap, recorded_geojson
from tests.unit.results.test_survey_map import DATUM, flown_map

MADE = Made()


@pytest.fixture
def survey() -> SurveyMap:
    return flown_map()


def test_csv_has_a_line_a_stall_in_the_order_of_labels(survey: SurveyMap) -> None:
    rows = list(csv.DictReader(io.StringIO(map_csv(survey, MADE).decode())))
    assert [(row["stall_id"], row["label"]) for row in rows] == [("7", "A 1"), ("3", "B 1"), ("2", "C 1"), ("9", "")]
    assert [row["state"] for row in rows] == ["free", "unknown", "taken", "suggested"]
    assert tuple(rows[0]) == CSV_COLUMNS
    assert float(rows[0]["direction_deg"]) == pytest.approx(30.0)


def test_tables_and_polygons_name_their_survey_moment_and_software(survey: SurveyMap) -> None:
    made = Made.now("000007-20260504T103000Z")
    row = next(csv.DictReader(io.StringIO(map_csv(survey, made).decode())))
    assert (row["survey_id"], row["made_utc"]) == ("000007-20260504T103000Z", made.utc)
    assert row["software"].startswith("hawk-drone ")
    assert json.loads(map_geojson(survey, made))["hawk"] == made.values()
    assert datetime.fromisoformat(made.utc).utcoffset() == timedelta(0)


def test_stalls_of_a_known_lot_have_the_labels_of_its_plan_and_others_none(survey: SurveyMap) -> None:
    survey = replace(survey, stalls={**survey.stalls, 7: replace(survey.stalls[7], label="P-101")})
    rows = csv.DictReader(io.StringIO(map_csv(survey, MADE).decode()))
    assert {row["stall_id"]: row["label"] for row in rows} == {"2": "", "3": "", "7": "P-101", "9": ""}
    features = json.loads(map_geojson(survey, MADE))["features"]
    assert [feature["properties"]["ref"] for feature in features] == ["P-101", "", "", ""]


def test_geojson_polygons_are_where_the_stalls_are(survey: SurveyMap) -> None:
    features = json.loads(map_geojson(survey, MADE))["features"]
    first = next(f for f in features if f["id"] == "7")
    polygon = shape(first["geometry"])
    assert polygon.is_valid
    assert polygon.exterior.is_ccw
    assert (polygon.centroid.y - DATUM.latitude) * 111_100 == pytest.approx(-10.0, abs=0.1)
    assert (polygon.centroid.x - DATUM.longitude) * 111_320 * math.cos(math.radians(43.26)) == pytest.approx(
        12.0, abs=0.1
    )
    assert first["properties"]["state"] == "free"


def test_an_empty_survey_has_files_too() -> None:
    empty = SurveyMap(DATUM, {}, {})
    assert map_csv(empty, MADE).count(b"\n") == 1
    assert json.loads(map_geojson(empty, MADE))["features"] == []
    assert map_picture(empty).shape == (1, 1, 3)


def test_a_live_map_and_a_stored_survey_have_the_same_columns_and_keys(survey: SurveyMap) -> None:
    looked = Observation(
        "a", "B 12", "", "free", 0.1, 1e9, 3, (43.26, -79.92), ((43.26, -79.92),) * 4, 2.5, 5.0, 30.0, False
    )
    stored = ExportRecord(
        "lot", "1", "2", 1e9, 1e9, True, 1, "hawk-drone", False, 2.0, False, (43.26, -79.92), Outline(), (looked,)
    )
    tables = [csv.reader(io.StringIO(data.decode())) for data in (map_csv(survey, MADE), survey_csv(stored))]
    assert [next(table) for table in tables] == [list(CSV_COLUMNS)] * 2
    live, kept = (json.loads(data)["features"] for data in (map_geojson(survey, MADE), survey_geojson(stored)))
    assert live[0]["properties"].keys() == kept[1]["properties"].keys()


def test_a_label_of_a_plan_is_no_formula_in_the_table(survey: SurveyMap) -> None:
    survey = replace(survey, stalls={7: replace(survey.stalls[7], label="=1+1")})
    assert next(csv.DictReader(io.StringIO(map_csv(survey, MADE).decode())))["label"] == "'=1+1"


def test_a_recording_keeps_the_keys_by_which_maps_are_compared(survey: SurveyMap) -> None:
    (first, *_) = json.loads(recorded_geojson(survey.datum, survey.stalls))["features"]
    assert (first["id"], first["properties"]["label"], first["properties"]["seen"]) == (2, None, 4)
