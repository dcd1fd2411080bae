"""Drone Camera (specification, section 7): the camera's pictures with their capture times.

It waits for a camera that is absent and connects again when it went away. The newest picture replaces the one before:
nothing queues. A picture's time is its sender's stamp on our clock, else its arrival minus a configured latency.
"""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from collections.abc import Callable
from contextlib import aclosing
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hawk.comm.cameras.calibration import Calibration, load_calibration
from hawk.comm.cameras.sources.mjpeg import HttpMjpegSource
from hawk.comm.cameras.sources.rpicam import RpicamSource
from hawk.comm.cameras.sources.rtsp import GStreamerSource, RtspSource
from hawk.comm.cameras.sources.source import CameraError, CameraSource, OpenCvSource, SourceFrame
from hawk.comm.cameras.sources.v4l2 import V4l2Source
from hawk.comm.cameras.stamp_clock import JUMP_S, StampClock
from hawk.comm.clock import Clock
from hawk.config.addresses import CAMERA_KINDS, RPICAM, V4L2, rpicam_camera, v4l2_camera
from hawk.config.sections import CameraSettings, ConfigError
from hawk.formats.image import NoImage, decode, read_jpeg
from hawk.model.operation import Health, HealthStatus
from hawk.model.pictures import CameraModel
from hawk.model.sentences import say
from hawk.runtime.repeated_log import Repeated, plain
from hawk.runtime.supervision import Supervisor, end_tasks

_LOG = logging.getLogger(__name__)

LONGEST_PAUSE_S: Final = 4.0
"""Real seconds between two attempts at most, unless `[camera] reconnect_s` is longer: a camera that is plugged in again
is seen soon."""
STALE_S = 1.0
"""Seconds without a picture after which the camera is unhealthy and `get_image` has none."""
_LOOKED_AT: Final = 20
"""Pictures, the last that were decoded, of which the damaged ones are reported."""
_MOST_DAMAGED: Final = 10
"""Of these; with more the camera is unhealthy."""
_LEFT_OUT: Final = say("damaged and left out: check the cable, the plug and the radio link")


@dataclass(frozen=True, slots=True)
class CameraFrame:
    """One picture. ``captured`` (capture time) and ``arrived`` are seconds of the daemon's clock."""

    jpeg: bytes = field(repr=False)
    captured: float
    sequence: int
    arrived: float
    width: int
    height: int


def make_source(settings: CameraSettings, clock: Clock) -> CameraSource:
    """Return the source for ``settings.url``. Raises ConfigError naming the known kinds."""
    url = settings.url.get_secret_value()
    if url.startswith(("http://", "https://")):
        return HttpMjpegSource(url, clock)
    if url.startswith("gst:"):
        return GStreamerSource(url.removeprefix("gst:"), clock)
    if url.startswith(("rtsp://", "rtsps://")):
        return RtspSource(url, clock)
    if url.startswith(RPICAM):
        return RpicamSource(rpicam_camera(url), clock)
    if url.startswith(V4L2):
        return V4l2Source(v4l2_camera(url), clock)
    if url.startswith("file://"):
        return OpenCvSource(url, clock)
    raise ConfigError(
        f"camera.url: {settings.url} is no source of pictures: it must start with {', '.join(CAMERA_KINDS)}"
    )


