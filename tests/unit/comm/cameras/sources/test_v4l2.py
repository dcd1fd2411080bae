from __future__ import annotations

import asyncio
import errno
import struct
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from hawk.comm.cameras.drone_camera import CameraFrame, DroneCamera
from hawk.comm.cameras.sources.source import CameraError, CameraSource, SourceFrame
from hawk.comm.cameras.sources.v4l2 import SizeRange, V4l2Format, V4l2Source, choose_format, read_formats
from hawk.comm.clock import Clock
from hawk.config.addresses import V4l2Camera
from hawk.config.sections import CameraSettings
from hawk.formats.image import decode
from tests.manual_clock import ManualClock
from tests.unit.comm.cameras.pictures import picture
from tests.unit.comm.cameras.sources.sources import first_frames
from tests.unit.comm.waiting import until

JPEG = picture(64, 48, 100)


def size(width: int, height: int) -> SizeRange:
    return SizeRange((width, width, 1), (height, height, 1))


WEBCAM = [
    V4l2Format("YUYV", (size(640, 480),)),
    V4l2Format("MJPG", (size(640, 480), size(1280, 720))),
]


class Webcam:
    """A USB camera as OpenCV shows it, on a device that is a file: remove it, and the camera is unplugged."""

    def __init__(self, device: Path, formats: Sequence[V4l2Format] = WEBCAM) -> None:
        self.device, self.formats = device, formats
        self.opened = 0
        self.released = 0
        self.is_silent = False
        self.is_busy = False
        self.hangs = threading.Event()
        self.hangs.set()
        self.age_s = 0.05
        self.data: Any = np.frombuffer(JPEG + b"\0" * 500, np.uint8)[None, :]
        self.values: dict[int, float] = {}
        self.device.touch()

    def source(self, clock: Clock, silence_s: float = 0.1, **options: Any) -> V4l2Source:
        camera = V4l2Camera(device=self.device, **options)
        return V4l2Source(camera, clock, self._open, lambda _: self.formats, silence_s)

    def _open(self, device: Path) -> Webcam:
        assert device == self.device
        self.opened += 1
        self.values = {cv2.CAP_PROP_FRAME_WIDTH: 640, cv2.CAP_PROP_FRAME_HEIGHT: 480}
        return self

    def isOpened(self) -> bool:  # noqa: N802
        return not self.is_busy

    def set(self, propId: int, value: float) -> bool:  # noqa: N803
        self.values[propId] = value
        return True

    def get(self, propId: int) -> float:  # noqa: N803
        if propId == cv2.CAP_PROP_POS_MSEC:
            return (time.clock_gettime(time.CLOCK_MONOTONIC) - self.age_s) * 1000
        return self.values[propId]

    def read(self) -> tuple[bool, Any]:
        self.hangs.wait()
        if self.is_silent or not self.device.exists():
            return False, None
        time.sleep(0.002)
        return True, self.data

    def release(self) -> None:
        self.released += 1


async def take(source: V4l2Source, count: int) -> list[SourceFrame]:
    try:
        return await first_frames(source, count)
    finally:
        await source.close()


def camera_threads() -> list[str]:
    return [thread.name for thread in threading.enumerate() if thread.name == "camera-source"]


async def test_the_camera_s_own_jpeg_is_passed_on_with_the_kernel_s_stamp(tmp_path: Path) -> None:
    webcam = Webcam(tmp_path / "video0")
    clock = ManualClock(20.0)
    (frame,) = await take(webcam.source(clock), 1)
    assert frame.jpeg == JPEG
    assert frame.arrival == 20.0
    assert frame.captured == pytest.approx(20.0 - 0.05, abs=0.001)
    assert webcam.values[cv2.CAP_PROP_FOURCC] == cv2.VideoWriter.fourcc(*"MJPG")
    assert webcam.values[cv2.CAP_PROP_CONVERT_RGB] == 0
    assert webcam.released == webcam.opened == 1
    assert camera_threads() == []


async def test_a_stamp_of_no_known_clock_is_left_to_be_estimated(tmp_path: Path) -> None:
    webcam = Webcam(tmp_path / "video0")
    webcam.age_s = time.clock_gettime(time.CLOCK_MONOTONIC) / 2  # this clock begins at the machine's start
    (frame,) = await take(webcam.source(ManualClock(20.0)), 1)
    assert frame.captured is None
    assert frame.stamp == pytest.approx(time.clock_gettime(time.CLOCK_MONOTONIC) - webcam.age_s, abs=5)


