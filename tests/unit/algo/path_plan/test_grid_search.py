from __future__ import annotations

import math

import numpy as np
import pytest

from hawk.algo.ground import COARSE_M, Window
from hawk.algo.path_plan.field import InformationField
from hawk.algo.path_plan.footprint import Swath
from tests.unit.algo.synthetic import CAMERA

WINDOW = Window(-50, -50, 100, 100, COARSE_M)


def field_of(*boxes: tuple[float, float, float, float], allowed: np.ndarray | None = None) -> InformationField:
    """Everything in the boxes (north from, to, east from, to) is to be learned."""
    gain = np.zeros(WINDOW.shape, np.float32)
    rows, columns = np.indices(WINDOW.shape)
    north, east = -(rows + WINDOW.row + 0.5) * COARSE_M, (columns + WINDOW.column + 0.5) * COARSE_M
    for a, b, c, d in boxes:
        gain[(north >= a) & (north < b) & (east >= c) & (east < d)] = COARSE_M**2
    free = np.ones(WINDOW.shape, np.uint8) if allowed is None else allowed.astype(np.uint8)
    return InformationField(WINDOW, gain, free, free, gain, gain * 0, gain * 0)


def test_a_swath_is_the_good_middle_of_the_picture() -> None:
    swath = Swath.of(CAMERA, 35.0, 0.85)
    assert swath.width == pytest.approx(35 * 1280 / 914 * 0.85)
    assert swath.depth == pytest.approx(35 * 720 / 914 * 0.85)


def test_the_path_round_a_corner_goes_to_what_can_be_reached_straight_on() -> None:
    """Two wings of ground meet at a corner; the wing that is wanted cannot be seen from the other's end."""
    rows, columns = np.indices(WINDOW.shape)
    north, east = -(rows + WINDOW.row + 0.5) * COARSE_M, (columns + WINDOW.column + 0.5) * COARSE_M
    wings = ((np.abs(east) < 6) & (north > -6)) | ((np.abs(north) < 6) & (east > -6))
    field = field_of((0, 5, 0, 5), allowed=wings)
    place, end = (60.0, 0.0), (0.0, 60.0)
    corner = field.corner_towards(place, end)
    assert corner is not None
    for share in np.linspace(0, 1, 50):
        n, e = (a + (b - a) * share for a, b in zip(place, corner, strict=True))
        assert abs(e) < 8 or abs(n) < 8
    assert math.hypot(*corner) < 20
    assert field.corner_towards(corner, end) is not None


def test_there_is_no_path_to_an_island() -> None:
    columns = np.indices(WINDOW.shape)[1]
    field = field_of((0, 5, 0, 5), allowed=(columns < 30) | (columns > 70))
    assert field.corner_towards((0.0, -60.0), (0.0, 60.0)) is None
    nowhere = field_of((0, 5, 0, 5), allowed=np.zeros(WINDOW.shape, np.uint8))
    assert nowhere.corner_towards((0.0, -60.0), (0.0, 60.0)) is None
