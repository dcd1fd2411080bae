"""Captions of the drawn films are read as the poses that they were written of."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.pictures.film import _caption
from hawk.picture.film.captions import read_captions
from hawk.picture.film.course import Course


def at(roll: float, pitch: float, yaw: float) -> Course:
    """Return one sample 35 m above the take-off."""
    time, latitude, longitude, altitude, height = (np.array([value]) for value in (0.0, 43.26, -79.92, 12.0, 35.0))
    return Course(time, latitude, longitude, altitude, height, np.radians([(roll, pitch, yaw)]))


@pytest.mark.parametrize("attitude", [(0.0, 0.0, 0.0), (1.5, -2.0, 90.0), (-3.0, 0.5, -170.0)])
def test_a_caption_says_the_pose_of_its_frame(attitude: tuple[float, float, float], tmp_path: Path) -> None:
    file = tmp_path / "DJI_0001.SRT"
    captions = (_caption(number, 5.0, at(*attitude)) for number in range(2))
    file.write_text("\n".join(captions), encoding="utf-8")
    read = read_captions(file, 2, 5.0).course
    assert (read.latitude[0], read.longitude[0], read.height[0]) == pytest.approx((43.26, -79.92, 35.0), abs=1e-6)
    assert np.degrees(read.attitude[0]) == pytest.approx(np.array(attitude), abs=0.15)
