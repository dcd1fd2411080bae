from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.algo.rows.evidence import Ground
from hawk.algo.rows.lot import NO_ROW, complete_rows
from hawk.algo.vision import quads
from hawk.algo.vision.detection import FloatArray
from tests.unit.algo.rows.parking import LENGTH, WIDTH, finds_at, ground_of, joined, row_at

ANGLE = 0.3 + math.pi / 2


def bare(places: FloatArray) -> Ground:
    nothing = np.zeros(places.shape[:-1])
    return Ground(nothing, nothing, nothing, np.ones(places.shape[:-1]))


@pytest.mark.nightly
@pytest.mark.parametrize("lean", [math.pi / 2, math.radians(60), math.radians(120)])
@given(direction=st.floats(0, math.pi), missing=st.sets(st.integers(1, 8), max_size=3))
@settings(max_examples=15)
def test_what_was_missed_in_a_row_is_filled_where_the_ground_shows_it(
    lean: float, direction: float, missing: set[int]
) -> None:
    truth = row_at(10, direction, lean)
    kept = [k for k in range(10) if k not in missing]
    ground = ground_of(truth, direction + lean)
    result = complete_rows(finds_at(truth[kept], direction + lean), ground)
    assert len(result) == 10
    assert int(result.inferred.sum()) == len(missing)
    apart = np.hypot(*np.moveaxis(result.centres[:, None] - truth, -1, 0))
    assert (apart.min(axis=0) < 0.15).all()
    assert (quads.angle_between(result.angle, direction + lean) < 0.02).all()
    assert len(set(result.row)) == 1
    assert sorted(result.number.tolist()) == list(range(10))


def test_back_to_back_rows_are_two_rows_and_inform_each_other() -> None:
    first = row_at(8)
    back = first + LENGTH * np.array([math.cos(ANGLE), math.sin(ANGLE)])
    finds = finds_at(np.concatenate([first, back]), ANGLE)
    result = complete_rows(finds, ground_of(finds.centres, ANGLE))
    assert len(result) == 16
    assert sorted(np.bincount(result.row).tolist()) == [8, 8]


def test_no_two_stalls_overlap() -> None:
    truth = row_at(9)
    across = finds_at(truth[4:5] + np.array([0.6, 0.9]), ANGLE + 0.9, 0.95)
    result = complete_rows(joined(finds_at(truth, ANGLE), across), ground_of(truth, ANGLE))
    corners = result.corners()
    i, j = np.triu_indices(len(result), 1)
    assert quads.overlaps(corners[i], corners[j]).max() <= 0.2


def test_a_find_that_contradicts_its_row_is_left_out() -> None:
    truth = row_at(9)
    between = finds_at((truth[3:4] + truth[4:5]) / 2, ANGLE, 0.7)
    result = complete_rows(joined(finds_at(truth, ANGLE), between), ground_of(truth, ANGLE))
    assert len(result) == 9
    assert 9 not in result.source


def test_weak_finds_alone_are_left_out_and_strong_ones_stay_in_no_row() -> None:
    finds = finds_at(np.array([(0.0, 0), (40, 0)]), 0.0, np.array([0.9, 0.5]))
    result = complete_rows(finds, bare)
    assert result.source.tolist() == [0]
    assert result.row.tolist() == [NO_ROW]


def test_no_finds_stay_none() -> None:
    assert len(complete_rows(finds_at(np.zeros((0, 2)), 0.0), bare)) == 0


def test_the_same_finds_give_the_same_stalls_in_any_order() -> None:
    truth = row_at(20) + np.random.default_rng(2).normal(0, 0.1, (20, 2))
    finds = finds_at(truth, ANGLE)
    order = np.random.default_rng(3).permutation(20)
    ground = ground_of(row_at(20), ANGLE)
    one, two = complete_rows(finds, ground), complete_rows(finds[order], ground)
    np.testing.assert_allclose(np.sort(one.centres, axis=0), np.sort(two.centres, axis=0), atol=1e-6)


def test_stalls_have_the_width_of_their_row_s_pitch() -> None:
    result = complete_rows(finds_at(row_at(8), ANGLE), ground_of(row_at(8), ANGLE))
    np.testing.assert_allclose(result.width, WIDTH, atol=0.05)
    np.testing.assert_allclose(result.length, LENGTH)
