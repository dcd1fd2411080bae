from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, AsyncIterator

import pytest

from hawk.comm.cameras.drone_camera import LONGEST_PAUSE_S, STALE_S, DroneCamera, make_source
from hawk.comm.cameras.sources.mjpeg import HttpMjpegSource
from hawk.comm.cameras.sources.rpicam import RpicamSource
from hawk.comm.cameras.sources.rtsp import GStreamerSource, RtspSource
from hawk.comm.cameras.sources.source import CameraError, CameraSource, OpenCvSource, SourceFrame
from hawk.comm.cameras.sources.v4l2 import V4l2Source
from hawk.comm.clock import Clock
from hawk.config.secrets import SecretUrl
from hawk.config.sections import CameraSettings, ConfigError
from hawk.formats.image import NoImage
from hawk.model.operation import Health
from tests.manual_clock import ManualClock
from tests.unit.comm.cameras.pictures import StreamServer, forever, part, picture
from tests.unit.comm.waiting import until

PICTURE = picture()


class HandFed(CameraSource):
    """A source that is fed by the test; a CameraError that is fed ends the stream."""

    def __init__(self) -> None:
        self.queue: asyncio.Queue[SourceFrame | Exception] = asyncio.Queue()
        self.opened = 0
        self.torn = 0
        self.closed = False

    async def frames(self) -> AsyncGenerator[SourceFrame, None]:
        self.opened += 1
        while True:
            item = await self.queue.get()
            if isinstance(item, Exception):
                raise item
            yield item

    async def close(self) -> None:
        self.closed = True


class Rig:
    def __init__(self) -> None:
        self.clock = ManualClock(100.0)
        self.source = HandFed()
        self.known: float | None = None
        self.camera = self.make(CameraSettings(latency_s=0.08, reconnect_s=0.01))

    def make(self, settings: CameraSettings, *, stamped: bool = False) -> DroneCamera:
        def make_it(_settings: CameraSettings, _clock: Clock) -> HandFed:
            return self.source

        self.camera = DroneCamera(settings, self.clock, (lambda _: self.known) if stamped else None, make_it)
        return self.camera

    async def feed(self, *items: SourceFrame | Exception) -> None:
        for item in items:
            self.source.queue.put_nowait(item)
        for _ in range(4):
            await asyncio.sleep(0)


@pytest.fixture
async def rig() -> AsyncIterator[Rig]:
    rig = Rig()
    yield rig
    await rig.camera.close()


def frame(arrival: float = 100.0, stamp: float | None = None, data: bytes = PICTURE) -> SourceFrame:
    return SourceFrame(data, arrival, stamp)


async def test_before_the_first_picture_there_is_none(rig: Rig) -> None:
    rig.camera.init()
    with pytest.raises(NoImage, match="No picture yet"):
        rig.camera.get_image()
    assert rig.camera.latest is None
    assert rig.camera.model is None
    assert not rig.camera.health.is_healthy


async def test_the_newest_picture_is_given_as_bgr(rig: Rig) -> None:
    rig.camera.init()
    await rig.feed(frame(data=picture(32, 16, 10)), frame(data=picture(32, 16, 200)))
    image = rig.camera.get_image()
    assert image.shape == (16, 32, 3)
    assert image.dtype == "uint8"
    assert abs(int(image.mean()) - 200) < 3
    assert rig.camera.health.is_healthy


async def test_an_old_picture_is_no_picture(rig: Rig) -> None:
    rig.camera.init()
    await rig.feed(frame())
    rig.clock.advance(STALE_S + 1.0)
    with pytest.raises(NoImage, match="no picture for 2 s"):
        rig.camera.get_image()
    assert "no picture for 2 s" in rig.camera.health.reason
    assert rig.camera.latest is not None


async def test_next_frame_waits_for_a_newer_one_and_skips_to_the_newest(rig: Rig) -> None:
    rig.camera.init()
    waiting = asyncio.create_task(rig.camera.next_frame())
    await asyncio.sleep(0)
    assert not waiting.done()
    await rig.feed(frame(100.0))
    assert (await waiting).sequence == 1
    await rig.feed(frame(100.1), frame(100.2), frame(100.3))
    newest = await rig.camera.next_frame()
    assert (newest.sequence, newest.arrived) == (4, 100.3)
    waiting = asyncio.create_task(rig.camera.next_frame())
    await rig.feed()
    assert not waiting.done()
    waiting.cancel()


