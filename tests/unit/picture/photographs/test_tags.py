from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.model.pictures import CAMERA_TO_BODY, rotation
from hawk.picture.photographs import tags
from hawk.picture.photographs.photograph import tilt_deg
from hawk.picture.photographs.xmp import read_xmp
from tests.unit.picture.photographs.photos import xmp

DEGREES = st.floats(-180.0, 180.0)
SMALL = st.floats(-20.0, 20.0)


def _gimbal(names: str, roll: float, pitch: float, yaw: float) -> dict[str, str]:
    return {names.format(name): f"{value:+.4f}" for name, value in (("Roll", roll), ("Pitch", pitch), ("Yaw", yaw))}


FORWARD = [
    "drone-dji:Gimbal{}Degree",
    "drone:Gimbal{}Degree",
    "drone-parrot:Camera{}Degree",
    "drone-skydio:CameraOrientationNED/drone-skydio:{}",
]


@pytest.mark.parametrize("names", FORWARD)
@given(yaw=DEGREES)
def test_a_gimbal_at_minus_90_looks_straight_down_with_its_yaw(names: str, yaw: float) -> None:
    attitude = tags.attitude(_gimbal(names, 0.0, -90.0, yaw), "any")
    assert attitude is not None
    assert attitude[:2] == pytest.approx((0.0, 0.0), abs=1e-6)
    assert math.cos(attitude[2] - math.radians(yaw)) == pytest.approx(1.0, abs=1e-9)


@given(roll=SMALL, pitch=SMALL, yaw=DEGREES)
def test_forward_angles_turn_the_axis_and_the_top_of_the_picture_as_a_gimbal_does(
    roll: float, pitch: float, yaw: float
) -> None:
    """The camera's own frame: x ahead along its axis, y to the picture's right, z to its foot."""
    turned = rotation(math.radians(roll), math.radians(pitch - 90.0), math.radians(yaw))
    attitude = tags.attitude(_gimbal(FORWARD[0], roll, pitch - 90.0, yaw), "DJI")
    assert attitude is not None
    right, foot, axis = (rotation(*attitude) @ CAMERA_TO_BODY).T
    assert np.column_stack([axis, right, foot]) == pytest.approx(turned, abs=2e-6)


@given(yaw=DEGREES)
def test_a_camera_tipped_past_straight_down_writes_a_roll_of_180_and_its_top_is_turned(yaw: float) -> None:
    """Mavic 3 Enterprise and H30T: roll 180, pitch -90 is straight down with the yaw half a turn on."""
    attitude = tags.attitude(_gimbal(FORWARD[0], 180.0, -90.0, yaw), "DJI")
    assert attitude is not None
    assert tilt_deg(attitude) == pytest.approx(0.0, abs=1e-3)
    assert math.cos(attitude[2] - math.radians(yaw) - math.pi) == pytest.approx(1.0, abs=1e-9)


@given(roll=SMALL, pitch=SMALL, yaw=DEGREES)
def test_pix4d_angles_are_from_straight_down_and_the_make_sensefly_rolls_the_other_direction(
    roll: float, pitch: float, yaw: float
) -> None:
    found = _gimbal("Camera:{}", roll, pitch, yaw)
    parrot, sensefly = tags.attitude(found, "Parrot"), tags.attitude(found, "senseFly")
    assert parrot is not None
    assert sensefly is not None
    assert parrot[:2] == pytest.approx((math.radians(roll), math.radians(pitch)), abs=1e-5)
    assert sensefly == pytest.approx((-parrot[0], *parrot[1:]))
    assert abs(parrot[2]) <= math.pi


def test_a_makers_own_angles_go_before_those_of_pix4d() -> None:
    found = _gimbal("Camera:{}", 0.0, 0.0, 10.0) | _gimbal(FORWARD[2], 0.0, -70.0, 20.0)
    attitude = tags.attitude(found, "Parrot")
    assert attitude is not None
    assert (tilt_deg(attitude), math.degrees(attitude[2])) == pytest.approx((20.0, 20.0), abs=1e-3)


