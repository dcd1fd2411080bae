"""Ends of rows, and rows."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hawk.algo.registration.likelihood import Placement
from hawk.algo.registration.neighbours import row_ends, row_numbers
from tests.unit.algo.registration.lots import PITCH_M, rectangles, rows


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.3])
def test_ends_are_the_first_and_the_last_stall_of_a_row_of_any_direction(angle: float) -> None:
    turned = Placement(angle, (0.0, 0.0), (0.0, 0.0))
    stalls = rows([5, 3])
    ends = row_ends(rectangles(turned.of(stalls.centres), angle))
    assert np.flatnonzero(ends).tolist() == [0, 4, 5, 7]


def test_a_slanted_row_has_two_ends() -> None:
    centres = np.array([(0.0, 3.5 * k) for k in range(6)])
    assert np.flatnonzero(row_ends(rectangles(centres, math.radians(45)))).tolist() == [0, 5]


def test_a_row_at_the_back_of_another_makes_no_neighbours() -> None:
    back_to_back = rectangles(np.array([(5.2 * r, PITCH_M * k) for r in range(2) for k in range(4)]))
    assert np.flatnonzero(row_ends(back_to_back)).tolist() == [0, 3, 4, 7]


def test_no_stalls_have_no_ends() -> None:
    assert row_ends(rectangles(np.zeros((0, 2)))).tolist() == []


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.57])
def test_stalls_side_by_side_are_of_one_row(angle: float) -> None:
    stalls = rows([5, 3, 1])
    turned = Placement(angle, (0.0, 0.0), (0.0, 0.0)).of(stalls.centres)
    assert row_numbers(rectangles(turned, angle)).tolist() == [0] * 5 + [1] * 3 + [2]


def test_a_gap_of_one_stall_makes_two_rows() -> None:
    assert row_numbers(rows([7])[np.array([0, 1, 2, 4, 5, 6])]).tolist() == [0, 0, 0, 1, 1, 1]
    assert row_numbers(rectangles(np.zeros((0, 2)))).tolist() == []