class DroneCamera:
    """The camera under the drone."""

    def __init__(
        self,
        settings: CameraSettings,
        clock: Clock,
        stamp_clock: Callable[[float], float | None] | None = None,
        make: Callable[[CameraSettings, Clock], CameraSource] = make_source,
        supervisor: Supervisor | None = None,
    ) -> None:
        """Load the calibration; nothing is opened before `init`. ``supervisor`` keeps the receiving task running.

        ``stamp_clock`` maps the camera's stamps (seconds) onto our clock where that is known (the simulator stamps by
        the autopilot's boot clock); None when it cannot. Otherwise the least delay seen is the latency.

        Raises:
            ConfigError: The calibration file cannot be used.
        """
        self._settings = settings
        self._clock = clock
        self._stamp_clock = stamp_clock
        self._make = make
        self._supervisor = supervisor or Supervisor()
        self._calibration: Calibration = load_calibration(settings)
        self._stamps = StampClock(settings.latency_s, clock.speed)
        self.latest: CameraFrame | None = None
        """The newest picture, however old."""
        self._given = 0
        self._sequence = 0
        self._problem: str = say("No picture yet")
        self._reported = ""
        self._repeated = Repeated()
        self._damaged = self._damaged_before = 0
        self._decoded: deque[bool] = deque(maxlen=_LOOKED_AT)  # True: damaged
        self._source: CameraSource | None = None
        self._arrived = asyncio.Event()
        self._task: asyncio.Task[None] | None = None

    def init(self) -> None:
        """Start to receive pictures; needs the running loop. Does nothing when it already does."""
        if self._task is None:
            self._task = self._supervisor.start("drone-camera", self._receive)

    def get_image(self) -> NDArray[np.uint8]:
        """Return the newest picture, (height, width, 3) BGR. Decodes (about 10 ms): call it off the loop.

        Raises:
            NoImage: There is no fresh picture, or it cannot be decoded; DamagedImage: a part of it was lost.
        """
        frame = self.latest
        if frame is None or self._clock() - frame.arrived > STALE_S * self._clock.speed:
            raise NoImage(self.health.reason or self._problem)
        return decode(frame.jpeg)

    async def next_frame(self) -> CameraFrame:
        """Wait for a picture newer than the last returned one; return the newest."""
        while self.latest is None or self.latest.sequence <= self._given:
            self._arrived.clear()
            await self._arrived.wait()
        self._given = self.latest.sequence
        return self.latest

    @property
    def health(self) -> Health:
        """Healthy while fresh pictures come that fit the calibration, most of them whole; damaged ones are reported."""
        frame = self.latest
        if frame is None:
            return Health.bad(say("Camera: {silence}", silence=self._silence()))
        age = self._clock() - frame.arrived
        if age > STALE_S * self._clock.speed:
            return Health.bad(say("Camera: no picture for {age:.0f} s. {silence}", age=age, silence=self._silence()))
        misfit = self._calibration.misfit(frame.width, frame.height)
        if misfit:
            return Health.bad(say("Camera: {misfit}", misfit=misfit))
        damaged = sum(self._decoded)
        if not damaged:
            return Health()
        count = len(self._decoded)
        if damaged == 1:
            words = say("Camera: 1 of the last {count} pictures was {left_out}", count=count, left_out=_LEFT_OUT)
        else:
            words = say(
                "Camera: {damaged} of the last {count} pictures were {left_out}",
                damaged=damaged,
                count=count,
                left_out=_LEFT_OUT,
            )
        return Health(HealthStatus.UNHEALTHY if damaged > _MOST_DAMAGED else HealthStatus.HEALTHY, words)

    @property
    def model(self) -> CameraModel | None:
        """The camera at the size of the newest picture, None before the first."""
        frame = self.latest
        return None if frame is None else self._calibration.for_size(frame.width, frame.height)

    def looked_at(self, *, is_damaged: bool) -> None:
        """Take what the decoder found in a picture that was given out."""
        self._decoded.append(is_damaged)
        self._damaged += is_damaged

    @property
    def damaged(self) -> int:
        """Number of damaged pictures: those that were dropped, and those that the decoder refused."""
        return self._damaged + (self._source.torn if self._source is not None else 0)

    async def close(self) -> None:
        """Stop receiving and release the camera."""
        task, self._task = self._task, None
        if task is not None:
            await end_tasks(task)
        if self._source is not None:
            await self._source.close()

    async def _receive(self) -> None:
        """Open the source for ever: after `reconnect_s`, after twice as long for each attempt without a picture."""
        shortest = self._settings.reconnect_s
        longest = max(shortest, LONGEST_PAUSE_S)
        pause = shortest
        while True:
            before = self._sequence
            try:
                self._source = self._source or self._make(self._settings, self._clock)
                async with aclosing(self._source.frames()) as frames:
                    async for frame in frames:
                        self._take(frame)
            except CameraError as error:
                self._report(str(error))
            except Exception as error:  # a broken source must not end the camera
                _LOG.exception("The camera's source failed")
                self._report(f"{type(error).__name__}: {error}")
            pause = shortest if self._sequence > before else pause
            await asyncio.sleep(pause)
            pause = min(2 * pause, longest)

    def _take(self, frame: SourceFrame) -> None:
        try:
            head = read_jpeg(frame.jpeg)
        except ValueError:
            self._damaged += 1
            return
        if head.end is None:
            self._damaged += 1
            return
        captured = self._captured(frame)
        if captured is None:
            return  # for a few pictures: none is placed by a wrong time
        jpeg, (width, height) = frame.jpeg[: head.end], head.size
        self._damaged_before = self.damaged
        self._sequence += 1
        if self._reported:
            _LOG.info("Camera: pictures come again")
            self._repeated.ends()
        self._problem = self._reported = ""
        self.latest = CameraFrame(jpeg, captured, self._sequence, frame.arrival, width, height)
        self._arrived.set()

    def _captured(self, frame: SourceFrame) -> float | None:
        """Return the capture time on our clock, never after the picture's arrival; None while it is not known."""
        if frame.captured is not None:
            return min(frame.captured, frame.arrival)
        if frame.stamp is None:
            return frame.arrival - self._settings.latency_s
        placed = self._stamps.take(frame.stamp, frame.arrival)
        if placed.stepped_s is not None:
            cause = "stepped" if placed.stepped_s < 0 else "stepped, or its delay fell,"
            _LOG.warning("Camera: its clock %s by %+.2f s; the next pictures are left out", cause, placed.stepped_s)
        if placed.stands:
            self._problem = say("Its time stamps stand still")
        if placed.time is None:
            return None
        return min(self._known(frame.stamp, frame.arrival, placed.time), frame.arrival)

    def _known(self, stamp: float, arrival: float, placed: float) -> float:
        """Return the time by the mapping that is known; ``placed`` where there is none or the stamp refutes it."""
        if self._stamp_clock is None or self._stamps.has_stepped:
            return placed
        known = self._stamp_clock(stamp)
        comes_before_it_is_taken = known is not None and known > arrival + JUMP_S * self._clock.speed
        return placed if known is None or comes_before_it_is_taken else known

    def _silence(self) -> str:
        """Return why there is no picture: what the source said, and how many came damaged since the last one."""
        damaged = self.damaged - self._damaged_before
        if not damaged:
            return self._problem
        came = say("{damaged} came damaged: check the cable, the plug and the radio link", damaged=damaged)
        return f"{self._problem}; {came}" if self._problem else came

    def _report(self, problem: str) -> None:
        problem = plain(problem)
        line = self._repeated.due(f"Camera: {problem}; trying again")
        if line is not None:
            _LOG.warning("%s", line)
        self._problem = self._reported = problem
