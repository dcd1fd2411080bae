"""A wrong compass shows in the movement of the ground."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.algo.mapper.register import Slip

Floats = NDArray[np.float64]
SPEED = 4.0


def lot(pitch: float = 2.6) -> Floats:
    north, east = np.meshgrid(np.arange(5) * 6.0, np.arange(60) * pitch)
    return np.column_stack([north.ravel(), east.ravel(), np.zeros(north.size)])


def seen_from(real: Floats, drone: Floats, scale: float, turn: float) -> Floats:
    """Return the sightings of a drone with ``scale`` times the true height and a heading that is ``turn`` more."""
    near = real[np.hypot(*(real[:, :2] - drone).T) < 14]
    c, s = scale * math.cos(turn), scale * math.sin(turn)
    return np.column_stack([drone + (near[:, :2] - drone) @ np.array([[c, s], [-s, c]]), near[:, 2] + turn])


def fly(slip: Slip, scale: float, turn: float = 0.0, length: float = 100.0, noise: float = 0.1) -> Slip:
    rng, real = np.random.default_rng(1), lot()
    for step in np.arange(0, length, 0.8):
        drone = np.array([12.0, 10.0 + step])
        found = seen_from(real, drone, scale, turn)
        found[:, :2] += rng.normal(0, noise, found[:, :2].shape)
        slip.move(found, (drone[0], drone[1]), step / SPEED)
    return slip


@pytest.mark.parametrize("scale", [0.8, 0.9, 0.97, 1.0, 1.05, 1.1, 1.2])
@pytest.mark.parametrize("turn", [0.0, 0.05, -0.03])
def test_the_compass_is_learned_from_the_movement_alone_at_right_and_wrong_heights(scale: float, turn: float) -> None:
    slip = fly(Slip(), scale, turn)
    assert slip.heading.turn == pytest.approx(-turn, abs=0.015)
    assert slip.is_sure


def test_a_drone_that_stands_learns_nothing_from_drift() -> None:
    slip, real = Slip(), lot()
    for step in range(600):
        place = np.array([12.0, 50.0 + step * 0.01])
        found = seen_from(real, np.array([12.0, 50.0]), 1.0, 0.0)
        found[:, 1] += step * 0.01
        slip.move(found, (place[0], place[1]), step * 0.2)
    assert slip.heading.turn == 0.0
    assert not slip.is_sure


def test_stalls_that_do_not_agree_and_jumps_say_nothing() -> None:
    slip, rng = Slip(), np.random.default_rng(2)
    for step in range(60):
        places = np.column_stack([rng.uniform(0, 30, (25, 2)), np.zeros(25)])
        slip.move(places, (0.0, step * 4.5), step * 1.1)
    assert abs(slip.heading.turn) < math.radians(3)
    assert not slip.is_sure
    slip = Slip()
    for step in range(10):
        slip.move(seen_from(lot(), np.array([12.0, 60.0]), 1.2, 0.0), (12.0, step * 50.0), step * 12.5)
    assert slip.heading.turn == 0.0
    assert not slip.is_sure
