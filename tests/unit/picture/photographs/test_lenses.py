from __future__ import annotations

import math
from pathlib import Path

import pytest

from hawk.model.pictures import CameraModel
from hawk.picture.photographs.exif import Exif
from hawk.picture.photographs.lenses import LensError, Lenses, scaled
from hawk.picture.values import PictureError

DJI = {
    "drone-dji:CalibratedFocalLength": "3666.666504",
    "drone-dji:CalibratedOpticalCenterX": "2736.000000",
    "drone-dji:CalibratedOpticalCenterY": "1824.000000",
}
DEWARP = "2018-09-04;3678.87,3671.84,10.1,27.29,-0.268652,0.114663,0.0000152688,-0.0000460707,-0.0350261"
SKYDIO = {
    "drone-skydio:CalibratedFocalLength/drone-skydio:X": "2376.5625",
    "drone-skydio:CalibratedFocalLength/drone-skydio:Y": "2376.5625",
    "drone-skydio:CalibratedOpticalCenter/drone-skydio:X": "2027.5",
    "drone-skydio:CalibratedOpticalCenter/drone-skydio:Y": "1519.5",
    "drone-skydio:DewarpData": "0.13000, -0.24000, 0.10400",
}
PIX4D = {
    "Camera:RigName": "Sequoia",
    "Camera:PerspectiveFocalLength": "4.812073",
    "Camera:PrincipalPoint": "3.042001,2.280612",
    "Camera:PerspectiveDistortion": "0.178,-0.474,0.402,-0.0009,-0.00065",
}
ENTRY = '[[lens]]\nmodel = "FC9999"\nsensor_width_mm = 10.0\n'


