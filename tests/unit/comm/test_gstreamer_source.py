from __future__ import annotations

import asyncio
import shutil
from contextlib import aclosing

import pytest

from hawk.comm.camera_sources.gstreamer import GStreamerSource
from hawk.comm.camera_sources.source import CameraError, SourceFrame
from hawk.comm.image import jpeg_size
from tests.manual_clock import ManualClock

TEST_PICTURE = "videotestsrc is-live=true ! video/x-raw,width=320,height=240,framerate=30/1"

needs_gstreamer = pytest.mark.skipif(
    shutil.which("gst-launch-1.0") is None, reason="needs the Debian package gstreamer1.0-tools"
)


async def first(source: GStreamerSource, count: int) -> list[SourceFrame]:
    found = []
    async with asyncio.timeout(20), aclosing(source.frames()) as frames:
        async for frame in frames:
            found.append(frame)
            if len(found) == count:
                break
    return found


@needs_gstreamer
async def test_any_pipeline_gives_pictures() -> None:
    source = GStreamerSource(TEST_PICTURE, ManualClock(4.0))
    found = await first(source, 3)
    assert [jpeg_size(frame.jpeg) for frame in found] == [(320, 240)] * 3
    assert [frame.arrival for frame in found] == [4.0] * 3
    assert source.torn == 0
    await source.close()


@needs_gstreamer
async def test_a_pipeline_that_ends_says_so() -> None:
    with pytest.raises(CameraError, match="the pipeline ended"):
        await first(GStreamerSource("videotestsrc num-buffers=2 ! video/x-raw,width=32,height=32", ManualClock()), 9)


@needs_gstreamer
async def test_an_element_that_is_not_there_names_the_packages() -> None:
    with pytest.raises(CameraError, match=r'no element "nosuchsource".*gstreamer1.0-plugins-good'):
        await first(GStreamerSource("nosuchsource ! videoconvert", ManualClock()), 1)


@needs_gstreamer
async def test_nothing_is_run_by_a_shell() -> None:
    with pytest.raises(CameraError):
        await first(GStreamerSource("videotestsrc num-buffers=1 ; touch /nowhere/file", ManualClock()), 99)


async def test_without_gstreamer_the_package_is_named() -> None:
    source = GStreamerSource(TEST_PICTURE, ManualClock(), program="no-gst-launch")
    with pytest.raises(CameraError, match=r"needs no-gst-launch, which is not installed: .*gstreamer1.0-tools"):
        await first(source, 1)


@needs_gstreamer
@pytest.mark.parametrize("pipeline", ["", "  ", 'videotestsrc pattern="open'])
async def test_a_pipeline_that_is_none_is_an_error(pipeline: str) -> None:
    with pytest.raises(CameraError, match="gst:"):
        await first(GStreamerSource(pipeline, ManualClock()), 1)
