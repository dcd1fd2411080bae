from __future__ import annotations

import math

import pytest

from hawk.algo.path_plan.footprint import LOOKS, SLOWEST_M_S, ReadableSpeed, exploring_height
from hawk.model.plans import HeightParameters
from tests.unit.algo.synthetic import CAMERA

DEPTH_M = 24.0


def after(times: list[float], exposure_s: float = 0.001) -> float:
    speed = ReadableSpeed(exposure_s)
    for captured in times:
        speed.take(captured)
    return speed.limit(DEPTH_M)


@pytest.mark.parametrize(
    ("cm_per_pixel", "height"),
    [(None, 35.0), (100 * 40.0 / CAMERA.fx, 40.0), (0.5, 15.0), (10.0, 60.0)],
)
def test_the_height_shows_pixels_of_the_wanted_size_within_min_and_max(
    cm_per_pixel: float | None, height: float
) -> None:
    assert exploring_height(HeightParameters(15, 35, 60), CAMERA, cm_per_pixel) == pytest.approx(height)


def test_each_place_is_in_some_pictures_however_seldom_they_are_read() -> None:
    for between in (0.2, 1.0, 2.5):
        limit = after([k * between for k in range(8)])
        assert limit * between * LOOKS == pytest.approx(DEPTH_M)


def test_a_single_gap_slows_nobody_down() -> None:
    assert after([0, 0.2, 0.4, 5.4, 5.6, 5.8, 6.0]) == pytest.approx(after([0, 0.2, 0.4, 0.6]))


def test_no_picture_is_smeared_by_more_than_a_pixel_of_the_network() -> None:
    assert after([0, 0.01, 0.02], exposure_s=0.05) == pytest.approx(2.0)
    assert after([], exposure_s=0.05) == pytest.approx(2.0)


def test_it_never_stands_still_for_it() -> None:
    assert after([0, 1000, 2000]) == SLOWEST_M_S
    assert after([0, 0.2], exposure_s=1.0) == SLOWEST_M_S


def test_a_clock_that_goes_back_begins_the_measurement_again() -> None:
    assert after([100.0, 109.0, 1.0, 1.2]) == pytest.approx(DEPTH_M / (LOOKS * 0.2))
    assert math.isfinite(after([5.0, 5.0]))
