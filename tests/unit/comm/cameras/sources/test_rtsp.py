from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from hawk.comm.cameras.drone_camera import DroneCamera
from hawk.comm.cameras.sources.child import ChildTimeouts
from hawk.comm.cameras.sources.rtsp import RtspSource
from hawk.comm.cameras.sources.source import CameraError
from hawk.comm.clock import Clock
from hawk.config.sections import CameraSettings
from hawk.formats.image import decode, jpeg_size
from tests.manual_clock import ManualClock
from tests.unit.comm.cameras.pictures import picture
from tests.unit.comm.cameras.sources.children import SHORT, program, running
from tests.unit.comm.cameras.sources.rtsp_server import HEIGHT, WIDTH, RtspCamera
from tests.unit.comm.cameras.sources.sources import first_frames, needs_gstreamer
from tests.unit.comm.waiting import until

URL = 'rtsp://me:w"ord@127.0.0.1:1/main.264?channel=1&stream=0'
JPEG = picture(64, 48, 100)


@pytest.mark.slow
async def test_the_address_is_one_word_of_the_pipeline(tmp_path: Path) -> None:
    lines = "open(os.path.join(folder, 'arguments'), 'w').write('|'.join(arguments))\npicture()\nhang()"
    source = RtspSource(URL, ManualClock(4.0), program(tmp_path, JPEG, lines), SHORT)
    (frame,) = await first_frames(source, 1)
    assert (frame.jpeg, frame.arrival, frame.captured) == (JPEG, 4.0, None)
    words = (tmp_path / "arguments").read_text().split("|")
    assert 'location="rtsp://me:w\\"ord@127.0.0.1:1/main.264?channel=1&stream=0"' in words
    assert words.index("rtspsrc") < words.index("decodebin") < words.index("jpegenc") < words.index("fdsink")


@pytest.mark.slow
async def test_a_camera_that_stops_is_ended_each_time_and_comes_back(tmp_path: Path) -> None:
    source = RtspSource(URL, ManualClock(), program(tmp_path, JPEG, "picture()\nhang()"), SHORT)
    for _ in range(2):
        with pytest.raises(CameraError, match=r"^rtsp://\*\*\*@127.0.0.1:1/\*\*\*: no picture for 0.3 s") as caught:
            await first_frames(source, 99)
        assert "ord" not in str(caught.value).replace(str(tmp_path), "")
        assert running(tmp_path) == []
    assert (tmp_path / "runs").stat().st_size == 2


async def test_without_gstreamer_the_packages_are_named() -> None:
    with pytest.raises(CameraError, match=r"needs no-gst-launch, which is not installed: .*gstreamer1.0-libav"):
        await first_frames(RtspSource(URL, ManualClock(), "no-gst-launch"), 1)


async def test_a_decoder_that_is_missing_names_the_packages(tmp_path: Path) -> None:
    lines = "sys.exit('ERROR: from element decodebin0: Your GStreamer installation is missing a plug-in.')"
    with pytest.raises(CameraError, match=r"missing a plug-in\. \(install .*gstreamer1.0-libav\)"):
        await first_frames(RtspSource(URL, ManualClock(), program(tmp_path, JPEG, lines)), 1)


@needs_gstreamer
async def test_a_camera_that_is_not_there_is_gstreamer_s_own_error() -> None:
    with pytest.raises(
        CameraError, match=r"^rtsp://\*\*\*@127.0.0.1:1/\*\*\*: ERROR: from element .*rtspsrc0: Could not"
    ):
        await first_frames(RtspSource(URL, ManualClock()), 1)


@pytest.fixture
async def camera() -> AsyncIterator[RtspCamera]:
    camera = RtspCamera()
    yield camera
    await camera.close()


@needs_gstreamer
async def test_a_real_stream_is_played_with_user_and_query(camera: RtspCamera) -> None:
    port = await camera.start()
    (frame, *_) = await first_frames(RtspSource(f"rtsp://me:w%21rd@127.0.0.1:{port}/live?channel=1", Clock()), 2)
    assert jpeg_size(frame.jpeg) == (WIDTH, HEIGHT)
    assert float(decode(frame.jpeg).mean()) == pytest.approx(camera.grey, abs=4)
    assert f"DESCRIBE rtsp://127.0.0.1:{port}/live?channel=1" in camera.paths


@pytest.mark.slow
@needs_gstreamer
async def test_a_camera_that_falls_silent_or_is_switched_off_comes_back(camera: RtspCamera) -> None:
    port = await camera.start()
    settings = CameraSettings(url=f"rtsp://127.0.0.1:{port}/live", reconnect_s=0.05)
    timeouts = ChildTimeouts(first_s=20.0, silence_s=1.0, end_s=1.0)
    received = DroneCamera(
        settings,
        Clock(),
        make=lambda settings, clock: RtspSource(settings.url.get_secret_value(), clock, timeouts=timeouts),
    )
    received.init()
    try:
        async with asyncio.timeout(60):
            await received.next_frame()
            camera.is_silent = True
            await until(lambda: sum(path.startswith("PLAY") for path in camera.paths) == 2, 30)
            camera.is_silent = False
            await received.next_frame()
            await camera.close()  # switched off
            await until(lambda: "Could not" in received.health.reason, 30)
            await camera.start(port)
            before = received.latest
            await until(lambda: received.latest is not before, 30)
    finally:
        await received.close()
