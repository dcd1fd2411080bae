from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from hawk.model.pictures import CameraModel
from hawk.picture.film.lens import LensChoice, lens_of
from hawk.picture.values import PictureError

SIZE = (3840, 2160)
PHOTO = CameraModel(1920, 1080, 1400.0, 1400.0, 960.0, 540.0, (0.1, 0.0, 0.0, 0.0, 0.0), mount_yaw=1.0)


def _lens(choice: LensChoice, model: str = "", focal: float | None = None, zoom: float = 1.0) -> tuple[float, bool]:
    found = lens_of("a.MP4", SIZE, choice, model, focal, zoom)
    return round(found.camera.fx, 1), found.is_known


def test_a_calibration_counts_first_at_any_size_of_its_shape() -> None:
    found = lens_of("a.MP4", SIZE, LensChoice(calibration=PHOTO, hfov_deg=50.0), "FC3170", 24.0, 2.0)
    assert found.camera == replace(
        PHOTO, width=3840, height=2160, fx=2800.0, fy=2800.0, cx=1920.5, cy=1080.5, mount_yaw=0.0
    )
    assert (found.is_known, found.notes) == (True, ())
    with pytest.raises(PictureError, match=r"a.MP4: is 3840 x 2160 pixels, its calibration 1920 x 1440"):
        lens_of("a.MP4", SIZE, LensChoice(calibration=replace(PHOTO, height=1440)), "", None, 1.0)


def test_the_field_of_view_and_the_focal_length_on_film_give_a_guess() -> None:
    assert _lens(LensChoice(hfov_deg=90.0)) == (1920.0, False)
    focal, is_known = _lens(LensChoice(focal35_mm=24.0))
    assert not is_known
    diagonal = math.hypot(3840, 0.75 * 3840)
    assert focal == pytest.approx(24.0 / math.hypot(36, 24) * diagonal, abs=0.1)
    assert _lens(LensChoice(), focal=24.0) == (focal, False)
    assert "--hfov" in lens_of("a.MP4", SIZE, LensChoice(), "", 24.0, 1.0).notes[0]


def test_the_tables_know_cameras_by_the_films_own_model(tmp_path: Path) -> None:
    assert _lens(LensChoice(), "FC3170") == (2700.0, False)
    assert _lens(LensChoice(model="FC6310"), "") == (2573.6, False)
    table = tmp_path / "lenses.toml"
    table.write_text(
        '[[lens]]\nmodel = "X1"\nsensor_width_mm = 10\nfilm_width_mm = 8\nfocal_mm = 6\n', encoding="utf-8"
    )
    assert _lens(LensChoice(lenses=table), "X1") == (2880.0, True)


@pytest.mark.parametrize(
    ("choice", "zoom", "words"),
    [
        (LensChoice(), 1.0, "nothing says how its lens draws; give its field of view across by --hfov"),
        (LensChoice(model="unknown"), 1.0, "nothing says how its lens draws"),
        (LensChoice(), 1.77, "was taken with a digital zoom of 1.77; give its field of view"),
        (LensChoice(hfov_deg=200.0), 1.0, "--hfov 200: must be 5 to 160 degrees"),
        (LensChoice(hfov_deg=math.nan), 1.0, "--hfov nan: must be"),
        (LensChoice(focal35_mm=2.0), 1.0, "--focal35 2: must be 8 to 500 mm"),
        (LensChoice(focal35_mm=10.0), 1.0, "--focal35 10: is wider or narrower than every lens.*--hfov DEGREES"),
    ],
)
def test_a_lens_that_nothing_says_is_asked_for(choice: LensChoice, zoom: float, words: str) -> None:
    with pytest.raises(PictureError, match=words):
        lens_of("a.MP4", SIZE, choice, "", None, zoom)


def test_a_focal_length_of_the_captions_that_no_lens_has_is_refused() -> None:
    with pytest.raises(PictureError, match=r"a.MP4: its captions give .* 12 mm, wider or narrower .*--hfov DEGREES"):
        lens_of("a.MP4", SIZE, LensChoice(), "", 12.0, 1.0)
