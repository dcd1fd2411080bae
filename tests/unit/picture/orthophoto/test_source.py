"""An orthophoto as a source: its kinds of files, its bands, and what is refused."""

from __future__ import annotations

import os
import pickle
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
import rasterio
import rasterio.shutil
from rasterio.control import GroundControlPoint
from rasterio.enums import ColorInterp
from rasterio.transform import Affine

from hawk.picture.orthophoto.source import open_orthophoto, parts_of
from hawk.picture.values import PictureError
from tests.unit.picture.orthophoto.drawn import UTM, blank, lot_picture, placed, rgb, write

PART = np.ascontiguousarray(lot_picture()[100:180, 200:320])
"""A small picture, (80, 120, 3) BGR."""
WHOLE = (0, 0, 120, 80)


def with_colours(path: Path, *colours: ColorInterp) -> Path:
    with rasterio.open(path, "r+") as file:
        file.colorinterp = colours
    return path


@pytest.mark.slow
def test_colours_are_read_in_their_order_whatever_the_bands(tmp_path: Path) -> None:
    bands = rgb(PART)
    near = np.full((1, 80, 120), 77, np.uint8)
    red, green, blue, alpha = (getattr(ColorInterp, name) for name in ("red", "green", "blue", "alpha"))
    files = [
        write(tmp_path / "rgb.tif", bands),
        with_colours(write(tmp_path / "rgba.tif", np.concatenate([bands, near])), red, green, blue, alpha),
        write(tmp_path / "nir.tif", np.concatenate([bands, near]), photometric="RGB", alpha="unspecified"),
        with_colours(write(tmp_path / "bgr.tif", bands[::-1]), blue, green, red),
    ]
    for file in files:
        pixels = open_orthophoto(file).read(WHOLE)
        assert np.array_equal(pixels.image, PART), file.name
        assert pixels.valid.all()


@pytest.mark.slow
def test_alpha_shows_where_ground_is_and_infrared_does_not(tmp_path: Path) -> None:
    band = np.zeros((1, 80, 120), np.uint8)
    band[:, :, :50] = 255
    four = np.concatenate([rgb(PART), band])
    alpha = with_colours(
        write(tmp_path / "alpha.tif", four), ColorInterp.red, ColorInterp.green, ColorInterp.blue, ColorInterp.alpha
    )
    assert np.array_equal(open_orthophoto(alpha).read(WHOLE).valid, band[0] > 0)
    infrared = write(tmp_path / "nir.tif", four, photometric="RGB", alpha="unspecified")
    assert open_orthophoto(infrared).read(WHOLE).valid.all()
    grey = write(tmp_path / "grey.tif", np.concatenate([rgb(PART)[1:2], band]))
    pixels = open_orthophoto(grey).read(WHOLE)
    assert np.array_equal(pixels.valid, band[0] > 0)
    assert np.array_equal(pixels.image, np.repeat(PART[..., 1:2], 3, axis=2))


def test_a_table_of_colours_is_looked_up(tmp_path: Path) -> None:
    path = write(tmp_path / "table.tif", (PART[None, ..., 0] > 90).astype(np.uint8), photometric="palette")
    with rasterio.open(path, "r+") as file:
        file.write_colormap(1, {0: (10, 20, 30, 255), 1: (200, 150, 100, 255)})
    found = np.unique(open_orthophoto(path).read(WHOLE).image.reshape(-1, 3), axis=0)
    assert found.tolist() == [[30, 20, 10], [100, 150, 200]]


def test_sixteen_bits_are_scaled_by_their_brightness_and_it_is_said(tmp_path: Path) -> None:
    bands = rgb(PART).astype(np.uint16) * 40 + 1000
    bands[:, :5, :5] = 60_000  # a glint
    bands[:, -20:] = 0
    source = open_orthophoto(write(tmp_path / "deep.tif", bands, nodata=0))
    pixels = source.read(WHOLE)
    assert not pixels.valid[-20:].any()
    assert pixels.valid[:60].all()
    shown, was = pixels.image[10:60].astype(float).ravel(), PART[10:60].astype(float).ravel()
    assert np.corrcoef(shown, was)[0, 1] > 0.99
    assert (shown.min(), shown.max()) == (0, 255)
    assert source.notes == ("The picture has 16 bits: brightness 3080 is shown as black and 8000 as white.",)


