from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.algo.vision.blur import BLURRED, blur_of
from hawk.algo.vision.detection import GroundImage

TO_MAP = np.array([[0.0, -0.1, 0.0], [0.1, 0.0, 0.0]])


def lot(side: int = 300) -> NDArray[np.uint8]:
    """Return asphalt with the grain of a sharp picture, lines and cars, 0.1 m a pixel."""
    rng = np.random.default_rng(7)
    picture = rng.normal(90, 6, (side, side, 3))
    picture[::25, :] = 220
    for row, column in rng.integers(0, side - 50, (20, 2)):
        picture[row : row + 45, column : column + 18] = rng.integers(0, 255, 3)
    return cv2.GaussianBlur(picture, (0, 0), 0.7).clip(0, 255).astype(np.uint8)


def ground(picture: NDArray[np.uint8], valid: NDArray[np.bool_] | None = None) -> GroundImage:
    return GroundImage(picture, TO_MAP, np.ones(picture.shape[:2], np.bool_) if valid is None else valid)


def smeared(picture: NDArray[np.uint8], pixels: int, axis: int) -> NDArray[np.uint8]:
    return np.asarray(cv2.blur(picture, (pixels, 1) if axis else (1, pixels)), np.uint8)


def test_a_sharp_picture_is_not_blurred_and_a_soft_one_is() -> None:
    blurs = [blur_of(ground(lot()))]
    blurs += [blur_of(ground(np.asarray(cv2.GaussianBlur(lot(), (0, 0), sigma), np.uint8))) for sigma in (1, 2, 3)]
    assert blurs == sorted(blurs)
    assert blurs[0] < BLURRED - 0.1
    assert blurs[2] > BLURRED


@pytest.mark.parametrize("axis", [0, 1])
def test_a_smear_along_one_axis_counts(axis: int) -> None:
    assert blur_of(ground(smeared(lot(), 3, axis))) < BLURRED
    assert blur_of(ground(smeared(lot(), 12, axis))) > BLURRED


def test_only_what_the_camera_saw_counts() -> None:
    picture, valid = lot(), np.zeros((300, 300), np.bool_)
    valid[:, :150] = True
    picture[:, 150:] = 0
    sharp = blur_of(ground(lot()[:, :150]))
    assert blur_of(ground(picture, valid)) == pytest.approx(sharp, abs=0.03)


def test_a_picture_that_shows_nothing_is_not_called_blurred() -> None:
    assert blur_of(ground(np.full((60, 60, 3), 90, np.uint8))) == 0.0
    assert blur_of(ground(lot(), np.zeros((300, 300), np.bool_))) == 0.0