def _table(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def test_dji_s_calibrated_focal_length_is_pixels() -> None:
    camera, is_known = Lenses().of(DJI, Exif(), (5472, 3648))
    assert is_known
    assert (camera.fx, camera.cx, camera.cy) == pytest.approx((3666.6665, 2735.5, 1823.5))
    assert camera.distortion == ()


def test_dji_s_dewarp_data_has_the_distortion_and_the_centre_s_offset() -> None:
    camera, _ = Lenses().of({**DJI, "drone-dji:DewarpData": DEWARP, "drone-dji:DewarpFlag": "0"}, Exif(), (5472, 3648))
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == pytest.approx((3678.87, 3671.84, 2745.6, 1850.79))
    assert camera.distortion == pytest.approx((-0.268652, 0.114663, 1.52688e-5, -4.60707e-5, -0.0350261))


def test_a_picture_that_the_camera_straightened_has_no_distortion() -> None:
    camera, _ = Lenses().of({**DJI, "drone-dji:DewarpData": DEWARP, "drone-dji:DewarpFlag": "1"}, Exif(), (5472, 3648))
    assert camera.fx == pytest.approx(3678.87)
    assert camera.distortion == ()


def test_a_picture_at_half_its_size_has_half_the_focal_length() -> None:
    camera, _ = Lenses().of(DJI, Exif(), (2736, 1824))
    assert (camera.fx, camera.cx) == pytest.approx((1833.333, 1367.5), abs=1e-3)


def test_a_picture_of_another_shape_is_not_of_that_calibration() -> None:
    camera, is_known = Lenses().of(DJI, Exif(model="FC6310", focal_mm=8.8), (5472, 3078))
    assert is_known
    assert camera.fx == pytest.approx(8.8 / 13.13 * 5472)


def test_skydio_s_lens_is_read_with_its_radial_distortion() -> None:
    camera, is_known = Lenses().of(SKYDIO, Exif(), (4056, 3040))
    assert is_known
    assert (camera.fx, camera.cx, camera.cy) == pytest.approx((2376.5625, 2027.5, 1519.5))
    assert camera.distortion == pytest.approx((0.13, -0.24, 0.0, 0.0, 0.104))


@pytest.mark.parametrize("exif", [Exif(), Exif(sensor_mm=6.17472)], ids=["by the table", "by the focal plane"])
def test_pix4d_s_millimetres_are_turned_into_pixels(exif: Exif) -> None:
    tags = PIX4D if exif.sensor_mm is None else {**PIX4D, "Camera:RigName": "another"}
    camera, _ = Lenses().of(tags, exif, (4608, 3456))
    per_mm = 4608 / 6.17472
    assert (camera.fx, camera.cx) == pytest.approx((4.812073 * per_mm, 3.042001 * per_mm - 0.5))
    assert camera.distortion == pytest.approx((0.178, -0.474, -0.0009, -0.00065, 0.402))


@pytest.mark.parametrize(
    ("model", "focal_mm", "width", "height", "wide_deg"),
    [
        ("FC300S", 3.61, 4000, 3000, 81.3), ("FC330", 3.61, 4000, 3000, 81.3), ("FC6310", 8.8, 5472, 3648, 73.4),
        ("fc220", 4.73, 4000, 3000, 66.5), ("FC3170", 4.5, 8000, 6000, 70.8), ("FC3411", 8.38, 5472, 3648, 76.2),
        ("FC7303", 4.49, 4000, 3000, 69.2), ("L1D-20c", 10.26, 5472, 3648, 65.2), ("M3E", 12.29, 5280, 3956, 70.7),
        ("XT705", 10.57, 5472, 3648, 63.7), ("Anafi", 4.0, 5344, 4016, 73.6), ("2", 3.7, 4056, 3040, 80.9),
        ("ILCE-6000", 16.0, 6000, 4000, 72.6), ("DSC-RX1RM2", 35.0, 7952, 5304, 54.3),
    ],
)  # fmt: skip
def test_common_drones_are_as_wide_as_their_makers_say(
    model: str, focal_mm: float, width: int, height: int, wide_deg: float
) -> None:
    exif = Exif(make="Skydio" if model == "2" else "any", model=model, focal_mm=focal_mm)
    camera, is_known = Lenses().of({}, exif, (width, height))
    assert is_known
    assert math.degrees(2 * math.atan(width / 2 / camera.fx)) == pytest.approx(wide_deg, abs=0.2)


@pytest.mark.parametrize("size", [(5472, 3648), (3648, 5472), (4864, 3648), (5472, 3078), (3648, 3648)])
@pytest.mark.parametrize("tags", [{}, DJI], ids=["table", "calibrated"])
def test_a_turned_or_cut_picture_has_its_camera_s_focal_length(tags: dict[str, str], size: tuple[int, int]) -> None:
    camera, is_known = Lenses().of(tags, Exif(make="DJI", model="FC6310", focal_mm=8.8), size)
    assert is_known
    assert (camera.width, camera.height) == size
    assert camera.fx == pytest.approx(3667.0, abs=1.0)


@pytest.mark.parametrize(
    ("size", "focal", "is_known"),
    [((4000, 3000), 3016, False), ((1824, 2736), 1833.7, True), ((1600, 1200), 1206.4, False)],
)
def test_a_part_of_a_sensor_whose_pixels_are_not_its_own_is_a_guess(
    size: tuple[int, int], focal: float, is_known: bool
) -> None:
    exif = Exif(make="DJI", model="FC6310", focal_mm=8.8)
    camera, found = Lenses().of({}, exif, size)
    assert found is is_known
    assert camera.fx == pytest.approx(focal, abs=1.0)


def test_a_sensor_of_the_focal_plane_is_known_where_the_table_guesses() -> None:
    exif = Exif(make="DJI", model="FC6310", focal_mm=8.8, sensor_mm=9.6)
    camera, is_known = Lenses().of({}, exif, (3000, 4000))
    assert is_known
    assert camera.fx == pytest.approx(8.8 / 9.6 * 4000)


def test_a_person_s_table_without_the_sensor_s_pixels_is_believed_for_every_shape(tmp_path: Path) -> None:
    lenses = Lenses(_table(tmp_path / "own.toml", ENTRY))
    exif = Exif(model="FC9999", focal_mm=5.0)
    found = [lenses.of({}, exif, size) for size in ((4000, 3000), (3000, 4000), (4000, 2250))]
    assert [(camera.fx, is_known) for camera, is_known in found] == [(2000.0, True)] * 3
    with_pixels = Lenses(_table(tmp_path / "own.toml", ENTRY + "sensor_pixels = [4000, 3000]\n"))
    assert [with_pixels.of({}, exif, size)[1] for size in ((4000, 2250), (2000, 1125))] == [True, False]


def test_a_turned_calibration_keeps_what_both_turns_have_alike() -> None:
    tags = {**DJI, "drone-dji:DewarpData": DEWARP, "drone-dji:DewarpFlag": "0"}
    camera, is_known = Lenses().of(tags, Exif(), (3648, 5472))
    assert is_known
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == pytest.approx((3671.84, 3678.87, 1823.5, 2735.5))
    assert camera.distortion == pytest.approx((-0.268652, 0.114663, 0.0, 0.0, -0.0350261))


def test_digital_zoom_lengthens_the_lens() -> None:
    plain, zoomed = (
        Lenses().of({}, Exif(model="FC3170", focal_mm=4.5, zoom=zoom), (4000, 3000))[0] for zoom in (1.0, 2.0)
    )
    assert zoomed.fx == pytest.approx(2 * plain.fx)


def test_the_focal_length_on_film_is_a_guess_by_the_diagonal() -> None:
    camera, is_known = Lenses().of({}, Exif(model="new", focal_35_mm=24.0), (4000, 3000))
    assert not is_known
    assert camera.fx == pytest.approx(24.0 * 5000 / math.hypot(36, 24))
    cut, _ = Lenses().of({}, Exif(model="new", focal_35_mm=24.0), (4000, 2250))
    assert cut.fx == pytest.approx(camera.fx)
    turned, _ = Lenses().of({}, Exif(model="new", focal_35_mm=24.0), (2250, 4000))
    assert turned.fx == pytest.approx(camera.fx)


def test_a_person_s_table_goes_before_every_tag(tmp_path: Path) -> None:
    path = _table(tmp_path / "own.toml", ENTRY + 'focal_mm = 5.0\ndistortion = [0.1, 0, 0, 0, 0]\nsource = "mine"\n')
    camera, is_known = Lenses(path).of(DJI, Exif(make="DJI", model="FC9999"), (5472, 3648))
    assert is_known
    assert camera.fx == pytest.approx(2736.0)
    assert camera.distortion == (0.1, 0.0, 0.0, 0.0, 0.0)


def test_without_any_focal_length_the_remedy_is_said() -> None:
    with pytest.raises(LensError, match=r"no focal length.*DJI FC9999.*--lenses FILE.*--calibration"):
        Lenses().of({}, Exif(make="DJI", model="FC9999"), (4000, 3000))
    with pytest.raises(LensError, match="fisheye"):
        Lenses().of({"Camera:ModelType": "fisheye"}, Exif(model="Bebop"), (4000, 3000))


def test_a_length_that_no_lens_has_is_passed_over() -> None:
    tags = {**DJI, "drone-dji:CalibratedFocalLength": "8.8"}  # millimetres, as some files have it
    camera, is_known = Lenses().of(tags, Exif(focal_35_mm=24.0), (5472, 3648))
    assert not is_known
    assert camera.fx == pytest.approx(3648, rel=0.01)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("[[lens]\n", "is no TOML"),
        ('[[lens]]\nmodel = "X"\n', r"lens\.0\.sensor_width_mm"),
        ('[[lens]]\nmodel = "X"\nsensor_width_mm = -1\n', r"lens\.0\.sensor_width_mm"),
        (ENTRY + "focal = 3\n", r"lens\.0\.focal"),
        (ENTRY + "distortion = [1, 2]\n", r"lens\.0\.distortion"),
        (ENTRY + "sensor_pixels = [0, 2]\n", r"lens\.0\.sensor_pixels"),
        ("", "lens"),
    ],
)
def test_a_wrong_table_names_its_field(tmp_path: Path, text: str, named: str) -> None:
    with pytest.raises(PictureError, match=rf"own\.toml.*{named}.*docs/photographs\.md"):
        Lenses(_table(tmp_path / "own.toml", text))


def test_a_table_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(PictureError, match=r"none\.toml cannot be read"):
        Lenses(tmp_path / "none.toml")


def test_a_lens_is_scaled_about_the_picture_s_corner() -> None:
    camera = CameraModel(400, 300, 300.0, 310.0, 199.5, 149.5, (0.1,))
    half = scaled(camera, (200, 150))
    assert half == CameraModel(200, 150, 150.0, 155.0, 99.5, 74.5, (0.1,))
    assert scaled(camera, (300, 300)) is None