def test_missing_ground_is_known_by_its_value_or_by_a_mask(tmp_path: Path) -> None:
    bands = np.maximum(rgb(PART), 1)
    bands[:, :, 70:] = 0
    by_value = write(tmp_path / "nodata.tif", bands, nodata=0)
    masked = write(tmp_path / "mask.tif", bands)
    with rasterio.open(masked, "r+") as file:
        file.write_mask(np.arange(120)[None].repeat(80, axis=0) < 70)
    for path in (by_value, masked):
        valid = open_orthophoto(path).read(WHOLE).valid
        assert valid[:, :70].all()
        assert not valid[:, 70:].any()


def test_a_picture_with_its_south_first_is_read_with_its_north_first(tmp_path: Path) -> None:
    a, b, c, d, e, f = tuple(placed(UTM, 120, 80))[:6]
    upside = Affine(a, -b, c + b * 80, d, -e, f + e * 80)
    source = open_orthophoto(write(tmp_path / "south.tif", rgb(PART[::-1]), upside))
    assert source.grid.is_mirrored
    assert np.array_equal(source.read(WHOLE).image, PART)
    assert np.array_equal(source.read((8, 12, 40, 30)).image, PART[12:30, 8:40])


def test_parts_are_averaged_while_they_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = open_orthophoto(write(tmp_path / "lot.tif", rgb(PART)))
    monkeypatch.setattr("hawk.picture.orthophoto.source._STRIP_PIXELS", 700)  # several strips
    pixels = source.read((0, 0, 119, 80), 3)
    assert pixels.image.shape == (26, 39, 3)
    mean = PART[:78, :117].reshape(26, 3, 39, 3, 3).mean(axis=(1, 3))
    assert np.abs(pixels.image - mean).max() <= 0.51


def test_a_jpeg_has_its_place_by_a_world_file(tmp_path: Path) -> None:
    path = tmp_path / "lot.jpg"
    cv2.imwrite(str(path), PART)
    with pytest.raises(PictureError, match=r"lot\.jpg: has no place on Earth; put its world file beside it"):
        open_orthophoto(path)
    a, b, c, d, e, f = tuple(placed(UTM, 120, 80))[:6]
    (tmp_path / "lot.jgw").write_text("\n".join(map(str, (a, d, b, e, c + (a + b) / 2, f + (d + e) / 2))))
    with pytest.raises(PictureError, match=r"lot\.jpg: does not say its system of coordinates; name it with --crs"):
        open_orthophoto(path)
    source = open_orthophoto(path, UTM)
    assert source.grid.metres == pytest.approx((0.1, 0.1), abs=2e-5)
    assert np.abs(np.subtract(source.grid.affine, (a, b, c, d, e, f))).max() < 1e-6
    with rasterio.open(blank(tmp_path)) as file:
        (tmp_path / "lot.prj").write_text(file.crs.to_wkt())
    assert open_orthophoto(path).crs == UTM


def test_a_virtual_file_changes_with_the_files_that_it_names(tmp_path: Path) -> None:
    part = write(tmp_path / "part.tif", rgb(PART))
    with rasterio.open(part) as file:
        a, b, c, d, e, f = tuple(file.transform)[:6]
        geo = ", ".join(map(str, (c, a, b, f, d, e)))
        wkt = file.crs.to_wkt().replace('"', "&quot;")
    bands = "".join(
        f'<VRTRasterBand dataType="Byte" band="{k}"><ColorInterp>{name}</ColorInterp><SimpleSource>'
        f'<SourceFilename relativeToVRT="1">part.tif</SourceFilename><SourceBand>{k}</SourceBand>'
        "</SimpleSource></VRTRasterBand>"
        for k, name in enumerate(("Red", "Green", "Blue"), 1)
    )
    path = tmp_path / "city.vrt"
    head = f'<VRTDataset rasterXSize="120" rasterYSize="80"><SRS>{wkt}</SRS><GeoTransform>{geo}</GeoTransform>'
    path.write_text(f"{head}{bands}</VRTDataset>")
    source = open_orthophoto(path)
    assert np.array_equal(source.read(WHOLE).image, PART)
    assert open_orthophoto(path).identity == source.identity
    outer = tmp_path / "country.vrt"
    outer.write_text(f"{head}{bands}</VRTDataset>".replace("part.tif", "city.vrt"))
    of_country = open_orthophoto(outer).identity
    os.utime(part, (1, 1))
    assert open_orthophoto(path).identity != source.identity
    assert open_orthophoto(outer).identity != of_country
    part.unlink()
    with pytest.raises(PictureError, match=r"country\.vrt: is made of files that are not there: .*part\.tif"):
        open_orthophoto(outer)


