"""A previewed plan is one operation of an edit, or the first layout of a new lot."""

from __future__ import annotations

from pathlib import Path

import pytest

from hawk.lots.ingest import save
from hawk.lots.values import LotInputError, LotStoreError, Placed
from tests.unit.lots import whole
from tests.unit.lots.plan_import.imports import Importer, drawn, geojson, importer
from tests.unit.lots.surveys import survey


@pytest.fixture
def person(tmp_path: Path) -> Importer:
    return importer(tmp_path)


@pytest.mark.slow
def test_a_plan_gives_its_labels_to_the_stalls_that_stay(person: Importer) -> None:
    ids = person.ids("A 1", "C 10")
    done = person.take(geojson(drawn(30)))
    stalls = person.stalls()
    assert [stalls["1"]["id"], stalls["30"]["id"]] == ids
    assert len(stalls) == 30
    assert all(stall["is_confirmed"] for stall in stalls.values())
    assert (done["undo"], done["redo"]) == (1, 0)


@pytest.mark.slow
def test_an_import_is_undone_done_again_and_one_version(person: Importer) -> None:
    before = person.plan()["stalls"]
    person.take(geojson(drawn(40)))
    after = person.plan()["stalls"]
    assert len(after) == 40
    assert person.undo()["operation"] == "import"
    assert person.plan()["stalls"] == before
    person.redo()
    assert person.plan()["stalls"] == after
    closed = person.close(why="the owner's plan")
    assert closed["layout"] == 2
    assert person.undo_change(closed["seq"]) == "plan"
    assert person.plan()["stalls"] == before


@pytest.mark.slow
def test_stalls_that_begin_have_the_owners_label_or_one_of_ours(person: Importer) -> None:
    features = drawn(40)
    features[39]["properties"] = {}
    person.take(geojson(features))
    labels = {*person.stalls()}
    assert "39" in labels
    assert len(labels) == 40
    (ours,) = labels - {str(number) for number in range(1, 40)}
    assert ours[0].isalpha()


@pytest.mark.slow
def test_nothing_is_written_by_a_preview(person: Importer) -> None:
    before = person.plan()
    person.preview(geojson(drawn(40)), replace="1", rename="1")
    assert person.plan() == before


@pytest.mark.slow
def test_a_plan_that_was_changed_since_the_preview_is_refused(person: Importer) -> None:
    found = person.preview(geojson(drawn(40)))
    person.do("remove", row="C")
    before = person.plan()
    with pytest.raises(LotStoreError, match="was changed since the preview: send the file again"):
        person.take_preview(found)
    assert person.plan() == before


@pytest.mark.slow
def test_a_label_of_another_stall_is_refused_or_renamed(person: Importer) -> None:
    """A person confirmed that label on a stall that the plan has not."""
    person.do("add_stall", north=30.0, east=0.0, angle=0.0, width=2.5, length=5.0, label="P 2")
    features = drawn(30)
    for number, label in ((0, "P 2"), (1, "7"), (2, "7")):
        features[number]["properties"] = {"ref": label}
    data = geojson(features)
    clashes = [f"{each['name']}: {each['reason']}" for each in person.shown(data)["clashes"]]
    assert clashes == [
        "features[0]: label P 2: a person confirmed it on another stall of this lot; write another one, or import with "
        "rename",
        *(
            f"features[{number}]: label 7: features[1] has it too; write another one, or import with rename"
            for number in (2, 6)
        ),
    ]
    before = person.plan()
    with pytest.raises(LotInputError, match=r"rename: is needed: features\[0\]: label P 2: .*, and 2 more"):
        person.take(data)
    assert person.plan() == before
    person.take(data, rename="1")
    stalls = person.stalls()
    assert {"P 2-2", "P 2", "7", "7-2", "7-3"} <= {*stalls}
    assert person.shown(data, rename="1")["stay"] == []


def test_a_plan_whose_place_is_not_certain_is_taken_on_ask_alone(person: Importer) -> None:
    data = geojson(drawn(3, north=-60.0))
    assert not person.shown(data)["placed"]["is_certain"]
    with pytest.raises(
        LotInputError, match=r"uncertain: must be true: it is not certain where the plan lies \(too few"
    ):
        person.take(data)
    with pytest.raises(LotInputError, match="uncertain: must be true or false"):
        person.take(data, uncertain="yes")
    person.take(data, uncertain=True)
    assert person.stalls()["1"]["north"] == pytest.approx(-60.0, abs=0.01)


@pytest.mark.slow
def test_an_edit_that_is_not_open_takes_nothing(person: Importer) -> None:
    found = person.preview(geojson(drawn(40)))
    person.close()
    with pytest.raises(LotStoreError, match="it was closed at"):
        person.take_preview(found)


