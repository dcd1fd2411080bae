"""Pictures through OpenCV: USB and V4L2 cameras, RTSP, video files. Each source has a thread of its own.

OpenCV gives no capture time: the frame's time is its arrival, less the configured latency.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
import time
from collections.abc import AsyncGenerator, Callable
from pathlib import Path
from urllib.parse import unquote, urlsplit

import cv2

from hawk.comm.camera_sources.source import CameraError, CameraSource, SourceFrame, without_secrets

_QUALITY = 90
_FILE_RATE_HZ = 15.0
_OPEN_TIMEOUT_MS = 5000
_FAILURES = 30
_CLOSE_S = 6.0


class OpenCvSource(CameraSource):
    """``v4l2:///dev/video0``, ``rtsp://...`` or ``file:///path`` (played at its own rate); torn ones are hidden."""

    def __init__(self, url: str, clock: Callable[[], float]) -> None:
        self._url = url
        self._clock = clock
        self._reader: _Reader | None = None

    async def frames(self) -> AsyncGenerator[SourceFrame, None]:
        """Open and give the newest picture each time, until the source ends. Raises CameraError."""
        await self.close()
        reader = _Reader(self._url, self._clock, asyncio.get_running_loop())
        self._reader = reader
        try:
            while (frame := await reader.next()) is not None:
                yield frame
        finally:
            reader.stop()
        raise CameraError(reader.problem or f"{without_secrets(self._url)}: the source ended")

    async def close(self) -> None:
        """End the thread after the current read."""
        reader, self._reader = self._reader, None
        if reader is not None:
            await reader.ended()


class _Reader:
    """The thread that opens, reads and encodes; keeps the newest picture only."""

    def __init__(self, url: str, clock: Callable[[], float], loop: asyncio.AbstractEventLoop) -> None:
        self._url = url
        self._shown = without_secrets(url)
        self._clock = clock
        self._loop = loop
        self._stop = threading.Event()
        self._news = asyncio.Event()
        self._over = asyncio.Event()
        self._frame: SourceFrame | None = None
        self.problem = ""
        self._thread = threading.Thread(target=self._run, name="camera-opencv", daemon=True)
        self._thread.start()

    async def next(self) -> SourceFrame | None:
        """Return the next picture, None after the last."""
        await self._news.wait()
        frame, self._frame = self._frame, None
        if not self._over.is_set():
            self._news.clear()
        return frame

    def stop(self) -> None:
        """Ask the thread to end."""
        self._stop.set()

    async def ended(self) -> None:
        """Ask the thread to end and wait for it; a hanging driver is abandoned after 6 s."""
        self.stop()
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(self._over.wait(), _CLOSE_S)
            self._thread.join(_CLOSE_S)  # this waits for its return only

    def _run(self) -> None:
        try:
            self._read()
        except cv2.error as error:
            self.problem = f"{self._shown}: OpenCV: {error}"
        finally:
            with contextlib.suppress(RuntimeError):  # the loop has ended
                self._loop.call_soon_threadsafe(self._end)

    def _read(self) -> None:
        self.problem = _missing(self._url)
        if self.problem:
            return
        capture = _open(self._url)
        try:
            if not capture.isOpened():
                self.problem = f"{self._shown}: cannot be opened; is the device or address right and free?"
                return
            period = _file_period(self._url, capture)
            failures = 0
            while not self._stop.is_set() and failures < _FAILURES:
                started = time.monotonic()
                whole, picture = capture.read()
                arrival = self._clock()
                if not whole or picture is None:
                    if period:
                        self.problem = f"{self._shown}: the file has ended"
                        return
                    failures += 1
                    self._stop.wait(0.02)
                    continue
                failures = 0
                encoded, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
                if encoded:
                    self._loop.call_soon_threadsafe(self._give, SourceFrame(data.tobytes(), arrival))
                if period:
                    self._stop.wait(max(0.0, period - (time.monotonic() - started)))
            if failures:
                self.problem = f"{self._shown}: no picture could be read"
        finally:
            capture.release()

    def _give(self, frame: SourceFrame) -> None:
        self._frame = frame
        self._news.set()

    def _end(self) -> None:
        self._over.set()
        self._news.set()


def _missing(url: str) -> str:
    """Name a device or file that does not exist (OpenCV reports a failure only); empty when it exists."""
    parts = urlsplit(url)
    if parts.scheme not in {"v4l2", "file"}:
        return ""
    path = Path(unquote(parts.path))
    if path.exists():
        return ""
    kind = "device (is the camera plugged in?)" if parts.scheme == "v4l2" else "file"
    return f"{without_secrets(url)}: there is no such {kind}"


def _open(url: str) -> cv2.VideoCapture:
    parts = urlsplit(url)
    if parts.scheme == "v4l2":
        return cv2.VideoCapture(unquote(parts.path), cv2.CAP_V4L2)
    if parts.scheme == "file":
        return cv2.VideoCapture(unquote(parts.path), cv2.CAP_FFMPEG)
    timeouts = [cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, _OPEN_TIMEOUT_MS, cv2.CAP_PROP_READ_TIMEOUT_MSEC, _OPEN_TIMEOUT_MS]
    return cv2.VideoCapture(url, cv2.CAP_FFMPEG, timeouts)


def _file_period(url: str, capture: cv2.VideoCapture) -> float:
    """Return the seconds between two pictures of a file, 0 for a live source."""
    if not url.startswith("file:"):
        return 0.0
    rate = capture.get(cv2.CAP_PROP_FPS)
    return 1.0 / rate if 1 <= rate <= 240 else 1.0 / _FILE_RATE_HZ
