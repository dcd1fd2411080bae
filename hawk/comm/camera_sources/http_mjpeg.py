"""Pictures over HTTP as MJPEG (``multipart/x-mixed-replace``): µStreamer, hawk-sim, the daemon's own stream."""

from __future__ import annotations

import math
from collections.abc import AsyncGenerator, Callable, Mapping

import aiohttp

from hawk.comm.camera_sources.multipart import BoundaryError, MultipartParser, Part, boundary_of
from hawk.comm.camera_sources.source import CameraError, SourceFrame, without_secrets

_SILENCE_S = 3.0
"""Real seconds without a byte after which the connection is given up."""
_READ = 1 << 16


class HttpMjpegSource:
    """One HTTP stream. ``X-Timestamp`` of a part (seconds of the sender's clock) becomes the frame's stamp."""

    def __init__(
        self,
        url: str,
        clock: Callable[[], float],
        headers: Mapping[str, str] | None = None,
        silence_s: float = _SILENCE_S,
    ) -> None:
        self._url = url
        self._clock = clock
        self._headers = dict(headers or {})
        self._timeout = aiohttp.ClientTimeout(total=None, sock_connect=silence_s, sock_read=silence_s)
        self._torn = 0

    @property
    def torn(self) -> int:
        """Pictures that came in pieces and were dropped."""
        return self._torn

    async def frames(self) -> AsyncGenerator[SourceFrame, None]:
        """Connect and give the pictures until the stream ends. Raises CameraError."""
        shown = without_secrets(self._url)
        try:
            async with (
                aiohttp.ClientSession(timeout=self._timeout, read_bufsize=_READ) as session,
                session.get(self._url, headers=self._headers) as response,
            ):
                parser = self._parser(response, shown)
                async for chunk in response.content.iter_any():
                    before = parser.torn
                    parts = parser.feed(chunk, self._clock())
                    self._torn += parser.torn - before
                    for part in parts:
                        yield SourceFrame(part.body, part.arrival, _stamp(part))
        except TimeoutError as error:
            raise CameraError(f"{shown}: nothing came for {self._timeout.sock_read:.0f} s") from error
        except (aiohttp.ClientError, OSError, ValueError) as error:
            raise CameraError(f"{shown}: {error or type(error).__name__}") from error
        raise CameraError(f"{shown}: the stream ended")

    async def close(self) -> None:
        """Nothing outlives `frames`."""

    @staticmethod
    def _parser(response: aiohttp.ClientResponse, shown: str) -> MultipartParser:
        if response.status != 200:
            raise CameraError(f"{shown}: answers {response.status} {response.reason}")
        try:
            return MultipartParser(boundary_of(response.headers.get("Content-Type", "")))
        except BoundaryError as error:
            raise CameraError(f"{shown}: not an MJPEG stream ({error}); name the address of the stream") from error


def _stamp(part: Part) -> float | None:
    try:
        stamp = float(part.headers["x-timestamp"])
    except (KeyError, ValueError):
        return None
    return stamp if math.isfinite(stamp) else None
