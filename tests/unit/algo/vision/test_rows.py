from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.algo.vision import quads
from hawk.algo.vision.rows import Evidence, RowOptions, RowStalls, complete_rows, row_of, row_stalls
from hawk.algo.vision.seen import FloatArray

WIDTH, LENGTH = 2.6, 5.2


def lattice(
    count: int, direction: float = 0.3, lean: float = math.pi / 2, origin: tuple[float, float] = (10, -20)
) -> FloatArray:
    """Centres of a row that runs along ``direction``; its stalls are turned by ``lean`` from it."""
    pitch = WIDTH / math.sin(lean)
    step = np.array([math.cos(direction), math.sin(direction)]) * pitch
    return np.array(origin) + np.arange(count)[:, None] * step


def stalls_at(centres: FloatArray, angle: float, score: float | FloatArray = 0.9) -> RowStalls:
    ones = np.ones(len(centres))
    return row_stalls(centres[:, 0], centres[:, 1], ones * angle % math.pi, ones * WIDTH, ones * LENGTH, ones * score)


def near(places: FloatArray, value: float = 0.9, elsewhere: float = 0.0) -> Evidence:
    """Evidence that knows where stalls are."""

    def evidence(corners: FloatArray) -> FloatArray:
        apart = np.hypot(*np.moveaxis(corners.mean(axis=1)[:, None] - places, -1, 0)).min(axis=1)
        return np.where(apart < 0.5, value, elsewhere)

    return evidence


@pytest.mark.parametrize("lean", [math.pi / 2, math.radians(60), math.radians(45), math.radians(120)])
@given(direction=st.floats(0, math.pi), missing=st.sets(st.integers(1, 8), max_size=3))
@settings(max_examples=20)
def test_gaps_are_filled_where_there_is_evidence(lean: float, direction: float, missing: set[int]) -> None:
    truth = lattice(10, direction, lean)
    keep = [k for k in range(10) if k not in missing]
    result = complete_rows(stalls_at(truth[keep], direction + lean), near(truth))
    assert len(result) == 10
    assert int(result.inferred.sum()) == len(missing)
    apart = np.hypot(*np.moveaxis(result.centres[:, None] - truth, -1, 0))
    assert (apart.min(axis=0) < 0.05).all()
    assert (quads.angle_between(result.angle, direction + lean) < 0.01).all()
    np.testing.assert_allclose(result.width, WIDTH, atol=0.05)


def test_without_evidence_nothing_is_inferred() -> None:
    truth = lattice(10)
    keep = [0, 1, 2, 5, 6, 9]
    result = complete_rows(stalls_at(truth[keep], 0.3 + math.pi / 2), near(truth, value=0.0))
    assert not result.inferred.any()
    assert result.source.tolist() == list(range(6))


def test_ends_need_more_evidence_than_gaps_and_stop_at_the_first_that_fails() -> None:
    truth = lattice(8)
    given_ = stalls_at(truth[2:5], 0.3 + math.pi / 2)
    assert len(complete_rows(given_, near(truth, value=0.3))) == 3
    assert len(complete_rows(given_, near(truth, value=0.8))) == 3 + 2 + 2
    skipping = near(truth[[0, 2, 3, 4, 6, 7]], value=0.8)
    assert len(complete_rows(given_, skipping)) == 3


def test_members_are_moved_onto_the_lattice() -> None:
    truth = lattice(9)
    crooked = truth + np.random.default_rng(1).normal(0, 0.2, truth.shape)
    result = complete_rows(stalls_at(crooked, 0.3 + math.pi / 2), near(truth, value=0.0))
    before = np.hypot(*(crooked - truth).T)
    after = np.hypot(*(result.centres - truth).T)
    assert after.mean() < 0.6 * before.mean()


def test_two_rows_back_to_back_stay_two_rows() -> None:
    first = lattice(6, 0.0, origin=(0, 0))
    second = first + np.array([0.0, LENGTH])
    both = stalls_at(np.concatenate([first, second]), math.pi / 2)
    rows = row_of(both)
    assert len(set(rows[:6])) == len(set(rows[6:])) == 1
    assert rows[0] != rows[6]
    assert len(complete_rows(both, lambda q: np.zeros(len(q)))) == 12


def test_a_break_in_the_rhythm_is_not_bridged() -> None:
    first = lattice(4, 0.0, origin=(0, 0))
    second = first + np.array([4 * WIDTH + 1.3, 0.0])  # an island of half a stall between them
    result = complete_rows(stalls_at(np.concatenate([first, second]), math.pi / 2), lambda q: np.full(len(q), 0.4))
    apart = np.hypot(*np.moveaxis(result.centres[:, None] - np.concatenate([first, second]), -1, 0)).min(axis=0)
    assert (apart < 0.1).all()
    assert len(result) == 8


def test_an_inferred_stall_never_lies_on_another() -> None:
    truth = lattice(7)
    row = stalls_at(truth[[0, 1, 2, 4, 5, 6]], 0.3 + math.pi / 2)
    across = truth[3] + np.array([0.5, 0.6])
    other = row_stalls(across[:1], across[1:], np.array([0.3]), np.array([WIDTH]), np.array([LENGTH]), np.array([0.95]))
    both = row_stalls(
        *(
            np.concatenate([getattr(row, n), getattr(other, n)])
            for n in ("north", "east", "angle", "width", "length", "score")
        )
    )
    result = complete_rows(both, lambda q: np.ones(len(q)), RowOptions(maximum_end=0))
    corners = result.corners()
    i, j = np.triu_indices(len(result), 1)
    assert quads.overlaps(corners[i], corners[j]).max() <= 0.3
    assert 6 in result.source


def test_weak_loners_are_dropped_and_strong_ones_stay() -> None:
    places = np.array([(0.0, 0), (40, 0), (80, 0), (80, WIDTH)])
    result = complete_rows(stalls_at(places, 0.0, np.array([0.9, 0.5, 0.5, 0.5])), lambda q: np.ones(len(q)))
    assert result.source.tolist() == [0, 2, 3]


def test_sources_point_at_the_given_stalls() -> None:
    truth = lattice(5)
    shuffled = truth[[3, 0, 4, 1, 2]]
    result = complete_rows(stalls_at(shuffled, 0.3 + math.pi / 2), lambda q: np.zeros(len(q)))
    np.testing.assert_allclose(result.centres, shuffled[result.source], atol=1e-6)


def test_no_stalls_stay_none() -> None:
    empty = stalls_at(np.zeros((0, 2)), 0.0)
    assert len(complete_rows(empty, lambda q: np.ones(len(q)))) == 0


def test_the_same_input_gives_the_same_output() -> None:
    truth = lattice(30) + np.random.default_rng(2).normal(0, 0.15, (30, 2))
    given_ = stalls_at(truth[np.random.default_rng(3).random(30) < 0.7], 0.3 + math.pi / 2)
    one, two = (complete_rows(given_, near(truth)) for _ in range(2))
    np.testing.assert_array_equal(one.corners(), two.corners())
