from __future__ import annotations

import numpy as np
import pytest

from hawk.algo.vision.rectify import GROUND_M
from hawk.model.pictures import CameraModel
from hawk.picture.photographs.orthorectification import LARGEST_M, orthorectify
from hawk.picture.reconstruction.camera_pose import CameraPose
from tests.unit.picture.flights import CAMERA, flight


def test_the_same_ground_is_at_the_same_place_in_two_photographs() -> None:
    flown = flight(lanes=1, count=2)
    first, second = (orthorectify(image, posed) for image, posed in zip(flown.pictures, flown.true, strict=True))
    assert first is not None
    assert second is not None
    assert first.metres_per_pixel == pytest.approx(GROUND_M)
    places = np.array([(n, e) for n in np.arange(-4, 4, 0.7) for e in np.arange(-6, 6, 0.7)])
    values = []
    for picture in (first, second):
        pixels = np.rint(picture.pixel_points(places)).astype(int)
        assert picture.valid[pixels[:, 1], pixels[:, 0]].all()
        values.append(picture.values[pixels[:, 1], pixels[:, 0], 0].astype(float))
    assert np.corrcoef(*values)[0, 1] > 0.95


@pytest.mark.slow
def test_its_view_shows_the_same_ground_more_finely() -> None:
    camera = CameraModel(1600, 1200, 1200.0, 1200.0, 799.5, 599.5)
    posed = CameraPose(camera, 2.0, -3.0, 40.0, (0.0, 0.0, 0.4))
    image = np.random.default_rng(1).integers(0, 255, (1200, 1600, 3)).astype(np.uint8)
    picture = orthorectify(image, posed)
    assert picture is not None
    assert picture.view is not None
    assert picture.view.image.shape[0] == 2 * picture.values.shape[0]
    place = np.array([2.0, -3.0, 1.0])
    column, row, one = picture.view.to_image @ place
    assert (column / one, row / one) == pytest.approx(2 * picture.pixel_points(place[:2]) + 0.5)


@pytest.mark.slow
def test_ground_far_aside_is_left_out() -> None:
    high = CameraPose(CAMERA, 0.0, 0.0, 400.0, (0.0, 0.0, 0.0))
    picture = orthorectify(np.zeros((360, 480, 3), np.uint8), high)
    assert picture is not None
    assert max(picture.valid.shape) * GROUND_M <= LARGEST_M


def test_a_photograph_of_no_ground_is_none() -> None:
    assert orthorectify(np.zeros((360, 480, 3), np.uint8), CameraPose(CAMERA, 0.0, 0.0, 1.0, (0.0, 0.0, 0.0))) is None
