from __future__ import annotations

import math
from dataclasses import astuple

import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.algo.mapper.evidence import transform_points
from hawk.algo.mapper.register import Registration, Shift

Floats = NDArray[np.float64]


def stalls(rows: int = 4, columns: int = 30) -> Floats:
    north, east = np.meshgrid(np.arange(rows) * 6.0, np.arange(columns) * 2.6)
    return np.column_stack([north.ravel(), east.ravel(), np.zeros(north.size)])


def seen(real: Floats, drone: tuple[float, float], error: Shift) -> tuple[Floats, tuple[float, float]]:
    """Return the sightings of a drone with a wrong pose: ``error`` off, and turned about itself."""
    affine = error.about(*drone)
    places = transform_points(affine, real[:, :2])
    return np.column_stack([places, real[:, 2] + error.turn]), (drone[0] + error.north, drone[1] + error.east)


def near(real: Floats, drone: tuple[float, float], reach: float = 14.0) -> Floats:
    return real[np.hypot(real[:, 0] - drone[0], real[:, 1] - drone[1]) < reach]


@pytest.mark.parametrize("error", [(0.7, 0.0), (0.0, 0.8), (-0.6, 0.5)])
def test_a_position_error_is_taken_out(error: tuple[float, float]) -> None:
    registration, real = Registration(2.0), stalls()
    for _ in range(20):
        found, drone = seen(near(real, (9.0, 30.0)), (9.0, 30.0), Shift(*error))
        registration.update(real, found, drone, 0.0)
    assert registration.shift.north == pytest.approx(-error[0], abs=0.02)
    assert registration.shift.east == pytest.approx(-error[1], abs=0.02)


@pytest.mark.slow
def test_a_slow_drift_is_followed_beyond_half_a_pitch() -> None:
    registration, real = Registration(2.0), stalls()
    for step in range(200):
        found, drone = seen(near(real, (9.0, 30.0)), (9.0, 30.0), Shift(0.0, step * 0.009))
        registration.update(real, found, drone, 0.0)
    assert registration.shift.east == pytest.approx(-1.8, abs=0.1)


def test_a_jump_of_a_whole_pitch_is_not_followed_to_the_wrong_stalls() -> None:
    """Nothing distinguishes it from standing still: the shift stays instead of slipping by half a pitch."""
    registration, real = Registration(2.0), stalls()
    found, drone = seen(near(real, (9.0, 30.0)), (9.0, 30.0), Shift(0.0, 2.6))
    registration.update(real, found, drone, 0.0)
    assert abs(registration.shift.east) < 0.05


def test_three_stalls_are_too_few() -> None:
    registration, real = Registration(2.0), stalls(1, 3)
    found, drone = seen(real, (0.0, 2.6), Shift(0.5, 0.0))
    assert registration.update(real, found, drone, 0.0) == Shift()


def test_stalls_that_do_not_agree_say_nothing() -> None:
    registration, real = Registration(2.0), stalls()
    found = near(real, (9.0, 30.0)).copy()
    found[:, :2] += np.random.default_rng(1).uniform(-1.0, 1.0, found[:, :2].shape)
    assert registration.update(real, found, (9.0, 30.0), 0.0) == Shift()


def test_no_stalls_known_or_found_keep_the_shift() -> None:
    registration, none = Registration(2.0), np.zeros((0, 3))
    registration.restore(Shift(0.4, -0.2, 0.01))
    for known, found in ((none, stalls()), (stalls(), none)):
        assert astuple(registration.update(known, found, (0.0, 0.0), 0.0)) == pytest.approx((0.4, -0.2, 0.01))


@pytest.mark.parametrize(("is_old", "least", "most"), [(True, 0.99, 1.01), (False, 0.9, 0.98)])
def test_stalls_of_an_earlier_pass_hold_the_shift_fresh_ones_let_it_leak(
    is_old: bool, least: float, most: float
) -> None:
    registration, real = Registration(2.0), stalls()
    anchored = np.full(len(real), is_old)
    for step in range(150):
        place = (9.0, 10.0 + step * 0.4)
        found, drone = seen(near(real, place), place, Shift(0.0, -1.0))
        registration.update(real, found, drone, 0.0, anchored)
    assert least < registration.shift.east < most


def test_the_shift_is_limited() -> None:
    registration, real = Registration(0.5), stalls()
    for _ in range(50):
        found, drone = seen(near(real, (9.0, 30.0)), (9.0, 30.0), Shift(0.9, 0.0))
        registration.update(real, found, drone, 0.0)
    assert registration.shift.north == -0.5


def test_without_stalls_the_shift_leaks_back_to_what_gnss_says() -> None:
    registration = Registration(2.0)
    registration.restore(Shift(1.0, 0.0))
    for step in range(800):
        registration.update(np.zeros((0, 3)), np.zeros((0, 3)), (0.0, step * 0.5), step * 0.2)
    assert registration.shift.north < 0.05


@pytest.mark.nightly
@pytest.mark.parametrize("turn", [0.03, -0.02, 0.02])
def test_a_map_made_with_a_wrong_compass_stays_straight(turn: float) -> None:
    """The map knows only its older frames; without what is learned from the movement of the ground it would bend."""
    registration, real = Registration(2.0), stalls(5, 80)
    known: dict[int, Floats] = {}
    for step in range(400):
        drone = (12.0, 15.0 + step * 0.4)
        index = np.flatnonzero(np.hypot(real[:, 0] - drone[0], real[:, 1] - drone[1]) < 14)
        found, place = seen(real[index], drone, Shift(0, 0, turn))
        old = np.array(list(known.values())).reshape(-1, 3)
        affine = registration.update(old, found, place, step * 0.1).about(*place)
        for i, at, angle in zip(index, transform_points(affine, found[:, :2]), found[:, 2], strict=True):
            known.setdefault(int(i), np.array([*at, angle + registration.shift.turn]))
    error = np.array([known[i][:2] - real[i, :2] for i in known])
    assert np.hypot(*error.T).max() < 0.7  # without what is learned it grows to 2.3 m and more
    assert registration.shift.turn == pytest.approx(-turn, abs=0.012)


def test_an_affine_of_a_shift_turns_about_the_drone() -> None:
    affine = Shift(1.0, 2.0, math.pi / 2).about(10.0, 20.0)
    assert transform_points(affine, np.array([[10.0, 20.0]])) == pytest.approx(np.array([[11.0, 22.0]]))
    assert transform_points(affine, np.array([[11.0, 20.0]])) == pytest.approx(np.array([[11.0, 23.0]]))
