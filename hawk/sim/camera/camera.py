"""The simulated camera: exposes on time, draws in its own thread, delivers the newest picture."""

from __future__ import annotations

import asyncio
import logging
import math
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.model.pictures import CameraModel, angles, rotation
from hawk.runtime.supervision import end_tasks


class SimulationClock:
    """Clock that runs from zero at ``speed`` simulated seconds per real second."""

    def __init__(self, speed: float = 1.0, monotonic: Callable[[], float] = time.monotonic) -> None:
        self.speed = speed
        self._monotonic = monotonic
        self._start = monotonic()

    def __call__(self) -> float:
        """Return simulated seconds since the start."""
        return (self._monotonic() - self._start) * self.speed


log = logging.getLogger(__name__)

RATE_HZ = 15.0
"""Pictures in a simulated second, unless the options say otherwise."""
FRAME_S = 1.0 / RATE_HZ
"""Their period, simulated seconds."""
JPEG_QUALITY = 85
WIDTH, HEIGHT = 1280, 720
HORIZONTAL_FOV = math.radians(70.0)


class Renderer(Protocol):
    """Draws what a downward camera sees: `hawk.worlds.camera.WorldCamera`."""

    def render(
        self,
        x_east: float,
        y_south: float,
        height: float,
        roll: float,
        pitch: float,
        yaw: float,
        *,
        rng: np.random.Generator,
    ) -> NDArray[np.uint8]:
        """Return the frame, BGR uint8."""
        ...


@dataclass(frozen=True, slots=True)
class Shot:
    """Pose of the camera at an exposure.

    ``stamp`` is the autopilot's boot clock, ``slot`` the simulation's (seconds); the place in metres in the world's
    picture (x east, y south) and above the ground; attitude in radians (NED, FRD body).
    """

    stamp: float
    slot: float
    x_east: float
    y_south: float
    height: float
    roll: float
    pitch: float
    yaw: float


@dataclass(frozen=True, slots=True)
class Frame:
    """An encoded picture; ``stamp`` is the time of its exposure, seconds of the autopilot's boot clock."""

    sequence: int
    stamp: float
    jpeg: bytes = field(repr=False)


def default_intrinsics() -> CameraModel:
    """Return the pinhole model of the simulated camera: 1280 x 720, 70 degrees wide, no distortion."""
    focal = WIDTH / 2.0 / math.tan(HORIZONTAL_FOV / 2.0)
    return CameraModel(WIDTH, HEIGHT, focal, focal, (WIDTH - 1) / 2.0, (HEIGHT - 1) / 2.0)


class Camera:
    """Draws one shot at a time; a shot that comes while one waits replaces it, and the replaced one is late.

    ``due`` counts the shots with a viewer, ``drawn`` the pictures, ``late`` the shots that were drawn more than a frame
    period after their slot or not at all: ``late / due`` is the share that voids a run. A picture is delivered
    ``latency`` simulated seconds after its exposure. Nothing is drawn without a viewer.
    """

    def __init__(
        self,
        renderer: Renderer,
        clock: SimulationClock,
        rng: np.random.Generator,
        latency: float = 0.05,
        frame_s: float = FRAME_S,
    ) -> None:
        self.due = 0
        self.drawn = 0
        self.late = 0
        self.frozen = False
        self.dark = False
        """Faults: the same picture again and again; no picture at all."""
        self.turned = 0.0
        self.mirrored = False
        """Faults: turned clockwise in its mount (radians, seen from above); left and right swapped."""
        self.contrast = 1.0
        self.blank_every = 0
        """Faults: share of the contrast that is left, as of bare ground; each such picture is grey, 0: none."""
        self._renderer = renderer
        self._clock = clock
        self._rng = rng
        self._latency = latency
        self._frame_s = frame_s
        self._executor = ThreadPoolExecutor(1, thread_name_prefix="hawk-sim camera")
        self._waiting: Shot | None = None
        self._drawing: asyncio.Task[None] | None = None
        self._frame: Frame | None = None
        self._next: asyncio.Future[Frame] | None = None
        self._viewers = 0

    @property
    def is_watched(self) -> bool:
        """True while there is a viewer."""
        return self._viewers > 0

    def expose(self, shot: Shot) -> None:
        """Expose a frame (called once a frame period, on the loop)."""
        if not self.is_watched or self.dark:
            return
        self.due += 1
        if self._waiting is not None:
            self.late += 1
        self._waiting = shot
        if self._drawing is None or self._drawing.done():
            self._drawing = asyncio.create_task(self._draw_waiting(), name="hawk-sim camera")

    async def next_frame(self, after: int = -1) -> Frame:
        """Return the newest picture with a sequence above ``after``, waiting for it."""
        self._viewers += 1
        try:
            while self._frame is None or self._frame.sequence <= after:
                if self._next is None:
                    self._next = asyncio.get_running_loop().create_future()
                await asyncio.shield(self._next)
            return self._frame
        finally:
            self._viewers -= 1

    def watch(self, viewers: int) -> None:
        """Add (1) or remove (-1) a viewer: a stream is a viewer between its pictures too."""
        self._viewers += viewers

    def forget(self) -> None:
        """Drop the last picture while there is no viewer, so that the next one gets a new picture."""
        if not self.is_watched:
            self._frame = None

    async def close(self) -> None:
        """End the thread."""
        if self._drawing is not None:
            await end_tasks(self._drawing)
        if self._next is not None:
            self._next.cancel()
        self._executor.shutdown(wait=True)

    async def _draw_waiting(self) -> None:
        loop = asyncio.get_running_loop()
        while self._waiting is not None:
            shot, self._waiting = self._waiting, None
            try:
                jpeg = await loop.run_in_executor(self._executor, self._draw, shot)
            except Exception:
                log.exception("a picture could not be drawn")
                continue
            late_by = self._clock() - shot.slot
            self.drawn += 1
            self.late += late_by > self._frame_s
            if self.frozen and self._frame is not None:
                jpeg = self._frame.jpeg
            frame = Frame(self.drawn, shot.stamp, jpeg)
            wait = (self._latency - late_by) / self._clock.speed
            loop.call_later(max(0.0, wait), self._publish, frame)

    def _draw(self, shot: Shot) -> bytes:
        attitude = turned_camera(shot.roll, shot.pitch, shot.yaw, self.turned)
        picture = self._renderer.render(shot.x_east, shot.y_south, shot.height, *attitude, rng=self._rng)
        if self.mirrored:
            picture = np.asarray(cv2.flip(picture, 1), np.uint8)
        is_blank = self.blank_every > 0 and self.drawn % self.blank_every == 0
        contrast = 0.0 if is_blank else self.contrast
        if contrast < 1.0:
            grey = (1.0 - contrast) * float(picture.mean())
            picture = np.asarray(cv2.convertScaleAbs(picture, alpha=contrast, beta=grey), np.uint8)
        done, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
        if not done:
            raise RuntimeError("the picture could not be encoded")
        return data.tobytes()

    def _publish(self, frame: Frame) -> None:
        if self.dark or (self._frame is not None and frame.sequence <= self._frame.sequence):
            return
        self._frame = frame
        if self._next is not None:
            if not self._next.done():
                self._next.set_result(frame)
            self._next = None


def turned_camera(roll: float, pitch: float, yaw: float, turn: float) -> tuple[float, float, float]:
    """Return the attitude (roll, pitch, yaw) of a camera that is turned in a body of that attitude; all in radians."""
    if turn == 0.0:
        return roll, pitch, yaw
    return angles(rotation(roll, pitch, yaw) @ rotation(0.0, 0.0, turn))
