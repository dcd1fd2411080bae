from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from hawk.stats.counts import count
from hawk.stats.flow import LONGEST_GAP_H, USUAL_CHANGES, USUAL_DRIFT, Flow, Moves, arrivals, rates
from hawk.stats.turnover import least, longest_gap, markov, most, turnover
from hawk.stats.values import FREE, TAKEN, UNSEEN, Panel
from tests.unit.stats.panels import at, everything, panel

STALLS, BEGIN, END, MEAN_H, GAP_H = 400, 8.0, 14.0, 1.5, 1.2


def stays(rng: np.random.Generator, *, is_exponential: bool) -> list[list[tuple[float, float]]]:
    """Return the stays of each stall, hours: lengths of a mean of 1.5 h, log-normal with sigma .8 or exponential."""
    found = []
    for _ in range(STALLS):
        now, mine = -12.0, []
        while now < END:
            now += rng.exponential(GAP_H)
            length = rng.exponential(MEAN_H) if is_exponential else rng.lognormal(math.log(MEAN_H) - 0.32, 0.8)
            mine.append((now, now + length))
            now += length
        found.append(mine)
    return found


def seen_at(found: list[list[tuple[float, float]]], gap_h: float) -> tuple[Panel, float]:
    """Return surveys that far apart, and the true arrivals between the first and the last one."""
    moments = np.arange(BEGIN, END, gap_h)
    states = [[int(any(a <= t < b for a, b in mine)) for mine in found] for t in moments]
    came = sum(moments[0] < a <= moments[-1] for mine in found for a, _ in mine)
    return panel([at(float(t)) for t in moments], states, a_row=100), came


def ratios(found: Panel, real: float) -> tuple[float, float]:
    """Return the changes seen, and the Markov estimate without an interval, over the true arrivals."""
    moves = Moves.of(found, everything(found))
    table = moves.table[:, 0]
    free, taken = table.sum(axis=2).T
    comes, leaves = rates(table[:, 0, 1] / free, table[:, 1, 0] / taken, moves.hours)
    markov = STALLS * arrivals(comes, leaves, taken / STALLS, moves.hours).sum()
    return float(table[:, 0, 1].sum() / real), float(markov / real)


@pytest.mark.parametrize("gap_h", [0.25, 0.5, 1.0])
def test_the_markov_estimate_is_right_for_exponential_stays(gap_h: float) -> None:
    _, markov = ratios(*seen_at(stays(np.random.default_rng(1), is_exponential=True), gap_h))
    assert markov == pytest.approx(1.0, abs=0.08)


@pytest.mark.parametrize(("gap_h", "changes", "markov"), [(0.25, 0.85, 1.1), (0.5, 0.7, 1.2), (1.0, 0.45, 1.3)])
def test_usual_stays_lie_between_the_changes_and_the_markov_estimate(
    gap_h: float, changes: float, markov: float
) -> None:
    shown, estimate = ratios(*seen_at(stays(np.random.default_rng(2), is_exponential=False), gap_h))
    assert shown == pytest.approx(changes, abs=0.12)
    assert 1.0 < estimate < markov + 0.4


def test_a_bracket_holds_the_arrivals_and_the_mean_stay_and_has_no_end_where_surveys_are_far_apart() -> None:
    drawn = stays(np.random.default_rng(3), is_exponential=False)
    near, came = seen_at(drawn, 0.25)
    moves = Moves.of(near, everything(near))
    (found,) = turnover(moves, longest_gap(moves))
    assert found.arrivals.low is not None
    assert found.arrivals.high is not None
    assert found.stay_hours.low
    assert found.stay_hours.high
    assert found.arrivals.low <= came <= found.arrivals.high
    assert found.stay_hours.low <= MEAN_H <= found.stay_hours.high
    far, came = seen_at(drawn, 1.0)
    moves = Moves.of(far, everything(far))
    (found,) = turnover(moves, longest_gap(moves))
    assert (found.arrivals.high, found.stay_hours.low, found.open_pairs) == (None, None, found.pairs)
    assert found.arrivals.low is not None
    assert found.arrivals.low <= came


def test_wrong_states_make_no_arrivals() -> None:
    rng = np.random.default_rng(4)
    real = np.tile(rng.random(300) < 0.5, (5, 1))
    flipped: NDArray[np.bool_] = rng.random(real.shape) < 0.05
    seen = panel([at(9 + 0.25 * k) for k in range(5)], np.where(real ^ flipped, TAKEN, FREE).tolist(), 0.95, a_row=60)
    raw = int(((seen.state[:-1] == FREE) & (seen.state[1:] == TAKEN)).sum())
    moves = Moves.of(seen, everything(seen))
    assert raw > 40
    assert float(least(moves).sum()) < raw / 8