def test_files_of_a_vrt_that_names_itself_are_found_once(tmp_path: Path) -> None:
    path = tmp_path / "loop.vrt"
    named = "".join(f"<SourceFilename relativeToVRT='1'>{each}</SourceFilename>" for each in ("loop.vrt", "a.tif"))
    path.write_text(f"<VRTDataset>{named}</VRTDataset>")
    assert parts_of(path) == [tmp_path / "a.tif", path]


def test_a_cloud_optimised_file_shows_its_ground_by_an_overview(tmp_path: Path) -> None:
    bands = np.full((3, 600, 600), 90, np.uint8)
    bands[:, 300:] = 0
    whole = placed(UTM, 600, 600)
    path = tmp_path / "cog.tif"
    write(path, bands, whole, nodata=0)
    assert open_orthophoto(path).ground() is None
    with rasterio.open(path, "r+") as file:
        file.build_overviews([2, 4, 8])
    ground = open_orthophoto(path).ground(most=60)
    assert ground is not None
    assert ground.shape == (60, 60)
    assert ground[:29].all()
    assert not ground[31:].any()


def test_another_process_can_read_the_same_picture(tmp_path: Path) -> None:
    source = open_orthophoto(write(tmp_path / "lot.tif", rgb(PART)))
    again = pickle.loads(pickle.dumps(source))  # noqa: S301 - our own bytes
    assert again == source
    assert np.array_equal(again.read(WHOLE).image, PART)


@pytest.mark.parametrize("east", [330_000.0, 500_000.0, 690_000.0])
def test_twenty_centimetres_of_a_projection_are_read_and_twelve_are_not_coarse(tmp_path: Path, east: float) -> None:
    def at(metres: float) -> Affine:
        return Affine(metres, 0.0, east, 0.0, -metres, 5_700_000.0)

    (note,) = open_orthophoto(blank(tmp_path, transform=at(0.2))).notes
    assert note.startswith("The picture has 20 cm a pixel, more than 12 cm.")
    assert open_orthophoto(blank(tmp_path, transform=at(0.12))).notes == ()


@pytest.mark.slow
def test_a_coarse_picture_is_warned_about_and_a_coarser_one_refused(tmp_path: Path) -> None:
    assert open_orthophoto(blank(tmp_path, transform=placed(UTM, 60, 40, metres=0.119))).notes == ()
    (note,) = open_orthophoto(blank(tmp_path, transform=placed(UTM, 60, 40, metres=0.15))).notes
    assert note.startswith("The picture has 15 cm a pixel, more than 12 cm. 17 labelled places were made coarser")
    with pytest.raises(PictureError, match=r"blank\.tif: has 0\.21 m a pixel on the ground, 0\.20 m is the coarsest"):
        open_orthophoto(blank(tmp_path, transform=placed(UTM, 60, 40, metres=0.21)))
    with pytest.raises(PictureError, match=r"has 0\.25 m a pixel"):  # Web Mercator's metres are no metres
        open_orthophoto(blank(tmp_path, crs="EPSG:3857", transform=placed("EPSG:3857", 60, 40, metres=0.25)))


def test_a_picture_smaller_than_a_stall_is_refused(tmp_path: Path) -> None:
    with pytest.raises(PictureError, match=r"shows 3\.0 by 1\.0 m of ground, less than a stall"):
        open_orthophoto(blank(tmp_path, rows=10, columns=30))


