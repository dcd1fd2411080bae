"""Pictures of a film, through OpenCV, played at its own rate.

A film gives no capture time: the frame's time is its arrival, less the configured latency.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path
from urllib.parse import unquote, urlsplit

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.comm.cameras.sources.source import CameraError, SourceFrame, without_secrets
from hawk.comm.cameras.sources.threaded import Give, ThreadedSource

_QUALITY = 90
_FILE_RATE_HZ = 15.0


class OpenCvSource(ThreadedSource):
    """``file:///path``."""

    def __init__(self, url: str, clock: Callable[[], float]) -> None:
        super().__init__(without_secrets(url))
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
