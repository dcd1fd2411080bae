"""The interval about the number of free stalls."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.model.lot_map import SPREADS, Counts, Stall, StallState, free_interval, free_variance, variance_of
from hawk.model.plans import WHOLE_SHARE, ExploreStatus

SHARES = st.floats(0, 1)


def stall(number: int, taken: float, score: float = 1.0) -> Stall:
    return Stall(number, 0.0, 0.0, 0.0, 2.5, 5.0, taken, StallState.FREE, score, 3, 0.0, 1)


def explored(seen: float, *, done: bool = True) -> ExploreStatus:
    return ExploreStatus(done=done, seen=seen)


def test_a_stall_that_is_sure_leaves_nothing_open() -> None:
    assert free_variance(1.0, 0.0) == free_variance(1.0, 1.0) == free_variance(0.0, 0.0) == 0.0
    assert free_interval(Counts(71, 40, 0, free_variance=0.0), explored(1.0)) == (71, 71)


def test_a_stall_whose_state_is_open_adds_most() -> None:
    assert free_variance(1.0, 0.5) == 0.25
    assert free_variance(0.9, 0.1) == pytest.approx(0.81 * 0.19)
    assert variance_of([stall(1, 0.5), stall(2, 0.1, 0.9), stall(3, 1.0)]) == pytest.approx(0.25 + 0.81 * 0.19)


def test_the_bounds_are_standard_deviations_about_the_count() -> None:
    assert free_interval(Counts(71, 40, 2, free_variance=4.0), explored(1.0)) == (
        math.floor(71 - 2 * SPREADS),
        math.ceil(71 + 2 * SPREADS),
    )


def test_patches_that_were_left_out_widen_it_upwards_alone() -> None:
    assert free_interval(Counts(30, 20, 0), explored(0.96)) == (30, 33)
    assert free_interval(Counts(30, 20, 0), explored(1.0)) == (30, 30)


@pytest.mark.parametrize(
    "explore",
    [
        None,
        ExploreStatus(),
        explored(1.0, done=False),
        explored(WHOLE_SHARE - 0.01),
        ExploreStatus(done=True, seen=1.0, lot_known=False),
        ExploreStatus(done=True, seen=1.0, asked_m2=1000.0, unseen_m2=250.0),
    ],
    ids=["no plan", "nothing seen", "exploring", "a part not seen", "no lot", "an outline that cannot be seen whole"],
)
def test_nothing_is_said_of_a_lot_that_was_not_seen_whole(explore: ExploreStatus | None) -> None:
    assert free_interval(Counts(30, 20, 0), explore) is None


def test_the_number_of_free_stalls_is_never_below_zero() -> None:
    assert free_interval(Counts(1, 20, 0, free_variance=4.0), explored(1.0)) == (0, math.ceil(1 + 2 * SPREADS))


@given(st.integers(0, 5000), st.integers(0, 5000), st.floats(0, 500), SHARES)
def test_it_holds_the_count_and_narrows_as_more_is_seen(free: int, taken: int, variance: float, seen: float) -> None:
    counts = Counts(free, taken, 0, free_variance=variance)
    bounds = free_interval(counts, explored(seen))
    if seen < WHOLE_SHARE:
        assert bounds is None
        return
    assert bounds is not None
    low, high = bounds
    assert 0 <= low <= free <= high
    whole = free_interval(counts, explored(1.0))
    assert whole is not None
    assert (low, high) >= (whole[0], whole[1])


@pytest.mark.parametrize(
    ("asked", "unseen", "share"), [(None, None, 0.6), (1000.0, None, 0.6), (1000.0, 250.0, 0.75), (1000.0, 1200.0, 0.0)]
)
def test_an_outline_that_is_done_counts_as_a_whole(asked: float | None, unseen: float | None, share: float) -> None:
    assert ExploreStatus(seen=0.6, asked_m2=asked, unseen_m2=unseen).seen_share == share


@given(SHARES, SHARES)
def test_a_variance_is_that_of_a_yes_or_no(score: float, taken: float) -> None:
    assert 0 <= free_variance(score, taken) <= 0.25
