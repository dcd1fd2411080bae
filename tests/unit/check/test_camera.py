from __future__ import annotations

from pathlib import Path

import pytest

from hawk.check.camera import CameraSight, CameraTimes, look_at_camera, remedy
from hawk.check.result import Outcome
from hawk.comm.clock import Clock
from hawk.config.sections import CameraSettings
from tests.unit.check.fakes import Pictures
from tests.unit.comm.cameras.pictures import picture

TIMES = CameraTimes(first_s=0.5, counted_s=0.5)
SETTINGS = CameraSettings(url="v4l2:///dev/video7")


async def look(source: Pictures, settings: CameraSettings = SETTINGS) -> CameraSight:
    sight = await look_at_camera(settings, source.clock, lambda _settings, _clock: source, TIMES)
    assert source.closed
    return sight


@pytest.mark.nightly
async def test_pictures_pass_with_size_rate_and_age() -> None:
    jpeg = picture()
    sight = await look(Pictures(jpeg, Clock()))
    (found,) = sight.results
    assert found.outcome is Outcome.PASSED
    assert found.value.startswith("64 x 48, ")
    assert sight.picture_bytes_s is not None
    assert sight.picture_bytes_s / len(jpeg) > 3  # pictures a second


@pytest.mark.slow
async def test_no_picture_fails_with_the_source_s_own_words() -> None:
    sight = await look(Pictures(None, Clock()))
    (found,) = sight.results
    assert found.outcome is Outcome.FAILED
    assert "/dev/video7: there is no such device" in found.value
    assert found.remedy
    assert sight.picture_bytes_s is None


@pytest.mark.nightly
async def test_one_picture_and_then_none_fails() -> None:
    (found,) = (await look(Pictures(picture(), Clock(), count=1))).results
    assert found.outcome is Outcome.FAILED
    assert "stopped" in found.value


@pytest.mark.slow
async def test_a_slow_camera_is_a_warning() -> None:
    (found,) = (await look(Pictures(picture(), Clock(), pause_s=0.4))).results
    assert found.outcome is Outcome.WARNING


@pytest.mark.nightly
async def test_a_picture_that_cannot_be_decoded_fails() -> None:
    jpeg = picture()
    broken = jpeg[: jpeg.index(b"\xff\xda") + 2] + b"\xff\xd9"  # the scan is empty
    (found,) = (await look(Pictures(broken, Clock()))).results
    assert found.outcome is Outcome.FAILED


async def test_a_calibration_that_cannot_be_read_fails(tmp_path: Path) -> None:
    settings = CameraSettings(url="v4l2:///dev/video7", calibration=tmp_path / "none.yaml")
    source = Pictures(picture(), Clock())
    sight = await look_at_camera(settings, source.clock, lambda _settings, _clock: source, TIMES)
    assert sight.results[0].outcome is Outcome.FAILED
    assert "calibration" in sight.results[0].remedy


@pytest.mark.parametrize(
    ("url", "words"),
    [
        ("v4l2:///dev/video97", "Plug the camera in"),
        ("v4l2:///dev/null?width=640&height=480", "fuser /dev/null."),
        ("rpicam:0?width=1456&height=1088", "rpicam-hello --list-cameras"),
        ("http://127.0.0.1:8090/stream", "ustreamer"),
        ("rtsp://user:secret-word@10.0.0.2/live", "another player"),
        ("gst:v4l2src ! videoconvert", "gst-launch-1.0"),
        ("file:///none.avi", "film"),
    ],
)
def test_the_remedy_fits_the_kind_of_camera(url: str, words: str) -> None:
    said = remedy(CameraSettings(url=url))
    assert words in said
    assert "secret-word" not in said
