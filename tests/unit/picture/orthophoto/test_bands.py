"""Black beside the ground of a picture that does not say what is missing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio
from rasterio.enums import Resampling

from hawk.picture.orthophoto.bands import Image, Mask
from hawk.picture.orthophoto.source import open_orthophoto
from tests.unit.picture.orthophoto.drawn import rgb, write

SIDE = 200
MISSING = np.zeros((SIDE, SIDE), np.bool_)
MISSING[:, :60] = True
MISSING[:90, :120] = True


def ground() -> Image:
    """Return grey ground with pixels of pure black here and there, and a small black roof."""
    rng = np.random.default_rng(1)
    image = rng.integers(60, 200, (SIDE, SIDE, 3), dtype=np.uint8)
    image[rng.random((SIDE, SIDE)) < 0.05] = 0
    image[150:158, 150:158] = 0
    return image


def valid(folder: Path, image: Image, **profile: Any) -> Mask:
    path = write(folder / "black.tif", rgb(image), **profile)
    return open_orthophoto(path).read((0, 0, SIDE, SIDE)).valid


def test_what_is_black_by_squares_is_missing_and_dark_ground_is_not(tmp_path: Path) -> None:
    image = ground()
    image[MISSING] = 0
    found = valid(tmp_path, image)
    assert not found[MISSING].any()
    assert (~found[~MISSING]).mean() < 0.03, "black pixels that touch it"
    assert found[150:158, 150:158].all()


def test_the_dark_rim_that_compression_leaves_is_missing_with_it(tmp_path: Path) -> None:
    image = ground()
    image[MISSING] = 0
    image[100:, 57:60] = 9
    assert not valid(tmp_path, image)[100:, :60].any()


def test_a_file_that_says_what_is_missing_is_believed(tmp_path: Path) -> None:
    image = ground()
    image[MISSING] = 0
    found = valid(tmp_path, image, nodata=255)
    assert found.all()


def test_a_picture_without_black_is_valid(tmp_path: Path) -> None:
    assert valid(tmp_path, np.maximum(ground(), 1)).all()


def test_white_from_the_border_is_missing_and_a_white_roof_is_not(tmp_path: Path) -> None:
    image = ground()
    image[MISSING] = 255
    image[130:170, 130:170] = 255
    found = valid(tmp_path, image)
    assert not found[MISSING].any()
    assert found[~MISSING].mean() > 0.97
    assert found[130:170, 130:170].all()


def test_the_bright_rim_that_compression_leaves_is_missing_with_it(tmp_path: Path) -> None:
    image = ground()
    image[MISSING] = 255
    image[:90, 118:124] = 246
    assert not valid(tmp_path, image)[:80, 118:124].any()


def test_a_white_roof_at_the_side_of_a_picture_without_a_white_border_is_ground(tmp_path: Path) -> None:
    image = ground()
    image[80:120, :60] = 255
    assert valid(tmp_path, image)[80:120, :60].all()


@pytest.mark.slow
@pytest.mark.parametrize("border", [0, 65535])
def test_a_black_or_white_border_of_16_bits_does_not_change_the_ground(tmp_path: Path, border: int) -> None:
    image = ground().astype(np.uint16) * 100 + 10_000
    bordered = image.copy()
    bordered[MISSING] = border
    write(tmp_path / "grey.tif", np.moveaxis(image, -1, 0))
    write(tmp_path / "bordered.tif", np.moveaxis(bordered, -1, 0))
    levels = [open_orthophoto(tmp_path / name).bands.levels for name in ("grey.tif", "bordered.tif")]
    assert levels[0] is not None
    assert levels[1] == pytest.approx(levels[0], abs=200)


@pytest.mark.slow
@pytest.mark.parametrize("times", [1, 24], ids=["small", "by overviews"])
def test_white_is_followed_from_the_border_through_several_windows(tmp_path: Path, times: int) -> None:
    image = np.repeat(np.maximum(ground(), 1), times, axis=1)
    arm, roof, half = np.s_[130:160, : 150 * times], np.s_[40:90, 70 * times : 130 * times], 100 * times
    image[arm] = image[:, : 30 * times] = image[roof] = 255
    path = write(tmp_path / "white.tif", rgb(image))
    if times > 1:
        with rasterio.open(path, "r+") as file:
            file.build_overviews([2, 4, 8], Resampling.average)
    source = open_orthophoto(path)
    sides = [source.read(box).valid for box in ((0, 0, half, SIDE), (half, 0, 2 * half, SIDE))]
    found = np.concatenate(sides, axis=1)
    assert not found[arm].any()
    assert not found[:, : 30 * times].any()
    assert found[roof].all(), "a roof that the windows cut lies on no border"


def test_without_overviews_white_that_a_window_cuts_is_missing(tmp_path: Path) -> None:
    image = np.repeat(np.maximum(ground(), 1), 24, axis=1)
    image[:, :720] = image[40:90, 1680:3120] = 255
    source = open_orthophoto(write(tmp_path / "white.tif", rgb(image)))
    assert not source.read((0, 0, 2400, SIDE)).valid[40:90, 1680:].any()
    assert source.read((1200, 0, 3600, SIDE)).valid[40:90, 480:1920].all()
