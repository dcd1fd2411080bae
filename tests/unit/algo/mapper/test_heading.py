"""A wrong compass is learned; an error that drifting GNSS may explain is not attributed to it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.algo.mapper.register import Heading

STEP = complex(3.0, 0.0)
SECONDS = 0.75
NOISE = 0.014


def flown(compass: float, slips: list[float], seed: int = 1) -> list[float]:
    """Return the turn, degrees, after each comparison of a flight; ``slips`` are what GNSS adds, radians."""
    heading, rng, turns = Heading(), np.random.default_rng(seed), []
    for slip in slips:
        heading.move(abs(STEP), SECONDS)
        heading.learn(compass + slip + float(rng.normal(0, NOISE)), STEP, SECONDS)
        turns.append(math.degrees(heading.turn))
    return turns


def test_gnss_that_drifts_to_and_fro_hardly_turns_the_map() -> None:
    """A filter that takes all of it for the compass's turns by the whole .43 degrees."""
    to_and_fro = [0.0075] * 13 + [-0.0075] * 13
    turns = np.array([flown(0.0, to_and_fro, seed) for seed in range(20)])
    assert math.sqrt(float(np.mean(turns[:, 4:] ** 2))) < 0.15
    assert float(np.abs(turns[:, -1]).max()) < 0.3


def steady(east: float, compass: float, *, turns_back: bool) -> float:
    """Return the turn, degrees, after 48 m over which GNSS drifted east, metres a second."""
    heading, half = Heading(), 8
    for number in range(2 * half):
        step = -STEP if turns_back and number >= half else STEP
        heading.move(abs(step), SECONDS)
        slip = (complex(0.0, east * SECONDS) / step).imag
        heading.learn(compass + slip, step, SECONDS)
    return math.degrees(heading.turn)


def test_a_steady_drift_is_distinguished_from_a_compass_error_where_the_drone_flies_back() -> None:
    assert abs(steady(0.05, 0.0, turns_back=False)) > 0.3
    assert abs(steady(0.05, 0.0, turns_back=True)) < 0.1
    assert steady(0.05, math.radians(2), turns_back=True) == pytest.approx(2.0, abs=0.2)


def test_the_slower_the_drone_the_more_is_ascribed_to_the_drift() -> None:
    def turned(seconds: float) -> float:
        heading = Heading()
        for _ in range(6):
            heading.move(abs(STEP), seconds)
            heading.learn(math.radians(1.5), STEP, seconds)
        return heading.turn

    assert turned(3.0) < turned(1.5) < turned(0.75)


@pytest.mark.parametrize("degrees", [-5.0, -2.0, 2.0, 4.0])
@pytest.mark.parametrize("seed", range(5))
def test_a_wrong_compass_is_learned_within_forty_metres(degrees: float, seed: int) -> None:
    assert flown(math.radians(degrees), [0.0] * 13, seed)[-1] == pytest.approx(degrees, abs=0.5)


def test_a_compass_that_changes_is_followed() -> None:
    heading = Heading()
    for measured in [0.0] * 20 + [math.radians(3.0)] * 60:
        heading.move(abs(STEP), SECONDS)
        heading.learn(measured, STEP, SECONDS)
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
def test_the_turn_never_exceeds_the_measured_ones(turns: list[float]) -> None:
    heading = Heading()
    for one in turns:
        heading.move(abs(STEP), SECONDS)
        heading.learn(one, STEP, SECONDS)
    assert abs(heading.turn) <= max(map(abs, turns)) + 1e-9
