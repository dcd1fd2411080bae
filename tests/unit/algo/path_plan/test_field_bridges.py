from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from hawk.algo.path_plan.field import with_bridges

SHAPE = (60, 80)
FREE = np.ones(SHAPE, np.uint8)


def ground(*boxes: tuple[int, int, int, int]) -> NDArray[np.uint8]:
    """Boxes of (row, column, rows, columns)."""
    made = np.zeros(SHAPE, np.uint8)
    for row, column, rows, columns in boxes:
        made[row : row + rows, column : column + columns] = 1
    return made


def parts(cells: NDArray[np.uint8]) -> int:
    return int(cv2.connectedComponents(cells, connectivity=8)[0]) - 1


def test_ground_in_one_part_stays_as_it_is() -> None:
    whole = ground((10, 10, 20, 20))
    assert (with_bridges(whole, FREE, 30.0) == whole).all()


def test_two_parts_are_joined_where_they_are_nearest() -> None:
    apart = ground((10, 5, 10, 10), (12, 30, 30, 10))
    joined = with_bridges(apart, FREE, 30.0)
    assert parts(joined) == 1
    rows, columns = np.nonzero(joined & ~apart)
    assert columns.min() >= 15
    assert columns.max() <= 31
    assert rows.min() >= 12 - 2
    assert rows.max() <= 19 + 2


def test_a_gap_that_is_too_wide_is_not_crossed() -> None:
    apart = ground((10, 5, 10, 10), (10, 60, 10, 10))
    assert parts(with_bridges(apart, FREE, 30.0)) == 2


def test_no_corridor_leaves_the_fence() -> None:
    apart = ground((10, 5, 10, 10), (10, 30, 10, 10))
    fenced = FREE.copy()
    fenced[:, 20:25] = 0
    assert (with_bridges(apart, fenced, 60.0) == apart).all()


def test_where_the_shortest_line_leaves_the_fence_another_may_not() -> None:
    apart = ground((5, 5, 50, 10), (5, 30, 50, 10))
    fenced = FREE.copy()
    fenced[:30, 20:25] = 0
    joined = with_bridges(apart, fenced, 60.0)
    assert parts(joined) == 1
    assert not (joined & ~fenced & 1).any()


def test_a_corridor_bends_around_what_lies_outside_when_no_straight_line_is_free() -> None:
    apart = ground((10, 5, 10, 10), (10, 30, 10, 10))
    fenced = FREE.copy()
    fenced[:30, 20:25] = 0
    joined = with_bridges(apart, fenced, 40.0)
    assert parts(joined) == 1
    assert (joined <= fenced).all()
    assert parts(np.ascontiguousarray(joined[::2, ::2])) == 1, "wide enough for routing, which takes every other cell"
    assert (with_bridges(apart, fenced, 20.0) == apart).all(), "too long"


def test_a_corridor_does_not_squeeze_along_a_fence_that_leaves_too_little_room() -> None:
    apart = ground((10, 5, 10, 10), (10, 30, 10, 10))
    fenced = FREE.copy()
    fenced[:, 20:25] = 0
    fenced[29:31, 20:25] = 1
    assert (with_bridges(apart, fenced, 60.0) == apart).all()


BOX = st.tuples(st.integers(0, 50), st.integers(0, 70), st.integers(1, 12), st.integers(1, 12))


@pytest.mark.slow
@settings(max_examples=60)
@given(st.lists(BOX, min_size=1, max_size=6), st.integers(0, 3))
def test_it_only_ever_adds_ground_inside_the_fence_and_never_parts_it(
    boxes: list[tuple[int, int, int, int]], walls: int
) -> None:
    fenced = FREE.copy()
    for wall in range(walls):
        fenced[: 40 + 5 * wall, 20 * (wall + 1)] = 0
    apart = np.asarray(ground(*boxes) & fenced, np.uint8)
    joined = with_bridges(apart, fenced, 200.0)
    assert (joined >= apart).all()
    assert (joined <= fenced).all()
    assert parts(joined) <= parts(apart)