async def test_without_a_stamp_the_light_was_caught_a_latency_before_arrival(rig: Rig) -> None:
    rig.camera.init()
    await rig.feed(frame(100.0))
    assert rig.camera.latest is not None
    assert rig.camera.latest.captured == pytest.approx(99.92)


async def test_a_stamp_is_mapped_by_the_least_delay_and_the_latency(rig: Rig) -> None:
    rig.camera.init()
    await rig.feed(frame(100.0, 5.0), frame(100.3, 5.1))  # the second came 0.2 s late
    assert rig.camera.latest is not None
    assert rig.camera.latest.captured == pytest.approx(100.02)


async def test_a_known_clock_is_believed_but_never_after_the_arrival(rig: Rig) -> None:
    rig.make(CameraSettings(), stamped=True)
    rig.camera.init()
    rig.known = 99.87
    await rig.feed(frame(100.0, 5.0))
    assert rig.camera.latest is not None
    assert rig.camera.latest.captured == 99.87
    rig.known = 100.15
    await rig.feed(frame(100.1, 5.1))
    assert rig.camera.latest.captured == 100.1


async def test_a_known_clock_that_puts_a_picture_long_after_its_arrival_is_not_believed(rig: Rig) -> None:
    rig.make(CameraSettings(latency_s=0.05), stamped=True)
    rig.camera.init()
    rig.known = 99.87
    await rig.feed(frame(100.0, 5.0))
    rig.known = 105.0
    await rig.feed(frame(100.1, 5.1))
    assert rig.camera.latest is not None
    assert rig.camera.latest.captured == pytest.approx(100.05)


@pytest.mark.fault("the camera's clock steps by .2 s to a day, forward or back, at 3 to 30 pictures a second")
@pytest.mark.parametrize("stamped", [False, True], ids=["least delay", "known clock"])
@pytest.mark.parametrize("step", [-0.2, -0.9, 0.4])
async def test_after_a_step_of_its_clock_no_picture_is_placed_by_the_old_one(
    rig: Rig, caplog: pytest.LogCaptureFixture, step: float, stamped: bool
) -> None:
    rig.make(CameraSettings(latency_s=0.0), stamped=stamped)
    rig.camera.init()
    placed: list[float] = []
    for n in range(60):
        taken = 100.0 + n / 10
        stamp = taken - 95.0 + (step if n >= 30 else 0.0)
        rig.known = stamp + 95.0
        rig.clock.now = taken + 0.02
        before = rig.camera.latest
        await rig.feed(frame(taken + 0.02, stamp))
        if rig.camera.latest is not before:
            assert rig.camera.latest is not None
            assert rig.camera.latest.captured == pytest.approx(taken, abs=0.03)
            placed.append(taken)
    assert 54 <= len(placed) < 60
    assert "its clock stepped" in caplog.text
    assert f"by {step:+.2f} s" in caplog.text


@pytest.mark.fault(
    "the camera's clock stands still, or counts whole seconds only",
    "a picture with the stamp of the one before is left out, and no other is placed by it; the camera says "
    "that its stamps stand still",
)
@pytest.mark.parametrize("stamped", [False, True], ids=["least delay", "known clock"])
async def test_pictures_whose_stamps_stand_still_are_left_out_and_reported(rig: Rig, stamped: bool) -> None:
    rig.make(CameraSettings(latency_s=0.0), stamped=stamped)
    rig.camera.init()
    rig.known = 100.0
    for n in range(30):
        rig.clock.now = 100.02 + n / 10
        await rig.feed(frame(rig.clock.now, 5.0))
    assert rig.camera.latest is not None
    assert (rig.camera.latest.sequence, rig.camera.latest.arrived) == (1, 100.02)
    assert rig.camera.health.reason == "Camera: no picture for 3 s. Its time stamps stand still"
    rig.known = 102.9
    await rig.feed(frame(rig.clock.now, 7.9))
    await rig.feed(*(frame(rig.clock.now + n / 10, 7.9 + n / 10) for n in range(1, 6)))
    assert rig.camera.health == Health()


async def test_a_capture_time_that_the_source_knows_is_believed_but_never_after_the_arrival(rig: Rig) -> None:
    rig.make(CameraSettings(), stamped=True)
    rig.camera.init()
    rig.known = 50.0
    await rig.feed(SourceFrame(PICTURE, 100.0, 5.0, 99.95))
    assert rig.camera.latest is not None
    assert rig.camera.latest.captured == 99.95
    await rig.feed(SourceFrame(PICTURE, 100.1, 5.1, 100.2))
    assert rig.camera.latest.captured == 100.1


