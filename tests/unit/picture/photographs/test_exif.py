from __future__ import annotations

import contextlib
import sys
from datetime import UTC, datetime
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from PIL.TiffImagePlugin import IFDRational

from hawk.picture.photographs.exif import Exif, read_exif
from hawk.picture.values import PictureError
from tests.examples import examples
from tests.unit.picture.photographs.photos import exif

NOON = datetime(2024, 5, 1, 12, tzinfo=UTC).timestamp()


def _read(found: Image.Exif, longer: int = 4000) -> Exif:
    return read_exif(found.tobytes().removeprefix(b"Exif\x00\x00"), longer)


@pytest.mark.slow
@settings(max_examples=examples(60), deadline=None)
@given(latitude=st.floats(-89.0, 89.0), longitude=st.floats(-179.0, 179.0), altitude=st.floats(-400.0, 5000.0))
def test_the_place_is_read_in_each_quarter_of_the_earth(latitude: float, longitude: float, altitude: float) -> None:
    found = _read(exif((latitude, longitude), altitude))
    assert (found.latitude, found.longitude) == pytest.approx((latitude, longitude), abs=1e-8)
    assert found.altitude == pytest.approx(altitude, abs=1e-4)


@pytest.mark.parametrize(
    "gps",
    [{9: "V"}, {2: None}, {2: (95.0, 0.0, 0.0)}, {2: (IFDRational(0, 0), 1.0, 1.0)}],
    ids=["no fix", "no latitude", "beyond the pole", "no number"],
)
def test_a_place_that_is_none_is_left_out(gps: dict[int, Any]) -> None:
    assert _read(exif(gps=gps)).latitude is None


@pytest.mark.parametrize(
    ("photo", "gps", "clock", "gnss"),
    [
        ({0x9003: "2024:05:01 12:00:00"}, {}, NOON, None),
        ({0x9003: "2024:05:01 14:00:00", 0x9011: "+02:00", 0x9291: "250"}, {}, NOON + 0.25, None),
        ({0x9003: "2024:05:01 14:00:00", 0x9011: "   :  "}, {}, NOON + 7200, None),
        ({0x9003: "0000:00:00 00:00:00"}, {}, None, None),
        ({0x9003: None}, {7: (12.0, 0.0, 33.853), 29: "2024:05:01"}, None, NOON + 33.853),
        ({}, {7: (12.0, 0.0, 1.0)}, NOON - 7200, None),
    ],
)
def test_the_moment_is_by_the_camera_s_clock_and_by_gnss(
    photo: dict[int, Any], gps: dict[int, Any], clock: float | None, gnss: float | None
) -> None:
    found = _read(exif(photo=photo, gps=gps))
    assert found.clock == (None if clock is None else pytest.approx(clock))
    assert found.gnss == (None if gnss is None else pytest.approx(gnss))


def test_camera_and_lens_are_read() -> None:
    photo = {0x920A: 4.88, 0xA405: 28, 0xA404: 2.0, 0xA20E: 746.2687, 0xA210: 4, 0xA002: 4608}
    found = _read(exif(make="Parrot\x00\x00", model="Sequoia", base={274: 6}, photo=photo))
    assert (found.make, found.model, found.orientation) == ("Parrot", "Sequoia", 6)
    assert (found.focal_mm, found.focal_35_mm, found.zoom) == pytest.approx((4.88, 28.0, 2.0))
    assert found.sensor_mm == pytest.approx(6.1747, abs=1e-3)


def test_the_focal_plane_of_a_turned_picture_gives_the_longer_side() -> None:
    plane = {0xA20E: 100.0, 0xA210: 4}
    assert _read(exif(photo={**plane, 0xA002: 1000, 0xA003: 1500})).sensor_mm == 15.0
    assert _read(exif(photo=plane), 1500).sensor_mm == 15.0


def test_a_focal_plane_that_no_sensor_has_is_not_believed() -> None:
    assert _read(exif(photo={0xA20E: 72.0, 0xA210: 2})).sensor_mm is None


@pytest.mark.parametrize(
    ("base", "saved_by"),
    [
        ({306: "2024:05:01 10:00:03", 305: "v01.23"}, ""),
        ({306: "2024:05:01 12:31:00", 305: "Windows Photo Viewer"}, "Windows Photo Viewer"),
        ({306: "2024:05:02 10:00:00"}, "another program"),
    ],
)
def test_a_file_that_was_saved_later_names_the_program(base: dict[int, Any], saved_by: str) -> None:
    assert _read(exif(base=base)).saved_by == saved_by


@settings(max_examples=examples(80), deadline=None)
@given(
    data=st.binary(max_size=80), start=st.sampled_from([b"", b"II*\x00\x08\x00\x00\x00", b"MM\x00*\x00\x00\x00\x08"])
)
def test_any_bytes_are_facts_or_a_refusal(data: bytes, start: bytes) -> None:
    with contextlib.suppress(ValueError):
        assert isinstance(read_exif(start + data, 100), Exif)


def test_without_pillow_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "PIL", None)
    with pytest.raises(PictureError, match=r"Pillow is not installed.*\[pictures\]"):
        read_exif(b"II*\x00", 100)
