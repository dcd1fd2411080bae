"""A wrong height and a wrong compass show in how the ground moves; sizes of stalls tell gross errors only."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from hawk.algo.mapper.slip import USUAL, Slip

Floats = NDArray[np.float64]
SPEED = 4.0


def lot(pitch: float = 2.6) -> Floats:
    north, east = np.meshgrid(np.arange(5) * 6.0, np.arange(60) * pitch)
    return np.column_stack([north.ravel(), east.ravel(), np.zeros(north.size)])


def laid(real: Floats, drone: Floats, scale: float, turn: float) -> Floats:
    """What a drone tells whose height is ``scale`` times, and whose heading ``turn`` more than, the true one."""
    near = real[np.hypot(*(real[:, :2] - drone).T) < 14]
    c, s = scale * math.cos(turn), scale * math.sin(turn)
    return np.column_stack([drone + (near[:, :2] - drone) @ np.array([[c, s], [-s, c]]), near[:, 2] + turn])


def fly(
    slip: Slip, scale: float, turn: float = 0.0, way: float = 100.0, drift: float = 0.0, noise: float = 0.1
) -> Slip:
    rng, real = np.random.default_rng(1), lot()
    for step in np.arange(0, way, 0.8):
        drone = np.array([12.0, 10.0 + step])
        found = laid(real, drone, scale, turn)
        found[:, :2] += rng.normal(0, noise, found[:, :2].shape)
        found[:, 0] += drift * step
        slip.move(found, (drone[0] + drift * step, drone[1]), step / SPEED)
    return slip


@pytest.mark.parametrize("scale", [0.8, 0.9, 0.97, 1.0, 1.05, 1.1, 1.2])
@pytest.mark.parametrize("turn", [0.0, 0.05, -0.03])
def test_height_and_compass_are_learned_from_the_movement_alone(scale: float, turn: float) -> None:
    slip = fly(Slip(), scale, turn)
    assert slip.scale == pytest.approx(1 / scale, abs=0.03)
    assert slip.turn == pytest.approx(-turn, abs=0.015)


def test_a_slow_drift_of_gnss_counts_little() -> None:
    assert fly(Slip(), 1.0, drift=0.0075).scale == pytest.approx(1.0, abs=0.01)


def test_unusual_stalls_do_not_outweigh_the_movement() -> None:
    slip = fly(Slip(), 1.0)
    for _ in range(30):
        slip.size(1.35)
    assert slip.scale == pytest.approx(1.0, abs=0.02)


@given(st.floats(*USUAL))
def test_sizes_that_lots_have_say_nothing(size: float) -> None:
    slip = Slip()
    slip.size(size)
    assert slip.scale == 1.0


@pytest.mark.parametrize(("told", "border"), [(1.3, USUAL[1]), (0.75, USUAL[0])])
def test_a_gross_error_is_taken_back_to_what_lots_have_before_the_drone_moves(told: float, border: float) -> None:
    slip = Slip()
    for _ in range(10):
        slip.size(told)
    assert told * slip.scale == pytest.approx(border, abs=0.02)


def test_a_drone_that_stands_learns_nothing_from_drift() -> None:
    slip, real = Slip(), lot()
    for step in range(600):
        place = np.array([12.0, 50.0 + step * 0.01])
        found = laid(real, np.array([12.0, 50.0]), 1.0, 0.0)
        found[:, 1] += step * 0.01
        slip.move(found, (place[0], place[1]), step * 0.2)
    assert slip.scale == 1.0


def test_stalls_that_do_not_agree_and_jumps_say_nothing() -> None:
    slip, rng = Slip(), np.random.default_rng(2)
    for step in range(60):
        places = np.column_stack([rng.uniform(0, 30, (25, 2)), np.zeros(25)])
        slip.move(places, (0.0, step * 4.5), step * 1.1)
    assert slip.scale == pytest.approx(1.0, abs=0.03)
    slip = Slip()
    for step in range(10):
        slip.move(laid(lot(), np.array([12.0, 60.0]), 1.2, 0.0), (12.0, step * 50.0), step * 12.5)
    assert slip.scale == 1.0


def test_what_an_earlier_flight_learned_is_taken_up() -> None:
    slip = Slip()
    slip.restore(0.85, 0.02)
    assert (slip.scale, slip.turn) == (0.85, 0.02)
