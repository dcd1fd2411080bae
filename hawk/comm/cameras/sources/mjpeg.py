"""Pictures as MJPEG (``multipart/x-mixed-replace``): the parser, and the source over HTTP.

µStreamer, hawk-sim and the daemon's own stream send it; GStreamer pipelines are read by the same parser.
"""

from __future__ import annotations

import math
import re
import ssl
from collections.abc import AsyncGenerator, Callable, Mapping
from dataclasses import dataclass, field

import aiohttp

from hawk.comm.cameras.sources.source import CameraError, CameraSource, SourceFrame
from hawk.config.secrets import SecretUrl, shown_address, without
from hawk.formats.image import whole_jpeg

MAX_PART = 8_000_000
"""Bytes of the largest accepted picture."""
_MAX_HEADERS = 8192
_HEAD = re.compile(rb"[^\n]*\n((?:[^\r\n][^\n]*\n)*)\r?\n")
"""The rest of the boundary's line, header lines, an empty line."""
_LINE_END = b"\r\n"
_SILENCE_S = 3.0
"""Real seconds without a byte after which the connection is given up."""
_READ = 1 << 16


class BoundaryError(ValueError):
    """The Content-Type names no boundary."""


@dataclass(frozen=True, slots=True)
class MultipartPicture:
    """One picture. ``headers`` in lower case; ``arrival``: the time at which its first bytes were fed."""

    headers: Mapping[str, str]
    body: bytes = field(repr=False)
    arrival: float


def boundary_of(content_type: str) -> bytes:
    """Return the boundary of a Content-Type, without its dashes. Raises BoundaryError."""
    found = re.search(r'boundary\s*=\s*(?:"([^"]+)"|([^\s;]+))', content_type, re.IGNORECASE)
    name = (found.group(1) or found.group(2)) if found else ""
    name = name.removeprefix("--")
    if not name:
        raise BoundaryError(f"Content-Type {content_type!r} names no boundary")
    return name.encode("latin-1")


class MultipartParser:
    """Parses ``multipart/x-mixed-replace``: feed it bytes, it returns whole pictures.

    A part ends after its Content-Length, else at the next boundary; what follows the JPEG in it is left out. A part
    that is not a whole JPEG, is too large or has a wrong length is dropped and counted in ``torn``; parsing goes on at
    the next boundary.
    """

    def __init__(self, boundary: bytes, max_part: int = MAX_PART) -> None:
        self._mark = b"--" + boundary
        self._max = max_part
        self._buffer = bytearray()
        self._arrival: float | None = None
        self._headers: dict[str, str] | None = None  # of the part whose body is read
        self._length = 0  # of that body; 0: up to the next boundary
        self._scanned = 0
        self.torn = 0

    def feed(self, data: bytes, now: float) -> list[MultipartPicture]:
        """Return the pictures that these bytes complete. ``now``: seconds, for their arrival."""
        self._buffer += data
        pictures: list[MultipartPicture] = []
        while self._read_head(now) if self._headers is None else self._read_body(pictures):
            pass
        return pictures

    def _read_head(self, now: float) -> bool:
        """Read up to the end of a part's headers; return False when more bytes are needed."""
        start = self._buffer.find(self._mark)
        if start < 0:
            del self._buffer[: max(0, len(self._buffer) - len(self._mark))]
            return False
        del self._buffer[:start]
        if self._arrival is None and len(self._buffer) > len(self._mark) + len(_LINE_END):
            self._arrival = now  # a boundary alone may have ended the part before: nothing of this one is there yet
        end = len(self._mark) + _MAX_HEADERS
        head = _HEAD.match(self._buffer, len(self._mark), end)
        if head is None:
            if len(self._buffer) <= end:
                return False
            self._lose(len(self._mark))
            return True
        self._arrival = now if self._arrival is None else self._arrival
        headers = _headers(head[1])
        del self._buffer[: head.end()]
        text = headers.get("content-length", "")
        self._length = int(text[:12]) if text.isdecimal() else 0
        self._scanned = 0
        if self._length > self._max:
            self._lose(0)
        else:
            self._headers = headers
        return True

    def _read_body(self, pictures: list[MultipartPicture]) -> bool:
        """Read up to the end of a part's body; return False when more bytes are needed."""
        end = self._length or self._buffer.find(self._mark, self._scanned)
        if end < 0 or end > len(self._buffer):
            self._scanned = max(0, len(self._buffer) - len(self._mark))
            if len(self._buffer) > self._max:
                self._lose(self._scanned)
            return False
        body = bytes(self._buffer[:end])
        if not self._length:
            body = body.removesuffix(b"\n").removesuffix(b"\r")
        jpeg = whole_jpeg(body)
        if jpeg is not None:
            pictures.append(MultipartPicture(self._headers or {}, jpeg, self._arrival or 0.0))
            del self._buffer[: len(jpeg)]  # the length may be wrong: the next boundary may be before the part's end
            self._headers = self._arrival = None
        else:
            self._lose(0)  # the length may be wrong: the next boundary may be inside
        return True

    def _lose(self, skip: int) -> None:
        self.torn += 1
        del self._buffer[:skip]
        self._headers = self._arrival = None


