"""Windows of an orthophoto, each looked at by itself."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import rasterio
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.lots.survey.moments import CaptureTime, MomentSource
from hawk.picture.orthophoto.bands import Bands
from hawk.picture.orthophoto.grid import PixelGrid, system
from hawk.picture.orthophoto.outline import LotOutline
from hawk.picture.orthophoto.source import Orthophoto, open_orthophoto
from hawk.picture.orthophoto.tile_detector import TileVehicles
from hawk.picture.orthophoto.windows import Window, WindowStalls, map_window, task_name, windows_of
from hawk.picture.values import PictureError
from tests.unit.picture.orthophoto.drawn import (
    UTM,
    blank,
    detector,
    lot_file,
    lot_picture,
    opened_blank,
    placed,
    rgb,
    write,
)

WKT, _ = system(UTM, "t")


def described(columns: int, rows: int, metres: tuple[float, float] = (0.1, 0.1)) -> Orthophoto:
    """Return a picture that no file holds."""
    grid = PixelGrid(columns, rows, WKT, (0.1, 0.0, 500_000.0, 0.0, -0.1, 5_770_000.0), metres=metres)
    return Orthophoto(Path("none.tif"), grid, Bands((1, 2, 3)), UTM, "[]", CaptureTime(0.0, MomentSource.FILE, False))


@settings(max_examples=25, deadline=None)
@given(
    st.integers(2, 9_000),
    st.integers(2, 9_000),
    st.tuples(st.floats(0.008, 0.2), st.floats(0.008, 0.2)),
)
def test_cores_cover_the_picture_once(columns: int, rows: int, metres: tuple[float, float]) -> None:
    windows = windows_of(described(columns, rows, metres))
    cores = shapely.box(*np.array([window.core for window in windows], float).T)
    step = windows[0].step
    assert sum(core.area for core in cores) == pytest.approx(shapely.union_all(cores).area)
    left, top, right, bottom = shapely.total_bounds(cores)
    assert (left, top) == (0, 0)
    assert max(columns - right, rows - bottom) <= step - 1
    for window in windows:
        assert shapely.box(*window.box).contains(shapely.box(*window.core))
        sides = np.array(window.box[2:]) - window.box[:2]
        assert (sides * metres <= 128 + 3 * 16 + 1).all()
        assert (sides / step <= 180 / 0.025).all()


def test_a_picture_of_up_to_144_metres_is_one_window() -> None:
    assert [window.box for window in windows_of(described(1440, 1000))] == [(0, 0, 1440, 1000)]
    first, second = windows_of(described(1500, 1000))
    assert (first.core, first.box) == ((0, 0, 1280, 1000), (0, 0, 1440, 1000))
    assert (second.core, second.box) == ((1280, 0, 1500, 1000), (1120, 0, 1500, 1000))


def test_only_windows_on_an_outline_or_with_ground_are_looked_at(tmp_path: Path) -> None:
    source = described(6000, 6000)
    corners = source.grid.on_earth(np.array([(100, 100), (900, 100), (900, 700), (100, 700)], float))
    lot = LotOutline.of(shapely.Polygon(corners[:, ::-1]))
    assert [window.core[:2] for window in windows_of(source, lot)] == [(0, 0)]
    wide = source.grid.on_earth(np.array([(100, 100), (1240, 100), (1240, 700), (100, 700)], float))
    near = LotOutline.of(shapely.Polygon(wide[:, ::-1]))  # 4 m from the next core
    assert [window.core[:2] for window in windows_of(source, near)] == [(0, 0), (1280, 0)]
    bands = np.zeros((3, 1400, 1600), np.uint8)
    bands[:, :, 1300:] = 99
    path = write(tmp_path / "half.tif", bands, placed(UTM, 1600, 1400, metres=0.2), nodata=0)
    assert len(windows_of(open_orthophoto(path))) == 9
    with rasterio.open(path, "r+") as file:
        file.build_overviews([2, 4, 8])
    assert [window.core[0] for window in windows_of(open_orthophoto(path))] == [1280] * 3


def test_a_result_is_named_by_everything_that_makes_it(tmp_path: Path) -> None:
    path = blank(tmp_path)
    source = open_orthophoto(path)
    (window,) = windows_of(source)
    name = task_name(source, window, "model")
    assert name == task_name(open_orthophoto(path), window, "model")
    assert len(name) == 64
    others = {
        task_name(source, window, "other"),
        task_name(source, replace(window, core=(0, 0, 30, 40)), "model"),
        task_name(replace(source, bands=Bands((3, 2, 1))), window, "model"),
        task_name(open_orthophoto(path, "EPSG:32632"), window, "model"),
    }
    os.utime(path, (1, 1))
    others.add(task_name(open_orthophoto(path), window, "model"))
    assert len(others | {name}) == 6


@pytest.mark.slow
def test_a_window_gives_the_same_bytes_and_they_hold_all_of_it(tmp_path: Path) -> None:
    source = open_orthophoto(lot_file(tmp_path))
    (window,) = windows_of(source)
    found = map_window(source, window, detector())
    assert len(found.score) > 30
    data = found.to_bytes()
    assert map_window(open_orthophoto(source.path), window, detector()).to_bytes() == data
    assert len(data) < 20_000
    again = WindowStalls.from_bytes(data)
    assert again.window == window
    for name in ("corners", "taken", "score", "suggested", "lot", "seen"):
        assert np.array_equal(getattr(again, name), getattr(found, name)), name
    assert again.to_bytes() == data
    direct = detector().detect(lot_picture(), source.grid.metres)
    assert np.abs(found.corners - direct.stalls / source.grid.metres).max() <= 0.0051


def test_a_window_without_ground_finds_nothing(tmp_path: Path) -> None:
    source = open_orthophoto(write(tmp_path / "none.tif", np.zeros((3, 40, 60), np.uint8), nodata=0))
    (window,) = windows_of(source)
    found = map_window(source, window, detector())
    assert (len(found.score), len(found.suggested), bool(found.seen.any())) == (0, 0, False)
    assert WindowStalls.from_bytes(found.to_bytes()).to_bytes() == found.to_bytes()


def with_vehicles(kind: int) -> WindowStalls:
    none, mask = np.zeros((0, 4, 2)), np.zeros((2, 2), np.bool_)
    corners = np.array([[(1.0, 2.0), (5.0, 2.0), (5.0, 9.0), (1.0, 9.0)]])
    vehicles = TileVehicles(corners, np.array([0.75]), np.array([kind]))
    return WindowStalls(Window((0, 0, 9, 9), (0, 0, 9, 9)), none, np.zeros(0), np.zeros(0), none, mask, mask, vehicles)


def test_vehicles_of_a_window_are_kept_and_those_of_no_kind_refused() -> None:
    found = with_vehicles(3)
    read = WindowStalls.from_bytes(found.to_bytes()).vehicles
    assert read is not None
    assert (read.corners.tolist(), read.probability.tolist(), read.kind.tolist()) == (
        found.vehicles.corners.tolist(),  # type: ignore[union-attr]
        [0.75],
        [3],
    )
    for kind in (-1, 4):
        with pytest.raises(PictureError, match="remove it and map again"):
            WindowStalls.from_bytes(with_vehicles(kind).to_bytes())


@pytest.mark.parametrize("data", [b"", b"{}", b'{"format":99}', b"[1]", b"\xff"])
def test_bytes_that_are_no_result_are_refused(data: bytes) -> None:
    with pytest.raises(PictureError, match="remove it and map again"):
        WindowStalls.from_bytes(data)


def test_a_result_of_which_a_part_is_missing_is_refused() -> None:
    none, mask = np.zeros((0, 4, 2)), np.zeros((2, 2), np.bool_)
    whole = WindowStalls(Window((0, 0, 9, 9), (0, 0, 9, 9)), none, np.zeros(1), np.zeros(0), none, mask, mask)
    with pytest.raises(PictureError, match="its parts differ"):
        WindowStalls.from_bytes(whole.to_bytes())


_MEASURE = """
import json, re, sys
from pathlib import Path
import cv2, shapely
cv2.setNumThreads(1)
from hawk.picture.city.run import map_orthophoto
from hawk.picture.orthophoto.outline import read_outline
mapped = map_orthophoto(Path(sys.argv[1]), outline=Path(sys.argv[2]))
# not getrusage: a new process begins with the peak of the one that started it
peak = int(re.search("VmHWM:[^0-9]*([0-9]+)", Path("/proc/self/status").read_text())[1]) / 1024
print(json.dumps([len(mapped.survey.stalls), peak]))
"""


@pytest.mark.slow
@pytest.mark.nightly
def test_a_picture_of_60000_pixels_a_side_is_mapped_in_less_than_a_gigabyte(tmp_path: Path) -> None:
    side, metres = 60_000, 0.05
    lot = np.repeat(np.repeat(rgb(lot_picture()), 2, axis=1), 2, axis=2)
    path = tmp_path / "city.tif"
    profile = {"tiled": True, "blockxsize": 512, "blockysize": 512, "BIGTIFF": "YES", "SPARSE_OK": "TRUE"}
    whole = placed(UTM, side, side, metres=metres)
    places = [(1_000, 1_000), (31_000, 52_000)]
    with rasterio.open(
        path, "w", "GTiff", side, side, 3, UTM, whole, "uint8", nodata=0, compress="deflate", **profile
    ) as file:
        for column, row in places:
            window = rasterio.windows.Window(column, row, lot.shape[2], lot.shape[1])
            file.write(np.maximum(lot, 1), window=window)
        noise = np.random.default_rng(1).integers(1, 255, (3, 2048, 2048), np.uint8)  # a picture that is not all empty
        file.write(noise, window=rasterio.windows.Window(20_480, 20_480, 2048, 2048))
    source = open_orthophoto(path)
    lots = []
    for column, row in places:
        ring = np.array([(column, row), (column + 1400, row), (column + 1400, row + 1200), (column, row + 1200)])
        lots.append(shapely.Polygon(source.grid.on_earth(ring.astype(float))[:, ::-1]))
    outline = tmp_path / "lots.geojson"
    outline.write_text(shapely.to_geojson(shapely.MultiPolygon(lots)))
    run = subprocess.run(
        [sys.executable, "-c", _MEASURE, str(path), str(outline)], capture_output=True, text=True, check=True
    )
    found, peak = (float(each) for each in run.stdout.strip("[]\n").split(","))
    assert found == pytest.approx(84, abs=6)
    assert peak < 1024


def test_a_window_is_named_by_the_pixels_of_its_file_and_its_middle(tmp_path: Path) -> None:
    grid = opened_blank(tmp_path, 40, 60).grid
    window = Window((0, 0, 60, 30), (0, 0, 60, 40))
    latitude, longitude = grid.on_earth(np.array([(30.0, 15.0)]))[0]
    assert window.name(grid) == f"columns 0 to 59, rows 0 to 29, about {latitude:.6f}, {longitude:.6f}"
    assert "rows 10 to 39," in window.name(replace(grid, is_mirrored=True))
