"""Pixels of an orthophoto on Earth."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.lots.registration.georeference import about
from hawk.picture.orthophoto.grid import PixelGrid, measure_grid, system
from hawk.picture.values import PictureError
from tests.unit.picture.orthophoto.drawn import HERE, placed

SYSTEMS = ["EPSG:32631", "EPSG:28992", "EPSG:2263", "EPSG:4326", "EPSG:3857"]


@functools.cache
def grid(crs: str, columns: int = 300, rows: int = 200, metres: float = 0.1, turn: float = 0.0) -> PixelGrid:
    a, b, c, d, e, f = tuple(placed(crs, columns, rows, metres=metres, turn=turn))[:6]
    return measure_grid(PixelGrid(columns, rows, system(crs, "t")[0], (a, b, c, d, e, f)), "t.tif")


@pytest.mark.nightly
@pytest.mark.parametrize("crs", SYSTEMS)
def test_the_scale_is_that_of_the_ground_whatever_the_units(crs: str) -> None:
    assert grid(crs).metres == pytest.approx((0.1, 0.1), abs=2e-5)
    assert grid(crs, metres=0.07, turn=33.0).metres == pytest.approx((0.07, 0.07), abs=2e-5)


@pytest.mark.nightly
@settings(max_examples=30, deadline=None)
@given(st.sampled_from(SYSTEMS), st.sampled_from((0.0, 40.0)), st.floats(0, 300), st.floats(0, 200))
def test_a_place_goes_to_the_earth_and_back(crs: str, turn: float, column: float, row: float) -> None:
    made = grid(crs, turn=turn)
    there = made.on_earth(np.array([(column, row)]))
    assert np.abs(made.in_picture(there) - (column, row)).max() < 0.01  # Amersfoort is shifted by PROJ to .4 mm
    assert np.abs(about(HERE, there)[:, :2]).max() < 20


def test_a_grid_whose_first_row_is_the_south_is_counted_from_the_north() -> None:
    usual = grid("EPSG:32631")
    a, b, c, d, e, f = usual.affine
    south_up = measure_grid(PixelGrid(300, 200, usual.crs, (a, -b, c + b * 200, d, -e, f + e * 200)), "t")
    assert (usual.is_mirrored, south_up.is_mirrored) == (False, True)
    corners = np.array([(0.0, 0.0), (300.0, 0.0), (0.0, 200.0)])
    assert np.abs(usual.on_earth(corners) - south_up.on_earth(corners)).max() < 1e-12


def test_a_grid_that_is_not_square_on_the_ground_is_refused_with_the_remedy() -> None:
    usual = grid("EPSG:32631")
    a, b, c, d, e, f = usual.affine
    with pytest.raises(PictureError, match=r"t\.tif: its grid is 11\.\d° off square .*gdalwarp"):
        measure_grid(PixelGrid(300, 200, usual.crs, (a, b + 0.2 * a, c, d, e, f)), "t.tif")


def test_coordinates_beyond_the_earth_are_refused() -> None:
    wkt, _ = system("EPSG:4326", "t")
    with pytest.raises(PictureError, match=r"no place on Earth.*--crs"):
        measure_grid(PixelGrid(10, 10, wkt, (1e9, 0, 1e12, 0, -1e9, 1e12)), "t.tif")


@pytest.mark.slow
def test_systems_have_short_names_and_unknown_ones_are_refused() -> None:
    assert system("EPSG:28992", "t")[1] == "EPSG:28992"
    assert system("EPSG:4326", "t")[1] == ""
    assert system("EPSG:7415", "t")[1] == "EPSG:28992"  # with heights above the sea
    for text in ("EPSG:1", "nothing", "EPSG:4978", "EPSG:5709", 'LOCAL_CS["mine",UNIT["metre",1]]'):
        with pytest.raises(PictureError, match="name it with --crs"):
            system(text, "t")
