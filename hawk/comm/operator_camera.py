"""Operator Camera (specification, section 8): the drone's annotated pictures for a Python program of the operator.

A plain, synchronous face: a loop on a thread of its own reads the daemon's MJPEG stream and connects again when it
breaks.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import threading
import time
from contextlib import aclosing

import numpy as np
from numpy.typing import NDArray

from hawk.comm.camera_sources.http_mjpeg import HttpMjpegSource
from hawk.comm.camera_sources.source import CameraError
from hawk.comm.image import NoImage, decode

_LOG = logging.getLogger(__name__)

STALE_S = 3.0
"""Seconds after which a picture is too old to be shown as the present one."""
_RECONNECT_S = 1.0
_CLOSE_S = 5.0


class OperatorCamera:
    """Reads ``http://HOST:PORT/stream.mjpg``; ``token`` is the daemon's, where it has one."""

    def __init__(
        self, host: str, port: int, token: str | None = None, *, tls: bool = False, reconnect_s: float = _RECONNECT_S
    ) -> None:
        if not 0 < port < 65536:
            raise ValueError(f"port must be 1 to 65535, not {port}")
        name = f"[{host}]" if ":" in host else host
        self._url = f"{'https' if tls else 'http'}://{name}:{port}/stream.mjpg"
        self._headers = {"Authorization": f"Bearer {token}"} if token else {}
        self._reconnect_s = reconnect_s
        self._lock = threading.Condition()
        self._jpeg: bytes | None = None
        self._arrived = 0.0
        self._problem = "no picture yet"
        self._started = threading.Event()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._task: asyncio.Task[None] | None = None
        self._thread: threading.Thread | None = None

    def init(self) -> None:
        """Start the thread that reads the stream. Does nothing when it runs already."""
        if self._thread is None:
            self._started.clear()
            self._thread = threading.Thread(target=self._run, name="operator-camera", daemon=True)
            self._thread.start()

    def get_image(self) -> NDArray[np.uint8]:
        """Return the latest picture, (height, width, 3) BGR. Raises NoImage when there is none of the last seconds."""
        with self._lock:
            data, age, problem = self._jpeg, time.monotonic() - self._arrived, self._problem
        if data is None or age > STALE_S:
            raise NoImage(f"{self._url}: {problem}")
        return decode(data)

    def wait_image(self, timeout_s: float) -> NDArray[np.uint8]:
        """Wait for the next picture and return it. Raises NoImage when none came in time."""
        with self._lock:
            before = self._jpeg
            if not self._lock.wait_for(lambda: self._jpeg is not before, timeout_s):
                raise NoImage(f"{self._url}: {self._problem}")
        return self.get_image()

    def close(self) -> None:
        """End the thread. Idempotent."""
        thread, self._thread = self._thread, None
        if thread is None:
            return
        self._started.wait(_CLOSE_S)
        loop, task = self._loop, self._task
        if loop is not None and task is not None:
            with contextlib.suppress(RuntimeError):  # it has ended
                loop.call_soon_threadsafe(task.cancel)
        thread.join(_CLOSE_S)

    def _run(self) -> None:
        with contextlib.suppress(asyncio.CancelledError):
            asyncio.run(self._receive())

    async def _receive(self) -> None:
        self._loop, self._task = asyncio.get_running_loop(), asyncio.current_task()
        self._started.set()
        source = HttpMjpegSource(self._url, time.monotonic, self._headers)
        while True:
            try:
                async with aclosing(source.frames()) as frames:
                    async for frame in frames:
                        self._take(frame.jpeg)
            except CameraError as error:
                self._tell(str(error))
            await asyncio.sleep(self._reconnect_s)

    def _take(self, data: bytes) -> None:
        with self._lock:
            self._jpeg, self._arrived, self._problem = data, time.monotonic(), "the picture is too old"
            self._lock.notify_all()

    def _tell(self, problem: str) -> None:
        with self._lock:
            if problem != self._problem:
                _LOG.warning("%s; trying again", problem)
            self._problem = problem
