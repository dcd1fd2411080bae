from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML

from hawk.comm.cameras.calibration import load_calibration
from hawk.config.sections import CameraSettings, ConfigError

INFO: dict[str, Any] = {
    "image_width": 1280,
    "image_height": 720,
    "camera_name": "hawk",
    "camera_matrix": {"rows": 3, "cols": 3, "data": [914.0, 0.0, 640.5, 0.0, 915.0, 359.5, 0.0, 0.0, 1.0]},
    "distortion_model": "plumb_bob",
    "distortion_coefficients": {"rows": 1, "cols": 5, "data": [-0.1, 0.01, 0.001, -0.002, 0.0]},
    "rectification_matrix": {"rows": 3, "cols": 3, "data": [1, 0, 0, 0, 1, 0, 0, 0, 1]},
    "projection_matrix": {"rows": 3, "cols": 4, "data": [914, 0, 640, 0, 0, 915, 360, 0, 0, 0, 1, 0]},
}


def written(path: Path, **changes: Any) -> CameraSettings:
    """Write the calibration with some keys changed (None: left out) and return settings that name it."""
    content = {key: value for key, value in (INFO | changes).items() if value is not None}
    with path.open("w") as file:
        YAML(typ="safe", pure=True).dump(content, file)
    return CameraSettings(calibration=path)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "camera.yaml"


def test_a_field_of_view_is_good_for_every_size() -> None:
    calibration = load_calibration(CameraSettings(horizontal_fov_deg=70.0))
    for width, height in ((1280, 720), (640, 480)):
        model = calibration.for_size(width, height)
        assert 2 * math.atan(width / 2 / model.fx) == pytest.approx(math.radians(70.0))
        assert (model.fx, model.cx, model.cy) == pytest.approx((model.fy, width / 2, height / 2))
        assert model.distortion == ()
        assert calibration.misfit(width, height) == ""


def test_mount_angles_are_radians_in_the_model() -> None:
    settings = CameraSettings(mount_roll_deg=1.0, mount_pitch_deg=-2.0, mount_yaw_deg=90.0)
    model = load_calibration(settings).for_size(640, 480)
    found = (model.mount_roll, model.mount_pitch, model.mount_yaw)
    assert found == pytest.approx((math.radians(1.0), math.radians(-2.0), math.pi / 2))


def test_a_calibration_file_is_read_as_ros_writes_it(file: Path) -> None:
    model = load_calibration(written(file)).for_size(1280, 720)
    assert (model.fx, model.fy, model.cx, model.cy) == pytest.approx((914.0, 915.0, 640.5, 359.5))
    assert model.distortion == (-0.1, 0.01, 0.001, -0.002, 0.0)


def test_pictures_of_another_size_scale_it(file: Path) -> None:
    model = load_calibration(written(file)).for_size(640, 360)
    assert (model.fx, model.fy) == pytest.approx((457.0, 457.5))
    assert (model.cx + 0.5, model.cy + 0.5) == pytest.approx((641.0 / 2, 360.0 / 2))


def test_pictures_of_another_shape_do_not_fit_it(file: Path) -> None:
    calibration = load_calibration(written(file))
    assert calibration.misfit(640, 360) == ""
    assert "640 x 480" in calibration.misfit(640, 480)
    assert "1280 x 720" in calibration.misfit(640, 480)


def test_the_rational_model_is_taken_where_it_is_plumb_bob(file: Path) -> None:
    coefficients = {"rows": 1, "cols": 8, "data": [0.1, 0.2, 0.0, 0.0, 0.3, 0.0, 0.0, 0.0]}
    settings = written(file, distortion_model="rational_polynomial", distortion_coefficients=coefficients)
    assert load_calibration(settings).for_size(1280, 720).distortion == (0.1, 0.2, 0.0, 0.0, 0.3)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"image_width": None}, "image_width: is missing: write it"),
        ({"image_height": 0}, "image_height: must be more than 0"),
        ({"camera_matrix": None}, "camera_matrix: is missing: write it"),
        ({"camera_matrix": {"rows": 3, "cols": 3, "data": [1.0]}}, "camera_matrix: data has 1 numbers, must have"),
        ({"camera_matrix": {"rows": 1, "cols": 2, "data": [1.0, 2.0]}}, "camera_matrix must be 3 x 3"),
        ({"camera_matrix": {"rows": 3, "cols": 3, "data": [0.0] * 9}}, "focal lengths"),
        ({"camera_matrix": {"rows": 3, "cols": 3, "data": [9.0, 0, 9e9, 0, 9.0, 5, 0, 0, 1]}}, "principal point"),
        ({"camera_matrix": {"rows": 3, "cols": 3, "data": ["x"] * 9}}, "camera_matrix.data.0"),
        ({"camera_matrix": {"rows": 3, "cols": 3, "data": [math.nan] * 9}}, "camera_matrix.data.0"),
        ({"distortion_model": "fisheye"}, "distortion_model 'fisheye' is not known: use one of plumb_bob"),
        ({"distortion_coefficients": {"rows": 1, "cols": 6, "data": [0.0] * 6}}, "plumb_bob has at most 5"),
        (
            {
                "distortion_model": "rational_polynomial",
                "distortion_coefficients": {"rows": 1, "cols": 8, "data": [0.1] * 8},
            },
            "k4 to k6 are not supported",
        ),
    ],
)
def test_a_wrong_file_names_itself_and_the_key(file: Path, changes: dict[str, Any], words: str) -> None:
    with pytest.raises(ConfigError) as caught:
        load_calibration(written(file, **changes))
    assert words in str(caught.value)
    assert str(file) in str(caught.value)
    assert "camera.calibration" in str(caught.value)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"a: [1, 2", "is not YAML"),
        (b"m: !!opencv-matrix\n  rows: 3", "is not YAML"),
        (b"- 1\n- 2\n", "has no keys"),
        (b"", "has no keys"),
        (b"\xff\xfe\x00", "cannot be read"),
    ],
)
def test_what_is_no_camera_info_says_what_it_is(file: Path, content: bytes, words: str) -> None:
    file.write_bytes(content)
    with pytest.raises(ConfigError, match=words):
        load_calibration(CameraSettings(calibration=file))


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"none.yaml cannot be read"):
        load_calibration(CameraSettings(calibration=tmp_path / "none.yaml"))


def test_tags_that_make_objects_are_not_followed(file: Path) -> None:
    file.write_text("!!python/object/apply:os.system ['true']")
    with pytest.raises(ConfigError):
        load_calibration(CameraSettings(calibration=file))
