from __future__ import annotations

import io
import re
import sys
from datetime import UTC, datetime, timedelta, timezone

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from hawk.picture.photographs.exif import read_exif
from hawk.sim.photos_tags import CAMERAS, TagsError, Written, tagged
from tests.unit.jpegs import jpeg

NOON = datetime(2026, 5, 4, 12, 30, 15, tzinfo=timezone(timedelta(hours=-5)))


def _written(
    latitude: float = 43.26, longitude: float = -79.92, altitude: float = 160.0, yaw: float = 181.5
) -> Written:
    return Written(CAMERAS["FC6310"], (320, 240), 214.4, NOON, latitude, longitude, altitude, 60.0, yaw)


def test_the_picture_stays_and_any_program_reads_it() -> None:
    plain = jpeg()
    with Image.open(io.BytesIO(tagged(plain, _written()))) as image:
        image.load()
        assert image.size == (320, 240)
        assert image.getexif()[272] == "FC6310"
        with Image.open(io.BytesIO(plain)) as before:
            assert image.tobytes() == before.tobytes()


def test_xmp_is_written_as_dji_does() -> None:
    text = tagged(jpeg(), _written()).decode("latin-1")
    tags = dict(re.findall(r'drone-dji:(\w+)="([^"]*)"', text))
    assert 'rdf:about="DJI Meta Data"' in text
    assert tags["RelativeAltitude"] == "+60.00"
    assert tags["AbsoluteAltitude"] == "+160.00"
    assert tags["GimbalYawDegree"] == "-178.50"
    assert tags["GimbalPitchDegree"] == "-90.00"
    assert tags["CalibratedFocalLength"] == "214.400000"


@pytest.mark.slow
@settings(max_examples=50, deadline=None)
@given(latitude=st.floats(-89.99, 89.99), longitude=st.floats(-179.99, 179.99), altitude=st.floats(-400.0, 8000.0))
def test_the_place_is_written_to_three_millimetres(latitude: float, longitude: float, altitude: float) -> None:
    with Image.open(io.BytesIO(tagged(jpeg(), _written(latitude, longitude, altitude)))) as image:
        found = read_exif(image.info["exif"].removeprefix(b"Exif\x00\x00"), 320)
    assert found.latitude == pytest.approx(latitude, abs=1.5e-8)
    assert found.longitude == pytest.approx(longitude, abs=1.5e-8)
    assert found.altitude == pytest.approx(altitude, abs=6e-4)
    assert found.clock == NOON.astimezone(UTC).timestamp()
    assert (found.focal_mm, found.focal_35_mm, found.saved_by) == (8.8, 24.0, "")


def test_without_pillow_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "PIL", None)
    with pytest.raises(TagsError, match=r"Pillow is not installed.*\[pictures\]"):
        tagged(jpeg(), _written())
