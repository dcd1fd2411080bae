"""Ground of an orthophoto for the sheet of a survey."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hawk.lots.registration.georeference import about
from hawk.picture.orthophoto.mosaic import ground_of_box
from hawk.picture.orthophoto.source import open_orthophoto
from tests.unit.picture.orthophoto.drawn import HERE, UTM, placed, write


@pytest.mark.parametrize("metres", [0.1, 0.04, 0.2])
@pytest.mark.parametrize("turn", [0.0, 30.0])
def test_a_mark_lies_where_its_pixels_lie_on_earth(tmp_path: Path, turn: float, metres: float) -> None:
    columns, rows = round(40 / metres), round(20 / metres)
    bands = np.full((3, rows, columns), 20, np.uint8)
    mark = np.array([30.0, 5.0, 32.0, 8.0]) / metres  # metres from the upper left corner
    left, top, right, bottom = np.round(mark).astype(int)
    bands[:, top:bottom, left:right] = 240
    source = open_orthophoto(write(tmp_path / "mark.tif", bands, placed(UTM, columns, rows, metres=metres, turn=turn)))
    ground = ground_of_box(source, (0.0, 0.0, 40.0, 20.0), HERE, 400.0)
    assert ground is not None
    ends = np.array([(left, top), (right, top), (right, bottom), (left, bottom)], np.float64)
    expected = ground.pixels(about(HERE, source.grid.on_earth(ends))[:, :2]).mean(axis=0)
    row, column = np.argwhere(ground.image[..., 0] > 130).mean(axis=0) + 0.5
    assert (column, row) == pytest.approx(expected, abs=0.7)
    assert ((ground.image[..., 0] > 130).sum() * 0.01) == pytest.approx(6.0, rel=0.1)
    assert (ground.seen > 0).sum() * 0.01 == pytest.approx(800.0, rel=0.02)


def test_of_ground_that_is_too_large_or_empty_there_is_no_picture(tmp_path: Path) -> None:
    source = open_orthophoto(write(tmp_path / "none.tif", np.zeros((3, 50, 50), np.uint8), nodata=0))
    assert ground_of_box(source, (0.0, 0.0, 5.0, 5.0), HERE, 4.0) is None
    assert ground_of_box(source, (0.0, 0.0, 5.0, 5.0), HERE, 400.0) is None
    assert ground_of_box(source, (0.0, 0.0, 0.0, 0.0), HERE, 400.0) is None
