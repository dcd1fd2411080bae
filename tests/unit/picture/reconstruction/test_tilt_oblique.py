from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.lots.survey.source import SourceKind
from hawk.picture.photographs.flight import survey_shots
from hawk.picture.photographs.shot_detections import Files
from hawk.picture.values import PictureError, Provenance, Shot, ShotSet
from tests.unit.picture.reconstruction.test_tilt import CAMERA, HEIGHT_M, STEP_M, _flown

YARD = Provenance("yard", SourceKind.PHOTOGRAPHS)


class _Drawn(Files):
    def __init__(self, images: dict[str, NDArray[np.uint8]]) -> None:
        self._images = images

    def picture(self, shot: Shot) -> NDArray[np.uint8]:
        return self._images[shot.name]


def _shots(folder: Path, tilt: float, count: int | None = None) -> tuple[ShotSet, _Drawn]:
    images = {f"{k}.jpg": image for k, image in enumerate(_flown(tilt)[1])}
    shots = []
    for k, name in enumerate(images):
        assert cv2.imwrite(str(folder / name), np.zeros((4, 4), np.uint8))
        east = math.degrees(k * STEP_M / 6_371_000)
        shots.append(Shot(folder / name, CAMERA, 0.0, east, 100.0, HEIGHT_M, None, (2.0, 3.0), 5.0 * k))
    return ShotSet(tuple(shots[:count])), _Drawn(images)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("tilt", "words"), [(40.0, r"looks about 3\d degrees or more off"), (70.0, "(looks about|shows sky)")]
)
def test_oblique_photographs_without_angles_are_left_out_for_what_is_true(
    tmp_path: Path, tilt: float, words: str
) -> None:
    with pytest.raises(PictureError, match=rf"yard: no photograph looks straight down: 0\.jpg {words}"):
        survey_shots(YARD, *_shots(tmp_path, tilt))


@pytest.mark.slow
def test_a_lone_photograph_with_a_horizon_is_left_out_and_one_straight_down_is_mapped(tmp_path: Path) -> None:
    ahead, pictures = _shots(tmp_path, 70.0, 1)
    with pytest.raises(PictureError, match=r"0\.jpg shows sky above the horizon, and its file says no angles"):
        survey_shots(YARD, ahead, pictures)
    down, pictures = _shots(tmp_path, 0.0, 1)
    assert survey_shots(YARD, down, pictures).mapped.left_out == ()
