"""Labels as they are painted: those of ours yield to a person's, and an undo gives each one back."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from hawk.lots.values import LotInputError
from tests.unit.lots.plan.plans import Person

ROW: dict[str, Any] = {"do": "add_row", "front": [[20.0, 0.0], [20.0, 25.0]], "far": [25.0, 0.0]}


@pytest.fixture
def ann(tmp_path: Path) -> Iterator[Person]:
    person = Person.at_work(tmp_path / "lots.db")
    yield person
    person.store.close()


def row(person: Person, north: float) -> list[str]:
    """Return the labels of a row of the lot from west to east."""
    return [each["label"] for each in sorted(person.plan()["stalls"], key=at) if each["north"] == north]


def at(stall: dict[str, Any]) -> float:
    return float(stall["east"])


def numbers(name: str, *of: int) -> list[str]:
    return [f"{name} {number}" for number in of or range(1, 11)]


FIRST, SECOND, THIRD = 0.0, -9.0, -18.0
"""North of the rows A, B, C, metres."""


@pytest.mark.parametrize(
    "operation",
    [
        {"do": "rename", "row": "C", "to": "A"},
        {"do": "renumber", "row": "C", "letter": "A"},
        {"do": "swap", "rows": ["C", "A"]},
    ],
)
def test_a_row_gets_a_letter_that_ours_gives_up_and_an_undo_gives_both_back(
    ann: Person, operation: dict[str, Any]
) -> None:
    before = ann.shown()
    done = ann.operate(operation)
    assert len(done["stalls"]) == 20
    assert (row(ann, THIRD), row(ann, FIRST)) == (numbers("A"), numbers("C"))
    ours = {each["label"] for each in ann.plan()["stalls"] if not each["is_named"]}
    assert ours == {*numbers("B"), *(() if operation["do"] == "swap" else numbers("C"))}
    ann.undo()
    assert ann.shown() == before
    ann.redo()
    assert (row(ann, THIRD), row(ann, FIRST)) == (numbers("A"), numbers("C"))


def test_a_shorter_row_takes_the_whole_name_of_one_of_ours(ann: Person) -> None:
    ann.do("remove", stalls=ann.ids(*numbers("C", 4, 5, 6, 7, 8, 9, 10)))
    ann.do("rename", row="C", to="A")
    assert (row(ann, THIRD), row(ann, FIRST)) == (numbers("A", 1, 2, 3), numbers("C"))


@pytest.mark.parametrize(
    "operation",
    [
        {"do": "rename", "row": "C", "to": "A"},
        {"do": "renumber", "row": "C", "letter": "A"},
        {"do": "renumber", "row": "C", "labels": numbers("A")},
    ],
)
def test_a_label_that_a_person_confirmed_is_refused_with_the_remedy_which_is_possible(
    ann: Person, operation: dict[str, Any]
) -> None:
    ann.do("confirm", row="A")
    before = ann.plan()
    words = r"^(to|letter|labels): A 1 and 9 more: a person confirmed the label of another stall: swap the rows, or"
    with pytest.raises(LotInputError, match=words):
        ann.operate(operation)
    assert ann.plan() == before
    ann.do("swap", rows=["A", "C"])
    assert (row(ann, THIRD), row(ann, FIRST)) == (numbers("A"), numbers("C"))


def test_one_stall_of_ours_yields_alone_and_gets_the_next_number_of_its_row(ann: Person) -> None:
    ann.do("renumber", stalls=ann.ids("C 10"), labels=["A 3"])
    assert row(ann, FIRST) == numbers("A", 1, 2, 11, 4, 5, 6, 7, 8, 9, 10)
    ann.do("shift", stalls=ann.ids("A 4", "A 5"), by=2)
    assert row(ann, FIRST) == numbers("A", 1, 2, 11, 6, 7, 12, 13, 8, 9, 10)


def test_a_row_is_numbered_from_its_other_end_and_its_numbers_are_shifted(ann: Person) -> None:
    ann.do("remove", stalls=ann.ids("A 4"))
    there = numbers("A", 1, 2, 3, 5, 6, 7, 8, 9, 10)
    ann.do("reverse", row="A")
    assert row(ann, FIRST) == there[::-1]
    ann.do("shift", row="A", by=100)
    assert row(ann, FIRST) == numbers("A", 110, 109, 108, 107, 106, 105, 103, 102, 101)
    ann.do("shift", row="A", by=-100)
    ann.do("reverse", row="A")
    assert row(ann, FIRST) == there
    for _ in range(4):
        ann.undo()
    assert row(ann, FIRST) == there
    assert not any(each["is_named"] for each in ann.plan()["stalls"])


def test_a_row_is_named_freely_and_found_by_its_name(ann: Person) -> None:
    ann.do("rename", row="B", to="Nord")
    assert row(ann, SECOND) == numbers("Nord")
    ann.do("set_kind", row="Nord", kind="staff")
    assert {each["label"] for each in ann.plan()["stalls"] if each["kind"] == "staff"} == {*numbers("Nord")}
    ann.do("swap", rows=["Nord", "A"])
    assert (row(ann, SECOND), row(ann, FIRST)) == (numbers("A"), numbers("Nord"))
    (new,) = ann.do("add_stall", north=0.0, east=25.0, angle=0.0, width=2.5, length=5.0)["stalls"]
    assert (new["label"], new["is_named"]) == ("Nord 11", False)


def test_labels_of_owners_keep_their_form(ann: Person) -> None:
    ids = ann.ids("A 1", "A 2", "A 3")
    ann.do("renumber", stalls=ids, labels=["P-008", "P-009", "P-010"])
    ann.do("shift", stalls=ids, by=1)
    assert row(ann, FIRST)[:3] == ["P-009", "P-010", "P-011"]
    ann.do("reverse", stalls=ids)
    assert row(ann, FIRST)[:3] == ["P-011", "P-010", "P-009"]
    ann.do("rename", stalls=ids, to="East")
    assert row(ann, FIRST)[:3] == ["East-011", "East-010", "East-009"]
    ann.do("renumber", stalls=ids[:1], labels=["Boss"])
    for asked in ({"do": "shift", "stalls": ids, "by": 1}, {"do": "rename", "stalls": ids, "to": "W"}):
        with pytest.raises(
            LotInputError, match=r"^(by|to): finds no number in Boss: give that stall a label by renumber"
        ):
            ann.operate(asked)


def test_two_stalls_never_get_one_label(ann: Person) -> None:
    with pytest.raises(LotInputError, match=r"^to: would give Q 1 to two stalls"):
        ann.do("rename", stalls=ann.ids("A 1", "B 1"), to="Q")


@pytest.mark.slow
@pytest.mark.parametrize("is_confirmed", [False, True])
def test_a_row_that_was_removed_and_is_drawn_again_gets_its_letter_again(ann: Person, *, is_confirmed: bool) -> None:
    if is_confirmed:
        ann.do("confirm", row="B")
    ids = {*ann.ids(*numbers("B"))}
    ann.do("remove", row="B")
    done = ann.do("add_row", front=[[-11.5, -1.25], [-11.5, 23.75]], far=[-6.5, 0.0])
    assert sorted(each["label"] for each in done["stalls"]) == sorted(numbers("B"))
    assert not {each["id"] for each in done["stalls"]} & ids
    assert not any(each["is_named"] for each in done["stalls"])  # its place is a person's, its label our guess


def test_a_label_that_a_person_confirmed_and_took_away_is_given_again(ann: Person) -> None:
    ann.do("confirm", row="A")
    ann.do("rename", row="A", to="Q")
    ann.do("rename", row="B", to="A")
    assert (row(ann, FIRST), row(ann, SECOND)) == (numbers("Q"), numbers("A"))
    ann.do("remove", row="Q")
    (new,) = ann.do("add_stall", label="Q 7", north=20.0, east=0.0, angle=0.0, width=2.5, length=5.0)["stalls"]
    assert (new["label"], new["is_named"]) == ("Q 7", True)


def test_a_confirmed_stall_has_the_label_that_is_painted(ann: Person) -> None:
    new = ann.do(**ROW)["stalls"]
    assert [(each["is_confirmed"], each["is_named"]) for each in new] == [(True, False)] * 10
    ann.do("confirm", row="D")
    assert [each["is_named"] for label, each in ann.stalls().items() if label[0] == "D"] == [True] * 10


def test_an_edit_that_is_closed_and_undone_gives_the_labels_back(ann: Person) -> None:
    before = ann.shown()
    ann.do("swap", rows=["A", "B"])
    ann.do("reverse", row="A")
    ann.do("rename", row="C", to="Z")
    closed = ann.close(why="as painted")
    assert [each["label"] for each in ann.plan(layout=1)["stalls"]] == [each["label"] for each in before["stalls"]]
    ann.undo_change(closed["seq"])
    assert ann.shown() == before
