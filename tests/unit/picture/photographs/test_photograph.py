from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.model.pictures import CameraModel
from hawk.picture.photographs.lenses import Lenses
from hawk.picture.photographs.photograph import UnusableError, read_photograph
from tests.unit.jpegs import jpeg
from tests.unit.picture.photographs.photos import DJI, exif, photo, xmp

LENSES = Lenses()


def test_a_dji_photograph_is_a_shot(tmp_path: Path) -> None:
    tags = {**DJI, "drone-dji:RtkStdLon": "0.02", "drone-dji:RtkStdLat": "0.03", "drone-dji:RtkStdHgt": "0.05"}
    found = read_photograph(photo(tmp_path / "a.jpg", exif((-33.9, 18.4), 160.0), xmp(tags)), LENSES)
    shot = found.shot
    assert (shot.latitude, shot.longitude) == pytest.approx((-33.9, 18.4), abs=1e-8)
    assert (shot.altitude, shot.height, shot.model) == (160.0, 60.0, "DJI FC330")
    assert shot.attitude == pytest.approx((0.0, 0.0, np.radians(30.0)), abs=1e-9)
    assert shot.sigma == (0.03, 0.05)
    assert shot.sigma_is_said
    assert (shot.lens_is_known, shot.yaw_is_sure) == (True, True)


def test_a_sony_has_a_place_and_a_lens_and_no_attitude(tmp_path: Path) -> None:
    sony = exif(make="SONY", model="DSC-RX1RM2", photo={0x920A: 35.0}, gps={31: 4.5})
    shot = read_photograph(photo(tmp_path / "a.jpg", sony, size=(160, 106)), LENSES).shot
    assert (shot.attitude, shot.height) == (None, None)
    assert shot.camera.fx == pytest.approx(35.0 / 35.9 * 160)
    assert (shot.sigma, shot.sigma_is_said) == ((4.5, 3.0), True)


def test_a_place_whose_precision_the_file_does_not_say_is_of_a_common_receiver(tmp_path: Path) -> None:
    shot = read_photograph(photo(tmp_path / "a.jpg", exif(), xmp(DJI)), LENSES).shot
    assert (shot.sigma, shot.sigma_is_said) == ((2.0, 3.0), False)


def test_a_turned_photograph_has_the_sensor_of_its_longer_side(tmp_path: Path) -> None:
    tags = {0x920A: 10.0, 0xA20E: 10.0, 0xA210: 4}
    found = exif(model="new", photo=tags)
    shot = read_photograph(photo(tmp_path / "a.jpg", found, xmp(DJI), (60, 90)), LENSES).shot
    assert shot.lens_is_known
    assert shot.camera.fx == pytest.approx(100.0)


def test_an_autel_of_older_firmware_is_read_by_pix4d_s_tags(tmp_path: Path) -> None:
    found = exif(make="Autel Robotics", model="XT705", photo={0x920A: 10.57})
    packet = xmp({"Camera:Pitch": "1.5", "Camera:Yaw": "200", "Camera:Roll": "0"})
    shot = read_photograph(photo(tmp_path / "a.jpg", found, packet), LENSES).shot
    assert shot.attitude == pytest.approx((0.0, np.radians(1.5), np.radians(-160.0)))


def test_a_place_that_only_xmp_has_is_taken(tmp_path: Path) -> None:
    tags = {**DJI, "drone-dji:GpsLatitude": "46.8", "drone-dji:GpsLongtitude": "-91.9"}
    shot = read_photograph(photo(tmp_path / "a.jpg", exif(None), xmp(tags)), LENSES).shot
    assert (shot.latitude, shot.longitude, shot.altitude) == (46.8, -91.9, 160.0)


@pytest.mark.parametrize("found", [exif(None), exif((0.0, 0.0)), exif(gps={9: "V"}), None])
def test_a_photograph_without_a_place_is_refused(tmp_path: Path, found: Any) -> None:
    with pytest.raises(UnusableError, match="has no GPS place; use the drone's own files"):
        read_photograph(photo(tmp_path / "a.jpg", found, xmp(DJI)), LENSES)


@settings(max_examples=30, deadline=None)
@given(pitch=st.floats(-120.0, -40.0), yaw=st.floats(-180.0, 180.0))
def test_a_camera_more_than_25_degrees_off_is_refused(
    tmp_path_factory: pytest.TempPathFactory, pitch: float, yaw: float
) -> None:
    tags = {**DJI, "drone-dji:GimbalPitchDegree": f"{pitch:.2f}", "drone-dji:GimbalYawDegree": f"{yaw:.2f}"}
    path = photo(tmp_path_factory.getbasetemp() / "off.jpg", exif(), xmp(tags))
    tilt = abs(round(pitch, 2) + 90.0)
    if tilt > 25.01:
        with pytest.raises(UnusableError, match=rf"looks {tilt:.0f} degrees off straight down"):
            read_photograph(path, LENSES)
    elif tilt < 24.99:
        assert read_photograph(path, LENSES).shot.attitude is not None


def test_a_calibration_goes_before_the_tags_and_is_scaled(tmp_path: Path) -> None:
    path = photo(tmp_path / "a.jpg", exif(), xmp(DJI))
    calibration = CameraModel(160, 120, 130.0, 130.0, 79.5, 59.5, (0.1,), mount_pitch=0.2)
    shot = read_photograph(path, LENSES, calibration).shot
    assert shot.camera == CameraModel(80, 60, 65.0, 65.0, 39.5, 29.5, (0.1,))
    with pytest.raises(UnusableError, match=r"is 80 x 60 pixels, its calibration 160 x 90"):
        read_photograph(path, LENSES, CameraModel(160, 90, 130.0, 130.0, 79.5, 44.5))


def test_a_camera_that_nothing_describes_is_refused_with_the_remedy(tmp_path: Path) -> None:
    path = photo(tmp_path / "a.jpg", exif(model="FC9999"), xmp(DJI))
    with pytest.raises(UnusableError, match=r"no focal length.*--lenses FILE"):
        read_photograph(path, LENSES)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"no picture", "is no JPEG"),
        (jpeg()[:-50], "is torn: its end is missing"),
        (b"\xff\xd8\xff\xe1\x00\x10Exif", "is torn within its head"),
    ],
)
def test_a_damaged_file_is_refused_with_the_remedy(tmp_path: Path, data: bytes, words: str) -> None:
    (tmp_path / "a.jpg").write_bytes(data)
    with pytest.raises(UnusableError, match=f"{words}; copy it again from the camera's card"):
        read_photograph(tmp_path / "a.jpg", LENSES)


def test_xmp_that_is_no_xml_is_refused(tmp_path: Path) -> None:
    path = photo(tmp_path / "a.jpg", exif(), xmp(DJI).replace(b"</rdf:RDF>", b""))
    with pytest.raises(UnusableError, match="its XMP cannot be read"):
        read_photograph(path, LENSES)


@pytest.mark.parametrize(("latitude", "longitude"), [("95", "5"), ("-91", "5"), ("52", "181"), ("52", "-180.5")])
def test_a_place_beyond_the_earth_is_none(tmp_path: Path, latitude: str, longitude: str) -> None:
    tags = {**DJI, "drone-dji:GpsLatitude": latitude, "drone-dji:GpsLongtitude": longitude}
    with pytest.raises(UnusableError, match="has no GPS place"):
        read_photograph(photo(tmp_path / "a.jpg", exif(None), xmp(tags)), LENSES)
