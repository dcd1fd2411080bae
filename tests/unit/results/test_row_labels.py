from __future__ import annotations

import itertools
import math

import pytest

from hawk.model.lot_map import Stall, StallState
from hawk.results.row_labels import row_labels

WIDTH, LENGTH = 2.5, 5.0


def stall(number: int, north: float, east: float, angle: float, state: StallState = StallState.FREE) -> Stall:
    return Stall(number, north, east, angle % math.pi, WIDTH, LENGTH, 0.1, state, 0.9, 5, 1.0, 1)


def lot(rows: dict[float, list[float]], turn: float = 0.0) -> dict[int, Stall]:
    """Rows from west to east at some norths, with stalls at some easts, all turned about the origin."""
    ids, cos, sin = itertools.count(1), math.cos(turn), math.sin(turn)
    return {
        number: stall(number, north * cos - east * sin, north * sin + east * cos, turn)
        for north, easts in rows.items() for east in easts for number in [next(ids)]
    }  # fmt: skip


def steps(first: int, count: int) -> list[float]:
    return [WIDTH * k for k in range(first, first + count)]


def test_rows_are_lettered_from_north_to_south_and_stalls_numbered_from_west_to_east() -> None:
    stalls = lot({-20.0: steps(0, 3), 0.0: steps(0, 4)})
    assert [row_labels(stalls)[k] for k in sorted(stalls)] == ["B 1", "B 2", "B 3", "A 1", "A 2", "A 3", "A 4"]


def test_back_to_back_rows_are_two_rows() -> None:
    stalls = lot({0.0: steps(0, 5), -LENGTH: steps(0, 5)})
    labels = row_labels(stalls)
    assert {label[0] for label in labels.values()} == {"A", "B"}
    assert labels[1] == "A 1"
    assert labels[6] == "B 1"


def test_islands_and_drives_part_no_row_but_another_lot_is_another_row() -> None:
    stalls = lot({0.0: [*steps(0, 4), *steps(6, 3), *steps(40, 2)]})
    labels = row_labels(stalls)
    assert [labels[k] for k in range(1, 8)] == [f"A {k}" for k in range(1, 8)]
    assert labels[8] == "B 1"


@pytest.mark.parametrize("degrees", [-40, 0, 30])
def test_a_lot_that_is_turned_a_little_has_the_same_labels(degrees: float) -> None:
    rows = {0.0: steps(0, 6), -12.0: steps(0, 6), -17.0: steps(0, 6)}
    assert row_labels(lot(rows, math.radians(degrees))) == row_labels(lot(rows))


def test_rows_from_north_to_south_are_lettered_from_west_to_east() -> None:
    rows = {0.0: steps(0, 6), -20.0: steps(0, 6)}
    labels = row_labels(lot(rows, math.pi / 2))
    # turned a quarter clockwise, the north row lies in the east and its first stall in the north
    assert labels[7] == "A 1"
    assert labels[1] == "B 1"


def test_angled_stalls_are_rows() -> None:
    lean = math.radians(60)
    stalls = {
        k: stall(k, -20.0 * (k > 6), (k - 6 * (k > 6)) * WIDTH / math.sin(lean), math.pi / 2 - lean)
        for k in range(1, 13)
    }
    labels = row_labels(stalls)
    assert [labels[k] for k in range(1, 13)] == [f"{row} {k}" for row in "AB" for k in range(1, 7)]


def test_suggested_stalls_have_no_label_and_stalls_alone_come_last() -> None:
    stalls = lot({0.0: [0.0], -20.0: steps(0, 3)})
    stalls[9] = stall(9, -40.0, 0.0, 0.0, StallState.SUGGESTED)
    assert row_labels(stalls) == {1: "B 1", 2: "A 1", 3: "A 2", 4: "A 3"}
    assert row_labels({}) == {}


def test_every_label_is_given_once_beyond_twenty_six_rows() -> None:
    stalls = lot({-12.0 * k: steps(0, 2) for k in range(30)})
    labels = row_labels(stalls)
    assert len(set(labels.values())) == 60
    assert labels[53] == "AA 1"
