from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pymap3d
import pyproj
import pytest
import rasterio
from rasterio.transform import from_origin

from hawk.exports.values import ExportRecord, Observation
from hawk.model.plans import Outline
from hawk.picture.files import stalls_in_system
from hawk.picture.reconstruction.camera_pose import CameraPose
from hawk.picture.values import PictureError, PictureSurvey
from hawk.picture.webodm import is_project, orthophoto, read_project, system_of
from tests.unit.picture.photographs.photos import DJI, exif, photo, xmp
from tests.unit.picture.surveys import mapped

SIZE = (4000, 3000)
UTM = "EPSG:32615"
CENTRE = (46.8424, -91.9937)
GROUND = 172.0
LENS = {
    "projection_type": "brown", "width": 4000, "height": 3000, "focal_x": 0.72, "focal_y": 0.721, "c_x": 0.004,
    "c_y": -0.003, "k1": -0.02, "k2": 0.01, "p1": 0.0005, "p2": -0.0004, "k3": 0.001,
}  # fmt: skip


def _pose(k: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a camera's place in UTM, and the rotation (3) of near straight down, as OpenSfM has it."""
    east, north = pyproj.Transformer.from_crs("EPSG:4326", UTM, always_xy=True).transform(CENTRE[1], CENTRE[0])
    rng = np.random.default_rng(k)
    place = np.array([east + 30.0 * k, north + 18.0 * (k % 2), GROUND + 60.0 + k])
    yaw, roll, pitch = 0.7 * k, *rng.uniform(-0.08, 0.08, 2)
    level = np.array([[math.cos(yaw), -math.sin(yaw), 0.0], [-math.sin(yaw), -math.cos(yaw), 0.0], [0.0, 0.0, -1.0]])
    sway = cv2.Rodrigues(np.array([roll, pitch, 0.0]))[0]
    return place, cv2.Rodrigues(sway @ level)[0].ravel()


def _feature(k: int, **changes: Any) -> dict[str, Any]:
    place, turn = _pose(k)
    back = pyproj.Transformer.from_crs(UTM, "EPSG:4326", always_xy=True)
    longitude, latitude = back.transform(place[0], place[1])
    properties = {
        "filename": f"DJI_{k:04d}.JPG", "focal": 0.72, "width": SIZE[0], "height": SIZE[1],
        "translation": place.tolist(), "rotation": turn.tolist(), **changes,
    }  # fmt: skip
    point = {"type": "Point", "coordinates": [longitude, latitude, float(place[2])]}
    return {"type": "Feature", "properties": properties, "geometry": point}


def _project(folder: Path, count: int = 4, lens: dict[str, Any] | None = None, **changes: Any) -> Path:
    for name in ("odm_report", "opensfm", "images", "odm_orthophoto", "odm_dem"):
        (folder / name).mkdir(parents=True)
    features = [_feature(k, **changes) for k in range(count)]
    text = json.dumps({"type": "FeatureCollection", "features": features})
    (folder / "odm_report" / "shots.geojson").write_text(text, encoding="utf-8")
    name = "v2 dji fc6310 4000 3000 brown 0.6"
    (folder / "cameras.json").write_text(json.dumps({name: LENS if lens is None else lens}), encoding="utf-8")
    for k in range(count):
        photo(folder / "images" / f"DJI_{k:04d}.JPG", exif(), xmp(DJI))
    return folder


def _raster(path: Path, value: float, crs: str = UTM) -> None:
    place, _ = _pose(0)
    values = np.full((1, 60, 60), value, np.float32)
    with rasterio.open(
        path, "w", driver="GTiff", width=60, height=60, count=1, dtype="float32", crs=crs,
        transform=from_origin(place[0] - 150.0, place[1] + 150.0, 5.0, 5.0), nodata=-9999.0,
    ) as raster:  # fmt: skip
        raster.write(values)


def _as_opensfm_draws(point: np.ndarray, k: int) -> np.ndarray:
    """Return the pixel of a point of UTM by OpenSfM's own formulas (https://opensfm.org/docs/geometry.html)."""
    place, turn = _pose(k)
    x, y, z = cv2.Rodrigues(turn)[0] @ (point - place)
    x, y = x / z, y / z
    square = x * x + y * y
    radial = 1 + LENS["k1"] * square + LENS["k2"] * square**2 + LENS["k3"] * square**3
    p1, p2 = float(LENS["p1"]), float(LENS["p2"])  # type: ignore[arg-type]
    bent_x = x * radial + 2 * p1 * x * y + p2 * (square + 2 * x * x)
    bent_y = y * radial + p1 * (square + 2 * y * y) + 2 * p2 * x * y
    u = LENS["focal_x"] * bent_x + LENS["c_x"]
    v = LENS["focal_y"] * bent_y + LENS["c_y"]
    return np.array([u * SIZE[0] + (SIZE[0] - 1) / 2, v * SIZE[0] + (SIZE[1] - 1) / 2])


def test_poses_and_lens_draw_the_ground_where_opensfm_does(tmp_path: Path) -> None:
    folder = _project(tmp_path / "task")
    _raster(folder / "odm_dem" / "dtm.tif", GROUND)
    found = read_project(folder)
    assert [shot.name for shot in found.shots] == [f"DJI_{k:04d}.JPG" for k in range(4)]
    back = pyproj.Transformer.from_crs(UTM, "EPSG:4326", always_xy=True)
    for k, shot in enumerate(found.shots):
        assert shot.height == pytest.approx(60.0 + k, abs=0.02)
        place, _ = _pose(k)
        posed = CameraPose(shot.camera, 0.0, 0.0, shot.height or 0.0, shot.attitude or (0, 0, 0))
        for across, along in ((-20.0, 10.0), (5.0, -12.0), (18.0, 14.0)):
            point = np.array([place[0] + across, place[1] + along, GROUND])
            longitude, latitude = back.transform(point[0], point[1])
            east, north, _ = pymap3d.geodetic2enu(latitude, longitude, 0.0, shot.latitude, shot.longitude, 0.0)
            shown = posed.pixels(np.array([[north, east]]))[0]
            assert shown == pytest.approx(_as_opensfm_draws(point, k), abs=1.5)  # a scale of UTM of 0.9997


def test_a_project_is_known_by_its_folders(tmp_path: Path) -> None:
    folder = _project(tmp_path / "task")
    assert is_project(folder)
    assert orthophoto(folder) is None
    _raster(folder / "odm_orthophoto" / "odm_orthophoto.tif", 1.0)
    assert orthophoto(folder) == folder / "odm_orthophoto" / "odm_orthophoto.tif"
    assert not is_project(folder / "images")
    assert not is_project(tmp_path / "none")
    (tmp_path / "photographs" / "opensfm").mkdir(parents=True)
    assert not is_project(tmp_path / "photographs")


def test_without_an_elevation_model_the_photographs_tags_give_the_height(tmp_path: Path) -> None:
    folder = _project(tmp_path / "task")
    assert [shot.height for shot in read_project(folder).shots] == [60.0] * 4
    assert not any(shot.sigma_is_said for shot in read_project(folder).shots), "it is of one place against the others"
    for image in (folder / "images").iterdir():
        photo(image, exif())
    assert [shot.height for shot in read_project(folder).shots] == [None] * 4, "the pictures say what would fit"
    assert np.median([shot.height for shot in read_project(folder, height_m=40.0).shots]) == pytest.approx(40.0)


def test_photographs_without_a_pose_or_a_file_and_those_askew_are_named(tmp_path: Path) -> None:
    folder = _project(tmp_path / "task")
    photo(folder / "images" / "DJI_0099.JPG", exif(), xmp(DJI))
    (folder / "images" / "DJI_0003.JPG").unlink()
    text = (folder / "odm_report" / "shots.geojson").read_text(encoding="utf-8")
    found = json.loads(text)
    found["features"][2]["properties"]["rotation"] = [math.pi / 2, 0.0, 0.0]
    (folder / "odm_report" / "shots.geojson").write_text(json.dumps(found), encoding="utf-8")
    project = read_project(folder)
    assert [shot.name for shot in project.shots] == ["DJI_0000.JPG", "DJI_0001.JPG"]
    reasons = {each.name: each.reason for each in project.left_out}
    assert "no pose for it" in reasons["DJI_0099.JPG"]
    assert "is not in images/" in reasons["DJI_0003.JPG"]
    assert "90 degrees off straight down" in reasons["DJI_0002.JPG"]


def test_one_focal_length_is_enough_for_a_lens(tmp_path: Path) -> None:
    plain = {"projection_type": "perspective", "width": 4000, "height": 3000, "focal": 0.7, "k1": 0.01, "k2": 0.0}
    camera = read_project(_project(tmp_path / "a", lens=plain)).shots[0].camera
    assert (camera.fx, camera.fy, camera.cx) == (2800.0, 2800.0, 1999.5)
    folder = _project(tmp_path / "b")
    (folder / "cameras.json").unlink()
    assert read_project(folder).shots[0].camera.fx == pytest.approx(2880.0)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("odm_report/shots.geojson", "{", r"shots\.geojson: is no JSON"),
        (
            "odm_report/shots.geojson",
            '{"features": [{"properties": {}}]}',
            r"features\.0\.properties\.filename: is missing",
        ),
        ("odm_report/shots.geojson", '{"features": []}', "none of its photographs can be used: no photograph is in it"),
        ("cameras.json", "[1]", "is no table of cameras"),
        ("cameras.json", '{"a": {}}', "projection_type: is missing"),
    ],
)
def test_a_damaged_project_names_the_file_and_the_field(tmp_path: Path, name: str, text: str, words: str) -> None:
    folder = _project(tmp_path / "task")
    (folder / name).write_text(text, encoding="utf-8")
    with pytest.raises(PictureError, match=words):
        read_project(folder)


