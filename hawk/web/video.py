"""Live pictures: ``/video`` (WebSocket, one frame in flight), ``/stream.mjpg`` and ``/snapshot.jpg``.

Frames are encoded once, elsewhere. A client receives the newest frame when it is ready for one, never an older one.
A slow link receives small pictures, so that they are fresh when they arrive.
"""

from __future__ import annotations

import asyncio
import contextlib
import fcntl
import json
import struct
import sys
import termios
from collections.abc import Iterator
from typing import Final

from aiohttp import WSCloseCode, WSMsgType, hdrs, web

from hawk.model import AnnotatedFrame
from hawk.supervision import until_first_ends
from hawk.web.access import OPEN, access_of
from hawk.web.services import COUNTERS, SERVICES, WebServices
from hawk.web.small_frames import LinkPace, SmallFrames
from hawk.web.ws import NOBODY, PING_INTERVAL_S, limit_buffers, places, registered

HEADER: Final = struct.Struct("<4sIdI")
"""Magic, sequence (mod 2**32), capture time (seconds of the daemon's clock), flags (0). Little-endian, 20 bytes."""
MAGIC: Final = b"HWK1"
ACK_TIMEOUT_S: Final = 10.0
"""Real seconds after which a client that does not acknowledge its frame, or does not read it, is disconnected."""
READ_LIMIT_BYTES: Final = 1024
BOUNDARY: Final = "hawkframe"
LEFT_POLL_S: Final = 0.01
"""Real seconds between two looks at whether a picture has left."""
SMALL_FRAMES: Final = web.AppKey("small_frames", SmallFrames)
SNAPSHOT_AGE_S: Final = 1.0
"""Greatest age of a snapshot, seconds of the daemon's clock."""


def pack(frame: AnnotatedFrame) -> bytes:
    """Return a frame as it goes over ``/video``."""
    return HEADER.pack(MAGIC, frame.sequence & 0xFFFFFFFF, frame.captured, 0) + frame.jpeg


async def video_socket(request: web.Request) -> web.StreamResponse:
    """Serve one client of ``/video``."""
    services = request.app[SERVICES]
    _refuse_crowd(request)
    response = web.WebSocketResponse(
        heartbeat=PING_INTERVAL_S, max_msg_size=READ_LIMIT_BYTES, compress=False, timeout=1.0
    )
    with _counted(request.app):
        await response.prepare(request)
        limit_buffers(request)
        with registered(request, response):
            connection = VideoConnection(services, response, request.app)
            await connection.run()
    return response


class VideoConnection:
    """Sends the newest frame, waits for its acknowledgement, sends the next newest."""

    def __init__(self, services: WebServices, response: web.WebSocketResponse, app: web.Application) -> None:
        self._services = services
        self._socket = response
        self._app = app
        self._pace = LinkPace()
        self._in_flight: int | None = None
        self._acknowledged = asyncio.Event()

    async def run(self) -> None:
        """Serve until the connection ends."""
        await until_first_ends(self._read(), self._write())

    async def _read(self) -> None:
        async for message in self._socket:
            if message.type is WSMsgType.TEXT and self._in_flight == _acknowledged_sequence(message.data):
                self._in_flight = None
                self._acknowledged.set()

    async def _write(self) -> None:
        sent: AnnotatedFrame | None = None
        loop = asyncio.get_running_loop()
        try:
            while True:
                sent = await newer_frame(self._services, sent)
                fitting = await fitting_frame(self._app, sent, self._pace)
                self._acknowledged.clear()
                self._in_flight = sent.sequence & 0xFFFFFFFF
                begun = loop.time()
                async with asyncio.timeout(ACK_TIMEOUT_S):
                    await self._socket.send_bytes(pack(fitting))
                    count_frame(self._app, sent)
                    await self._acknowledged.wait()
                self._pace.arrived(loop.time(), loop.time() - begun, len(sent.jpeg) / len(fitting.jpeg))
        except TimeoutError:
            await self._socket.close(code=WSCloseCode.POLICY_VIOLATION, message=b"frame not acknowledged")
        except ConnectionError:
            pass  # the reader sees the end too