def test_a_file_without_angles_or_with_half_of_them_says_none() -> None:
    assert tags.attitude({}, "Sony") is None
    assert tags.attitude({"drone-dji:GimbalPitchDegree": "-90.0"}, "DJI") is None
    assert tags.attitude({"drone-dji:GimbalPitchDegree": "-90.0", "drone-dji:GimbalYawDegree": "nan"}, "DJI") is None


@pytest.mark.parametrize(
    ("found", "height"),
    [
        ({"drone-dji:RelativeAltitude": "+39.90"}, 39.9),
        ({"drone:RelativeAltitude": "-2.5"}, -2.5),
        ({"drone-skydio:RelativeAltitude": "61.2"}, 61.2),
        ({"Camera:AboveGroundAltitude": "11485529/262144"}, 43.813816),
        ({"drone-dji:RelativeAltitude": "high"}, None),
        ({"Camera:AboveGroundAltitude": "1/0"}, None),
    ],
)
def test_each_maker_says_the_height_in_its_own_tag(found: dict[str, str], height: float | None) -> None:
    assert tags.height(found) == (None if height is None else pytest.approx(height))


@pytest.mark.parametrize(
    ("found", "sigma"),
    [
        (
            {"drone-dji:RtkStdLon": "0.012", "drone-dji:RtkStdLat": "0.015", "drone-dji:RtkStdHgt": "0.03"},
            (0.015, 0.03),
        ),
        (
            {"drone-dji:RtkStdLon": "0.001", "drone-dji:RtkStdLat": "0.002", "drone-dji:RtkStdHgt": "0.004"},
            (0.01, 0.01),
        ),
        ({"drone-dji:RtkStdLon": "0", "drone-dji:RtkStdLat": "0"}, (None, None)),
        ({"Camera:GPSXYAccuracy": "2.138", "Camera:GPSZAccuracy": "3.362"}, (2.138, 3.362)),
        ({"drone-skydio:GpsHorizontalAccuracy": "0.9", "drone-skydio:GpsVerticalAccuracy": "1.4"}, (0.9, 1.4)),
    ],
)
def test_the_precision_of_a_place_is_that_of_rtk_or_of_the_receiver(
    found: dict[str, str], sigma: tuple[float | None, float | None]
) -> None:
    assert tags.sigma(found) == sigma


def test_the_place_is_read_under_each_spelling() -> None:
    dji = {"drone-dji:GpsLatitude": "46.8", "drone-dji:GpsLongtitude": "-91.9"}
    autel = {"drone:GpsLatitude": "46.8", "drone:GpsLongtitude": "-91.9"}
    skydio = {"drone-skydio:Latitude": "46.8", "drone-skydio:Longitude": "-91.9"}
    assert tags.place(dji) == tags.place(autel) == tags.place(skydio) == (46.8, -91.9)
    assert tags.place({"drone-dji:GpsLatitude": "46.8"}) is None


def test_skydio_s_structure_is_read_as_elements() -> None:
    ned = "".join(f"<drone-skydio:{n}>{v}</drone-skydio:{n}>" for n, v in (("Roll", 0), ("Pitch", -84), ("Yaw", 146.5)))
    inner = (
        f'<drone-skydio:CameraOrientationNED rdf:parseType="Resource">{ned}</drone-skydio:CameraOrientationNED>'
        '<drone-skydio:CameraOrientationFLU drone-skydio:Roll="9" drone-skydio:Pitch="9" drone-skydio:Yaw="9"/>'
    )
    attitude = tags.attitude(read_xmp(xmp({}, inner)), "Skydio")
    assert attitude is not None
    assert [math.degrees(angle) for angle in attitude] == pytest.approx([0.0, 6.0, 146.5])
