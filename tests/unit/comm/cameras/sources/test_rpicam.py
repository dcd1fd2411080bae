from __future__ import annotations

import asyncio
import time
from pathlib import Path

import pytest

from hawk.comm.cameras.drone_camera import DroneCamera
from hawk.comm.cameras.sources.rpicam import RpicamSource, rpicam_arguments
from hawk.comm.cameras.sources.source import CameraError, CameraSource
from hawk.comm.clock import Clock
from hawk.config.addresses import rpicam_camera
from hawk.config.sections import CameraSettings
from tests.manual_clock import ManualClock
from tests.unit.comm.cameras.pictures import picture
from tests.unit.comm.cameras.sources.children import SHORT, program, running
from tests.unit.comm.cameras.sources.sources import first_frames
from tests.unit.comm.waiting import until

JPEG = picture(64, 48, 100)
OLD = "picture(time.clock_gettime_ns(time.CLOCK_MONOTONIC) - 50_000_000)"
"""A picture whose first row was exposed 50 ms ago."""


def source(folder: Path, lines: str, clock: Clock, url: str = "rpicam:") -> RpicamSource:
    return RpicamSource(rpicam_camera(url), clock, program(folder, JPEG, lines, "rpicam"), SHORT)


async def test_pictures_are_stamped_by_the_sensor(tmp_path: Path) -> None:
    clock = Clock()
    lines = "now = time.clock_gettime_ns(time.CLOCK_MONOTONIC)\n"
    lines += "for age in (50, 250): picture(now - age * 1_000_000)\nhang()"
    before = clock()
    first, second = await first_frames(source(tmp_path, lines, clock), 2)
    assert first.jpeg == second.jpeg == JPEG
    assert first.captured is not None
    assert second.captured is not None
    assert before - 0.05 <= first.captured <= first.arrival
    assert first.captured - second.captured == pytest.approx(0.2, abs=0.01)
    stamp = first.stamp or 0.0
    assert first.captured == pytest.approx(clock() - (time.clock_gettime(time.CLOCK_MONOTONIC) - stamp), abs=0.01)
    assert running(tmp_path) == []


async def test_a_picture_without_a_stamp_is_given_without(tmp_path: Path) -> None:
    (frame,) = await first_frames(source(tmp_path, "picture(None)\nhang()", ManualClock(7.0)), 1)
    assert (frame.arrival, frame.stamp, frame.captured) == (7.0, None, None)


@pytest.mark.fault("a picture of a CSI camera is torn", "dropped and counted; the stamps of the others stay theirs")
async def test_a_torn_picture_does_not_shift_the_stamps(tmp_path: Path) -> None:
    lines = "now = time.clock_gettime_ns(time.CLOCK_MONOTONIC)\n"
    lines += r"picture(now - 900_000_000, b'\xff\xd8 torn ')" + "\npicture(now - 100_000_000)\nhang()"
    torn = source(tmp_path, lines, Clock())
    (frame,) = await first_frames(torn, 1)
    assert torn.torn == 1
    assert frame.stamp == pytest.approx(time.clock_gettime(time.CLOCK_MONOTONIC) - 0.1, abs=0.5)


async def test_its_first_error_is_the_message(tmp_path: Path) -> None:
    lines = "sys.exit('[0:00:01.5] [77] ERROR: *** no cameras available ***\\nERROR: later')"
    with pytest.raises(CameraError, match=r"^rpicam:0: ERROR: \*\*\* no cameras available \*\*\*$"):
        await first_frames(source(tmp_path, lines, ManualClock()), 1)


@pytest.mark.slow
async def test_pictures_without_metadata_are_an_error_not_a_wait(tmp_path: Path) -> None:
    lines = "picture(None)\nout.write(jpeg); out.flush()\nhang()"
    with pytest.raises(CameraError, match=r"no picture for 0.3 s"):
        await first_frames(source(tmp_path, lines, ManualClock()), 2)
    assert running(tmp_path) == []


async def test_without_the_program_the_package_is_named() -> None:
    missing = RpicamSource(rpicam_camera("rpicam:"), ManualClock(), "no-rpicam-vid")
    with pytest.raises(CameraError, match=r"rpicam:0: needs no-rpicam-vid, which is not installed: .*rpicam-apps"):
        await first_frames(missing, 1)


@pytest.mark.slow
@pytest.mark.fault("a camera's program (GStreamer, rpicam-vid) hangs")
async def test_a_camera_that_hangs_is_killed_and_started_again_and_one_that_is_unplugged_comes_back(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    lines = f"""
if run == 0:
    {OLD}
    hang()
if run in (1, 2):
    sys.exit("ERROR: *** no cameras available ***")
while True:
    {OLD}
    time.sleep(0.02)
"""
    clock = Clock()
    made = source(tmp_path, lines, clock)

    def make(_settings: CameraSettings, _clock: Clock) -> CameraSource:
        return made

    camera = DroneCamera(CameraSettings(url="rpicam:", reconnect_s=0.01), clock, make=make)
    camera.init()
    try:
        async with asyncio.timeout(30):
            await camera.next_frame()
            await until(lambda: (tmp_path / "runs").stat().st_size == 4, 20)
            frame = await camera.next_frame()
        assert 0.049 < frame.arrived - frame.captured < 2.0  # a busy computer reads late, and the stamp stays
    finally:
        await camera.close()
    assert (tmp_path / "runs").stat().st_size == 4
    assert running(tmp_path) == []
    assert [record.getMessage() for record in caplog.records if record.levelname == "WARNING"] == [
        f"Camera: rpicam:0: no picture for 0.3 s; {tmp_path}/program was ended; trying again",
        "Camera: rpicam:0: ERROR: *** no cameras available ***; trying again",  # once for two attempts
    ]


def test_options_become_arguments_of_rpicam_vid() -> None:
    camera = rpicam_camera(
        "rpicam:1?width=1456&height=1088&framerate=10&shutter=2000&gain=4&lens-position=0.1&rotation=180"
    )
    words = " ".join(rpicam_arguments(camera, "/proc/self/fd/9"))
    for expected in (
        "--camera 1", "--width 1456", "--height 1088", "--framerate 10.0", "--shutter 2000", "--gain 4.0",
        "--lens-position 0.1", "--rotation 180", "--exposure sport", "--codec mjpeg", "--timeout 0", "--output -",
        "--metadata /proc/self/fd/9", "--metadata-format txt", "--flush",
    ):  # fmt: skip
        assert expected in words
    assert "--tuning-file" not in words
