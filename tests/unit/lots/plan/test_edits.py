"""Edits of a plan: who edits, undo and redo, the layout version that an edit makes, and the plans of earlier ones."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from hawk.lots import lists
from hawk.lots.ingest import save
from hawk.lots.plan import edits
from hawk.lots.plan.edits import IDLE_S
from hawk.lots.storage.database import Database
from hawk.lots.values import (
    BeingEditedError,
    KnownGround,
    LotStoreError,
    MappedGround,
    NotFoundError,
    Registration,
)
from tests.unit.lots import whole
from tests.unit.lots.plan.plans import FAST, Person
from tests.unit.lots.surveys import later, survey


@pytest.fixture
def ann(tmp_path: Path) -> Iterator[Person]:
    person = Person.at_work(tmp_path / "lots.db")
    yield person
    person.store.close()


def beside(person: Person) -> Person:
    """Return another person at the same plan."""
    return Person(person.store, person.lot, now=person.now)


def shown_lot(person: Person) -> dict[str, Any]:
    with person.store.reading() as connection:
        return whole.lot(connection, person.lot)


def test_a_second_person_sees_who_edits_and_since_when(ann: Person) -> None:
    bob = beside(ann)
    ann.now += 60
    ann.do("remove", stalls=ann.ids("A 1"))
    with pytest.raises(BeingEditedError) as refused:
        bob.open("Bob")
    assert str(refused.value) == (
        "edit: Ann edits this plan since 2026-02-03T06:26:40Z: wait until it is closed, or take it over"
    )
    assert refused.value.who == "Ann"
    edit = bob.plan()["edit"]
    assert edit == {"who": "Ann", "since": "2026-02-03T06:26:40Z", "last": "2026-02-03T06:27:40Z", "layout": 2}
    assert ann.edit not in str(bob.plan())


def test_the_same_person_goes_on_with_the_open_edit(ann: Person) -> None:
    first = ann.edit
    ann.do("remove", stalls=ann.ids("A 1"))
    again = ann.open("  Ann ")
    assert (again["edit"], again["layout"], again["undo"], again["redo"]) == (first, 2, 1, 0)


@pytest.mark.slow
def test_an_edit_is_taken_over_on_request_and_nothing_of_it_is_lost(ann: Person) -> None:
    bob = beside(ann)
    ann.do("remove", stalls=ann.ids("A 1"))
    opened = bob.open("Bob", take_over=True)
    assert (opened["layout"], opened["undo"]) == (3, 0)
    with pytest.raises(BeingEditedError, match=r"it was closed at .*, and Bob edits this plan since"):
        ann.do("remove", stalls=ann.ids("A 2"))
    bob.do("remove", stalls=bob.ids("A 3"))
    bob.close(why="the west end is closed")
    versions = [(each["version"], each["who"], each["why"]) for each in shown_lot(ann)["layouts"]]
    assert versions == [(1, "hawk", "drawn"), (2, "Ann", "taken over by Bob"), (3, "Bob", "the west end is closed")]
    assert {"A 1", "A 3"}.isdisjoint(ann.stalls())


def test_an_idle_edit_is_taken_over_without_a_question(ann: Person) -> None:
    bob = beside(ann)
    bob.now = ann.now + IDLE_S - 1
    with pytest.raises(BeingEditedError):
        bob.open("Bob")
    bob.now += 1
    assert bob.open("Bob")["layout"] == 2  # nothing of the first edit was done: its version was never made


@pytest.mark.slow
def test_an_edit_outlives_the_program(ann: Person) -> None:
    ann.do("remove", stalls=ann.ids("A 1"))
    ann.undo()
    ann.store.close()
    ann.store = Database(ann.store.path, FAST)
    assert ann.redo()["operation"] == "remove"
    assert "A 1" not in ann.stalls()
    assert ann.close()["layout"] == 2


@pytest.mark.nightly
def test_operations_are_undone_and_done_again_without_end(ann: Person) -> None:
    plans = [ann.shown()]
    for number in range(1, 11):
        ann.do("move", stalls=ann.ids(f"A {number}"), north=30.0, east=0.0)
        plans.append(ann.shown())
    answers = [ann.undo() for _ in range(10)]
    assert [(each["undo"], each["redo"]) for each in answers[::9]] == [(9, 1), (0, 10)]
    assert ann.shown() == plans[0]
    with pytest.raises(LotStoreError, match="edit: nothing of it is left to undo"):
        ann.undo()
    for plan in plans[1:]:
        ann.redo()
        assert ann.shown() == plan


def test_a_new_operation_drops_those_that_could_be_done_again(ann: Person) -> None:
    added = ann.do("add_stall", north=30.0, east=0.0, angle=0.0, width=2.5, length=5.0)["stalls"][0]
    assert ann.undo()["gone"] == [added["id"]]
    other = ann.do("add_stall", north=30.0, east=0.0, angle=0.0, width=2.5, length=5.0)["stalls"][0]
    assert (added["label"], other["label"]) == ("D 1", "D 1")  # an undo gives a label back
    with pytest.raises(LotStoreError, match="edit: nothing of it is left to do again"):
        ann.redo()


@pytest.mark.slow
def test_an_edit_is_one_layout_version_and_earlier_ones_keep_their_shapes_labels_and_kinds(ann: Person) -> None:
    first = ann.plan(layout=1)
    ann.do("move", row="A", north=1.0, east=0.0)
    ann.do("set_kind", stalls=ann.ids("A 1"), kind="disabled")
    ann.do("remove", row="B")
    ann.do("add_row", front=[[-29.5, 0], [-29.5, 25]], far=[-24.5, 0])
    ann.do("forbid", outline=[[-3.0, -3.0], [-3.0, 4.0], [4.0, 4.0], [4.0, -3.0]])
    ann.close(why="repainted")
    second = ann.plan(layout=2)
    ann.open("Bob")
    ann.do("renumber", row="C", letter="X")
    ann.do("move", row="A", north=1.0, east=0.0)
    ann.do("allow", zone=second["zones"][0]["id"])
    ann.close()
    assert ann.plan(layout=1) == first
    assert ann.plan(layout=2) == second
    assert ann.stalls(layout=2)["A 3"]["north"] == 1.0
    assert ann.stalls(layout=3)["A 3"]["north"] == 2.0
    assert (len(second["zones"]), len(ann.plan(layout=3)["zones"])) == (1, 0)
    with pytest.raises(NotFoundError, match="layout: there is no version 4"):
        ann.plan(layout=4)


@pytest.mark.slow
def test_a_closed_edit_is_undone_as_one_change_once(ann: Person) -> None:
    before, layouts = ann.shown(), shown_lot(ann)["layouts"]
    ann.do("add_row", front=[[20, 0], [20, 25]], far=[25, 0])
    ann.do("move", row="D", north=5.0, east=0.0)
    ann.do("renumber", row="A", letter="K")
    ann.do("remove", row="B")
    ann.undo()
    ann.do("split", stall=ann.ids("C 1")[0], parts=2)
    ann.do("remove", stalls=ann.ids("C 1"))
    changed = ann.close()
    assert changed["layout"] == 2
    with ann.store.reading() as connection:
        (listed,) = lists.changes(connection, whole.ALL).items
    assert (listed.seq, listed.kind, listed.who) == (changed["seq"], "plan", "Ann")
    assert ann.undo_change(changed["seq"]) == "plan"
    assert (ann.shown(), shown_lot(ann)["layouts"]) == (before, layouts)
    with pytest.raises(LotStoreError, match="was undone already; make the change again"):
        ann.undo_change(changed["seq"])
    ann.open()
    assert ann.do("add_row", front=[[20, 0], [20, 25]], far=[25, 0])["stalls"][0]["label"] == "D 1"


@pytest.mark.slow
def test_an_edit_with_a_later_one_upon_it_is_undone_after_that(ann: Person) -> None:
    before = ann.shown()
    ann.do("move", row="A", north=1.0, east=0.0)
    first = ann.close()
    ann.open()
    with pytest.raises(BeingEditedError, match=r"edit: Ann edits the plan of this lot since .*: close the edit first"):
        ann.undo_change(first["seq"])
    ann.do("move", row="A", north=1.0, east=0.0)
    second = ann.close()
    with pytest.raises(LotStoreError, match="undo the later changes first"):
        ann.undo_change(first["seq"])
    ann.undo_change(second["seq"])
    ann.undo_change(first["seq"])
    assert ann.shown() == before


@pytest.mark.slow
def test_an_edit_that_changes_nothing_makes_no_version_and_no_change(ann: Person) -> None:
    before = ann.shown()
    ann.do("remove", row="A")
    ann.do("move", row="B", north=1.0, east=0.0)
    ann.undo()
    ann.undo()
    closed = ann.close()
    assert (closed["seq"], closed["layout"]) == (None, None)
    assert (ann.shown(), [each["version"] for each in shown_lot(ann)["layouts"]]) == (before, [1])
    assert ann.plan(layout=1)["stalls"] == before["stalls"]


@pytest.mark.slow
def test_a_page_follows_the_changes_since_its_revision(ann: Person) -> None:
    begun = ann.plan()["revision"]
    ids = ann.ids("A 1", "A 2", "A 3")
    ann.do("move", stalls=ids[:1], north=30.0, east=0.0)
    ann.do("remove", stalls=ids[1:2])
    ann.undo()
    ann.do("remove", stalls=ids[2:])
    found = ann.plan(since=begun)
    assert (found["whole"], found["revision"]) == (False, begun + 4)
    assert ([each["id"] for each in found["stalls"]], found["gone"]) == (ids[:2], ids[2:])
    assert ann.plan(since=begun + 3)["stalls"] == []
    changed = ann.close()
    assert ann.plan(since=begun + 4)["stalls"] == []
    ann.undo_change(changed["seq"])
    assert (ann.plan(since=begun + 4)["whole"], len(ann.plan(since=begun + 4)["stalls"])) == (True, 30)
    assert ann.plan(since=10**6)["whole"]  # a revision of a store that was restored since


@pytest.mark.slow
@pytest.mark.parametrize(
    ("act", "asked", "refusal"),
    [
        (edits.open_edit, {}, "who: must be text"),
        (edits.open_edit, {"who": " "}, "who: is empty"),
        (edits.open_edit, {"who": "x" * 81}, "who: has 81 characters"),
        (edits.open_edit, {"who": "Ann", "take_over": "yes"}, "take_over: must be true or false"),
        (edits.open_edit, {"who": "Ann", "by": True}, "by: is no field of this request: it takes who, take_over"),
        (edits.do, {"operation": {"do": "remove", "row": "A"}}, "edit: must be the id of your edit: open one first"),
        (edits.undo, {"edit": 7}, "edit: must be the id of your edit"),
        (edits.close, {"edit": "OPEN", "why": "x" * 81}, "why: has 81 characters"),
        (edits.undo, {"edit": "gone"}, "edit: there is none with this id, and Ann edits this plan since"),
    ],
)  # fmt: skip
def test_a_request_about_an_edit_that_cannot_be_used_names_its_field(
    ann: Person, act: Any, asked: dict[str, Any], refusal: str
) -> None:
    named = {key: ann.edit if value == "OPEN" else value for key, value in asked.items()}
    with pytest.raises(LotStoreError) as refused:
        ann.ask(act, named)
    assert re.match(refusal, str(refused.value)), str(refused.value)


def test_a_closed_edit_takes_no_operation_and_a_lot_that_is_none_no_edit(ann: Person) -> None:
    ann.close()
    with pytest.raises(LotStoreError, match=r"edit: it was closed at 2026-02-03T06:26:40Z; open another one"):
        ann.do("remove", stalls=ann.ids("A 1"))
    ann.lot = "0" * 36
    with pytest.raises(NotFoundError, match="lot: there is no lot with this id; reload the list"):
        ann.open()


def same_place(known: KnownGround, found: MappedGround) -> Registration:
    """Register a survey without a move: its stalls are the nearest ones of the lot."""
    names = {(round(each.north, 3), round(each.east, 3)): each.id for each in known.stalls}
    same = {each.id: names.get((round(each.north, 3), round(each.east, 3))) for each in found.stalls}
    return Registration(0.0, 0.0, 0.0, {number: stall for number, stall in same.items() if stall is not None})


@pytest.mark.nightly
def test_a_survey_that_lands_during_an_edit_is_placed_on_the_open_version(tmp_path: Path) -> None:
    store = Database(tmp_path / "lots.db", FAST)
    with store.writing() as connection:
        lot = save(connection, survey(stalls=40)).lot
    assert lot is not None
    ann = Person(store, lot)
    ann.open()
    removed = ann.ids("A 5")
    ann.do("remove", stalls=removed)
    with store.writing() as connection:
        save(connection, later(survey(stalls=40), 2), same_place)
    shown = shown_lot(ann)
    assert [(each["placed"], each["layout"]) for each in shown["surveys"]] == [("first", 1), ("registered", 2)]
    (found,) = shown["newest_registered"]["found"]
    assert (found["id"], shown["newest_registered"]["missed"]) == (5, [])
    ann.do("add_stall", **{name: found[name] for name in ("north", "east", "angle", "width", "length")})
    assert shown_lot(ann)["newest_registered"] == {**shown["newest_registered"], "found": []}
    ann.do("remove", stalls=ann.ids("A 5"))
    north, east = found["north"], found["east"]
    ann.do("forbid", outline=[[north - 1, east - 1], [north - 1, east + 1], [north + 1, east]])
    assert shown_lot(ann)["newest_registered"]["found"] == []
    changed = ann.close()
    with pytest.raises(LotStoreError, match="surveys were registered since with the layout it made"):
        ann.undo_change(changed["seq"])
    assert removed[0] in {each["id"] for each in ann.plan(layout=1)["stalls"]}
    store.close()


@pytest.mark.slow
def test_a_survey_keeps_the_version_that_an_edit_without_a_rest_made(tmp_path: Path) -> None:
    store = Database(tmp_path / "lots.db", FAST)
    with store.writing() as connection:
        lot = save(connection, survey(stalls=40)).lot
    assert lot is not None
    ann = Person(store, lot)
    ann.open()
    ann.do("remove", stalls=ann.ids("A 5"))
    with store.writing() as connection:
        save(connection, later(survey(stalls=40), 2), same_place)
    ann.undo()
    assert ann.close() == {"lot": lot, "edit": ann.edit, "seq": None, "layout": None}
    assert [each["version"] for each in shown_lot(ann)["layouts"]] == [1, 2]
    store.close()


@pytest.mark.slow
def test_the_stalls_that_a_first_survey_goes_on_to_find_are_seen_by_who_follows_the_plan(tmp_path: Path) -> None:
    store = Database(tmp_path / "lots.db", FAST)
    with store.writing() as connection:
        lot = save(connection, survey(stalls=20)).lot
    assert lot is not None
    ann = Person(store, lot)
    begun = ann.plan()["revision"]
    with store.writing() as connection:
        save(connection, survey(stalls=40))
    found = ann.plan(since=begun)
    assert (found["whole"], len(found["stalls"])) == (True, 40)
    store.close()


@pytest.mark.slow
@pytest.mark.fault(
    "the disk is full while a plan is corrected",
    "nothing of the operation is written; the error names file and remedy",
)
def test_a_full_disk_during_an_operation_leaves_the_plan_as_it_was(ann: Person) -> None:
    plans = [ann.plan()]

    def add_rows() -> None:
        for north in range(20, 1000, 9):
            ann.do("add_row", front=[[north, 0], [north, 75]], far=[north + 5, 0])
            plans.append(ann.plan())

    ann.store.close()
    ann.store = Database(ann.store.path, {"max_page_count": 1, **FAST})  # SQLite takes the pages that there are
    with pytest.raises(LotStoreError, match=r"lots\.db cannot grow: the disk is full"):
        add_rows()
    assert ann.plan() == plans[-1]


@pytest.mark.parametrize("odd", ["\ud800", "\0", "x" * 5000, "' OR 1 = 1 --"])
def test_an_id_that_is_no_text_of_ours_is_not_in_the_plan(ann: Person, odd: str) -> None:
    for act, asked in (
        (edits.undo, {"edit": odd}),
        (edits.do, {"edit": ann.edit, "operation": {"do": "split", "stall": odd, "parts": 2}}),
        (edits.do, {"edit": ann.edit, "operation": {"do": "remove", "stalls": [odd]}}),
        (edits.do, {"edit": ann.edit, "operation": {"do": "allow", "zone": odd}}),
    ):
        with pytest.raises(LotStoreError, match=r"^(edit|stall|stalls\[0\]|zone): "):
            ann.ask(act, asked)
