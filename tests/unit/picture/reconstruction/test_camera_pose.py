from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.algo.vision.rectify import project
from hawk.model.pictures import CameraModel
from hawk.picture.reconstruction.camera_pose import CameraPose

LENS = CameraModel(640, 480, 500.0, 500.0, 320.0, 238.0, (0.05, -0.02, 0.001, 0.0005, 0.0))
angle = st.floats(-0.2, 0.2)


@settings(max_examples=40, deadline=None)
@given(
    angle, angle, st.floats(-math.pi, math.pi), st.floats(-3, 3), st.sampled_from([0.0, 5e-5]),
    st.tuples(st.floats(-0.15, 0.15), st.floats(-0.15, 0.15)),
)  # fmt: skip
def test_ground_and_pixels_are_each_others_inverse(
    roll: float, pitch: float, yaw: float, level: float, line_s: float, slope: tuple[float, float]
) -> None:
    turning, velocity = (0.2, -0.1, 0.3), (9.0, -4.0)
    posed = CameraPose(LENS, 3.0, -7.0, 60.0, (roll, pitch, yaw), turning, velocity, line_s, level, slope)
    pixels = np.array([(10.0, 20.0), (320.0, 240.0), (600.0, 30.0), (50.0, 470.0)])
    assert posed.pixels(posed.ground(pixels)) == pytest.approx(pixels, abs=0.02)


def test_a_still_camera_shows_what_the_flights_projection_shows() -> None:
    posed = CameraPose(LENS, 3.0, -7.0, 60.0, (0.05, -0.1, 1.2))
    ground = np.array([(0.0, 0.0), (10.0, -20.0), (-5.0, 4.0)])
    assert posed.pixels(ground) == pytest.approx(project(ground, LENS, posed.pose), abs=1e-6)


def test_a_place_above_the_ground_shows_farther_out() -> None:
    posed = CameraPose(CameraModel(640, 480, 500.0, 500.0, 319.5, 239.5), 0.0, 0.0, 50.0, (0.0, 0.0, 0.0))
    (low, high) = posed.pixels(np.array([(0.0, 20.0, 0.0), (0.0, 20.0, 10.0)]))
    assert low[0] == pytest.approx(319.5 + 200)
    assert high[0] == pytest.approx(319.5 + 250)


def test_ground_that_rises_is_met_sooner() -> None:
    posed = CameraPose(
        CameraModel(640, 480, 500.0, 500.0, 319.5, 239.5), 0.0, 0.0, 50.0, (0.0, 0.0, 0.0), slope=(0.0, 0.1)
    )
    ahead = posed.ground(np.array([(319.5 + 200, 239.5)]))[0]
    assert ahead == pytest.approx((0.0, 50 / (500 / 200 + 0.1)))
    assert posed.ground_height(ahead[None])[0, 0] == pytest.approx(0.1 * ahead[1])


def test_what_lies_above_the_horizon_is_far_away() -> None:
    posed = CameraPose(LENS, 0.0, 0.0, 50.0, (0.0, 1.5, 0.0))
    assert np.hypot(*posed.ground(np.array([(320.0, 0.0)]))[0]) > 1000