async def stream(request: web.Request) -> web.StreamResponse:
    """Serve ``/stream.mjpg``: multipart/x-mixed-replace with X-Timestamp (daemon clock) in each part."""
    services = request.app[SERVICES]
    _refuse_crowd(request)
    response = web.StreamResponse(headers={hdrs.CONTENT_TYPE: f"multipart/x-mixed-replace; boundary={BOUNDARY}"})
    with _counted(request.app):
        await response.prepare(request)
        limit_buffers(request)
        sent: AnnotatedFrame | None = None
        pace, loop = LinkPace(is_acknowledged=False), asyncio.get_running_loop()
        try:
            with request.app[OPEN].kept(access_of(request) or NOBODY, lambda: _cut(request)):
                while True:
                    sent = await newer_frame(services, sent)
                    fitting = await fitting_frame(request.app, sent, pace)
                    begun = loop.time()
                    async with asyncio.timeout(ACK_TIMEOUT_S):
                        await response.write(part(fitting))
                        count_frame(request.app, sent)
                        await has_left(request)
                    pace.arrived(loop.time(), loop.time() - begun, len(sent.jpeg) / len(fitting.jpeg))
        except TimeoutError:  # a viewer that does not read keeps no place
            _cut(request)
        except ConnectionError:
            pass
    return response


def _cut(request: web.Request) -> None:
    if request.transport is not None:
        request.transport.abort()


async def snapshot(request: web.Request) -> web.StreamResponse:
    """Serve the newest picture, 503 when it is missing or old."""
    video = request.app[SERVICES].video
    frame = video.value
    if frame is None or video.age > SNAPSHOT_AGE_S:
        raise web.HTTPServiceUnavailable(text="There is no live picture: the camera or vision is away.")
    return web.Response(body=frame.jpeg, content_type="image/jpeg", headers={"X-Timestamp": f"{frame.captured:.6f}"})


def part(frame: AnnotatedFrame) -> bytes:
    """Return one part of the multipart stream, ending in the boundary, so that a reader need not wait for the next."""
    head = (
        f"--{BOUNDARY}\r\nContent-Type: image/jpeg\r\nContent-Length: {len(frame.jpeg)}\r\n"
        f"X-Timestamp: {frame.captured:.6f}\r\n\r\n"
    )
    return head.encode("ascii") + frame.jpeg + b"\r\n"


async def newer_frame(services: WebServices, sent: AnnotatedFrame | None) -> AnnotatedFrame:
    """Return the newest frame if it differs from ``sent``, else wait for the next."""
    newest = services.video.value
    if newest is not None and newest is not sent:
        return newest
    return await services.video.next()


async def fitting_frame(app: web.Application, frame: AnnotatedFrame, pace: LinkPace) -> AnnotatedFrame:
    """Return the frame as this client's link takes it: whole or small."""
    return frame if pace.takes_whole else await app[SMALL_FRAMES].of(frame)


async def has_left(request: web.Request) -> None:
    """Wait until everything that was written has reached the other side.

    This stream has no acknowledgement of its own. Without this wait the buffers hold seconds of video on a slow link.
    What the other side's own buffer holds is not seen from here.
    """
    transport = request.transport
    found = None if transport is None else transport.get_extra_info("socket")
    while transport is not None and not transport.is_closing():
        if transport.get_write_buffer_size() == 0 and (found is None or unacknowledged(found.fileno()) == 0):
            return
        await asyncio.sleep(LEFT_POLL_S)


def unacknowledged(descriptor: int) -> int:
    """Return the bytes in a TCP socket that the other side has not acknowledged; 0 where the system does not say."""
    try:
        return int.from_bytes(fcntl.ioctl(descriptor, termios.TIOCOUTQ, bytes(4)), sys.byteorder)
    except OSError:
        return 0


def count_frame(app: web.Application, frame: AnnotatedFrame) -> None:
    """Count a frame, and note its age when it was handed to the network."""
    counters = app[COUNTERS]
    counters.video_frames += 1
    counters.frame_latency_s = app[SERVICES].clock() - frame.captured


@contextlib.contextmanager
def _counted(app: web.Application) -> Iterator[None]:
    app[COUNTERS].video_clients += 1
    try:
        yield
    finally:
        app[COUNTERS].video_clients -= 1


def _refuse_crowd(request: web.Request) -> None:
    limit = request.app[SERVICES].web.maximum_clients
    if request.app[COUNTERS].video_clients >= places(request):
        raise web.HTTPServiceUnavailable(text=f"{limit} viewers are watching already (web.maximum_clients)")


def _acknowledged_sequence(text: str) -> int | None:
    try:
        found = json.loads(text)["ack"]
    except (ValueError, KeyError, TypeError, RecursionError):
        return None
    return found if isinstance(found, int) and not isinstance(found, bool) else None