@pytest.mark.slow
def test_a_new_lot_is_made_of_a_plan_and_undone(person: Importer) -> None:
    far = geojson(drawn(24, a_row=12, north=5000.0))
    made = person.begin(far)
    with person.store.reading() as connection:
        lot = whole.lot(connection, made["lot"])
    assert [stall["label"] for stall in lot["stalls"]] == [str(number) for number in range(1, 25)]
    assert all(stall["is_confirmed"] for stall in lot["stalls"])
    assert (lot["name"], lot["datum_is_pinned"], lot["surveys"]) == ("North", True, [])
    assert lot["layouts"][0]["why"] == "imported from plan.geojson"
    with pytest.raises(LotInputError, match="is there already on the ground of this plan: import it into that lot"):
        person.begin(far, "Again")
    assert person.undo_change(made["seq"]) == "import"
    with person.store.reading() as connection:
        assert [each["name"] for each in whole.lots(connection)] == ["Lot 1"]


@pytest.mark.slow
def test_a_new_lot_may_lie_beside_another_one_and_not_on_a_part_of_it(person: Importer) -> None:
    near = drawn(24, a_row=12, north=100.0)
    assert person.begin(geojson(near))["stalls"] == 24
    for north, east in ((113.0, 0.0), (109.0, 27.0)):  # by more and by less than what makes two lots one
        with pytest.raises(LotInputError, match="is there already on the ground of this plan"):
            person.begin(geojson(drawn(24, a_row=12, north=north, east=east)), "Again")
    assert person.begin(geojson(drawn(24, a_row=12, north=160.0)), "Beside")["stalls"] == 24


@pytest.mark.slow
def test_adjoining_lots_of_one_file_are_made_one_after_another(person: Importer) -> None:
    """Their stalls stand back to back, and rows go on in the next lot: they share an aisle's width about them."""
    for name, north, east in (("South", 1000.0, 0.0), ("North", 1021.5, 0.0), ("East", 1000.0, 30.1)):
        assert person.begin(geojson(drawn(24, a_row=12, north=north, east=east)), name)["stalls"] == 24
    with pytest.raises(LotInputError, match="South is there already on the ground of this plan"):
        person.begin(geojson(drawn(1, north=1001.0)), "One stall")


@pytest.mark.slow
@pytest.mark.parametrize("is_within_first", [False, True])
def test_a_lot_within_the_arms_of_another_and_a_row_behind_a_row_are_lots_of_their_own(
    person: Importer, *, is_within_first: bool
) -> None:
    arms = [drawn(10, a_row=1, north=4990.0, east=east, first=first) for east, first in ((0.0, 11), (60.0, 21))]
    around, within = [*drawn(10, north=5000.0), *arms[0], *arms[1]], drawn(6, a_row=3, north=4955.0, east=25.0)
    for number, features in enumerate([within, around] if is_within_first else [around, within]):
        person.begin(geojson(features), f"Lot {number}")
    for number, north in enumerate((7000.0, 6995.0)):  # back to back
        person.begin(geojson(drawn(20, a_row=20, north=north)), f"Row {number}")


@pytest.mark.slow
@pytest.mark.parametrize(("apart", "away"), [(1800.0, 1800), (5000.0, 5000)])
def test_two_halves_that_are_far_from_each_other_are_two_lots(person: Importer, apart: float, away: int) -> None:
    features = [*drawn(10, north=8000.0), *drawn(10, north=8000.0 + apart, first=11)]
    with pytest.raises(LotInputError, match=f"would be {away} m off the rest of the lot: 1000 m is the most"):
        person.begin(geojson(features), "Halves")


@pytest.mark.slow
def test_on_the_ground_of_a_lot_without_any_stall_is_no_other_lot(person: Importer) -> None:
    person.lot = person.begin(geojson(drawn(20, north=5000.0)), "Empty")["lot"]
    person.open()
    person.do("remove", all=True)
    with pytest.raises(LotInputError, match="Empty is there already"):
        person.begin(geojson(drawn(20, north=5000.0)), "Again")


@pytest.mark.slow
def test_a_survey_that_follows_is_placed_on_the_plan(tmp_path: Path) -> None:
    person = importer(tmp_path, 0)
    flown = survey(stalls=40)
    features = drawn(40, a_row=20, north=0.8, east=-0.6)
    made = person.begin(geojson(features))
    with person.store.writing() as connection:
        saved = save(connection, flown, person.register)
    assert (saved.lot, saved.placed, saved.known) == (made["lot"], Placed.REGISTERED, 40)


@pytest.mark.parametrize("name", ["", None, 7, "x" * 81, "a\x00b"])
def test_a_new_lot_needs_a_name(person: Importer, name: object) -> None:
    with pytest.raises(LotInputError, match=r"^name: "):
        person.begin(geojson(drawn(24, north=5000.0)), name)


@pytest.mark.slow
@pytest.mark.fault("a plan of 20,000 stalls", "it makes a lot, and is undone")
@pytest.mark.nightly
def test_a_plan_of_20_000_stalls_makes_a_lot_and_is_undone(tmp_path: Path) -> None:
    person = importer(tmp_path, 0)
    made = person.begin(geojson(drawn(20_000, a_row=100)))
    assert made["stalls"] == 20_000
    person.lot = made["lot"]
    assert {*person.stalls()} == {str(number) for number in range(1, 20_001)}
    person.undo_change(made["seq"])
    with person.store.reading() as connection:
        assert [each["name"] for each in whole.lots(connection)] == ["Lot 1"]
