"""Sections of a file become sections of a lot: they begin, change and end; the same file again changes nothing."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import shapely

from hawk.lots.values import LotInputError
from tests.unit.lots import whole
from tests.unit.lots.plan_files.files import degrees, feature
from tests.unit.lots.plan_import.imports import Importer, drawn, geojson, importer

Json = dict[str, Any]
KERB = [(20.0, 0.0), (20.0, 56.0)]
SQUARE = [(30.0, 0.0), (30.0, 20.0), (40.0, 20.0), (40.0, 0.0), (30.0, 0.0)]


@pytest.fixture
def person(tmp_path: Path) -> Iterator[Importer]:
    found = importer(tmp_path)
    yield found
    found.store.close()


def kerb(line: list[tuple[float, float]] = KERB, **facts: object) -> Json:
    said = {"name": "Elm", "side": "right", "width": 2.2, "kind": "parallel", **facts}
    return feature(degrees(line), "LineString", **{key: each for key, each in said.items() if each is not None})


def yard(**facts: object) -> Json:
    return feature([degrees(SQUARE)], **{"amenity": "parking", "name": "Yard", "capacity": 30, **facts})


def sections(person: Importer) -> dict[str, Json]:
    return {each["name"]: each for each in person.plan()["sections"]}


def effects(person: Importer, *features: Json, **asked: str) -> tuple[list[tuple[str, str]], int]:
    """Return the effect of a file on each section that it changes, and the number of those that are so already."""
    shown = person.shown(geojson(features), **asked)
    return [(each["change"], each["name"]) for each in shown["sections"]], shown["same_sections"]


def test_a_file_of_sections_is_taken_undone_done_again_and_the_second_time_nothing(person: Importer) -> None:
    data = geojson([kerb(capacity=9, note="permit"), yard()])
    before = person.plan()
    shown = person.shown(data)
    assert [(each["change"], each["name"], each["capacity"]) for each in shown["sections"]] == [
        ("begin", "Elm", 9), ("begin", "Yard", 30),
    ]  # fmt: skip
    assert person.plan() == before
    done = person.take(data)
    elm = sections(person)["Elm"]
    assert (elm["kind"], elm["length_m"], elm["capacity"], elm["is_capacity_given"], elm["note"]) == (
        "parallel", pytest.approx(56.0, abs=0.01), 9, True, "permit",
    )  # fmt: skip
    corners = shapely.Polygon(elm["outline"]).bounds
    assert corners == pytest.approx((17.8, 0.0, 20.0, 56.0), abs=0.01)
    assert (done["undo"], len(person.plan()["stalls"])) == (1, 30)
    assert effects(person, kerb(capacity=9, note="permit"), yard()) == ([], 2)
    assert person.take(data)["undo"] == 1  # nothing is done
    assert person.undo()["operation"] == "import"
    assert sections(person) == {}
    person.redo()
    assert sections(person)["Elm"] == elm


@pytest.mark.slow
def test_stalls_and_sections_of_one_file_are_one_operation(person: Importer) -> None:
    person.take(geojson([*drawn(40), yard()]))
    assert (len(person.plan()["stalls"]), [*sections(person)]) == (40, ["Yard"])
    person.undo()
    assert (len(person.plan()["stalls"]), [*sections(person)]) == (30, [])


@pytest.mark.slow
def test_a_capacity_that_the_file_does_not_say_follows_from_the_length(person: Importer) -> None:
    person.take(geojson([kerb(), kerb([(60.0, 0.0), (60.0, 70.0)], name="Oak", kind="diagonal", metres=35)]))
    found = sections(person)
    assert (found["Elm"]["capacity"], found["Elm"]["is_capacity_given"]) == (10, False)
    assert (found["Oak"]["kind"], found["Oak"]["length_m"], found["Oak"]["capacity"]) == ("across", 35.0, 10)


def test_a_section_is_known_again_by_its_ground_or_by_its_name_where_both_touch(person: Importer) -> None:
    person.take(geojson([kerb(capacity=9), yard(note="staff")]))
    before = sections(person)
    renamed = yard(name="Court", capacity=None)
    longer = kerb([(20.0, 0.0), (20.0, 130.0)])
    assert effects(person, longer, renamed) == ([("stay", "Elm"), ("stay", "Court")], 0)
    person.take(geojson([longer, renamed]))
    after = sections(person)
    assert after["Elm"]["id"] == before["Elm"]["id"]
    assert (after["Elm"]["length_m"], after["Elm"]["capacity"]) == (pytest.approx(130.0, abs=0.02), 9)
    assert after["Court"] == before["Yard"] | {"name": "Court"}  # the file says nothing else of it


def test_sections_that_exchange_their_names_do_so(person: Importer) -> None:
    person.take(geojson([kerb(), yard()]))
    before = sections(person)
    person.take(geojson([kerb(name="Yard"), yard(name="Elm")]))
    after = sections(person)
    assert (after["Yard"]["id"], after["Elm"]["id"]) == (before["Elm"]["id"], before["Yard"]["id"])


def test_a_name_of_another_section_is_refused_or_renamed(person: Importer) -> None:
    person.take(geojson([kerb()]))
    far = [(80.0, 0.0), (80.0, 30.0)]
    features = [kerb(far), yard(), yard() | {"geometry": kerb([(99.0, 0.0), (99.0, 30.0)])["geometry"]}]
    features[2]["properties"]["side"] = "left"
    shown = person.shown(geojson(features))
    assert [f"{each['name']}: {each['reason']}" for each in shown["clashes"]] == [
        "features[0]: name Elm: another section of this lot has it too; write another one, or import with rename",
        "features[2]: name Yard: features[1] has it too; write another one, or import with rename",
    ]
    with pytest.raises(LotInputError, match=r"rename: is needed: features\[0\]: name Elm: .*, and 1 more"):
        person.take(geojson(features))
    person.take(geojson(features), rename="1")
    assert [*sections(person)] == ["Elm", "Elm 2", "Yard", "Yard 2"]
    assert person.shown(geojson(features), rename="1")["sections"] == []


def test_a_section_without_a_name_gets_one(person: Importer) -> None:
    person.take(geojson([kerb(name=None), yard(name=None)]))
    assert [*sections(person)] == ["Section", "Section 2"]
    assert effects(person, yard(name=None), kerb(name=None)) == ([], 2)


@pytest.mark.slow
def test_sections_that_the_file_has_not_end_amid_its_own_on_ask_alone(person: Importer) -> None:
    far = kerb([(400.0, 0.0), (400.0, 30.0)], name="Far")
    person.take(geojson([kerb(), yard(), far]))
    assert effects(person, kerb()) == ([], 1)
    wide = kerb([(20.0, 0.0), (50.0, 30.0)], name="New")
    assert effects(person, kerb(), wide, replace="1") == ([("begin", "New"), ("end", "Yard")], 1)
    person.take(geojson([kerb(), wide]), replace="1")
    assert [*sections(person)] == ["Elm", "Far", "New"]
    person.take(geojson(drawn(30)), replace="1")  # a file of stalls alone ends no section
    assert [*sections(person)] == ["Elm", "Far", "New"]


@pytest.mark.nightly
def test_a_new_lot_of_sections_alone_is_made_and_undone(person: Importer) -> None:
    north = [(5000.0, 0.0), (5000.0, 80.0)]
    made = person.begin(geojson([kerb(north, capacity=12)]), "Elm Street")
    assert (made["stalls"], made["sections"]) == (0, 1)
    person.lot = made["lot"]
    elm = sections(person)["Elm"]
    assert (elm["capacity"], person.plan()["layout"]) == (12, None)
    with person.store.reading() as connection:
        outline = whole.lot(connection, made["lot"])["outline"]
    assert shapely.Polygon(outline[0]).covers(shapely.Point(52.0 + 5000 / 111_250, 5.0005))
    with pytest.raises(LotInputError, match="is there already on the ground of this plan"):
        person.begin(geojson([kerb(north)]), "Again")
    assert person.undo_change(made["seq"]) == "import"


@pytest.mark.slow
@pytest.mark.parametrize("said", [{}, {"capacity": None, "kind": None}, {"kind": "across", "note": ""}])
def test_the_plan_of_a_lot_comes_back_exactly(person: Importer, said: Json) -> None:
    person.take(geojson([kerb(**said), yard(**{"note": "staff", **said}), *drawn(30)]))
    person.do("draw_section", name="Long cars", line=[[50, 0], [60, 9], [60, 40]], side="left", width=3, place_m=7.0)
    before = person.plan()
    data = json.dumps(before).encode()
    shown = person.shown(data)
    assert (shown["sections"], shown["same_sections"]) == ([], 3)
    assert shown["left_out_count"] == 0
    person.undo()
    person.take(data)
    again = sections(person)["Long cars"]
    (first,) = (each for each in before["sections"] if each["name"] == "Long cars")
    ring = again.pop("outline")
    assert shapely.Polygon(ring).symmetric_difference(shapely.Polygon(first.pop("outline"))).area < 1e-2
    assert again == first | {"id": again["id"]}
