"""A survey in the words of receivers, judged by their own schemas where they have one."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from referencing import Registry, Resource
from referencing.jsonschema import DRAFT202012

from hawk.exports.feeds import cds_spaces, ngsi_entities, parkapi, valid_at
from hawk.exports.formats import FEEDS, VALID_S, Span
from hawk.exports.values import ExportRecord
from hawk.model.plans import Outline
from tests.unit.exports.stored import Stored

SCHEMAS = Path(__file__).parent / "schemas"
COMMON = "https://smart-data-models.github.io/data-models/common-schema.json"
NAMES = ("EntityIdentifierType", "GSMA-Commons", "Location-Commons", "PhysicalObject-Commons", "timeInstant")
"""Parts of the common schema that the models refer to; the models' own keys are what is judged here."""


@pytest.fixture(scope="module")
def models() -> dict[str, Draft202012Validator]:
    common = Resource.from_contents({"definitions": {name: {} for name in NAMES}}, default_specification=DRAFT202012)
    registry = Registry().with_resource(COMMON, common)
    files = [json.loads(file.read_text()) for file in sorted(SCHEMAS.glob("*.schema.json"))]
    return {each["title"].split(" - ")[-1]: Draft202012Validator(each, registry=registry) for each in files}


def validator(models: dict[str, Draft202012Validator], kind: str) -> Draft202012Validator:
    (found,) = (each for each in models.values() if each.schema["allOf"][-1]["properties"]["type"]["enum"] == [kind])
    return found


def fresh(survey: ExportRecord) -> ExportRecord:
    return valid_at(survey, max(stall.looked_at or 0.0 for stall in survey.stalls), VALID_S)


def by_type(entities: list[dict[str, Any]]) -> dict[str, list[dict[str, Any]]]:
    found: dict[str, list[dict[str, Any]]] = {}
    for entity in entities:
        found.setdefault(entity["type"], []).append(entity)
    return found


@pytest.mark.slow
def test_ngsi_entities_are_valid_by_the_models(stored: Stored, models: dict[str, Draft202012Validator]) -> None:
    entities = ngsi_entities(fresh(stored.read()))
    for entity in entities:
        errors = [error.message for error in validator(models, entity["type"]).iter_errors(entity)]
        assert errors == []
    found = by_type(entities)
    assert {kind: len(each) for kind, each in found.items()} == {
        "OffStreetParking": 1, "ParkingGroup": 3, "ParkingSpot": 60,
    }  # fmt: skip


@pytest.mark.slow
def test_a_model_finds_an_entity_that_is_wrong(stored: Stored, models: dict[str, Draft202012Validator]) -> None:
    (spot, *_) = by_type(ngsi_entities(stored.read()))["ParkingSpot"]
    wrong = {**spot, "status": "taken"}
    assert [error.path[0] for error in validator(models, "ParkingSpot").iter_errors(wrong)] == ["status"]


@pytest.mark.slow
def test_spots_groups_and_site_refer_to_each_other_and_counts_add_up(stored: Stored) -> None:
    survey = fresh(stored.read())
    found = by_type(ngsi_entities(survey))
    (site,) = found["OffStreetParking"]
    assert site["totalSpotNumber"] == 60
    assert site["availableSpotNumber"] == survey.count("free")
    assert site["availableSpotNumber"] + site["occupiedSpotNumber"] == 60
    assert sum(group["availableSpotNumber"] for group in found["ParkingGroup"]) == survey.count("free")
    assert {spot["refParkingGroup"] for spot in found["ParkingSpot"]} == {
        group["id"] for group in found["ParkingGroup"]
    }
    assert {each["refParkingSite"] for each in found["ParkingSpot"] + found["ParkingGroup"]} == {site["id"]}
    assert [spot["status"] for spot in found["ParkingSpot"]] == [
        {"free": "free", "taken": "occupied"}[stall.state] for stall in survey.stalls
    ]


