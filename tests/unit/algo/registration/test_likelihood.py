"""Placements, and what counts for and against a place."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from hawk.algo.registration.likelihood import DEVIATION_M, Likelihood, Placement, StallMap
from hawk.algo.rows.fit import Rectangles
from tests.unit.algo.registration.lots import ground_about, map_of, rectangles, rows

HERE = Placement(0.0, (0.0, 0.0), (0.0, 0.0))
SHORT = st.floats(-5, 5)


@given(st.floats(-math.pi, math.pi), SHORT, SHORT, SHORT, SHORT)
def test_a_placement_there_and_back_changes_nothing(turn: float, a: float, b: float, c: float, d: float) -> None:
    placement = Placement(turn, (a, b), (c, d))
    places = np.array([[1.0, 2.0], [-30.0, 7.0]])
    assert placement.back(placement.of(places)) == pytest.approx(places)


@given(st.floats(-0.2, 0.2))
def test_a_placement_turns_directions_by_its_turn(turn: float) -> None:
    there = Placement(turn, (3.0, -1.0), (5.0, 5.0)).of(np.array([[0.0, 0.0], [1.0, 0.0]]))
    north, east = there[1] - there[0]
    assert math.atan2(east, north) == pytest.approx(turn)


def test_the_same_map_pairs_every_stall_with_itself() -> None:
    known = map_of(rows([6, 4]))
    fit = Likelihood(known, known).fit(HERE)
    assert fit.pairs[:, 0].tolist() == fit.pairs[:, 1].tolist()
    assert sorted(fit.pairs[:, 0].tolist()) == list(range(10))
    assert fit.share == 1.0


def test_a_stall_counts_against_a_place_only_on_ground_that_both_saw() -> None:
    known, fewer = map_of(rows([8])), rectangles(rows([8]).centres[:6])
    looked_there = StallMap(fewer, known.seen)
    looked_less = StallMap(fewer, ground_about(fewer, 3.0))
    there, less = (Likelihood(known, found).fit(HERE) for found in (looked_there, looked_less))
    assert len(there.pairs) == len(less.pairs) == 6
    assert (there.known_in_view, less.known_in_view) == (8, 6)
    assert there.score < less.score


def test_an_end_says_less_than_a_stall_within_a_row() -> None:
    known = map_of(rows([9]))
    without_end = StallMap(known.stalls[np.arange(8)], known.seen)
    without_middle = StallMap(known.stalls[np.delete(np.arange(9), 4)], known.seen)
    whole = Likelihood(known, known).fit(HERE).score
    lost_end, lost_middle = (whole - Likelihood(known, m).fit(HERE).score for m in (without_end, without_middle))
    assert 0 < lost_end < lost_middle


@given(st.floats(0.0, 0.9))
def test_a_pair_brings_less_the_farther_it_is_apart_and_costs_no_more_than_two_alone(apart: float) -> None:
    known = map_of(rectangles(np.array([[0.0, 0.0], [0.0, 40.0]])))
    north = np.array([apart, 0.0])
    moved = StallMap(rectangles(known.stalls.centres + north), known.seen)
    alone = 2 * math.log((1 - 0.08) / 0.08)
    expected = 2 * max(1 - 0.5 * (apart / DEVIATION_M) ** 2, -alone)
    assert Likelihood(known, moved).fit(HERE).score == pytest.approx(expected)


def test_stalls_of_another_direction_are_no_pair() -> None:
    known = map_of(rows([4]))
    crossed = StallMap(rectangles(known.stalls.centres, math.pi / 2), known.seen)
    assert len(Likelihood(known, crossed).fit(HERE).pairs) == 0


def test_no_stall_is_two() -> None:
    known = map_of(rectangles(np.array([[0.0, 0.0], [0.0, 2.6]])))
    doubled = rectangles(np.array([[0.0, 0.1], [0.0, -0.3], [0.0, 2.6]]))
    pairs = Likelihood(known, StallMap(doubled, shapely.box(-20, -20, 20, 20))).fit(HERE).pairs
    assert pairs.tolist() == [[0, 0], [1, 2]]


def rows_off(known: StallMap, found: Rectangles) -> float:
    likelihood = Likelihood(known, StallMap(found, known.seen))
    return likelihood.rows_off(HERE, likelihood.fit(HERE).pairs)


def test_rows_that_lie_off_are_distinguished_from_stalls_that_are_off_each_by_itself() -> None:
    known = map_of(rows([12] * 6))
    rng = np.random.default_rng(1)
    jittered = rectangles(known.stalls.centres + rng.normal(0, 0.3, (72, 2)))
    off = np.array([0.6, -0.6, -0.6, 0.6, 0.6, -0.6])
    slid = rectangles(known.stalls.centres + np.repeat(np.column_stack([np.zeros(6), off]), 12, axis=0))
    each, whole = (rows_off(known, stalls) for stalls in (jittered, slid))
    assert each < 0.2
    assert 0.5 < whole < 0.6


@pytest.mark.parametrize("stretch", [[[1.015, 0.0], [0.0, 1.015]], [[1.0, 0.01], [0.0, 1.0]]])
def test_a_map_that_is_stretched_or_sheared_as_a_whole_is_no_other_lot(stretch: list[list[float]]) -> None:
    one = rows([10] * 4).centres
    known = map_of(rectangles(np.vstack([one, one + np.array([0.0, 40.0])])))
    middle = known.stalls.centres.mean(axis=0)
    found = rectangles((known.stalls.centres - middle) @ np.array(stretch) + middle)
    assert rows_off(known, found) < 0.01


def test_rows_of_few_pairs_say_nothing_about_where_they_lie() -> None:
    known = map_of(rows([2, 2, 2]))
    slid = rectangles(known.stalls.centres + np.repeat([[0, 0.6], [0, -0.6], [0, 0.6]], 2, axis=0))
    assert rows_off(known, slid) == 0.0
    assert rows_off(known, rectangles(known.stalls.centres + 500.0)) == 0.0