def refused(tmp_path: Path, kind: str) -> tuple[Path, str | None, str]:
    """Return a file, the system that is asked for, and the beginning of the refusal."""
    path = tmp_path / f"{kind}.tif"
    grey = np.full((3, 20, 30), 100, np.uint8)
    if kind == "missing":
        return path, None, r"is no file; name a GeoTIFF"
    if kind == "text":
        path.write_text("no picture")
        return path, None, r"text\.tif: is of no kind that is known: export it as GeoTIFF"
    if kind == "heights":
        return (
            write(path, grey[:1].astype(np.float32)),
            None,
            r"is a model of heights \(DSM, DTM; float32\), no picture",
        )
    if kind == "float":
        return write(path, grey.astype(np.float32)), None, "has pixels of type float32.*gdal_translate -ot Byte"
    if kind == "many":
        return write(path, np.full((6, 20, 30), 9, np.uint8), photometric="minisblack"), None, "has 6 bands .*-b 3"
    if kind == "empty":
        return write(path, np.zeros((3, 20, 30), np.uint16), nodata=0), None, "shows no ground"
    if kind == "unplaced":
        return write(path, grey, Affine.identity(), None), UTM, "has no place on Earth"
    if kind == "unknown":
        return write(path, grey, placed(UTM, 30, 20), None), None, "does not say its system .* --crs EPSG:25832"
    if kind == "named":
        return write(path, grey, placed(UTM, 30, 20), None), "EPSG:99999", "system of coordinates is not known"
    points = [GroundControlPoint(row, column, 500_000 + column, 5_700_000 - row) for row, column in
              ((0, 0), (0, 30), (20, 0), (20, 30))]  # fmt: skip
    with rasterio.open(path, "w", "GTiff", 30, 20, 3, dtype="uint8") as file:
        file.write(grey)
        file.gcps = (points, rasterio.crs.CRS.from_epsg(32631))
    return path, None, r"tied to the ground by control points.*gdalwarp"


@pytest.mark.filterwarnings("ignore::rasterio.errors.NotGeoreferencedWarning")
@pytest.mark.parametrize(
    "kind", ["missing", "text", "heights", "float", "many", "empty", "unplaced", "unknown", "named", "points"]
)
def test_what_cannot_be_mapped_is_refused_with_the_remedy(tmp_path: Path, kind: str) -> None:
    path, crs, words = refused(tmp_path, kind)
    with pytest.raises(PictureError, match=words):
        open_orthophoto(path, crs)


def test_a_part_that_is_cut_off_is_named(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    path = write(tmp_path / "cut.tif", rng.integers(0, 255, (3, 600, 600), np.uint8))
    path.write_bytes(path.read_bytes()[:300_000])
    source = open_orthophoto(path)
    with pytest.raises(PictureError, match=r"cut\.tif: cannot be read as a picture"):
        source.read((300, 300, 600, 600))


def test_without_the_extra_the_remedy_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = blank(tmp_path)
    monkeypatch.setitem(sys.modules, "rasterio", None)
    with pytest.raises(PictureError, match=r"rasterio and pyproj are not installed.*\[pictures\]"):
        open_orthophoto(path)


def test_the_missing_file_of_a_virtual_one_is_named(tmp_path: Path) -> None:
    tile = blank(tmp_path)
    path = tmp_path / "city.vrt"
    rasterio.shutil.copy(tile, path, driver="VRT")
    tile.unlink()
    with pytest.raises(
        PictureError, match=r"city.vrt: is made of files that are not there: .*blank.tif; .*gdalbuildvrt"
    ):
        open_orthophoto(path).read((0, 0, 20, 20))


def test_a_scale_just_beyond_a_limit_is_said_with_the_digit_that_differs(tmp_path: Path) -> None:
    def there(metres: float) -> Affine:
        return Affine(metres, 0, 500_000, 0, -metres, 5_700_000)

    (note,) = open_orthophoto(blank(tmp_path, transform=there(0.1235))).notes
    assert note.startswith("The picture has 12.4 cm a pixel, more than 12 cm.")
    with pytest.raises(PictureError, match=r"has 0\.206 m a pixel on the ground, 0\.20 m is the coarsest"):
        open_orthophoto(blank(tmp_path, transform=there(0.2055)))
