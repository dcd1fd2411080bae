"""Mosaic and occupancy as Cloud Optimised GeoTIFF, and the STAC item of both."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
import rasterio
from rasterio.warp import transform
from rio_cogeo.cogeo import cog_validate

from hawk.exports.ground import OCCUPANCY, ground_of
from hawk.exports.rasters import plane_of, write_rasters
from hawk.lots.registration.frames import Move
from hawk.lots.values import LotStoreError
from tests.unit.exports.stored import Stored, mosaic

TILES = {key: tile.data for key, tile in mosaic().items()}


@pytest.mark.slow
def test_both_files_are_cloud_optimised_and_place_each_stall_to_a_centimetre(stored: Stored, tmp_path: Path) -> None:
    survey = stored.read()
    files = write_rasters(survey, ground_of(survey, TILES, Move()), tmp_path / "lot.tif")
    assert [file.name for file in files] == ["lot.tif", "lot-occupancy.tif", "lot.json"]
    for file in files[:2]:
        is_valid, errors, warnings = cog_validate(file, quiet=True)
        assert (is_valid, errors, warnings) == (True, [], [])
    with rasterio.open(files[1]) as states:
        assert states.nodata == 0
        values = states.read(1)
        latitudes, longitudes = zip(*(stall.place for stall in survey.stalls), strict=True)
        east, north = transform("EPSG:4326", states.crs, longitudes, latitudes)
        for stall, x, y in zip(survey.stalls, east, north, strict=True):
            row, column = states.index(x, y)
            assert values[row, column] == OCCUPANCY[stall.state]
        back = transform(states.crs, "EPSG:4326", east, north)
        assert np.abs(np.array(back) - (longitudes, latitudes)).max() < 1e-9
        assert states.tags()["SURVEY_ID"] == survey.survey
    with rasterio.open(files[0]) as colours:
        assert colours.count == 4
        assert colours.read(4).min() == 255
        assert colours.tags()["SOFTWARE"] == "hawk-drone 0.3.0"


def test_the_plane_is_metric_about_the_lots_datum(stored: Stored) -> None:
    survey = stored.read()
    latitude, longitude = survey.origin
    east, north = transform("EPSG:4326", plane_of(survey), [longitude, longitude], [latitude, latitude + 0.001])
    assert (east[0], north[0]) == pytest.approx((0.0, 0.0), abs=1e-3)
    assert north[1] == pytest.approx(111.27, abs=0.05)


@pytest.mark.slow
def test_the_item_describes_both_files_as_stac_says(stored: Stored, tmp_path: Path) -> None:
    survey = stored.read()
    *_, item = write_rasters(survey, ground_of(survey, TILES, Move()), tmp_path / "lot.tif")
    found = json.loads(item.read_text())
    assert (found["type"], found["stac_version"], found["id"]) == ("Feature", "1.0.0", survey.survey)
    assert found["properties"]["datetime"] == "2026-02-03T02:55:00Z"
    west, south, east, north = found["bbox"]
    assert west < min(stall.place[1] for stall in survey.stalls) < east
    assert south < min(stall.place[0] for stall in survey.stalls) < north
    assert {asset["href"] for asset in found["assets"].values()} == {"./lot.tif", "./lot-occupancy.tif"}
    with rasterio.open(tmp_path / "lot.tif") as file:
        assert found["properties"]["proj:shape"] == [file.height, file.width]
        assert found["properties"]["proj:transform"] == pytest.approx(list(file.transform)[:6])


@pytest.mark.slow
def test_without_rasterio_the_remedy_is_named(stored: Stored, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    survey = stored.read()
    monkeypatch.setitem(sys.modules, "rasterio", None)
    with pytest.raises(LotStoreError, match=r"rasterio is not installed, which writes GeoTIFF files: .*\[background\]"):
        write_rasters(survey, ground_of(survey, TILES, Move()), tmp_path / "lot.tif")
    assert not list(tmp_path.glob("*.tif"))
