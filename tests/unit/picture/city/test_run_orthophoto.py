"""An orthophoto mapped from its file to its survey."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import rasterio
import shapely
from rasterio.enums import ColorInterp
from rasterio.transform import Affine

from hawk.picture.city.run import map_orthophoto
from hawk.picture.orthophoto.outline import LotOutline
from hawk.picture.orthophoto.source import open_orthophoto
from hawk.picture.values import PictureError, PictureSurvey
from tests.unit.picture.orthophoto.drawn import UTM, corners_m, detector, lot_file, lot_picture, placed, rgb, write

pytestmark = pytest.mark.slow

HIGH, WIDE = lot_picture().shape[:2]
SYSTEMS = {"EPSG:28992": "Dutch", "EPSG:2263": "feet", "EPSG:4326": "degrees", "EPSG:3857": "web"}


@pytest.fixture(autouse=True)
def one_eye(monkeypatch: pytest.MonkeyPatch) -> None:
    """Load the network once."""
    loaded = detector()
    monkeypatch.setattr("hawk.picture.city.run.TileDetector.load", lambda *_: loaded)


@pytest.fixture(scope="module")
def usual(tmp_path_factory: pytest.TempPathFactory) -> PictureSurvey:
    return map_orthophoto(lot_file(tmp_path_factory.mktemp("usual")))


def same_stalls(mapped: PictureSurvey, usual: PictureSurvey) -> bool:
    """Return True for the same stalls in the same places, to a centimetre, with the same states."""
    one, other = mapped.survey, usual.survey
    return (
        len(one.stalls) == len(other.stalls) > 30
        and bool(np.abs(corners_m(mapped) - corners_m(usual)).max() < 0.01)
        and [(s.id, s.state, s.taken_probability) for s in one.stalls]
        == [(s.id, s.state, s.taken_probability) for s in other.stalls]
    )


@pytest.mark.parametrize("crs", SYSTEMS, ids=SYSTEMS.values())
def test_the_same_ground_in_another_system_has_the_same_stalls(tmp_path: Path, usual: PictureSurvey, crs: str) -> None:
    path = lot_file(tmp_path, transform=placed(crs, WIDE, HIGH), crs=crs)
    mapped = map_orthophoto(path)
    assert same_stalls(mapped, usual)
    assert mapped.crs == ("" if crs == "EPSG:4326" else crs)
    assert mapped.area_m2 == pytest.approx(usual.area_m2, abs=0.5)


@pytest.mark.parametrize("kind", ["alpha", "infrared", "south first"])
def test_the_same_ground_with_other_bands_or_rows_has_the_same_stalls(
    tmp_path: Path, usual: PictureSurvey, kind: str
) -> None:
    bands, path = rgb(lot_picture()), tmp_path / "other.tif"
    full = np.full((1, HIGH, WIDE), 255, np.uint8)
    if kind == "south first":
        a, b, c, d, e, f = tuple(placed(UTM, WIDE, HIGH))[:6]
        write(path, bands[:, ::-1], Affine(a, -b, c + b * HIGH, d, -e, f + e * HIGH))
    elif kind == "alpha":
        write(path, np.concatenate([bands, full]))
        with rasterio.open(path, "r+") as file:
            file.colorinterp = [ColorInterp.red, ColorInterp.green, ColorInterp.blue, ColorInterp.alpha]
    else:
        write(path, np.concatenate([bands, full // 3]), photometric="RGB", alpha="unspecified")
    assert same_stalls(map_orthophoto(path), usual)


def test_the_eye_finds_the_same_in_the_picture_itself(usual: PictureSurvey) -> None:
    found = detector().detect(lot_picture(), 0.1)
    assert len(found.stalls) == len(usual.survey.stalls)
    metres = found.stalls.mean(axis=1) - np.array([WIDE, HIGH]) * 0.05
    places = corners_m(usual).mean(axis=1)
    apart = np.hypot(metres[:, None, 1] + places[None, :, 0], metres[:, None, 0] - places[None, :, 1])
    assert apart.min(axis=0).max() < 0.02


def test_an_outline_and_progress_and_a_sheet(tmp_path: Path, usual: PictureSurvey) -> None:
    path = lot_file(tmp_path)
    grid = open_orthophoto(path).grid
    half = np.array([(0, 0), (WIDE / 2, 0), (WIDE / 2, HIGH), (0, HIGH)])
    outline = tmp_path / "half.geojson"
    outline.write_text(shapely.to_geojson(shapely.Polygon(grid.on_earth(half)[:, ::-1])))
    steps: list[tuple[int, int]] = []
    mapped = map_orthophoto(path, outline=outline, progress=lambda done, count: steps.append((done, count)))
    assert steps == [(0, 1), (1, 1)]
    assert 0 < len(mapped.survey.stalls) < len(usual.survey.stalls)
    assert corners_m(mapped).mean(axis=1)[:, 1].max() < 0
    assert mapped.area_m2 == pytest.approx(usual.area_m2 / 2, rel=0.01)
    far = LotOutline.of(shapely.box(1, 1, 1.001, 1.001))
    with pytest.raises(PictureError, match="none of the outlines lies in the picture"):
        map_orthophoto(path, outline=far)


def test_a_window_that_is_cut_off_is_named_and_the_others_are_mapped(tmp_path: Path) -> None:
    noise = np.random.default_rng(2).integers(0, 255, (3, 100, 2000), np.uint8)
    path = write(tmp_path / "cut.tif", noise, placed(UTM, 2000, 100, metres=0.2))
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) - 150_000])
    mapped = map_orthophoto(path)
    assert [each.name for each in mapped.left_out] == ["columns 1280 to 1999, rows 0 to 99, about 52.100000, 5.201868"]
    assert "cut.tif: cannot be read as a picture" in mapped.left_out[0].reason
    assert mapped.area_m2 == pytest.approx(256 * 20, rel=0.01)
    assert mapped.ground is not None
    assert (mapped.ground.seen > 0).mean(axis=0)[[400, 3900]].tolist() == pytest.approx([0.9, 0], abs=0.1)
    path.write_bytes(whole[:3_000])
    with pytest.raises(PictureError, match="cannot be read"):
        map_orthophoto(path)


def test_a_picture_of_clouds_shows_no_stall(tmp_path: Path) -> None:
    clouds = np.random.default_rng(3).normal(235, 6, (3, 300, 300)).clip(0, 255).astype(np.uint8)
    mapped = map_orthophoto(write(tmp_path / "clouds.tif", clouds))
    assert mapped.survey.stalls == ()
    assert mapped.area_m2 == pytest.approx(900, rel=0.01)


def test_a_finer_picture_has_the_same_stalls(tmp_path: Path, usual: PictureSurvey) -> None:
    bands = np.repeat(np.repeat(rgb(lot_picture()), 4, axis=1), 4, axis=2)
    path = write(tmp_path / "fine.tif", bands, placed(UTM, 4 * WIDE, 4 * HIGH, metres=0.025))
    mapped = map_orthophoto(path)
    assert len(mapped.survey.stalls) == len(usual.survey.stalls)
    assert np.abs(corners_m(mapped) - corners_m(usual)).max() < 0.05


def test_a_turned_picture_has_the_same_stalls_where_they_are_then(tmp_path: Path, usual: PictureSurvey) -> None:
    mapped = map_orthophoto(lot_file(tmp_path, transform=placed(UTM, WIDE, HIGH, turn=90.0)))
    north, east = np.moveaxis(corners_m(usual), -1, 0)
    assert np.abs(corners_m(mapped) - np.stack([east, -north], -1)).max() < 0.01
