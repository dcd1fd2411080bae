from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.lots.labels import lasting_labels, parts_of
from hawk.lots.operations import free_labels
from hawk.model.lot_map import Stall
from hawk.results.label_parts import numbered
from tests.unit.lots.surveys import stall


def stalls(*numbers: int) -> dict[int, Stall]:
    return {number: stall(number).on_map() for number in numbers}


def test_a_first_map_has_the_labels_of_its_rows() -> None:
    labels = lasting_labels(stalls(*range(1, 41)), {}, set())
    assert labels == {number: f"{'AB'[(number - 1) // 20]} {(number - 1) % 20 + 1}" for number in range(1, 41)}


def test_a_row_north_of_all_gets_the_next_letter_and_no_other_row_another_one() -> None:
    kept = lasting_labels(stalls(*range(1, 41)), {}, set())
    above = {number: replace(stall(number - 100, north=9.0).on_map(), id=number) for number in range(101, 121)}
    labels = lasting_labels(stalls(*range(1, 41)) | above, kept, set(kept.values()))
    assert {key: labels[key] for key in kept} == kept
    assert [labels[number] for number in range(101, 121)] == [f"C {number}" for number in range(1, 21)]


def test_a_stall_between_known_ones_gets_the_next_number_of_the_row() -> None:
    kept = lasting_labels(stalls(*range(1, 10), *range(11, 21)), {}, set())
    labels = lasting_labels(stalls(*range(1, 21)), kept, set(kept.values()))
    assert labels[10] == "A 20"
    assert labels[11] == "A 10"


def test_a_label_that_an_owner_gave_stays_and_belongs_to_no_row_of_ours() -> None:
    labels = lasting_labels(stalls(*range(1, 21)), {3: "P2-014"}, {"P2-014", "A 7"})
    assert labels[3] == "P2-014"
    assert labels[1] == "B 1"
    assert parts_of("P2-014") is None
    assert parts_of("AB 12") == ("AB", 12)


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(flights=st.lists(st.sets(st.integers(1, 60), min_size=1), min_size=1, max_size=5))
def test_no_label_is_two_stalls_and_each_keeps_its_own(flights: list[set[int]]) -> None:
    """A stall that comes back after its end is a new one here: it has lost its label."""
    kept: dict[int, str] = {}
    for flight in flights:
        before = {key: label for key, label in kept.items() if key in flight}
        kept = lasting_labels(stalls(*sorted(flight)), before, ())
        assert len(set(kept.values())) == len(kept) == len(flight)
        assert before.items() <= kept.items()


@pytest.mark.parametrize(
    ("missing", "labels"),
    [
        ([5], ["A 5"]), ([1, 2], ["A 1", "A 2"]), ([19, 20], ["A 19", "A 20"]), ([7, 8, 9], ["A 7", "A 8", "A 9"]),
    ],
)  # fmt: skip
@pytest.mark.parametrize("is_reversed", [False, True])
def test_stalls_that_are_drawn_again_get_the_numbers_that_their_neighbours_leave(
    missing: list[int], labels: list[str], *, is_reversed: bool
) -> None:
    def label(number: int) -> str:
        return f"A {21 - number if is_reversed else number}"

    kept = {number: label(number) for number in range(1, 21) if number not in missing}
    found = lasting_labels(stalls(*range(1, 21)), kept, ())
    assert [found[number] for number in missing] == [label(number) for number in missing]
    assert is_reversed or [found[number] for number in missing] == labels


def test_a_number_that_another_stall_of_the_lot_has_is_not_given_to_its_neighbour() -> None:
    kept = {number: f"A {number}" for number in range(1, 20)}
    assert lasting_labels(stalls(*range(1, 21)), kept, {"A 20"})[20] == "A 21"


@pytest.mark.parametrize(
    ("label", "next_one", "elsewhere"),
    [("B 12", "B 13", "Q 12"), ("P2-014", "P2-015", "Q-014"), ("7", "8", "Q 7"), ("P9", "P10", "Q9")],
)
def test_labels_of_owners_are_numbered_as_they_are_written(label: str, next_one: str, elsewhere: str) -> None:
    parts = numbered(label)
    assert parts is not None
    assert (parts.with_number(parts.number + 1), parts.in_row("Q")) == (next_one, elsewhere)
    assert numbered("Boss") is None


def test_rows_of_a_lot_that_joins_another_one_get_letters_that_neither_has() -> None:
    used = {"A 1", "B 1", "Gate"}
    assert free_labels(["A 1", "A 2", "C 1", "Gate", "Exit"], used) == ["D 1", "D 2", "C 1", "Gate-2", "Exit"]
    assert free_labels(["C 1", "B 2"], used) == ["C 1", "D 2"]
