"""Operator Camera (specification, section 8): the drone's annotated pictures for a Python program of the operator.

A plain, synchronous face: a loop on a thread of its own reads the daemon's MJPEG stream and connects again when it
breaks.
"""

from __future__ import annotations

import asyncio
import logging
import ssl
import threading
import time
from collections.abc import Callable
from contextlib import aclosing

import numpy as np
from numpy.typing import NDArray

from hawk.comm.cameras.sources.mjpeg import HttpMjpegSource
from hawk.comm.cameras.sources.source import CameraError
from hawk.formats.image import NoImage, decode
from hawk.specification.loop_thread import LoopThread

_LOG = logging.getLogger(__name__)

STALE_S = 3.0
"""Real seconds after which a picture is too old to be shown as the present one."""


class OperatorCamera:
    """Reads ``http://HOST:PORT/stream.mjpg``, or the same by HTTPS."""

    def __init__(
        self,
        host: str,
        port: int,
        token: str | None = None,
        *,
        tls: ssl.SSLContext | None = None,
        reconnect_s: float = 1.0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Keep the address; nothing is opened before `init`.

        Args:
            host: The drone's address.
            port: TCP port.
            token: The daemon's, where it has one.
            tls: Certificates that are trusted, for a daemon with HTTPS (`ssl.create_default_context`, with ``cafile``
                for a self-signed one); None: HTTP.
            reconnect_s: Real seconds between attempts to connect.
            clock: Real seconds.

        Raises:
            ValueError: The port is not 1 to 65535.
        """
        if not 0 < port < 65536:
            raise ValueError(f"port must be 1 to 65535, not {port}")
        name = f"[{host}]" if ":" in host else host
        self._url = f"{'http' if tls is None else 'https'}://{name}:{port}/stream.mjpg"
        self._tls = tls
        self._headers = {"Authorization": f"Bearer {token}"} if token else {}
        self._reconnect_s = reconnect_s
        self._clock = clock
        self._lock = threading.Lock()
        self._jpeg: bytes | None = None
        self._arrived = 0.0
        self._problem = "no picture yet"
        self._thread: LoopThread | None = None

    def init(self) -> None:
        """Start the thread that reads the stream. Does nothing when it runs already."""
        if self._thread is None:
            self._thread = LoopThread("operator-camera")
            self._thread.begin(self._receive())

    def get_image(self) -> NDArray[np.uint8]:
        """Return the latest picture, (height, width, 3) BGR. Raises NoImage when the last seconds brought none."""
        with self._lock:
            data, age, problem = self._jpeg, self._clock() - self._arrived, self._problem
        if data is None or age > STALE_S:
            raise NoImage(f"{self._url}: {problem}")
        return decode(data)

    def close(self) -> None:
        """End the thread. Closing twice is no error."""
        thread, self._thread = self._thread, None
        if thread is not None:
            thread.stop()

    async def _receive(self) -> None:
        source = HttpMjpegSource(self._url, self._clock, self._headers, tls=self._tls)
        while True:
            try:
                async with aclosing(source.frames()) as frames:
                    async for frame in frames:
                        self._take(frame.jpeg)
            except CameraError as error:
                self._report(str(error))
            await asyncio.sleep(self._reconnect_s)

    def _take(self, data: bytes) -> None:
        with self._lock:
            self._jpeg, self._arrived, self._problem = data, self._clock(), "the picture is too old"

    def _report(self, problem: str) -> None:
        with self._lock:
            if problem != self._problem:
                _LOG.warning("%s; trying again", problem)
            self._problem = problem
