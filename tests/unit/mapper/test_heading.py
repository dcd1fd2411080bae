"""A wrong compass is learned; what drifting GNSS may explain is not laid to it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.algo.mapper.heading import Heading

BASE_M = 3.0
NOISE = 0.014


def flown(compass: float, slips: list[float], seed: int = 1) -> list[float]:
    """Return the turn, degrees, after each comparison of a flight; ``slips`` are what GNSS adds, radians."""
    heading, rng, turns = Heading(), np.random.default_rng(seed), []
    for slip in slips:
        heading.move(BASE_M)
        heading.learn(compass + slip + float(rng.normal(0, NOISE)))
        turns.append(math.degrees(heading.turn))
    return turns


def test_gnss_that_drifts_to_and_fro_hardly_turns_the_map() -> None:
    """A filter that takes all of it for the compass's turns by the whole .43 degrees."""
    to_and_fro = [0.0075] * 13 + [-0.0075] * 13
    turns = np.array([flown(0.0, to_and_fro, seed) for seed in range(20)])
    assert math.sqrt(float(np.mean(turns[:, 4:] ** 2))) < 0.15
    assert float(np.abs(turns[:, -1]).max()) < 0.3


@pytest.mark.parametrize("degrees", [-5.0, -2.0, 2.0, 4.0])
@pytest.mark.parametrize("seed", range(5))
def test_a_wrong_compass_is_learned_within_forty_metres(degrees: float, seed: int) -> None:
    assert flown(math.radians(degrees), [0.0] * 13, seed)[-1] == pytest.approx(degrees, abs=0.5)


def test_a_compass_that_changes_is_followed() -> None:
    heading = Heading()
    for told in [0.0] * 20 + [math.radians(3.0)] * 60:
        heading.move(BASE_M)
        heading.learn(told)
    assert math.degrees(heading.turn) == pytest.approx(3.0, abs=0.8)


def test_more_than_any_compass_is_wrong_is_not_believed() -> None:
    assert max(flown(math.radians(20.0), [0.0] * 50)) <= 6.0 + 1e-9


def test_before_the_drone_moved_nothing_is_known() -> None:
    assert Heading().turn == 0.0


@given(st.floats(-0.1, 0.1))
def test_what_an_earlier_flight_learned_is_taken_up(turn: float) -> None:
    heading = Heading()
    heading.restore(turn)
    assert heading.turn == pytest.approx(turn, abs=1e-9)


@given(st.lists(st.floats(-0.1, 0.1), min_size=1, max_size=40))
def test_never_more_than_was_told(told: list[float]) -> None:
    heading = Heading()
    for one in told:
        heading.move(BASE_M)
        heading.learn(one)
    assert abs(heading.turn) <= max(map(abs, told)) + 1e-9