async def test_pictures_of_a_camera_without_jpeg_are_encoded(tmp_path: Path) -> None:
    webcam = Webcam(tmp_path / "video0", WEBCAM[:1])
    webcam.data = np.full((48, 64, 3), 200, np.uint8)
    (frame,) = await take(webcam.source(ManualClock()), 1)
    assert abs(float(decode(frame.jpeg).mean()) - 200) < 3
    assert webcam.values[cv2.CAP_PROP_FOURCC] == cv2.VideoWriter.fourcc(*"YUYV")
    assert cv2.CAP_PROP_CONVERT_RGB not in webcam.values


@pytest.mark.fault("any number of bytes follows a JPEG's end")
async def test_the_rest_of_a_longer_picture_in_the_buffer_is_no_part_of_it(tmp_path: Path) -> None:
    webcam = Webcam(tmp_path / "video0")
    webcam.data = np.frombuffer(JPEG + JPEG[-50:], np.uint8)
    (frame,) = await take(webcam.source(ManualClock(20.0)), 1)
    assert frame.jpeg == JPEG


async def test_a_torn_picture_is_dropped_and_counted(tmp_path: Path) -> None:
    webcam = Webcam(tmp_path / "video0")
    webcam.data = np.frombuffer(JPEG[:-40], np.uint8)[None, :]
    source = webcam.source(ManualClock())
    waiting = asyncio.create_task(take(source, 1))
    await until(lambda: source.torn > 0)
    webcam.data = np.frombuffer(JPEG, np.uint8)[None, :]
    assert (await waiting)[0].jpeg == JPEG


async def test_size_and_rate_are_asked_for(tmp_path: Path) -> None:
    webcam = Webcam(tmp_path / "video0")
    await take(webcam.source(ManualClock(), width=1280, height=720, framerate=15), 1)
    wanted = {cv2.CAP_PROP_FRAME_WIDTH: 1280, cv2.CAP_PROP_FRAME_HEIGHT: 720, cv2.CAP_PROP_FPS: 15}
    assert wanted.items() <= webcam.values.items()


async def test_a_size_that_the_camera_does_not_have_names_those_that_it_has(tmp_path: Path) -> None:
    webcam = Webcam(tmp_path / "video0")
    with pytest.raises(CameraError, match=r"no 1920 x 1080; it has YUYV 640 x 480; MJPG 640 x 480, 1280 x 720$"):
        await take(webcam.source(ManualClock(), width=1920, height=1080), 1)
    with pytest.raises(CameraError, match=r"no YUYV 1280 x 720; it has YUYV 640 x 480; MJPG"):
        await take(webcam.source(ManualClock(), width=1280, height=720, format="YUYV"), 1)
    assert webcam.opened == 0


async def test_a_driver_that_gives_another_size_is_an_error(tmp_path: Path) -> None:
    class Stubborn(Webcam):
        def set(self, propId: int, value: float) -> bool:  # noqa: N803
            return False

    webcam = Stubborn(tmp_path / "video0", [V4l2Format("MJPG", ())])
    with pytest.raises(CameraError, match="gives 640 x 480, not 1280 x 720"):
        await take(webcam.source(ManualClock(), width=1280, height=720), 1)
    assert webcam.released == 1


async def test_a_device_that_another_program_uses_is_an_error(tmp_path: Path) -> None:
    webcam = Webcam(tmp_path / "video0")
    webcam.is_busy = True
    with pytest.raises(CameraError, match=r"cannot be opened; does another program use it\? fuser .*video0"):
        await take(webcam.source(ManualClock()), 1)


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (PermissionError(errno.EACCES, "no"), "join the group video"),
        (OSError(errno.ENODEV, "No such device"), "No such"),
    ],
)
async def test_a_device_that_may_not_be_opened_is_an_error(tmp_path: Path, error: OSError, words: str) -> None:
    def formats(_: Path) -> list[V4l2Format]:
        raise error

    device = Webcam(tmp_path / "video0").device
    with pytest.raises(CameraError, match=words):
        await take(V4l2Source(V4l2Camera(device=device), ManualClock(), formats=formats), 1)


async def test_a_silent_camera_is_an_error(tmp_path: Path) -> None:
    webcam = Webcam(tmp_path / "video0")
    webcam.is_silent = True
    with pytest.raises(CameraError, match=r"video0: no picture for 0.1 s"):
        await take(webcam.source(ManualClock()), 1)
    assert webcam.released == 1


