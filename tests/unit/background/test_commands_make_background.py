from __future__ import annotations

import math
import stat
import subprocess
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import rasterio
from rasterio.crs import CRS
from rasterio.transform import Affine, from_origin
from rasterio.warp import transform as reproject

from hawk.background import tiles
from hawk.background.tiles import MISSING, TILE_PX, PictureError, open_picture, tile_side, tiles_of, zooms_for
from hawk.cli import main
from hawk.web.background import read_tile, zooms_in

WIDTH, HEIGHT, PIXEL_M = 900, 600, 0.2
WEST, NORTH = 587_000.0, 4_790_000.0
"""In UTM zone 17 N, metres."""
QUARTERS = {(0.25, 0.25): (200, 40, 40), (0.75, 0.25): (40, 200, 40), (0.25, 0.75): (40, 40, 200)}
"""Place by share from west and north -> red, green, blue. The last quarter is white."""
UTM = "EPSG:32617"


def pixels(bands: int = 3, kind: type = np.uint8) -> np.ndarray[Any, Any]:
    picture = np.full((3, HEIGHT, WIDTH), 255, np.uint8)
    for (right, down), colour in QUARTERS.items():
        rows, columns = slice(*_half(HEIGHT, down)), slice(*_half(WIDTH, right))
        picture[:, rows, columns] = np.array(colour, np.uint8)[:, None, None]
    opaque = np.full((1, HEIGHT, WIDTH), 255, np.uint8)
    return {1: picture[:1], 3: picture, 4: np.concatenate([picture, opaque])}[bands].astype(kind)


