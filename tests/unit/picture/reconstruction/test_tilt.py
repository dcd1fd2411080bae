from __future__ import annotations

import functools
import math

import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.model.pictures import CameraModel
from hawk.picture.reconstruction.camera_pose import CameraPose
from hawk.picture.reconstruction.features import Features, features
from hawk.picture.reconstruction.tilt import has_horizon, tilts
from hawk.worlds.camera import WorldCamera
from tests.drawn_worlds import drawn_world

CAMERA = CameraModel(900, 600, 603.0, 603.0, 449.5, 299.5)
HEIGHT_M, STEP_M = 50.0, 15.0


@functools.cache
def _flown(tilt: float) -> tuple[list[CameraPose], list[NDArray[np.uint8]]]:
    """Return photographs of a drawn lot at this tilt, beside each other."""
    world = drawn_world(3)
    camera = WorldCamera(world, CAMERA)
    width, height = world.size_m
    posed, images = [], []
    for k in range(3):
        x, y = width / 2 - 20 + k * STEP_M, height / 2 + 10 + 30 * math.tan(math.radians(tilt))
        rng = np.random.default_rng(k)
        images.append(camera.render(x, y, HEIGHT_M, 0.0, math.radians(tilt), 0.0, rng=rng))
        posed.append(CameraPose(CAMERA, -y, x, HEIGHT_M, (0.0, 0.0, 0.0)))
    return posed, images


@pytest.mark.nightly
@pytest.mark.parametrize("tilt", [0.0, 40.0])
def test_the_ground_that_neighbours_show_says_how_photographs_are_tilted(tilt: float) -> None:
    posed, images = _flown(tilt)
    seen = [features(image) for image in images]
    found = [math.degrees(each) for each in tilts(posed, range(3), seen.__getitem__).values()]
    assert len(found) >= 2
    assert np.median(found) == pytest.approx(tilt, abs=9.0)
    assert all((each > 20.0) == (tilt > 20.0) for each in found)


def test_photographs_that_share_nothing_say_no_tilt() -> None:
    nothing = Features(np.zeros((0, 2)), np.zeros((0, 128), np.uint8))
    posed = [CameraPose(CAMERA, 0.0, 10.0 * k, 50.0, (0.0, 0.0, 0.0)) for k in range(3)]
    assert tilts(posed, range(3), lambda _: nothing) == {}


@pytest.mark.nightly
def test_a_horizon_is_seen_where_there_is_one() -> None:
    assert all(has_horizon(image) for image in _flown(70.0)[1])
    assert not any(has_horizon(image) for tilt in (0.0, 40.0) for image in _flown(tilt)[1])


def test_a_bright_roof_beside_a_lot_is_no_horizon() -> None:
    rng = np.random.default_rng(1)
    image = rng.normal(90, 12, (400, 600, 3)).clip(0, 255).astype(np.uint8)
    image[:120, :400] = 220
    assert not has_horizon(image)
    image[:120] = 220
    image[:120, ..., 2] = 235
    assert not has_horizon(image), "sky is not red"
