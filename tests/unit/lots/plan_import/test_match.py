"""Stalls of a plan beside those of a lot: which stay, begin, end, and which are no part of it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.unit.lots.plan_import.imports import Importer, drawn, geojson, importer


@pytest.fixture
def person(tmp_path: Path) -> Importer:
    found = importer(tmp_path)
    found.register = None
    return found


def test_a_stall_that_overlaps_by_half_is_the_same_one(person: Importer) -> None:
    shown = person.shown(geojson(drawn(30, east=1.0)))
    assert (len(shown["stay"]), shown["begin"], shown["end"]) == (30, [], [])
    assert shown["stay"][0] | {"id": "", "angle": 0.0} == {
        "id": "", "north": 0.0, "east": 1.0, "angle": 0.0, "width": 2.5, "length": 5.0,
        "label": "1", "kind": "", "former": "A 1",
    }  # fmt: skip


@pytest.mark.slow
def test_a_stall_that_conflicts_with_one_that_stays_is_left_out(person: Importer) -> None:
    """Rows at another pitch: nearly every stall of the plan lies on two of the lot."""
    data = geojson(drawn(6, a_row=6, pitch=3.8))
    shown = person.shown(data)
    assert shown["left_out_count"] > 0
    assert "would overlap A " in shown["left_out"][0]["reason"]
    assert "import with replace, or remove that one" in shown["left_out"][0]["reason"]
    person.take(data)
    replaced = person.shown(data, replace="1")
    assert replaced["left_out_count"] == 0
    person.take(data, replace="1")
    row = [label for label, stall in person.stalls().items() if stall["north"] == 0.0]
    assert sorted(row) == ["1", "2", "3", "4", "5", "6"]


@pytest.mark.slow
def test_stalls_that_the_plan_has_not_end_on_ask_on_its_ground_alone(person: Importer) -> None:
    features = [each for k, each in enumerate(drawn(20)) if k not in (4, 5)]
    assert person.shown(geojson(features))["end"] == []
    ended = person.shown(geojson(features), replace="1")["end"]
    assert [each["label"] for each in ended] == ["A 5", "A 6"]
    person.take(geojson(features), replace="1")
    stalls = person.stalls()
    assert len(stalls) == 28
    assert {"C 1", "C 10"} <= {*stalls}


def test_a_stall_in_an_area_without_stalls_is_left_out(person: Importer) -> None:
    person.do("forbid", outline=[[20, -5], [20, 40], [30, 40], [30, -5]], name="Trees")
    shown = person.shown(geojson([*drawn(2), *drawn(2, north=25.0, first=50)]))
    reasons = [each["reason"] for each in shown["left_out"]]
    assert reasons == ['stands in "Trees" without stalls: allow stalls there first'] * 2


@pytest.mark.slow
def test_a_file_without_labels_and_kinds_keeps_those_of_the_lot(person: Importer) -> None:
    person.do("set_kind", row="A", kind="staff")
    features = drawn(20, north=0.2)
    for each in features:
        each["properties"] = {}
    person.take(geojson(features))
    stall = person.stalls()["A 1"]
    assert (stall["kind"], stall["is_confirmed"], stall["north"]) == ("staff", True, pytest.approx(0.2, abs=1e-3))
    features[0]["properties"] = {"parking_space": "normal"}
    person.take(geojson(features))
    assert person.stalls()["A 1"]["kind"] == ""


@pytest.mark.slow
def test_the_export_of_a_lot_changes_nothing_of_it(person: Importer) -> None:
    person.do("confirm", all=True)
    exported = json.dumps(person.plan()).encode()
    shown = person.shown(exported)
    assert (shown["begin"], shown["stay"], shown["end"], shown["same"]) == ([], [], [], 30)
    before = person.plan()["stalls"]
    person.take(exported)
    assert person.plan()["stalls"] == before


@pytest.mark.slow
def test_labels_that_the_owner_exchanged_are_exchanged_confirmed_or_not(person: Importer) -> None:
    person.do("confirm", stalls=person.ids("A 1"))
    ids = person.ids("A 2", "A 1")
    features = drawn(2)
    features[0]["properties"], features[1]["properties"] = {"ref": "A 2"}, {"ref": "A 1"}
    assert person.shown(geojson(features))["clash_count"] == 0
    person.take(geojson(features))
    assert person.ids("A 1", "A 2") == ids