@pytest.mark.slow
def test_a_look_that_is_too_old_or_of_tomorrow_is_unknown_and_no_count_is_given(stored: Stored) -> None:
    survey = stored.read()
    latest = max(stall.looked_at or 0.0 for stall in survey.stalls)
    for now in (latest + VALID_S + 700, latest - VALID_S - 700):
        old = valid_at(survey, now, VALID_S)
        assert {stall.state for stall in old.stalls} == {"unknown"}
        (site,) = by_type(ngsi_entities(old))["OffStreetParking"]
        assert "availableSpotNumber" not in site
        assert all("available" not in space for space in cds_spaces(old)["data"]["spaces"])
        assert {spot["realtime_status"] for spot in parkapi(old)["parking_spots"]} == {"UNKNOWN"}
        assert "realtime_free_capacity" not in parkapi(old)["parking_sites"][0]
    assert valid_at(survey, latest, 1e9) == survey


@pytest.mark.slow
def test_one_stall_that_was_not_seen_makes_the_count_of_its_row_unknown(stored: Stored) -> None:
    survey = fresh(stored.read())
    unseen = replace(survey.stalls[0], state="unknown", taken_probability=None, looked_at=None, picture_count=0)
    found = by_type(ngsi_entities(replace(survey, stalls=(unseen, *survey.stalls[1:]))))
    first, second, _ = found["ParkingGroup"]
    assert "availableSpotNumber" not in first
    assert "availableSpotNumber" in second
    assert "availableSpotNumber" not in found["OffStreetParking"][0]


@pytest.mark.slow
def test_an_owners_labels_make_rows_where_they_name_one(stored: Stored) -> None:
    survey = stored.read()

    def labelled(word: str) -> dict[str, Any]:
        stalls = tuple(replace(stall, label=word.format(stall.label)) for stall in survey.stalls)
        return by_type(ngsi_entities(replace(survey, stalls=stalls)))

    found = labelled("{}-own")
    assert "ParkingGroup" not in found
    assert all("refParkingGroup" not in spot for spot in found["ParkingSpot"])
    groups = labelled("Été {}")["ParkingGroup"]
    assert groups[0]["id"] == f"urn:ngsi-ld:ParkingGroup:{survey.lot_id}:%C3%89t%C3%A9%20A"


@pytest.mark.slow
def test_cds_spaces_have_what_the_specification_requires(stored: Stored) -> None:
    survey = fresh(stored.read())
    found = cds_spaces(survey)
    assert found.keys() >= {"version", "time_zone", "last_updated", "currency", "data"}
    assert (found["version"], found["last_updated"]) == ("1.0.0", round(survey.ended * 1000))
    spaces = found["data"]["spaces"]
    required = {"curb_space_id", "geometry", "published_date", "last_updated_date", "curb_zone_id", "length"}
    assert all(space.keys() >= required for space in spaces)
    assert [space["space_number"] for space in spaces] == list(range(1, 61))
    assert [space["available"] for space in spaces] == [stall.state == "free" for stall in survey.stalls]
    assert (spaces[0]["length"], spaces[0]["width"]) == (500, 250)
    assert spaces[0]["availability_time"] == round((survey.stalls[0].looked_at or 0) * 1000)


@pytest.mark.slow
def test_parkapi_has_site_and_spots_with_audience_and_state(stored: Stored) -> None:
    survey = fresh(stored.read())
    found = parkapi(survey)
    (site,) = found["parking_sites"]
    assert (site["capacity"], site["capacity_disabled"]) == (60, 20)
    assert site["realtime_free_capacity"] == survey.count("free")
    assert 51.9 < site["lat"] < 52.1
    spot = found["parking_spots"][20]
    assert spot["restricted_to"] == [{"type": "DISABLED"}]
    assert spot["realtime_status"] == {"free": "AVAILABLE", "taken": "TAKEN"}[survey.stalls[20].state]
    assert spot["realtime_data_updated_at"].endswith("+00:00")


@pytest.mark.nightly
@pytest.mark.parametrize("name", [name for name, feed in FEEDS.items() if feed.span is Span.SURVEY])
def test_a_lot_without_an_outline_and_a_survey_of_nothing_are_feeds_too(stored: Stored, name: str) -> None:
    survey = stored.read()
    assert json.dumps(FEEDS[name].make(replace(survey, outline=Outline())), allow_nan=False)
    assert json.dumps(FEEDS[name].make(replace(survey, stalls=())), allow_nan=False)
