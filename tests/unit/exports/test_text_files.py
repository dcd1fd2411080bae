"""A survey as a table and as GeoJSON."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace

import numpy as np
import pytest
import shapely

from hawk.exports.shapes import lot_shape, stall_shape
from hawk.exports.text_files import survey_csv, survey_geojson
from hawk.model.plans import Outline
from hawk.results.stall_files import CSV_COLUMNS
from tests.unit.exports.stored import NAME, Stored


@pytest.mark.slow
def test_the_table_has_a_line_for_each_stall_with_the_survey_in_it(stored: Stored) -> None:
    survey = stored.read()
    rows = list(csv.DictReader(io.StringIO(survey_csv(survey).decode())))
    assert tuple(rows[0]) == CSV_COLUMNS
    assert len(rows) == 60
    row, stall = rows[20], survey.stalls[20]
    assert (row["stall_id"], row["label"], row["kind"], row["state"]) == (stall.id, "B 1", "disabled", stall.state)
    assert (float(row["latitude"]), float(row["longitude"])) == pytest.approx(stall.place, abs=1e-8)
    assert (row["survey_id"], row["lot_id"], row["software"]) == (survey.survey, survey.lot_id, "hawk-drone 0.3.0")
    assert (row["survey_ended_utc"], row["time_is_sure"]) == ("2026-02-03T02:55:00Z", "yes")
    assert row["observed_utc"].startswith("2026-02-02T02:")
    assert float(row["position_uncertainty_m"]) == pytest.approx(1.53)
    assert row["confirmed"] == row["simulated"] == "no"


@pytest.mark.slow
@pytest.mark.parametrize(("blurred", "shown"), [(3, "3"), (0, "0"), (None, "")])
def test_the_number_of_stalls_that_were_seen_blurred_is_in_every_file(
    stored: Stored, blurred: int | None, shown: str
) -> None:
    survey = replace(stored.read(), blurred=blurred)
    assert next(csv.DictReader(io.StringIO(survey_csv(survey).decode())))["stalls_blurred"] == shown
    assert json.loads(survey_geojson(survey))["hawk"]["stalls_blurred"] == blurred


@pytest.mark.slow
def test_a_name_is_no_formula_in_a_table_and_stays_as_it_is_in_geojson(stored: Stored) -> None:
    survey = replace(stored.read(), lot=NAME)
    row = next(csv.DictReader(io.StringIO(survey_csv(survey).decode())))
    assert row["lot_name"] == f"'{NAME}"
    assert json.loads(survey_geojson(survey))["features"][0]["properties"]["name"] == NAME


@pytest.mark.slow
def test_geojson_has_osm_keys_and_rings_of_rfc_7946(stored: Stored) -> None:
    survey = stored.read()
    found = json.loads(survey_geojson(survey))
    lot, *stalls = found["features"]
    assert lot["properties"] == {
        "amenity": "parking", "name": "Lot 1", "capacity": 60, "capacity:disabled": 20,
    }  # fmt: skip
    assert len(stalls) == 60
    assert stalls[20]["properties"]["parking_space"] == "disabled"
    assert (
        stalls[0]["properties"] | {"amenity": "parking_space", "parking_space": "normal", "ref": "A 1"}
        == (stalls[0]["properties"])
    )
    for feature in found["features"]:
        for part in shapely.get_parts(shapely.geometry.shape(feature["geometry"])):
            assert part.exterior.is_ccw
            assert part.is_valid
    for feature, stall in zip(stalls, survey.stalls, strict=True):
        ring = shapely.get_coordinates(stall_shape(stall))
        assert np.abs(np.array(feature["geometry"]["coordinates"][0]) - ring).max() < 1e-8
    longitude, latitude = stalls[0]["geometry"]["coordinates"][0][0]
    assert (latitude, longitude) == pytest.approx(survey.stalls[0].corners[0], abs=1e-8)
    assert found["hawk"]["survey_id"] == survey.survey
    assert found["hawk"]["free"] + found["hawk"]["taken"] == 60


@pytest.mark.slow
def test_a_stall_that_was_not_looked_at_has_no_probability_and_no_time(stored: Stored) -> None:
    survey = stored.read()
    unseen = replace(survey.stalls[0], state="unknown", taken_probability=None, looked_at=None, picture_count=0)
    survey = replace(survey, stalls=(unseen,))
    row = next(csv.DictReader(io.StringIO(survey_csv(survey).decode())))
    assert (row["state"], row["taken_probability"], row["observed_utc"], row["picture_count"]) == (
        "unknown",
        "",
        "",
        "0",
    )
    properties = json.loads(survey_geojson(survey))["features"][1]["properties"]
    assert (properties["taken_probability"], properties["observed_utc"]) == (None, None)


def test_the_ground_of_a_lot_has_its_holes_and_may_be_empty() -> None:
    square = ((52.0, 5.0), (52.001, 5.0), (52.001, 5.001), (52.0, 5.001))
    hole = ((52.0004, 5.0004), (52.0006, 5.0004), (52.0006, 5.0006), (52.0004, 5.0006))
    (part,) = lot_shape(Outline((square,), (hole,))).geoms
    assert part.exterior.is_ccw
    assert len(part.interiors) == 1
    assert lot_shape(Outline()).is_empty
