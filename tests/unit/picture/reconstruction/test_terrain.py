"""Sloping ground, roofs beside it, and too little to judge by."""

from __future__ import annotations

import numpy as np
import pytest

from hawk.model.pictures import CameraModel
from hawk.picture.reconstruction.camera_pose import CameraPose, FloatArray
from hawk.picture.reconstruction.terrain import fit_terrain

LENS = CameraModel(640, 480, 500.0, 500.0, 319.5, 239.5)
SLOPE = (-0.036, 0.01)


def _hill(count: int, seed: int = 1) -> FloatArray:
    """Return tied places over 200 m of a hillside, good to 5 cm."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(-100, 100, (count, 2))
    return np.column_stack([places, 2.0 + places @ SLOPE + rng.normal(0, 0.05, count)])


def _posed(north: float, east: float) -> CameraPose:
    return CameraPose(LENS, north, east, 80.0, (0.0, 0.0, 0.0))


def test_each_photograph_has_the_hillsides_slope_and_the_level_below_it() -> None:
    placed = fit_terrain([_posed(60.0, -20.0), _posed(-60.0, 40.0)], _hill(400))
    for one in placed:
        assert one.slope == pytest.approx(SLOPE, abs=0.002)
        assert one.level == pytest.approx(2.0 + np.dot((one.north, one.east), SLOPE), abs=0.15)


def test_two_photographs_agree_where_a_place_between_them_lies() -> None:
    first, second = fit_terrain([_posed(40.0, 0.0), _posed(-40.0, 0.0)], _hill(400))
    place = np.array([(0.0, 5.0, 2.05)])
    apart = first.ground(first.pixels(place)) - second.ground(second.pixels(place))
    assert np.abs(apart).max() < 0.05


def test_a_roof_below_a_photograph_is_no_ground() -> None:
    roof = np.column_stack([np.random.default_rng(2).uniform(30, 50, (150, 2)), np.full(150, 9.0)])
    (one,) = fit_terrain([_posed(40.0, 40.0)], np.concatenate([_hill(400), roof]))
    assert one.level == pytest.approx(2.0 + np.dot((40.0, 40.0), SLOPE), abs=0.2)


def test_a_few_places_say_nothing() -> None:
    given = (_posed(0.0, 0.0),)
    assert fit_terrain(given, _hill(5)) == given