class HttpMjpegSource(CameraSource):
    """One HTTP stream. ``X-Timestamp`` of a part (seconds of the sender's clock) becomes the frame's stamp."""

    def __init__(
        self,
        url: str,
        clock: Callable[[], float],
        headers: Mapping[str, str] | None = None,
        silence_s: float = _SILENCE_S,
        tls: ssl.SSLContext | None = None,
    ) -> None:
        """``tls``: certificates that are trusted for HTTPS; None: those of the system."""
        self._url = url
        self._secrets = tuple(SecretUrl(url).secrets())
        self._clock = clock
        self._headers = dict(headers or {})
        self._tls = tls
        self._timeout = aiohttp.ClientTimeout(total=None, sock_connect=silence_s, sock_read=silence_s)

    async def frames(self) -> AsyncGenerator[SourceFrame, None]:
        """Connect and give the pictures until the stream ends. Raises CameraError."""
        shown, torn_before = shown_address(self._url), self.torn
        try:
            async with (
                aiohttp.ClientSession(timeout=self._timeout, read_bufsize=_READ) as session,
                session.get(self._url, headers=self._headers, ssl=self._tls or True) as response,
            ):
                try:
                    parser = self._parser(response, shown)
                    async for chunk in response.content.iter_any():
                        parts = parser.feed(chunk, self._clock())
                        self.torn = torn_before + parser.torn
                        for part in parts:
                            yield SourceFrame(part.body, part.arrival, _stamp(part))
                finally:
                    _drop(response)
        except TimeoutError as error:
            raise CameraError(f"{shown}: nothing came for {self._timeout.sock_read:.0f} s") from error
        except (aiohttp.ClientError, OSError, ValueError) as error:
            raise CameraError(f"{shown}: {without(str(error), self._secrets) or type(error).__name__}") from error
        raise CameraError(f"{shown}: the stream ended")

    @staticmethod
    def _parser(response: aiohttp.ClientResponse, shown: str) -> MultipartParser:
        if response.status != 200:
            raise CameraError(f"{shown}: answers {response.status} {response.reason}")
        try:
            return MultipartParser(boundary_of(response.headers.get("Content-Type", "")))
        except BoundaryError as error:
            raise CameraError(f"{shown}: not an MJPEG stream ({error}); name the address of the stream") from error


def _drop(response: aiohttp.ClientResponse) -> None:
    """End the connection at once: TLS would wait for the server's farewell, which never comes in a stream."""
    connection = response.connection
    if connection is not None and connection.transport is not None:
        connection.transport.abort()


def _stamp(part: MultipartPicture) -> float | None:
    try:
        stamp = float(part.headers["x-timestamp"])
    except (KeyError, ValueError):
        return None
    return stamp if math.isfinite(stamp) else None


def _headers(head: bytes) -> dict[str, str]:
    headers = {}
    for line in head.decode("latin-1").splitlines():
        name, colon, value = line.partition(":")
        if colon:
            headers[name.strip().lower()] = value.strip()
    return headers