@given(seed=st.integers(0, 2**32 - 1), surveys=st.integers(2, 4), stalls=st.integers(1, 12))
def test_tables_are_those_of_the_inverse_matrices_of_wrong_states(seed: int, surveys: int, stalls: int) -> None:
    rng = np.random.default_rng(seed)
    states = rng.integers(UNSEEN, TAKEN + 1, (surveys, stalls))
    found = panel([at(9 + number / 4) for number in range(surveys)], states.tolist(), float(rng.uniform(0.6, 1.0)))
    moves = Moves.of(found, everything(found))
    for pair, table in enumerate(moves.table[:, 0]):
        before, after = states[pair], states[pair + 1]
        raw = np.array([[((before == a) & (after == b)).sum() for b in (FREE, TAKEN)] for a in (FREE, TAKEN)])
        inverse = [np.linalg.inv(called(found, number)) for number in (pair, pair + 1)]
        right = np.maximum(inverse[0].T @ raw @ inverse[1], 0.0)
        expected = right * raw.sum() / max(right.sum(), 1e-12)
        np.testing.assert_allclose(table, expected, rtol=1e-4, atol=1e-4)


def called(found: Panel, survey: int) -> NDArray[np.float64]:
    """Return the chances that a stall which is free or taken (rows) is called free or taken (columns)."""
    state, taken = found.state[survey], found.taken_probability[survey].astype(np.float64)
    chances = []
    for true, right, wrong in ((1 - taken, FREE, TAKEN), (taken, TAKEN, FREE)):
        missed, met = true[state == wrong].sum(), true[state == right].sum()
        chances.append(min(missed / max(met + missed, 1e-9), 0.45))
    return np.array([[1 - chances[0], chances[0]], [chances[1], 1 - chances[1]]])


def test_the_estimate_of_near_pairs_is_the_same_beside_pairs_that_are_far_apart() -> None:
    found, _ = seen_at(stays(np.random.default_rng(5), is_exponential=True), 0.5)
    moves, longest_h = Moves.of(found, everything(found)), 0.75
    far = replace(moves, hours=np.where(np.arange(len(moves.hours)) % 2, moves.hours, 3.0))
    alone, beside = markov(moves, longest_h), markov(far, longest_h)
    for one, other in zip(alone, beside, strict=True):
        assert np.isfinite(one).all()
        assert np.isnan(other[::2]).all()
        np.testing.assert_array_equal(other[1::2], one[1::2])
    assert np.isnan(markov(moves, None)).all()


def test_nights_and_long_gaps_are_no_pairs() -> None:
    seen = panel([at(9), at(9 + LONGEST_GAP_H + 1), at(9, days=1), at(9.5, days=1)], [[FREE, TAKEN]] * 4)
    moves = Moves.of(seen, everything(seen))
    assert moves.begin.tolist() == [2]


def test_without_surveys_that_follow_each_other_nothing_is_said() -> None:
    seen = panel([at(9), at(9.5)], [[UNSEEN] * 3] * 2)
    moves = Moves.of(seen, everything(seen))
    (found,) = turnover(moves, longest_gap(moves))
    assert (found.arrivals.low, found.arrivals.high, found.pairs) == (None, None, 0)
    assert Flow.of(moves, count(seen, everything(seen))).changes == USUAL_CHANGES


@pytest.mark.parametrize("surveys", [3, 4])
def test_the_movement_of_a_lot_is_its_own_from_three_pairs_on(surveys: int) -> None:
    states = [[FREE, TAKEN] * 10, [TAKEN, FREE] * 10] * 2
    seen = panel([at(9 + number / 2) for number in range(surveys)], states[:surveys])
    flow = Flow.of(Moves.of(seen, everything(seen)), count(seen, everything(seen)))
    assert (flow == Flow(USUAL_CHANGES, USUAL_DRIFT)) is (surveys == 3)


@given(come=st.floats(0, 0.45), leave=st.floats(0, 0.45), hours=st.floats(0.05, 6))
def test_rates_give_back_the_chances_that_they_were_fitted_to(come: float, leave: float, hours: float) -> None:
    one, other = rates(np.array(come), np.array(leave), np.array(hours))
    both = float(one + other)
    settled = float(one) / both if both else 0.0
    assert settled * (1 - math.exp(-both * hours)) == pytest.approx(come, abs=1e-6)


def test_chances_of_looks_that_are_too_far_apart_have_no_rates_and_no_end() -> None:
    one, _ = rates(np.array(0.6), np.array(0.5), np.array(1.0))
    assert np.isnan(one)
    flipping = panel([at(9), at(9.1)], [[FREE, TAKEN] * 20, [TAKEN, FREE] * 20])
    moves = Moves.of(flipping, everything(flipping))
    assert np.isnan(most(moves, 1.0)).all()
