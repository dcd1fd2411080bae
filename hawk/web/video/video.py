"""Live pictures: ``/video`` (WebSocket, one frame in flight), ``/stream.mjpg`` and ``/snapshot.jpg``.

Frames are encoded once, elsewhere. A client receives the newest frame when it is ready for one, never an older one.
A slow link receives smaller pictures, so that they are fresh when they arrive (`hawk.web.video.viewers`).
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Iterator
from typing import Final

from aiohttp import WSCloseCode, WSMsgType, hdrs, web

from hawk.model.pictures import AnnotatedFrame
from hawk.runtime.supervision import until_first_ends
from hawk.web.access.access import OPEN, access_of
from hawk.web.door import WebConnection
from hawk.web.services import COUNTERS, SERVICES
from hawk.web.video import video_wire
from hawk.web.video.viewers import End, Viewer, Viewers
from hawk.web.ws import NOBODY, PING_INTERVAL_S, limit_buffers, places, registered

READ_LIMIT_BYTES: Final = 1024
VIEWERS: Final = web.AppKey("viewers", Viewers)
SNAPSHOT_AGE_S: Final = 1.0
"""Greatest age of a snapshot, seconds of the daemon's clock."""
_CLOSE_CODES: Final = {
    End.GONE: WSCloseCode.OK,
    End.OVERDUE: WSCloseCode.POLICY_VIOLATION,
    End.FAILED: WSCloseCode.INTERNAL_ERROR,
    End.STOPPED: WSCloseCode.GOING_AWAY,
}
PLAIN: Final = "plain"
"""Parameter of ``/video``: a message is a JPEG and nothing else, and the pong to a ping acknowledges it."""


async def video_socket(request: web.Request) -> web.StreamResponse:
    """Serve one client of ``/video``."""
    _refuse_crowd(request)
    is_plain = request.query.get(PLAIN) in ("1", "true")
    response = web.WebSocketResponse(
        heartbeat=PING_INTERVAL_S, autoping=not is_plain, max_msg_size=READ_LIMIT_BYTES, compress=False, timeout=1.0
    )
    with _counted(request.app):
        try:
            await response.prepare(request)
        except ConnectionError:  # it left before it was answered
            return response
        limit_buffers(request)
        with registered(request, response):
            if request.transport is not None:
                wire = video_wire.plain_socket_frame if is_plain else video_wire.socket_frame
                viewer = Viewer(request.transport, wire, is_closed=lambda: response.closed)
                await _serve_socket(request.app[VIEWERS], viewer, response)
    return response


async def _serve_socket(viewers: Viewers, viewer: Viewer, socket: web.WebSocketResponse) -> None:
    """Serve until the connection or the service ends."""

    async def end() -> None:
        why = await asyncio.shield(viewer.ended)
        await socket.close(code=_CLOSE_CODES[why], message=why.value.encode())

    connection = viewer.transport.get_protocol()
    if isinstance(connection, WebConnection) and viewer.wire is video_wire.socket_frame:
        connection.tap = video_wire.AckTap(lambda sequence: viewers.acknowledged(viewer, sequence))
    with viewers.watching(viewer):
        await until_first_ends(_read(viewers, viewer, socket), end())


async def _read(viewers: Viewers, viewer: Viewer, socket: web.WebSocketResponse) -> None:
    """Read acknowledgements: ``{"ack": sequence}``, of a plain client its pongs."""
    is_plain = viewer.wire is video_wire.plain_socket_frame
    async for message in socket:
        if message.type is WSMsgType.PING:
            await socket.pong(message.data)
        elif message.type is WSMsgType.PONG:
            viewers.acknowledged(viewer, video_wire.marked_sequence(message.data))
        elif message.type is WSMsgType.TEXT and not is_plain:
            viewers.acknowledged(viewer, video_wire.acknowledged_sequence(message.data))


async def stream(request: web.Request) -> web.StreamResponse:
    """Serve ``/stream.mjpg``: multipart/x-mixed-replace with X-Timestamp (daemon clock) in each part."""
    _refuse_crowd(request)
    response = web.StreamResponse(
        headers={hdrs.CONTENT_TYPE: f"multipart/x-mixed-replace; boundary={video_wire.BOUNDARY}"}
    )
    with _counted(request.app):
        await response.prepare(request)
        if request.method == hdrs.METH_HEAD or request.transport is None:
            return response
        limit_buffers(request)
        with contextlib.suppress(ConnectionError):
            await response.write(video_wire.opening())
            is_chunked = response.headers.get(hdrs.TRANSFER_ENCODING) == "chunked"
            viewer = Viewer(
                request.transport, video_wire.chunked_part if is_chunked else video_wire.part, is_acknowledged=False
            )
            kept = request.app[OPEN].kept(access_of(request) or NOBODY, lambda: _cut(request))
            with kept, request.app[VIEWERS].watching(viewer):
                why = await asyncio.shield(viewer.ended)
            if why in (End.OVERDUE, End.FAILED):
                _cut(request)  # a viewer that does not read keeps no place
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


def make_viewers(app: web.Application) -> Viewers:
    """Return the service of all viewers. It counts frames, and notes their age when they are handed to the network."""
    counters, services = app[COUNTERS], app[SERVICES]

    def handed_over(frame: AnnotatedFrame) -> None:
        counters.video_frames += 1
        counters.frame_latency_s = services.clock() - frame.captured

    return Viewers(services.video, handed_over)


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
