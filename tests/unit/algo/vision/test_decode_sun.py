"""The sun as the finder gives it to the network: the shadow turns with the picture."""

from __future__ import annotations

import math
from datetime import UTC, datetime

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from hawk.algo.vision.detection import GroundImage
from hawk.algo.vision.detector import StallDetector
from hawk.algo.vision.network import Blob, NetworkMaps, StallNetwork, maps_from_output, sun_input
from hawk.algo.vision.rectify import GROUND_M, Rectifier, project
from hawk.model.pictures import CameraModel
from hawk.model.poses import MapPose
from hawk.model.sun import sun_position

CAMERA = CameraModel(320, 240, 300.0, 300.0, 159.5, 119.5)
FRAME = np.full((240, 320, 3), 90, np.uint8)
turns = st.floats(-math.pi, math.pi)
metres = st.floats(-5, 5)


class Listener(StallNetwork):
    """Keeps the sun that it is given; sees nothing."""

    def __init__(self) -> None:
        self.suns: list[Blob | None] = []

    def run(self, picture: NDArray[np.uint8], sun: Blob | None = None) -> NetworkMaps:
        self.suns.append(sun)
        rows, columns = (-(-side // 2) for side in picture.shape[:2])
        return maps_from_output(np.full((12, rows, columns), -9, np.float32))


def picture_at(yaw: float) -> GroundImage:
    """Return what a camera that looks straight down sees, heading ``yaw`` (radians)."""
    return Rectifier().rectify(FRAME, CAMERA, MapPose(3.0, -4.0, 30.0, 0.0, 0.0, yaw))


def given_sun(picture: GroundImage, shadow: tuple[float, float] | None) -> Blob | None:
    network = Listener()
    StallDetector(network).detect(picture, shadow)
    (sun,) = network.suns
    return sun


def test_at_noon_in_the_north_shadows_point_up_in_a_picture_with_north_up() -> None:
    shadow = sun_position(datetime(2026, 6, 21, 11, 42, tzinfo=UTC), 52.0, 5.0).shadow()
    sun = given_sun(picture_at(0.0), shadow)
    assert sun is not None
    assert sun[1] < -0.2
    assert abs(sun[0]) < 0.02


def test_at_noon_in_the_south_they_point_down() -> None:
    shadow = sun_position(datetime(2026, 6, 21, 2, 5, tzinfo=UTC), -33.9, 151.2).shadow()
    sun = given_sun(picture_at(0.0), shadow)
    assert sun is not None
    assert sun[1] > 0.4


def test_in_the_morning_they_point_west_which_is_left() -> None:
    shadow = sun_position(datetime(2026, 3, 20, 7, 0, tzinfo=UTC), 0.0, 0.0).shadow()
    sun = given_sun(picture_at(0.0), shadow)
    assert sun is not None
    assert sun[0] < -0.8
    assert abs(sun[1]) < 0.05


def test_without_a_sun_the_network_gets_none() -> None:
    assert given_sun(picture_at(0.3), None) is None


@pytest.mark.slow
@given(yaw=turns, north=metres, east=metres)
def test_a_turn_of_the_picture_turns_the_shadow_the_other_direction(yaw: float, north: float, east: float) -> None:
    level, turned = (given_sun(picture_at(angle), (north, east)) for angle in (0.0, yaw))
    assert level is not None
    assert turned is not None
    back = np.array([[math.cos(yaw), math.sin(yaw)], [-math.sin(yaw), math.cos(yaw)]])  # clockwise, rows go down
    assert turned == pytest.approx(back @ level, abs=1e-5)


@pytest.mark.slow
@given(yaw=turns, north=metres, east=metres)
def test_the_shadow_lies_where_the_camera_would_see_it(yaw: float, north: float, east: float) -> None:
    pose = MapPose(3.0, -4.0, 30.0, 0.0, 0.0, yaw)
    ends = project(np.array([[3.0, -4.0], [3.0 + north, -4.0 + east]]), CAMERA, pose)
    cast = (ends[1] - ends[0]) * pose.height / CAMERA.fx
    sun = given_sun(picture_at(yaw), (north, east))
    assert sun == pytest.approx(sun_input(cast), abs=1e-5)


def test_its_length_is_in_metres_whatever_the_raster_s_scale() -> None:
    coarse = GroundImage(FRAME, np.array([[0.0, -0.4, 0.0], [0.4, 0.0, 0.0]]), np.ones(FRAME.shape[:2], np.bool_))
    fine = GroundImage(FRAME, coarse.to_map * GROUND_M / 0.4, coarse.valid)
    assert coarse.in_pixels((1.0, 2.0)) == pytest.approx(fine.in_pixels((1.0, 2.0)))
    assert coarse.in_pixels((1.0, 2.0)) == pytest.approx((2.0, -1.0))
