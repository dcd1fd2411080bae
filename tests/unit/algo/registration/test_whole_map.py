"""Whole maps find their place on an earlier one, or say that they do not know it."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.algo.registration.likelihood import Placement, StallMap
from hawk.algo.registration.whole_map import MARGIN, REACH_M, Doubt, Registration, register
from hawk.algo.rows.fit import Rectangles
from tests.examples import examples
from tests.unit.algo.registration.lots import PITCH_M, flown_again, map_of, rectangles, rows

LOT = map_of(rows([14, 9, 12, 6], [0.0, 5.0, 1.5, 14.0]))
SEEDS = st.integers(0, 2**32 - 1)


def placed(turn_deg: float, shift: tuple[float, float], known: StallMap = LOT) -> Placement:
    north, east = known.stalls.centres.mean(axis=0).tolist()
    return Placement(math.radians(turn_deg), shift, (north, east))


def apart(registration: Registration, truth: Placement, found: StallMap) -> float:
    """Return how far the best place puts the stalls from where they are, metres."""
    assert registration.best is not None
    places = found.stalls.centres
    return float(np.hypot(*(registration.best.placement.of(places) - truth.of(places)).T).max())


@pytest.mark.nightly
@settings(max_examples=examples(12), deadline=None)
@given(st.floats(-4, 4), st.floats(0, 4.4), st.floats(-math.pi, math.pi), SEEDS)
def test_a_lot_is_found_wherever_it_lies_within_reach(turn: float, size: float, toward: float, seed: int) -> None:
    truth = placed(turn * 0.98, (size * math.cos(toward), size * math.sin(toward)))
    found, which = flown_again(LOT, truth, np.random.default_rng(seed))
    registration = register(LOT, found)
    assert registration.is_certain, registration.doubt
    assert apart(registration, truth, found) < 0.5
    assert (which[registration.pairs[:, 1]] == registration.pairs[:, 0]).all()
    assert len(registration.pairs) > 0.95 * len(found.stalls)


@pytest.mark.nightly
@settings(max_examples=examples(12), deadline=None)
@given(st.integers(2, 4), SEEDS)
def test_a_map_with_many_errors_is_right_or_not_certain(count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    known = map_of(rows(rng.integers(3, 12, count).tolist(), (PITCH_M * rng.integers(0, 4, count)).tolist()))
    truth = placed(rng.uniform(-2, 2), (rng.uniform(-2, 2), rng.uniform(-2, 2)), known)
    found, which = flown_again(known, truth, rng, missed=0.2, deviation=0.25)
    registration = register(known, found)
    assert not registration.is_certain or (which[registration.pairs[:, 1]] == registration.pairs[:, 0]).all()


@pytest.mark.slow
def test_a_row_of_forty_equal_stalls_without_an_end_in_view_is_not_certain() -> None:
    row = rows([40])
    ground = shapely.box(-10, 8, 10, 40 * PITCH_M - 8)
    inner = row[(row.centres[:, 1] > 10) & (row.centres[:, 1] < 40 * PITCH_M - 10)]
    registration = register(StallMap(row, ground), StallMap(inner, ground))
    assert registration.doubt is Doubt.ALIKE
    assert registration.lead < MARGIN
    assert len(registration.pairs) == 0


def test_one_row_is_not_certain_even_with_both_ends() -> None:
    """Finds past an end, and ends that are missed, are too usual."""
    assert register(map_of(rows([40])), map_of(rows([40]))).doubt is Doubt.ALIKE


def test_both_places_are_given_where_two_fit_alike() -> None:
    registration = register(map_of(rows([20])), map_of(rows([20])))
    assert registration.best is not None
    assert registration.second is not None
    shifts = [candidate.placement.shift for candidate in (registration.best, registration.second)]
    assert math.dist(*shifts) == pytest.approx(PITCH_M, abs=0.3)


@pytest.mark.slow
def test_half_of_a_lot_is_registered_by_what_both_saw() -> None:
    truth = placed(1.0, (1.0, -2.0))
    whole, which = flown_again(LOT, truth, np.random.default_rng(4))
    west = whole.stalls.centres[:, 1] < 16.0
    half = StallMap(whole.stalls[west], whole.seen.intersection(shapely.box(-100, -100, 100, 18.5)))
    registration = register(LOT, half)
    assert registration.is_certain
    assert (which[west][registration.pairs[:, 1]] == registration.pairs[:, 0]).all()


@pytest.mark.slow
def test_a_row_that_was_painted_again_does_not_mislead_the_others() -> None:
    kept = LOT.stalls[LOT.stalls.centres[:, 0] < 40]
    wider = rectangles(np.array([(45.0, 14.0 + 3.1 * k) for k in range(5)]))
    both = (np.concatenate([getattr(kept, n), getattr(wider, n)]) for n in ("centres", "angle", "width", "length"))
    painted = StallMap(Rectangles(*both), LOT.seen)
    registration = register(LOT, painted)
    assert registration.is_certain
    assert np.count_nonzero(registration.pairs[:, 0] < 35) == 35


@pytest.mark.slow
def test_another_lot_is_not_taken_for_this_one() -> None:
    other = map_of(rows([5, 13, 7, 11], [9.0, 0.0, 12.0, 2.2], pitch=2.85))
    registration = register(LOT, other)
    assert not registration.is_certain
    assert len(registration.pairs) == 0


@pytest.mark.slow
@pytest.mark.parametrize("stalls", [2, 3, 4])
def test_a_lot_farther_off_than_reach_is_not_certain(stalls: int) -> None:
    off = placed(0.0, (0.0, REACH_M + stalls * PITCH_M))
    found, _ = flown_again(LOT, off, np.random.default_rng(stalls))
    assert register(LOT, found).doubt is Doubt.FAR


@pytest.mark.parametrize("count", [0, 1, 3])
def test_too_few_stalls_are_said(count: int) -> None:
    few = StallMap(LOT.stalls[np.arange(count)], LOT.seen)
    for registration in (register(LOT, few), register(few, LOT)):
        assert registration.doubt is Doubt.TOO_FEW
        assert registration.lead == 0.0


def test_maps_far_from_each_other_have_too_few_stalls_in_common() -> None:
    far = StallMap(rectangles(LOT.stalls.centres + 500.0), shapely.transform(LOT.seen, lambda places: places + 500.0))
    assert register(LOT, far).doubt is Doubt.TOO_FEW


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(10))
def test_another_lot_with_the_same_distances_between_rows_of_the_same_lengths_is_not_taken_for_this_one(
    seed: int,
) -> None:
    rng = np.random.default_rng(seed)
    counts = rng.integers(8, 22, 8).tolist()
    one, other = (map_of(rows(counts, rng.uniform(0, PITCH_M, 8).tolist())) for _ in range(2))
    assert register(one, other).doubt in (Doubt.DIFFERENT, Doubt.ALIKE)