async def test_attempts_become_rarer_and_soon_again_after_a_picture(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    pauses: list[float] = []
    sleep = asyncio.sleep

    async def count(seconds: float) -> None:
        if seconds >= 0.5:  # not those of the test's own waiting
            pauses.append(seconds)
        await sleep(0)

    monkeypatch.setattr("hawk.comm.cameras.drone_camera.asyncio.sleep", count)
    rig.make(CameraSettings(reconnect_s=0.5))
    rig.source.queue = asyncio.Queue()
    gone = CameraError("gone")
    items: list[SourceFrame | Exception] = [*[gone] * 6, frame(), gone, gone]
    for item in items:
        rig.source.queue.put_nowait(item)
    rig.camera.init()
    await until(lambda: len(pauses) == 8)
    assert pauses == [0.5, 1, 2, LONGEST_PAUSE_S, LONGEST_PAUSE_S, LONGEST_PAUSE_S, 0.5, 1]


async def test_a_problem_is_logged_once_and_its_end_once(rig: Rig, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO")
    rig.camera.init()
    gone = CameraError("cam: gone")
    await rig.feed(gone, gone, CameraError("cam: busy"), frame(), gone)
    await until(lambda: rig.source.opened == 5)
    assert [record.getMessage() for record in caplog.records] == [
        "Camera: cam: gone; trying again",
        "Camera: cam: busy; trying again",
        "Camera: pictures come again",
        "Camera: cam: gone; trying again",
    ]


async def test_while_the_known_clock_is_not_known_the_stamp_is_estimated(rig: Rig) -> None:
    rig.make(CameraSettings(latency_s=0.05), stamped=True)
    rig.camera.init()
    await rig.feed(frame(100.0, 5.0))
    assert rig.camera.latest is not None
    assert rig.camera.latest.captured == pytest.approx(99.95)


async def test_a_camera_that_goes_away_is_reported_and_found_again(rig: Rig) -> None:
    rig.camera.init()
    await rig.feed(frame(100.0), CameraError("http://cam: the stream ended"))
    rig.clock.advance(2.0)
    assert "the stream ended" in rig.camera.health.reason
    waiting = asyncio.create_task(rig.camera.next_frame())
    await rig.feed()
    waiting.cancel()
    await until(lambda: rig.source.opened == 2)
    await rig.feed(frame(102.0))
    assert rig.camera.health.is_healthy


async def test_an_unexpected_failure_does_not_end_the_camera(rig: Rig) -> None:
    rig.camera.init()
    await rig.feed(RuntimeError("a bug in a driver"))
    assert "RuntimeError: a bug in a driver" in rig.camera.health.reason
    await asyncio.sleep(0.02)
    await rig.feed(frame(100.0))
    assert rig.camera.health.is_healthy


async def test_what_is_no_jpeg_is_dropped_and_counted(rig: Rig) -> None:
    rig.camera.init()
    rig.source.torn = 3
    await rig.feed(frame(data=b"\xff\xd8 no picture \xff\xd9"))
    assert rig.camera.latest is None
    assert rig.camera.damaged == 4


async def test_a_picture_that_cannot_be_decoded_is_no_image_and_no_opencv_error(rig: Rig) -> None:
    rig.camera.init()
    data = picture()
    await rig.feed(frame(data=data.replace(b"\xff\xc0", b"\xff\xc3")))  # lossless: no camera sends it
    with pytest.raises(NoImage, match="cannot be decoded"):
        rig.camera.get_image()


async def test_what_follows_a_picture_is_left_out(rig: Rig) -> None:
    rig.camera.init()
    await rig.feed(frame(data=PICTURE + b"\0" * 500))
    assert rig.camera.latest is not None
    assert rig.camera.latest.jpeg == PICTURE


@pytest.mark.fault(
    "more than half of the last 20 pictures are damaged, or none comes whole",
    "camera unhealthy with the number and what to check; fewer are reported and change nothing",
)
async def test_damaged_pictures_are_reported_and_make_the_camera_unhealthy_when_they_are_most(rig: Rig) -> None:
    rig.camera.init()
    await rig.feed(frame())
    assert rig.camera.health == Health()
    for at in range(10):
        rig.camera.looked_at(is_damaged=at == 3)
    assert rig.camera.damaged == 1
    few = rig.camera.health
    assert few.is_healthy
    assert "1 of the last 10 pictures was damaged" in few.reason
    for _ in range(10):
        rig.camera.looked_at(is_damaged=True)
    most = rig.camera.health
    assert not most.is_healthy
    assert "11 of the last 20 pictures were damaged and left out: check the cable" in most.reason
    for _ in range(20):
        rig.camera.looked_at(is_damaged=False)
    assert rig.camera.health == Health()
    assert rig.camera.damaged == 11


@pytest.mark.fault("more than half of the last 20 pictures are damaged, or none comes whole")
async def test_a_camera_all_of_whose_pictures_come_damaged_is_reported(rig: Rig) -> None:
    rig.camera.init()
    await rig.feed(frame(data=PICTURE[:-2]))
    assert "1 came damaged" in rig.camera.health.reason
    await rig.feed(frame(100.0))
    rig.source.torn += 6
    rig.clock.advance(3.0)
    assert "no picture for 3 s" in rig.camera.health.reason
    assert "6 came damaged: check the cable" in rig.camera.health.reason


async def test_the_model_is_that_of_the_newest_picture(rig: Rig) -> None:
    rig.make(CameraSettings(horizontal_fov_deg=90.0))
    rig.camera.init()
    await rig.feed(frame(data=picture(640, 480)))
    model = rig.camera.model
    assert model is not None
    assert (model.width, model.height) == (640, 480)
    assert model.fx == pytest.approx(320.0)


async def test_closing_ends_task_and_source_and_may_be_done_twice(rig: Rig) -> None:
    rig.camera.init()
    rig.camera.init()
    await rig.feed(frame())
    await rig.camera.close()
    await rig.camera.close()
    assert rig.source.closed
    assert not [task for task in asyncio.all_tasks() if task.get_name() == "drone-camera"]


@pytest.mark.parametrize(
    ("url", "kind"),
    [
        ("http://127.0.0.1:8090/stream", HttpMjpegSource),
        ("https://cam/stream", HttpMjpegSource),
        ("rpicam:0?width=1456&height=1088", RpicamSource),
        ("v4l2:///dev/video0?width=1280&height=720", V4l2Source),
        ("rtsp://cam/stream", RtspSource),
        ("rtsps://cam/stream", RtspSource),
        ("file:///video.mp4", OpenCvSource),
        ("gst:videotestsrc", GStreamerSource),
    ],
)
def test_the_address_chooses_the_source(url: str, kind: type) -> None:
    assert isinstance(make_source(CameraSettings(url=url), ManualClock()), kind)


def test_an_address_of_no_known_kind_names_those_that_are() -> None:
    with pytest.raises(ConfigError, match=r"camera.url: ftp://x .*http://.*gst:"):
        make_source(CameraSettings().model_copy(update={"url": SecretUrl("ftp://x")}), ManualClock())


async def test_a_source_that_cannot_be_made_is_reported_and_tried_again_and_the_camera_can_be_closed() -> None:
    made: list[SecretUrl] = []

    def make(settings: CameraSettings, clock: Clock) -> CameraSource:
        made.append(settings.url)
        if len(made) < 3:
            raise ConfigError("camera.url: no such source")
        return make_source(settings, clock)

    camera = DroneCamera(CameraSettings(reconnect_s=0.01), ManualClock(5.0), make=make)
    camera.init()
    try:
        async with asyncio.timeout(10):
            await until(lambda: "no such source" in camera.health.reason)
            await until(lambda: len(made) == 3)
    finally:
        await camera.close()


async def test_over_http_it_waits_for_an_absent_camera_and_finds_it_again(unused_tcp_port: int) -> None:
    url = f"http://127.0.0.1:{unused_tcp_port}/stream"
    camera = DroneCamera(CameraSettings(url=url, reconnect_s=0.02), ManualClock(5.0))
    camera.init()
    server = None
    try:
        async with asyncio.timeout(10):
            await until(lambda: "Cannot connect" in camera.health.reason)
            for _ in range(2):
                server = StreamServer(forever(part(PICTURE)), port=unused_tcp_port)
                await server.start()
                await camera.next_frame()
                await server.close()
    finally:
        await camera.close()
        if server is not None:
            await server.close()