def test_a_project_without_poses_or_with_a_fisheye_is_refused(tmp_path: Path) -> None:
    folder = _project(tmp_path / "a")
    (folder / "odm_report" / "shots.geojson").unlink()
    with pytest.raises(PictureError, match=r"shots\.geojson cannot be read"):
        read_project(folder)
    with pytest.raises(PictureError, match="of the kind fisheye, which is no pinhole; map the orthophoto"):
        read_project(_project(tmp_path / "b", lens={**LENS, "projection_type": "fisheye"}))


def _survey() -> PictureSurvey:
    corners = ((46.8424, -91.9937), (46.8424, -91.99367), (46.84245, -91.99367), (46.84245, -91.9937))
    stall = Observation(
        "a1", "1", "", "free", 0.02, 1.7e9, 3, (46.84242, -91.99368), corners, 2.5, 5.0, 10.0, True
    )  # fmt: skip
    survey = ExportRecord(
        "lot", "l", "s", 1.7e9, 1.7e9, True, None, "hawk", False, 1.0, False, CENTRE, Outline(), (stall,)
    )  # fmt: skip
    return PictureSurvey(survey, mapped().landed, None, 100.0)


@pytest.mark.parametrize("crs", ["", UTM, "EPSG:2277"])
def test_stalls_lie_in_the_orthophotos_system_as_gdal_reads_them(tmp_path: Path, crs: str) -> None:
    path = tmp_path / "stalls.geojson"
    path.write_bytes(stalls_in_system(replace(_survey(), crs=crs or "OGC:CRS84")))
    pyogrio = pytest.importorskip("pyogrio")
    info = pyogrio.read_info(path)
    assert pyproj.CRS.from_user_input(info["crs"]).equals(pyproj.CRS.from_user_input(crs or "OGC:CRS84"))
    ring = np.array(json.loads(path.read_text(encoding="utf-8"))["features"][0]["geometry"]["coordinates"][0])
    back = pyproj.Transformer.from_crs(crs or "OGC:CRS84", "EPSG:4326", always_xy=True)
    longitude, latitude = back.transform(ring[0, 0], ring[0, 1])
    assert (latitude, longitude) == pytest.approx((46.8424, -91.9937), abs=2e-8)


def test_the_system_is_that_of_the_orthophoto_else_of_the_project(tmp_path: Path) -> None:
    folder = _project(tmp_path / "task")
    assert system_of(folder) == ""
    (folder / "odm_georeferencing").mkdir()
    proj = "+proj=utm +zone=15 +datum=WGS84 +units=m +no_defs"
    (folder / "odm_georeferencing" / "proj.txt").write_text(proj + "\n", encoding="utf-8")
    assert system_of(folder) == proj
    _raster(folder / "odm_orthophoto" / "odm_orthophoto.tif", 1.0)
    assert system_of(folder) == UTM
    (folder / "odm_orthophoto" / "odm_orthophoto.tif").write_bytes(b"no picture")
    with pytest.raises(PictureError, match=r"odm_orthophoto\.tif cannot be read"):
        system_of(folder)
