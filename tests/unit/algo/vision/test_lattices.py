"""All rows at once give what they give one after another."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.algo.vision import quads
from hawk.algo.vision.lattices import fit_lattices
from hawk.algo.vision.rows import Evidence, RowOptions, RowStalls, complete_rows, row_stalls
from hawk.algo.vision.seen import FloatArray
from tests.unit.algo.vision import row_by_row

ONE = np.ones(1)
COLUMNS = ("north", "east", "angle", "width", "length", "score")


def lot(rng: np.random.Generator, lean: float) -> RowStalls:
    """Some double rows with holes, breaks in the rhythm, crooked places and loners, all turned somehow."""
    turn, noise = rng.uniform(0, math.pi), rng.uniform(0, 0.35)
    places = []
    for row in range(int(rng.integers(1, 6))):
        count = int(rng.integers(1, 16))
        along = np.arange(count) * 2.6 / math.sin(lean) + rng.uniform(-5, 5)
        along[rng.integers(count) :] += rng.choice([0.0, 0.0, 1.3, 4.0])
        stay = rng.random(count) > 0.25
        places += [(a, row * 5.3 + row // 2 * 7.0) for a in along[stay]]
    places += rng.uniform(-20, 60, (3, 2)).tolist()
    spots = np.array(places) + rng.normal(0, noise, (len(places), 2))
    c, s = math.cos(turn), math.sin(turn)
    spots = spots @ np.array([[c, s], [-s, c]])
    angle = (turn + lean + rng.normal(0, 0.05, len(spots))) % math.pi
    width, length = rng.normal(2.6, 0.15, len(spots)), rng.normal(5.2, 0.2, len(spots))
    return row_stalls(spots[:, 0], spots[:, 1], angle, width, length, rng.uniform(0.3, 1, len(spots)))


def patchy(seed: int) -> Evidence:
    """Evidence that differs from place to place."""

    def evidence(corners: FloatArray) -> FloatArray:
        middle = corners.mean(axis=1)
        return np.asarray(np.abs(np.sin(middle[:, 0] * 0.7 + seed) * np.cos(middle[:, 1] * 0.5)))

    return evidence


def by_place(stalls: RowStalls) -> FloatArray:
    table = np.column_stack([np.round(getattr(stalls, name), 6) for name in (*COLUMNS, "source")])
    return np.asarray(table[np.lexsort(table[:, :2].T)])


@pytest.mark.slow
@pytest.mark.parametrize("lean", [math.pi / 2, math.radians(60)])
@given(seed=st.integers(0, 10_000))
@settings(max_examples=40)
def test_rows_at_once_are_completed_as_one_by_one(lean: float, seed: int) -> None:
    stalls, options = lot(np.random.default_rng(seed), lean), RowOptions()
    quick = complete_rows(stalls, patchy(seed), options)
    slow = row_by_row.complete_rows(stalls, patchy(seed), options)
    np.testing.assert_allclose(by_place(quick), by_place(slow), atol=2e-6)


def test_the_comparison_has_lattices_to_compare() -> None:
    implied = [complete_rows(lot(np.random.default_rng(k), math.pi / 2), patchy(k)).inferred.sum() for k in range(20)]
    assert sum(implied) > 40


def test_no_row_is_long_enough() -> None:
    one = row_stalls(ONE, ONE, ONE, ONE, ONE, ONE)
    fitted = fit_lattices(one.centres, one.angle, one.width, one.length, one.score, np.zeros(1, np.intp), 6)
    assert len(fitted) == 0
    assert len(fitted.member) == 0


BOX = st.tuples(
    st.floats(-4, 4), st.floats(-4, 4), st.floats(0, math.pi), st.floats(0.5, 4), st.floats(0.5, 7), st.booleans()
)


@pytest.mark.slow
@given(st.lists(st.tuples(BOX, BOX), max_size=20), st.floats(0.05, 0.9))
def test_overlap_more_is_what_the_overlap_says(pairs: list[tuple[tuple[float, ...], ...]], limit: float) -> None:
    first, second = (boxes([pair[k] for pair in pairs]) for k in (0, 1))
    np.testing.assert_array_equal(quads.overlap_more(first, second, limit), quads.overlaps(first, second) > limit)


def boxes(values: list[tuple[float, ...]]) -> FloatArray:
    """Quads (N, 4, 2), some with their corners in the other order."""
    table = np.array(values).reshape(-1, 6)
    corners = quads.corners(*table[:, :5].T)
    return np.asarray(np.where(table[:, 5, None, None] > 0, corners[:, ::-1], corners))
