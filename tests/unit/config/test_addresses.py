from __future__ import annotations

from pathlib import Path

import pytest

from hawk.config.addresses import rpicam_camera, v4l2_camera
from hawk.config.loader import load_config
from hawk.config.sections import CameraSettings, ConfigError


def test_a_csi_camera_has_a_number_and_options() -> None:
    assert rpicam_camera("rpicam:").number == 0
    camera = rpicam_camera("rpicam:1?width=1456&height=1088&lens-position=0.2&tuning-file=/etc/my.json")
    assert (camera.number, camera.width, camera.height, camera.lens_position) == (1, 1456, 1088, 0.2)
    assert camera.tuning_file == Path("/etc/my.json")
    assert rpicam_camera("rpicam:?framerate=10").framerate == 10


def test_a_v4l2_camera_has_a_device_and_options() -> None:
    assert v4l2_camera("v4l2:///dev/video0").device == Path("/dev/video0")
    camera = v4l2_camera("v4l2:///dev/v4l/by-id/usb-A%20B-index0?width=1280&height=720&format=YUYV&framerate=15")
    assert camera.device == Path("/dev/v4l/by-id/usb-A B-index0")
    assert (camera.width, camera.height, camera.format, camera.framerate) == (1280, 720, "YUYV", 15)


@pytest.mark.parametrize(
    ("url", "words"),
    [
        ("rpicam:0?witdh=1456", "has no option 'witdh'; there are width, height, framerate, shutter"),
        ("rpicam:0?number=1", "has no option 'number'"),
        ("rpicam:front", "number: Input should be a valid integer"),
        ("rpicam:0?width=1456", "name width and height, or neither"),
        ("rpicam:0?shutter=fast", "shutter: Input should be a valid integer"),
        ("rpicam:0?rotation=90", "rotation: Input should be '0' or '180'"),
        ("rpicam:0?awb=--timeout", "awb: String should match"),
        ("v4l2:///dev/video0?size=3", "has no option 'size'; there are width, height, framerate, format"),
        ("v4l2:///dev/video0?device=/dev/video1", "has no option 'device'"),
        ("v4l2:///dev/video0?format=mjpeg", "format: String should match"),
        ("v4l2://dev/video0", "three slashes"),
    ],
)
def test_an_option_that_is_none_is_an_error_before_anything_starts(url: str, words: str) -> None:
    with pytest.raises(ConfigError, match=r"camera\.url") as caught:
        load_config(None, {"HAWK_CAMERA__URL": url})
    assert words in str(caught.value)


@pytest.mark.parametrize(
    "url", ["gst:videotestsrc is-live=true ! videoconvert", "rtsp://cam/?number=1", "http://cam/?a=b"]
)
def test_queries_of_other_kinds_are_their_own(url: str) -> None:
    assert CameraSettings(url=url).url.get_secret_value() == url
