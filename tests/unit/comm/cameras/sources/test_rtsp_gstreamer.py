from __future__ import annotations

import asyncio
import time
from pathlib import Path

import pytest

from hawk.comm.cameras.drone_camera import DroneCamera
from hawk.comm.cameras.sources.rtsp import GStreamerSource
from hawk.comm.cameras.sources.source import CameraError, CameraSource
from hawk.comm.clock import Clock
from hawk.config.sections import CameraSettings
from hawk.formats.image import jpeg_size
from tests.manual_clock import ManualClock
from tests.unit.comm.cameras.pictures import picture
from tests.unit.comm.cameras.sources.children import SHORT, program, running
from tests.unit.comm.cameras.sources.sources import first_frames, needs_gstreamer
from tests.unit.comm.waiting import until

TEST_PICTURE = "videotestsrc is-live=true ! video/x-raw,width=320,height=240,framerate=30/1"
JPEG = picture(64, 48, 100)


@needs_gstreamer
async def test_any_pipeline_gives_pictures() -> None:
    source = GStreamerSource(TEST_PICTURE, ManualClock(4.0))
    found = await first_frames(source, 3)
    assert [jpeg_size(frame.jpeg) for frame in found] == [(320, 240)] * 3
    assert [frame.arrival for frame in found] == [4.0] * 3
    assert source.torn == 0
    await source.close()


@pytest.mark.slow
@needs_gstreamer
async def test_a_source_that_is_not_live_is_paced_to_its_own_rate() -> None:
    pipeline = "videotestsrc ! video/x-raw,width=64,height=48,framerate=25/1"
    clock = Clock()
    found = await first_frames(GStreamerSource(pipeline, clock), 25)
    # from the start of the process: 24 periods are 0.96 s, of which 0.2 s may come at once; never less
    assert found[-1].arrival > 0.75


@needs_gstreamer
async def test_a_pipeline_that_ends_says_so() -> None:
    with pytest.raises(CameraError, match="the pipeline ended"):
        await first_frames(
            GStreamerSource("videotestsrc num-buffers=2 ! video/x-raw,width=32,height=32", ManualClock()), 9
        )


@needs_gstreamer
async def test_an_element_that_is_not_there_names_the_packages() -> None:
    with pytest.raises(CameraError, match=r'no element "nosuchsource".*gstreamer1.0-plugins-good'):
        await first_frames(GStreamerSource("nosuchsource ! videoconvert", ManualClock()), 1)


@needs_gstreamer
async def test_gstreamer_s_first_error_is_shown() -> None:
    with pytest.raises(CameraError, match=r"ERROR: from element .*GstFileSrc.*: Resource not found\.$"):
        await first_frames(GStreamerSource("filesrc location=/there/is/none ! jpegdec", ManualClock()), 1)


async def test_the_first_error_wins_over_what_follows(tmp_path: Path) -> None:
    lines = r"""sys.exit("WARNING: from element a: slow\nERROR: from element b: the cause\nAdditional debug info:\n"
        "file.c(1): f (): /b:\nFailed to connect\nERROR: pipeline doesn't want to preroll.")"""
    with pytest.raises(CameraError, match=r"^gst:b: ERROR: from element b: the cause$"):
        await first_frames(GStreamerSource("b", ManualClock(), program(tmp_path, JPEG, lines)), 1)


@needs_gstreamer
async def test_nothing_is_run_by_a_shell() -> None:
    with pytest.raises(CameraError):
        await first_frames(GStreamerSource("videotestsrc num-buffers=1 ; touch /nowhere/file", ManualClock()), 99)


async def test_without_gstreamer_the_package_is_named() -> None:
    source = GStreamerSource(TEST_PICTURE, ManualClock(), program="no-gst-launch")
    with pytest.raises(CameraError, match=r"needs no-gst-launch, which is not installed: .*gstreamer1.0-tools"):
        await first_frames(source, 1)


@needs_gstreamer
@pytest.mark.parametrize("pipeline", ["", "  ", 'videotestsrc pattern="open'])
async def test_a_pipeline_that_is_none_is_an_error(pipeline: str) -> None:
    with pytest.raises(CameraError, match="gst:"):
        await first_frames(GStreamerSource(pipeline, ManualClock()), 1)


async def test_passwords_of_a_pipeline_are_not_shown() -> None:
    source = GStreamerSource("rtspsrc user-pw=word location=rtsp://me:word@cam/", ManualClock(), "no-gst-launch")
    with pytest.raises(CameraError, match="needs no-gst-launch") as caught:
        await first_frames(source, 1)
    assert "word" not in str(caught.value)


@pytest.mark.fault(
    "a camera's program (GStreamer, rpicam-vid) hangs",
    "ended 3 s after its last picture, by SIGKILL 2 s later if it does not end, and started again; nothing of "
    "it is left",
)
@pytest.mark.slow
async def test_a_pipeline_that_hangs_is_killed_and_started_again_and_one_that_fails_is_tried_for_ever(
    tmp_path: Path,
) -> None:
    lines = """
if run == 0:
    picture()
    hang()
if run < 4:
    sys.exit("ERROR: from element src: Device '/dev/video0' is not there")
while True:
    picture()
    time.sleep(0.02)
"""
    clock = Clock()
    made = GStreamerSource("src", clock, program(tmp_path, JPEG, lines), SHORT)

    def make(_settings: CameraSettings, _clock: Clock) -> CameraSource:
        return made

    camera = DroneCamera(CameraSettings(url="gst:src", reconnect_s=0.01), clock, make=make)
    camera.init()
    try:
        async with asyncio.timeout(30):
            await camera.next_frame()
            started = time.monotonic()
            await camera.next_frame()
            assert time.monotonic() - started > 0.3  # the silence was waited for
            assert camera.health.is_healthy
            await until(lambda: camera.latest is not None and camera.latest.sequence > 4)
    finally:
        await camera.close()
    assert (tmp_path / "runs").stat().st_size == 5
    assert running(tmp_path) == []
