"""Drone Camera (specification, section 7): the camera's pictures with the moment their light was caught.

It waits for a camera that is absent and finds it again when it went away. The newest picture replaces the one before:
nothing queues. A picture's time is its sender's stamp mapped onto our clock, else its arrival minus a configured
latency.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Callable
from contextlib import aclosing
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hawk.comm import jpeg
from hawk.comm.calibration import Calibration, load_calibration
from hawk.comm.camera_sources.make import make_source
from hawk.comm.camera_sources.source import CameraError, CameraSource, SourceFrame
from hawk.comm.clock import Clock, OffsetEstimator
from hawk.comm.image import NoImage, decode
from hawk.config import CameraSettings
from hawk.model import CameraModel, Health

_LOG = logging.getLogger(__name__)

STALE_S = 1.0
"""Seconds without a picture after which the camera counts as unhealthy and `get_image` has none."""


@dataclass(frozen=True, slots=True)
class CameraFrame:
    """One picture. ``captured`` (when its light was caught) and ``arrived`` are seconds of the daemon's clock."""

    jpeg: bytes = field(repr=False)
    captured: float
    sequence: int
    arrived: float
    width: int
    height: int


class DroneCamera:
    """The camera under the drone.

    ``stamp_clock`` maps the camera's stamps onto our clock where that is known (the simulator stamps by the
    autopilot's boot clock); it returns None when it cannot. Otherwise the least delay seen counts as the latency.
    """

    def __init__(
        self,
        settings: CameraSettings,
        clock: Clock,
        stamp_clock: Callable[[float], float | None] | None = None,
        make: Callable[[CameraSettings, Clock], CameraSource] = make_source,
    ) -> None:
        """Raises ConfigError when the calibration file cannot be used."""
        self._settings = settings
        self._clock = clock
        self._stamp_clock = stamp_clock
        self._make = make
        self._calibration: Calibration = load_calibration(settings)
        self._estimator = OffsetEstimator(latency_s=settings.latency_s)
        self._latest: CameraFrame | None = None
        self._given = 0
        self._sequence = 0
        self._problem = "No picture yet"
        self._damaged = 0
        self._source: CameraSource | None = None
        self._arrived = asyncio.Event()
        self._task: asyncio.Task[None] | None = None

    def init(self) -> None:
        """Start to receive pictures; needs the running loop. Does nothing when it already does."""
        if self._task is None:
            self._task = asyncio.get_running_loop().create_task(self._receive(), name="drone-camera")

    def get_image(self) -> NDArray[np.uint8]:
        """Return the newest picture, (height, width, 3) BGR. Decodes (about 10 ms): call it off the loop.

        Raises NoImage when there is none that is fresh, or when it cannot be decoded.
        """
        frame = self._latest
        if frame is None or self._clock() - frame.arrived > STALE_S * self._clock.speed:
            raise NoImage(self.health.reason or self._problem)
        return decode(frame.jpeg)

    async def next_frame(self) -> CameraFrame:
        """Wait for a picture newer than the last one that this method gave; return the newest."""
        while self._latest is None or self._latest.sequence <= self._given:
            self._arrived.clear()
            await self._arrived.wait()
        self._given = self._latest.sequence
        return self._latest

    @property
    def latest(self) -> CameraFrame | None:
        """The newest picture, however old."""
        return self._latest

    @property
    def health(self) -> Health:
        """Whether fresh pictures come that fit the calibration."""
        frame = self._latest
        if frame is None:
            return Health.bad(f"Camera: {self._problem}")
        age = self._clock() - frame.arrived
        if age > STALE_S * self._clock.speed:
            return Health.bad(f"Camera: no picture for {age:.0f} s. {self._problem}".strip())
        misfit = self._calibration.misfit(frame.width, frame.height)
        return Health.bad(f"Camera: {misfit}") if misfit else Health()

    @property
    def model(self) -> CameraModel | None:
        """The camera as it sees the newest picture, None before the first."""
        frame = self._latest
        return None if frame is None else self._calibration.for_size(frame.width, frame.height)

    @property
    def damaged(self) -> int:
        """Pictures that were dropped because they were not whole."""
        return self._damaged + (self._source.torn if self._source is not None else 0)

    async def close(self) -> None:
        """Stop receiving and let go of the camera."""
        task, self._task = self._task, None
        if task is not None:
            task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await task
        if self._source is not None:
            await self._source.close()

    async def _receive(self) -> None:
        while True:
            try:
                self._source = self._source or self._make(self._settings, self._clock)
                async with aclosing(self._source.frames()) as frames:  # type: ignore[type-var]
                    async for frame in frames:
                        self._take(frame)
            except CameraError as error:
                self._tell(str(error))
            except Exception as error:  # a broken source must not end the camera
                _LOG.exception("The camera's source failed")
                self._tell(f"{type(error).__name__}: {error}")
            await asyncio.sleep(self._settings.reconnect_s)

    def _take(self, frame: SourceFrame) -> None:
        try:
            width, height = jpeg.size(frame.jpeg)
        except ValueError:
            self._damaged += 1
            return
        self._sequence += 1
        self._problem = ""
        self._latest = CameraFrame(frame.jpeg, self._captured(frame), self._sequence, frame.arrival, width, height)
        self._arrived.set()

    def _captured(self, frame: SourceFrame) -> float:
        """Return when the light was caught; never after the picture's arrival."""
        if frame.stamp is None:
            return frame.arrival - self._settings.latency_s
        known = self._stamp_clock(frame.stamp) if self._stamp_clock is not None else None
        estimated = self._estimator.update(frame.stamp, frame.arrival)
        return min(estimated if known is None else known, frame.arrival)

    def _tell(self, problem: str) -> None:
        if problem != self._problem:
            _LOG.warning("Camera: %s; trying again", problem)
        self._problem = problem