@pytest.mark.fault(
    "a USB camera's driver hangs",
    "no second thread enters the driver; camera unhealthy with the reason until it returns",
)
async def test_while_a_driver_hangs_no_second_thread_hangs_in_it(tmp_path: Path) -> None:
    webcam = Webcam(tmp_path / "video0")
    source = webcam.source(ManualClock())
    source._close_s = 0.05
    webcam.hangs.clear()
    with pytest.raises(TimeoutError):
        async with asyncio.timeout(0.1):
            await anext(source.frames())
    with pytest.raises(CameraError, match="the driver hangs"):
        await take(source, 1)
    webcam.hangs.set()
    assert (await take(source, 1))[0].jpeg == JPEG
    assert camera_threads() == []


def pictures_come(camera: DroneCamera, before: CameraFrame | None) -> Callable[[], bool]:
    return lambda: camera.latest is not before


def says_no_device(caplog: pytest.LogCaptureFixture, times: int) -> Callable[[], bool]:
    return lambda: caplog.text.count("there is no such device") == times


@pytest.mark.fault(
    "a USB camera is unplugged and plugged in again",
    "camera unhealthy with the reason; opened again at the same path, within 4 s of its return",
)
async def test_a_camera_that_is_unplugged_is_found_again_at_the_same_path(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    webcam = Webcam(tmp_path / "by-id")
    clock = Clock()
    made = webcam.source(clock)

    def make(_settings: CameraSettings, _clock: Clock) -> CameraSource:
        return made

    camera = DroneCamera(CameraSettings(reconnect_s=0.01), clock, make=make)
    camera.init()
    try:
        async with asyncio.timeout(30):
            for times in (1, 2):
                webcam.device.touch()
                await until(pictures_come(camera, camera.latest))
                webcam.device.unlink()
                await until(says_no_device(caplog, times))
    finally:
        await camera.close()
    assert [record.getMessage() for record in caplog.records if record.levelname == "WARNING"] == [
        f"Camera: v4l2://{webcam.device}: {words}; trying again"
        for _ in range(2)
        for words in ("the camera was unplugged", "there is no such device (is the camera plugged in?)")
    ]
    assert camera_threads() == []


class Kernel:
    """Answers as the kernel does: formats by index, then sizes by format and index, then EINVAL."""

    def __init__(self, sizes: dict[bytes, list[tuple[int, ...]]]) -> None:
        self.sizes = sizes

    def ioctl(self, _descriptor: int, call: int, data: bytearray) -> int:
        index, second = struct.unpack_from("II", data)
        try:
            if call == 0xC0405602:
                assert (len(data), second) == (64, 1)
                data[44:48] = list(self.sizes)[index]
            else:
                assert (call, len(data)) == (0xC02C564A, 44)
                kind, *numbers = self.sizes[second.to_bytes(4, "little")][index]
                struct.pack_into(f"{1 + len(numbers)}I", data, 8, kind, *numbers)
        except IndexError:
            raise OSError(errno.EINVAL, "Invalid argument") from None
        return 0


def test_formats_and_sizes_are_read_from_the_driver(tmp_path: Path) -> None:
    device = tmp_path / "video0"
    device.touch()
    kernel = Kernel({b"MJPG": [(1, 1280, 720), (1, 640, 480)], b"Y16 ": [(3, 32, 640, 16, 24, 480, 8)], b"GREY": []})
    found = read_formats(device, kernel.ioctl)
    assert [str(each) for each in found] == ["MJPG 1280 x 720, 640 x 480", "Y16 32 x 24 to 640 x 480", "GREY"]
    assert (64, 48) in found[1].sizes[0]
    assert (65, 48) not in found[1].sizes[0]
    assert (656, 480) not in found[1].sizes[0]


@pytest.mark.parametrize(
    ("formats", "options", "code"),
    [
        ([], {}, None),
        ([], {"format": "MJPG"}, "MJPG"),
        (WEBCAM, {}, "MJPG"),
        (WEBCAM, {"format": "YUYV"}, "YUYV"),
        (WEBCAM[:1], {"width": 640, "height": 480}, "YUYV"),
        ([V4l2Format("NV12", ()), *WEBCAM[:1]], {"width": 800, "height": 600}, "NV12"),
    ],
)
def test_jpeg_is_preferred(formats: list[V4l2Format], options: dict[str, Any], code: str | None) -> None:
    assert choose_format(V4l2Camera(device=Path("/dev/video0"), **options), formats) == code
