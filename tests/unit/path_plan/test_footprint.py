from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.algo.path_plan.footprint import Bools, Footprint, Singles, Turns

PICTURE = Footprint(40.0, 24.0, 19.0)
CELLS = np.random.default_rng(3).uniform(-30, 30, (1500, 2)).astype(np.float32)


def in_picture(cells: Singles, heading: float) -> Bools:
    """Which cells a picture taken at the origin shows."""
    along = cells[:, 0] * math.cos(heading) + cells[:, 1] * math.sin(heading)
    across = cells[:, 1] * math.cos(heading) - cells[:, 0] * math.sin(heading)
    return np.asarray((np.abs(along) <= PICTURE.depth / 2) & (np.abs(across) <= PICTURE.width / 2))


@settings(max_examples=40, deadline=None)
@given(st.floats(-3.1, 3.1), st.floats(-3.1, 3.1))
def test_a_turn_shows_what_the_picture_passes_over(begin: float, end: float) -> None:
    turn = math.remainder(end - begin, math.tau)
    passed = np.any([in_picture(CELLS, begin + turn * share) for share in np.linspace(0, 1, 200)], axis=0)
    near = np.hypot(*CELLS.T) <= PICTURE.turned
    shown = PICTURE.swept(CELLS, np.zeros(2), begin, np.array([end]))[0]
    assert not shown[~near].any()
    assert np.count_nonzero(shown[near] != passed[near]) <= 0.01 * len(CELLS)


def test_turning_by_as_much_as_a_cell_needs_shows_it() -> None:
    near = CELLS[np.hypot(*CELLS.T) <= PICTURE.turned]
    left, right = PICTURE.turns_until_shown(near, 0.4)
    assert ((left == 0) == in_picture(near, 0.4)).all()
    assert ((right == 0) == in_picture(near, 0.4)).all()
    for cell, to_left, to_right in zip(near[::50], left[::50], right[::50], strict=True):
        for turn in (-to_left, to_right):
            assert in_picture(cell[None], 0.4 + turn + math.copysign(1e-3, turn))[0]
            assert turn == 0 or not in_picture(cell[None], 0.4 + turn - math.copysign(1e-2, turn))[0]


def test_a_leg_shows_a_disc_about_its_ends_where_the_picture_turns() -> None:
    begin, end = np.array([[0.0, 0.0]]), np.array([[50.0, 0.0]])
    cells = np.array([[-18.0, 0.0], [68.0, 0.0], [-14.0, 14.0], [25.0, 19.0], [25.0, 21.0]], np.float32)
    assert PICTURE.shown(cells, begin, end)[0].tolist() == [False, False, False, True, False]
    assert PICTURE.shown(cells, begin, end, Turns(True, False))[0].tolist() == [True, False, False, True, False]
    assert PICTURE.shown(cells, begin, end, Turns(False, True))[0].tolist() == [False, True, False, True, False]
    straight = Footprint(40.0, 24.0)
    assert straight.shown(cells, begin, end, Turns(True, True))[0].tolist() == [False, False, False, True, False]


def test_between_two_legs_the_turning_picture_shows_the_disc_that_is_counted_on() -> None:
    """Whatever the corner: two legs and the turn on the spot between them."""
    radius = np.hypot(*CELLS.T)
    for turn in np.linspace(0.1, math.pi, 12):
        ends = np.array([[-60.0, 0.0], [60 * math.cos(turn), 60 * math.sin(turn)]])
        legs = PICTURE.shown(CELLS, np.array([ends[0], [0, 0]]), np.array([[0, 0], ends[1]])).any(0)
        turned = np.any([in_picture(CELLS, turn * share) for share in np.linspace(0, 1, 100)], axis=0)
        counted = PICTURE.shown(CELLS, np.zeros((1, 2)), ends[1:], Turns(True, False))[0] & (radius <= PICTURE.turned)
        assert not (counted & ~legs & ~turned).any()


def test_cells_far_off_are_shown_by_no_turn() -> None:
    far = np.array([[50.0, 0.0]], np.float32)
    assert not PICTURE.swept(far, np.zeros(2), 0.0, np.array([3.0])).any()
    assert PICTURE.shown(far, np.zeros((1, 2)), np.ones((1, 2)), Turns(True, True)).sum() == pytest.approx(0)
