"""The face of every camera source to `hawk.comm.cameras.drone_camera`, and the base of those whose driver blocks."""

from __future__ import annotations

import asyncio
import contextlib
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import AsyncGenerator, Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final
from urllib.parse import unquote, urlsplit

import cv2
import numpy as np
from numpy.typing import NDArray


class CameraError(Exception):
    """The source cannot give pictures; the text names the source, the problem and the remedy."""


@dataclass(frozen=True, slots=True)
class SourceFrame:
    """A whole JPEG picture. The source gives ``captured``, or ``stamp``, or neither."""

    jpeg: bytes = field(repr=False)
    arrival: float
    """Seconds of the daemon's clock."""
    stamp: float | None = None
    """Capture time in seconds of the source's own clock, when it sends one."""
    captured: float | None = None
    """Capture time in seconds of the daemon's clock, where the source knows it."""


class CameraSource(ABC):
    """A source of pictures."""

    torn: int = 0
    """Pictures that were damaged or cut and dropped."""

    @abstractmethod
    def frames(self) -> AsyncGenerator[SourceFrame, None]:
        """Open the source and give its pictures until it ends. Raises CameraError. May be called again afterwards."""

    async def close(self) -> None:  # noqa: B027 - most sources need nothing beyond the end of `frames`
        """Release the source; its threads and processes have ended on return."""


_CLOSE_S: Final = 6.0
"""Real seconds that a driver may take to return from a read."""

Give = Callable[[SourceFrame], None]


class ThreadedSource(CameraSource):
    """A source that reads on a thread."""

    def __init__(self, name: str, close_s: float = _CLOSE_S) -> None:
        """``name`` stands before each error; ``close_s``: real seconds after which a hanging thread is abandoned."""
        self._name = name
        self._close_s = close_s
        self._thread: _Thread | None = None

    @abstractmethod
    def capture(self, give: Give, stopping: threading.Event) -> None:
        """Open, read until ``stopping`` is set, release; on the thread. Raises CameraError at the source's end."""

    async def frames(self) -> AsyncGenerator[SourceFrame, None]:
        """Open and give the newest picture each time, until the source ends. Raises CameraError."""
        await self.close()
        if self._thread is not None:  # another thread would hang in the same driver
            raise CameraError(f"{self._name}: the driver hangs; unplug the camera and plug it in again")
        thread = self._thread = _Thread(self, asyncio.get_running_loop())
        try:
            while (frame := await thread.next()) is not None:
                yield frame
        finally:
            thread.stopping.set()
        raise CameraError(f"{self._name}: {thread.problem or 'the source ended'}")

    async def close(self) -> None:
        """End the thread after the current read; one whose driver hangs is abandoned after 6 s."""
        if self._thread is not None and await self._thread.ended(self._close_s):
            self._thread = None


class _Thread:
    """One run of a source's ``capture``."""

    def __init__(self, source: ThreadedSource, loop: asyncio.AbstractEventLoop) -> None:
        self._source = source
        self._loop = loop
        self._news = asyncio.Event()
        self._over = asyncio.Event()
        self._frame: SourceFrame | None = None
        self.stopping = threading.Event()
        self.problem = ""
        self._thread = threading.Thread(target=self._run, name="camera-source", daemon=True)
        self._thread.start()

    async def next(self) -> SourceFrame | None:
        """Return the next picture, None after the last."""
        await self._news.wait()
        frame, self._frame = self._frame, None
        if not self._over.is_set():
            self._news.clear()
        return frame

    async def ended(self, timeout_s: float) -> bool:
        """Ask the thread to end and wait for it; return False when it does not."""
        self.stopping.set()
        try:
            async with asyncio.timeout(timeout_s):
                await self._over.wait()
        except TimeoutError:
            return False
        self._thread.join(timeout_s)  # this waits for its return only
        return True

    def _run(self) -> None:
        try:
            self._source.capture(self._give, self.stopping)
        except Exception as error:  # a driver's own kinds of errors: the camera is opened again
            self.problem = str(error) if isinstance(error, CameraError) else f"{type(error).__name__}: {error}"
        finally:
            with contextlib.suppress(RuntimeError):  # the loop has ended
                self._loop.call_soon_threadsafe(self._end)

    def _give(self, frame: SourceFrame) -> None:
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._put, frame)

    def _put(self, frame: SourceFrame) -> None:
        self._frame = frame
        self._news.set()

    def _end(self) -> None:
        self._over.set()
        self._news.set()


_QUALITY = 90
_FILE_RATE_HZ = 15.0


class OpenCvSource(ThreadedSource):
    """``file:///path``."""

    def __init__(self, url: str, clock: Callable[[], float]) -> None:
        super().__init__(url)
        self._path = Path(unquote(urlsplit(url).path))
        self._clock = clock

    def capture(self, give: Give, stopping: threading.Event) -> None:
        """Play the film once. Raises CameraError at its end."""
        if not self._path.exists():
            raise CameraError("there is no such file")
        film = cv2.VideoCapture(str(self._path), cv2.CAP_FFMPEG)
        try:
            if not film.isOpened():
                raise CameraError("cannot be opened; is it a film?")
            rate = film.get(cv2.CAP_PROP_FPS)
            period = 1.0 / (rate if 1 <= rate <= 240 else _FILE_RATE_HZ)
            while not stopping.is_set():
                started = time.monotonic()
                whole, picture = film.read()
                if not whole or picture is None:
                    raise CameraError("the file has ended")
                give(SourceFrame(encoded(np.asarray(picture, np.uint8)), self._clock()))
                stopping.wait(max(0.0, period - (time.monotonic() - started)))
        finally:
            film.release()


def encoded(picture: NDArray[np.uint8]) -> bytes:
    """Return a picture, (height, width, 3) BGR, as JPEG. Raises CameraError."""
    done, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    if not done:
        raise CameraError("a picture cannot be encoded")
    return bytes(data.tobytes())
