from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.algo.rows.evidence import STEPS, strip
from hawk.algo.rows.fit import Finds, Row, fit_row
from hawk.algo.rows.sequence import Chosen, RowOptions, best_sequence, choose
from hawk.algo.vision.detection import FloatArray
from tests.unit.algo.rows.parking import WIDTH, finds_at, ground_of, row_at

ANGLE = 0.3 + math.pi / 2
OPTIONS = RowOptions()


def worth(value: FloatArray, begins: list[int], options: RowOptions) -> float:
    """Return the worth of a sequence, counted one stall after another."""
    total = 0.0
    for k, begin in enumerate(begins):
        goes_on = k > 0 and begins[k - 1] + STEPS == begin
        total += value[begin] - (0.0 if goes_on else options.begin)
        total -= 0.0 if k + 1 < len(begins) and begins[k + 1] == begin + STEPS else options.close
    return total


@pytest.mark.slow
@given(st.lists(st.floats(-6, 8), min_size=1, max_size=30), st.floats(0, 4), st.floats(0, 4))
@settings(max_examples=60)
def test_no_other_sequence_brings_more(values: list[float], begin: float, close: float) -> None:
    value, options = np.array(values), RowOptions(begin=begin, close=close)
    best = best_sequence(value, options).tolist()
    assert all(b - a >= STEPS for a, b in itertools.pairwise(best))
    others: list[list[int]] = [[]] + [list(c) for n in (1, 2, 3) for c in itertools.combinations(range(len(value)), n)]
    allowed = [one for one in others if all(b - a >= STEPS for a, b in itertools.pairwise(one))]
    assert worth(value, best, options) == pytest.approx(max(worth(value, one, options) for one in allowed), abs=1e-6)


def test_nothing_is_chosen_where_nothing_speaks_for_a_stall() -> None:
    assert len(best_sequence(np.full(200, -1.0), OPTIONS)) == 0


def chosen(truth: FloatArray, kept: list[int], shown: list[int], noise: float = 0.0) -> tuple[Row, Chosen, Finds]:
    """Choose in a row of which some stalls were found and some are shown by the ground."""
    rng = np.random.default_rng(1)
    finds = finds_at(truth[kept] + rng.normal(0, noise, (len(kept), 2)), ANGLE)
    row = fit_row(finds, np.arange(len(kept)))
    assert row is not None
    return row, choose(row, strip(row, ground_of(truth[shown], ANGLE), finds), finds, OPTIONS), finds


def test_a_whole_row_is_chosen_as_it_is() -> None:
    truth = row_at(9)
    row, some, _ = chosen(truth, list(range(9)), list(range(9)))
    assert some.source.tolist() == list(range(9))
    assert set(some.run) == {0}
    np.testing.assert_allclose(row.centres(some.t), truth, atol=0.05)
    assert (some.log_odds > 2).all()


@pytest.mark.parametrize(("core", "count"), [(0.0, 8), (0.3, 9)])
def test_a_hole_in_a_row_is_filled_where_the_ground_shows_a_stall_even_weakly_and_an_island_is_not(
    core: float, count: int
) -> None:
    truth, kept = row_at(9), [0, 1, 2, 3, 5, 6, 7, 8]
    finds = finds_at(truth[kept], ANGLE)
    row = fit_row(finds, np.arange(8))
    assert row is not None
    shown = np.where(np.arange(9) == 4, core, 0.95)
    some = choose(row, strip(row, ground_of(truth, ANGLE, core=shown), finds), finds, OPTIONS)
    assert len(some.t) == count
    assert (some.source < 0).sum() == count - 8


def test_a_drive_through_a_row_is_not_filled() -> None:
    truth = row_at(12)
    kept = [0, 1, 2, 3, 7, 8, 9, 10, 11]
    _, some, _ = chosen(truth, kept, kept)
    assert len(some.t) == 9
    assert some.run.tolist() == [0] * 4 + [1] * 5


def test_a_row_goes_on_past_its_finds_where_the_ground_shows_stalls_and_ends_where_it_does_not() -> None:
    truth = row_at(9)
    _, some, _ = chosen(truth, [2, 3, 4, 5], [1, 2, 3, 4, 5, 6, 7])
    assert len(some.t) == 7
    assert (some.source < 0).sum() == 3


def test_one_find_half_a_stall_off_does_not_shift_the_others() -> None:
    truth = row_at(9)
    finds = finds_at(truth.copy(), ANGLE)
    finds.centres[4] += 0.45 * WIDTH * np.array([math.cos(0.3), math.sin(0.3)])
    row = fit_row(finds, np.arange(9))
    assert row is not None
    some = choose(row, strip(row, ground_of(truth, ANGLE), finds), finds, OPTIONS)
    np.testing.assert_allclose(row.centres(some.t), truth, atol=0.2)


def test_stalls_of_a_run_stand_at_even_distances() -> None:
    truth = row_at(12)
    row, some, finds = chosen(truth, list(range(12)), list(range(12)), noise=0.2)
    assert np.ptp(np.diff(some.t)) < 1e-6
    before = np.abs(row.place(finds.centres)[0] - row.place(truth)[0])
    after = np.abs(some.t - row.place(truth)[0])
    assert after.mean() < 0.7 * before.mean()


def test_a_single_stall_needs_more_than_one_of_several() -> None:
    truth = row_at(1)
    finds = finds_at(truth, ANGLE, 0.5)
    row = fit_row(finds, np.arange(1))
    assert row is not None
    bare = choose(row, strip(row, ground_of(truth, ANGLE, core=0.2), finds), finds, OPTIONS)
    assert len(bare.t) == 0
