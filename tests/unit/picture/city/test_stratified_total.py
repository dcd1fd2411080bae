"""The difference estimator: exact where all is checked, and its interval holds the truth as often as it says."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.picture.city.stratified_total import LEAST_DRAWN, CheckedStratum, allocated, checked_total


def test_all_windows_checked_give_the_truth_itself() -> None:
    strata = [
        CheckedStratum(3, np.array([1.0, 0.0, -2.0])),
        CheckedStratum(0, np.zeros(0)),
        CheckedStratum(1, np.ones(1)),
    ]
    found = checked_total(100.0, strata)
    assert (found.total, found.least, found.most) == (100.0, 100, 100)


def test_a_few_windows_without_an_error_are_no_proof() -> None:
    found = checked_total(100.0, [CheckedStratum(50, np.zeros(5))])
    assert found.total == 100.0
    assert found.least <= 90 < 110 <= found.most
    more = checked_total(100.0, [CheckedStratum(50, np.zeros(40))])
    assert found.least < more.least <= 100 <= more.most < found.most


def city(rng: np.random.Generator) -> tuple[list[np.ndarray], list[float]]:
    """Return the differences of all windows by stratum, and their expected spreads: errors are rare."""
    shapes = ((300, 0.04, 1.5), (200, 0.15, 1.2), (200, 0.35, 1.5), (200, 0.6, 2.5))
    every = []
    for size, share, scale in shapes:
        wrong = rng.random(size) < share
        every.append(np.where(wrong, np.round(rng.normal(0.4, 1.0, size) * scale + rng.choice([-1, 1], size)), 0.0))
    return every, [0.2, 0.3, 0.8, 2.0]


@pytest.mark.parametrize("count", [30, 50, 100])
def test_the_interval_holds_the_truth_in_nine_of_ten_samples(count: int) -> None:
    """Of 600 samples of drawn cities; rare errors make few windows say little, so that the share may be lower."""
    rng = np.random.default_rng(7)
    held, widths = 0, []
    for _ in range(600):
        every, spreads = city(rng)
        drawn = allocated([len(part) for part in every], spreads, count)
        strata = [
            CheckedStratum(len(part), rng.choice(part, n, replace=False)) for part, n in zip(every, drawn, strict=True)
        ]
        truth = 5000 + sum(float(part.sum()) for part in every)
        found = checked_total(5000.0, strata)
        held += found.least <= truth <= found.most
        widths.append(found.most - found.least)
    assert 0.87 <= held / 600 <= 0.95, held / 600
    assert np.median(widths) < 1000


@given(st.lists(st.integers(0, 400), min_size=1, max_size=5), st.integers(1, 500))
def test_no_more_windows_are_drawn_than_there_are_and_as_many_as_are_asked_for(sizes: list[int], count: int) -> None:
    drawn = allocated(sizes, [0.2 + k for k in range(len(sizes))], count)
    least = [min(size, LEAST_DRAWN) for size in sizes]
    assert all(few <= each <= size for few, each, size in zip(least, drawn, sizes, strict=True))
    assert sum(drawn) == max(min(count, sum(sizes)), sum(least))


def test_windows_in_doubt_are_drawn_more_often() -> None:
    assert allocated([100, 100], [0.2, 1.0], 60) == [10, 50]