def _half(size: int, share: float) -> tuple[int, int]:
    return (0, size // 2) if share < 0.5 else (size // 2, size)


def geotiff(
    path: Path, data: np.ndarray[Any, Any] | None = None, crs: str | None = UTM, at: Affine | None = None, **more: Any
) -> Path:
    data = pixels() if data is None else data
    profile = {"driver": "GTiff", "width": WIDTH, "height": HEIGHT, "count": len(data), "dtype": data.dtype, **more}
    if crs is not None:
        profile |= {"crs": CRS.from_string(crs), "transform": at or from_origin(WEST, NORTH, PIXEL_M, PIXEL_M)}
    with rasterio.open(path, "w", **profile) as file:
        file.write(data)
    return path


def place_of(right: float, down: float) -> tuple[float, float]:
    """Return a place of the picture in Web Mercator, by share from west and north."""
    east, north = WEST + right * WIDTH * PIXEL_M, NORTH - down * HEIGHT * PIXEL_M
    xs, ys = reproject(CRS.from_string(UTM), CRS.from_epsg(3857), [east], [north])
    return xs[0], ys[0]


def shown(folder: Path, zoom: int, place: tuple[float, float]) -> tuple[int, ...]:
    """Return the colour (red, green, blue, and opacity where the tile has it) that the page shows at a place."""
    side, half = tile_side(zoom), math.pi * 6_378_137.0
    x, y = (place[0] + half) / side, (half - place[1]) / side
    found = read_tile(folder, zoom, int(x), int(y))
    if found is None:
        return ()
    image = cv2.imdecode(np.frombuffer(found[1], np.uint8), cv2.IMREAD_UNCHANGED)
    assert image is not None
    pixel = image[int(y % 1 * TILE_PX), int(x % 1 * TILE_PX)].tolist()
    return (*pixel[2::-1], *pixel[3:])


@pytest.mark.slow
@pytest.mark.parametrize("bands", [3, 4])
@pytest.mark.parametrize("compression", ["none", "lzw", "deflate"])
def test_every_place_of_the_picture_is_shown_at_its_place(tmp_path: Path, bands: int, compression: str) -> None:
    picture = geotiff(tmp_path / "lot.tif", pixels(bands), compress=compression)
    assert main(["make-background", str(picture), "--out", str(tmp_path / "tiles")]) == 0
    zooms = zooms_in(tmp_path / "tiles")
    assert zooms == [17, 18, 19], (
        "0.2 m on the ground at 43 degrees are 0.27 m of the projection, a tile of zoom 19 has 0.30"
    )
    for zoom in zooms:
        for (right, down), colour in QUARTERS.items():
            assert shown(tmp_path / "tiles", zoom, place_of(right, down))[:3] == pytest.approx(colour, abs=6)
        assert min(shown(tmp_path / "tiles", zoom, place_of(0.75, 0.75))[:3]) > 248


@pytest.mark.slow
def test_beside_the_picture_there_is_nothing(tmp_path: Path) -> None:
    picture = geotiff(tmp_path / "lot.tif")
    assert main(["make-background", str(picture), "--out", str(tmp_path / "tiles")]) == 0
    deepest = zooms_in(tmp_path / "tiles")[-1]
    assert shown(tmp_path / "tiles", deepest, place_of(-0.005, 0.5))[3:] == (0,)
    assert shown(tmp_path / "tiles", deepest, place_of(-0.9, 0.5)) == ()
    kinds = {path.suffix for path in (tmp_path / "tiles" / str(deepest)).rglob("*.*")}
    assert kinds == {".jpg", ".png"}, "the edge is transparent, the inside is small"


@pytest.mark.slow
def test_the_edges_between_colours_lie_within_a_pixel(tmp_path: Path) -> None:
    picture = geotiff(tmp_path / "lot.tif")
    assert main(["make-background", str(picture), "--out", str(tmp_path / "tiles"), "--zooms", "21"]) == 0
    off = PIXEL_M / (WIDTH * PIXEL_M)
    assert shown(tmp_path / "tiles", 21, place_of(0.5 - 1.5 * off, 0.25))[:3] == pytest.approx((200, 40, 40), abs=30)
    assert shown(tmp_path / "tiles", 21, place_of(0.5 + 1.5 * off, 0.25))[:3] == pytest.approx((40, 200, 40), abs=30)


def test_degrees_are_a_reference_system_too_and_grey_is_shown_as_grey(tmp_path: Path) -> None:
    degrees = from_origin(-79.93, 43.26, 2.5e-6, 1.8e-6)
    picture = geotiff(tmp_path / "lot.tif", pixels(1), "EPSG:4326", degrees)
    assert main(["make-background", str(picture), "--out", str(tmp_path / "tiles"), "--zooms", "18-19"]) == 0
    middle = (-79.93 + 0.25 * WIDTH * 2.5e-6, 43.26 - 0.25 * HEIGHT * 1.8e-6)
    (x,), (y,) = reproject(CRS.from_epsg(4326), CRS.from_epsg(3857), [middle[0]], [middle[1]])
    assert shown(tmp_path / "tiles", 19, (x, y))[:3] == pytest.approx((200, 200, 200), abs=4)
    assert zooms_in(tmp_path / "tiles") == [18, 19]


@pytest.mark.slow
def test_the_folder_can_be_read_by_the_daemon_and_is_named_with_the_setting(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    geotiff(tmp_path / "lot.tif")
    assert main(["make-background", "lot.tif", "--out", "deep/tiles"]) == 0
    said = capsys.readouterr()
    count = len(list((tmp_path / "deep" / "tiles").rglob("*.*")))
    assert f"{count} tiles of the zooms 17 to 19" in said.out
    assert f'background_tiles = "{tmp_path}/deep/tiles"' in said.err
    assert stat.S_IMODE((tmp_path / "deep" / "tiles").stat().st_mode) == 0o755
    assert [path.name for path in (tmp_path / "deep").iterdir()] == ["tiles"], "nothing else is left"


def refusal(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    assert main(["make-background", *arguments]) == 2
    return capsys.readouterr().err


@pytest.mark.slow
def test_a_picture_that_cannot_be_used_is_refused_with_a_remedy(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = ["--out", str(tmp_path / "tiles")]
    nowhere = tmp_path / "nowhere.tif"
    with pytest.warns(rasterio.errors.NotGeoreferencedWarning):
        geotiff(nowhere, crs=None)
    assert "does not say where it lies: georeference it" in refusal([str(nowhere), *out], capsys)
    deep = geotiff(tmp_path / "deep.tif", pixels(kind=np.uint16))
    assert "gdal_translate -ot Byte -scale" in refusal([str(deep), *out], capsys)
    palette = geotiff(tmp_path / "palette.tif", pixels(1), photometric="palette")
    assert "gdal_translate -expand rgb" in refusal([str(palette), *out], capsys)
    words = tmp_path / "words.tif"
    words.write_text("no picture")
    assert "is of no kind that is known: export it as GeoTIFF" in refusal([str(words), *out], capsys)
    assert "cannot be read: No such file" in refusal([str(tmp_path / "missing.tif"), *out], capsys)
    clear = geotiff(tmp_path / "clear.tif", pixels(4) * np.array([1, 1, 1, 0], np.uint8)[:, None, None])
    assert "all of it is transparent" in refusal([str(clear), *out], capsys)
    assert not (tmp_path / "tiles").exists()
    assert not list(tmp_path.glob(".tiles*")), "nothing half done is left"


@pytest.mark.slow
def test_a_folder_that_holds_something_is_not_written_into(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = geotiff(tmp_path / "lot.tif")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes").write_text("keep")
    assert "is not empty: name a new folder" in refusal([str(picture), "--out", str(tmp_path / "mine")], capsys)
    assert "is not empty" in refusal([str(picture), "--out", str(picture)], capsys)
    assert "notes" in refusal([str(picture), "--out", str(tmp_path / "mine" / "notes" / "deeper")], capsys)
    (tmp_path / "empty").mkdir()
    assert main(["make-background", str(picture), "--out", str(tmp_path / "empty")]) == 0


@pytest.mark.parametrize("zooms", ["", "20-18", "3-24", "-3", "3-", "x", "24"])
def test_zooms_that_there_are_not_are_refused(zooms: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["make-background", __file__, "--out", "x", f"--zooms={zooms}"]) == 2
    assert "--zooms" in capsys.readouterr().err


def test_more_tiles_than_a_disk_takes_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tiles, "MOST_TILES", 10)
    with (
        open_picture(geotiff(tmp_path / "lot.tif")) as picture,
        pytest.raises(PictureError, match="tiles are too many, at most 10: name lower zooms"),
    ):
        tiles.write_tiles(picture, tmp_path / "tiles", zooms_for(picture.bounds, picture.metres_per_pixel))


def test_without_rasterio_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rasterio", None)
    with pytest.raises(PictureError) as raised, open_picture(Path("lot.tif")):
        pass
    assert str(raised.value) == MISSING


@pytest.mark.slow
def test_a_command_line_that_makes_no_background_imports_nothing_that_reads_pictures() -> None:
    look = "import sys, hawk.cli; print({'cv2', 'numpy', 'rich', 'aiohttp', 'rasterio'} & set(sys.modules))"
    assert subprocess.run([sys.executable, "-c", look], capture_output=True, text=True, check=True).stdout == "set()\n"


LOCAL = 'LOCAL_CS["site",UNIT["metre",1],AXIS["Easting",EAST],AXIS["Northing",NORTH]]'
ENGINEERING = 'ENGCRS["site",EDATUM["a peg"],CS[Cartesian,2],AXIS["x",east],AXIS["y",north],LENGTHUNIT["metre",1]]'


@pytest.mark.fault("a background in local coordinates, or beyond the map", "refused with a remedy, status 2")
@pytest.mark.parametrize("system", [LOCAL, ENGINEERING])
def test_local_coordinates_are_refused_with_a_remedy(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], system: str
) -> None:
    path = geotiff(tmp_path / "site.tif", crs=system, at=from_origin(100.0, 200.0, PIXEL_M, PIXEL_M))
    assert main(["make-background", str(path), "--out", str(tmp_path / "tiles")]) == 2
    said = capsys.readouterr().err
    assert "site.tif is in local coordinates" in said
    assert "EPSG:3857" in said
    assert "Traceback" not in said


@pytest.mark.fault("a background in local coordinates, or beyond the map")
@pytest.mark.parametrize("at", [from_origin(0.0, 89.9, 1e-4, 1e-4), from_origin(500.0, 200.0, 1e-4, 1e-4)])
def test_a_picture_beyond_the_map_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str], at: Affine) -> None:
    path = geotiff(tmp_path / "pole.tif", crs="EPSG:4326", at=at)
    assert main(["make-background", str(path), "--out", str(tmp_path / "tiles")]) == 2
    assert "Traceback" not in capsys.readouterr().err


def banded(path: Path, order: list[int], interpretation: list[str], names: list[str]) -> Path:
    """Write the picture's bands in an order (0 red, 1 green, 2 blue, 3 near infrared, 4 opacity)."""
    bands = np.concatenate([pixels(3), np.full((1, HEIGHT, WIDTH), 7, np.uint8), pixels(4)[3:]])
    geotiff(path, bands[order], photometric="MINISBLACK")
    with rasterio.open(path, "r+") as file:
        if interpretation:
            file.colorinterp = [getattr(rasterio.enums.ColorInterp, each) for each in interpretation]
        for number, name in enumerate(names, start=1):
            file.set_band_description(number, name)
    return path


@pytest.mark.slow
@pytest.mark.fault(
    "a background whose bands are in another order, or unnamed",
    "red, green and blue by their names; unnamed: refused with a remedy",
)
@pytest.mark.parametrize(
    ("order", "interpretation", "names"),
    [
        ([2, 1, 0], ["blue", "green", "red"], []),
        ([2, 1, 0, 3], ["blue", "green", "red", "undefined"], []),
        ([3, 0, 1, 2], ["gray", "red", "green", "blue"], []),
        ([2, 1, 0, 3], [], ["Blue", "Green", "Red", "NIR"]),
        ([4, 0, 1, 2], ["alpha", "red", "green", "blue"], []),
        ([0, 1, 2, 3, 4], ["red", "green", "blue", "undefined", "alpha"], []),
    ],
)
def test_the_order_of_the_bands_is_read(
    tmp_path: Path, order: list[int], interpretation: list[str], names: list[str]
) -> None:
    path = banded(tmp_path / "bands.tif", order, interpretation, names)
    with open_picture(path) as picture, open_picture(geotiff(tmp_path / "plain.tif")) as plain:
        tiles = list(tiles_of(plain.bounds, zooms_for(plain.bounds, plain.metres_per_pixel)))
        assert tiles
        for tile in tiles[:6]:
            found, expected = picture.read(tile), plain.read(tile)
            assert (found is None) == (expected is None)
            if found is not None and expected is not None:
                solid = (found[..., 3] == 255) & (expected[..., 3] == 255)
                off = np.abs(found[solid].astype(int) - expected[solid]).max(axis=1)
                assert np.mean(off > 2) < 0.04  # along the edges between colours


@pytest.mark.fault("a background whose bands are in another order, or unnamed")
def test_bands_that_nobody_names_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = banded(tmp_path / "bands.tif", [2, 1, 0, 3], [], [])
    assert main(["make-background", str(path), "--out", str(tmp_path / "tiles")]) == 2
    said = capsys.readouterr().err
    assert "does not say which of its bands are red, green and blue" in said
    assert "gdal_translate -b RED" in said
