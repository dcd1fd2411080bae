from __future__ import annotations

import asyncio
import struct

import aiohttp
import pytest

from hawk.config.sections import WebSettings
from hawk.model.pictures import AnnotatedFrame
from hawk.web.services import COUNTERS
from hawk.web.video import viewers
from hawk.web.video.video_wire import HEADER, socket_frame
from tests.unit.web.rig import PATIENCE_S, Rig, browser


def frame(number: int, captured: float = 1.5) -> AnnotatedFrame:
    return AnnotatedFrame(number, captured, b"\xff\xd8" + bytes([number % 256]) + b"\xff\xd9")


async def read(socket: aiohttp.ClientWebSocketResponse) -> tuple[int, float, bytes]:
    async with asyncio.timeout(PATIENCE_S):
        data = await socket.receive_bytes()
    magic, sequence, captured, flags = struct.unpack("<4sIdI", data[:20])
    assert (magic, flags) == (b"HWK1", 0)
    return sequence, captured, data[20:]


async def quiet(socket: aiohttp.ClientWebSocketResponse, rig: Rig) -> None:
    """Assert that nothing comes: a second viewer has been served in the meantime."""
    assert rig.server is not None
    async with browser() as session, session.ws_connect(rig.server.make_url("/video")) as other:
        await read(other)
    with pytest.raises(TimeoutError):
        async with asyncio.timeout(0.02):
            await socket.receive()


def test_the_header_is_20_bytes_and_the_sequence_wraps() -> None:
    assert HEADER.size == 20
    packed = socket_frame(AnnotatedFrame(2**32 + 7, 0.25, b"jpeg"))
    assert packed == b"\x82\x18HWK1" + struct.pack("<IdI", 7, 0.25, 0) + b"jpeg"


async def test_one_frame_in_flight_and_the_newest_after_it(rig: Rig) -> None:
    server = await rig.start()
    async with browser() as session, session.ws_connect(server.make_url("/video")) as socket:
        rig.video.publish(frame(1, 10.25))
        assert await read(socket) == (1, 10.25, frame(1).jpeg)
        for number in (2, 3, 4):
            rig.video.publish(frame(number))
        await quiet(socket, rig)
        await socket.send_str('{"ack": 1}')
        assert (await read(socket))[0] == 4
        await socket.send_str('{"ack": 4}')
        await quiet(socket, rig)  # 4 is not sent twice
        rig.video.publish(frame(5))
        assert (await read(socket))[0] == 5


@pytest.mark.parametrize(
    "word",
    [
        "x",
        '{"ack":01}x',
        '{"ack":-1}',
        '{"ack":99999999999999999999}',
        "{}",
        "[]",
        '{"ack": "1"}',
        '{"ack": true}',
        '{"ack": 2}',
        "[" * 900,
        "null",
    ],
)
async def test_a_wrong_acknowledgement_frees_nothing_and_ends_nothing(rig: Rig, word: str) -> None:
    server = await rig.start()
    async with browser() as session, session.ws_connect(server.make_url("/video")) as socket:
        rig.video.publish(frame(1))
        await read(socket)
        await socket.send_str(word)
        rig.video.publish(frame(2))
        await quiet(socket, rig)
        await socket.send_str('{"ack": 1}')
        assert (await read(socket))[0] == 2


async def test_a_viewer_that_never_acknowledges_costs_another_nothing(rig: Rig) -> None:
    server = await rig.start()
    async with browser() as session, session.ws_connect(server.make_url("/video")) as stuck:
        async with session.ws_connect(server.make_url("/video")) as socket:
            for number in range(1, 30):
                rig.video.publish(frame(number))
                assert (await read(socket))[0] == number
                await socket.send_str(f'{{"ack": {number}}}')
        assert (await read(stuck))[0] == 1


async def test_a_viewer_that_comes_late_sees_the_newest_frame_at_once(rig: Rig) -> None:
    server = await rig.start()
    rig.video.publish(frame(9))
    async with browser() as session, session.ws_connect(server.make_url("/video")) as socket:
        assert (await read(socket))[0] == 9


async def test_viewers_are_limited_and_make_room_when_they_go(rig: Rig) -> None:
    rig.web = WebSettings(maximum_clients=1)
    server = await rig.start()
    async with browser() as session:
        async with session.ws_connect(server.make_url("/video")):
            async with session.get(server.make_url("/stream.mjpg")) as response:
                assert response.status == 503
            with pytest.raises(aiohttp.WSServerHandshakeError):
                await session.ws_connect(server.make_url("/video"))
        rig.video.publish(frame(1))
        async with session.ws_connect(server.make_url("/video")) as socket:
            await read(socket)


async def test_the_stream_is_multipart_with_capture_times(rig: Rig) -> None:
    server = await rig.start()
    rig.video.publish(frame(1, 12.5))
    async with browser() as session, session.get(server.make_url("/stream.mjpg")) as response:
        assert response.content_type == "multipart/x-mixed-replace"
        reader = aiohttp.MultipartReader.from_response(response).stream
        for number, captured in ((1, 12.5), (2, 12.75)):
            async with asyncio.timeout(PATIENCE_S):
                part = await reader.next()
                assert isinstance(part, aiohttp.BodyPartReader)
                assert part.headers["Content-Type"] == "image/jpeg"
                assert float(part.headers["X-Timestamp"]) == captured
                length = int(part.headers["Content-Length"])
                assert await part.read_chunk(length) == frame(number).jpeg
            rig.video.publish(frame(number + 1, captured + 0.25))


async def test_a_snapshot_is_of_now_or_not_at_all(rig: Rig) -> None:
    server = await rig.start()
    async with browser() as session:
        async with session.get(server.make_url("/snapshot.jpg")) as response:
            assert response.status == 503
        rig.video.publish(frame(3, 0.5))
        async with session.get(server.make_url("/snapshot.jpg")) as response:
            assert (response.status, await response.read()) == (200, frame(3).jpeg)
            assert float(response.headers["X-Timestamp"]) == 0.5
        rig.clock.advance(1.1)
        async with session.get(server.make_url("/snapshot.jpg")) as response:
            assert response.status == 503
            assert "no live picture" in await response.text()


async def test_server_stop_ends_viewers(rig: Rig) -> None:
    server = await rig.start()
    async with browser() as session, session.ws_connect(server.make_url("/video")) as socket:
        async with asyncio.timeout(PATIENCE_S):
            closing = asyncio.create_task(server.close())
            message = await socket.receive()
            await closing
    assert message.data == aiohttp.WSCloseCode.GOING_AWAY


async def test_a_writer_that_fails_ends_the_connection(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_frame: AnnotatedFrame) -> bytes:
        raise ValueError("broken")

    monkeypatch.setattr("hawk.web.video.video_wire.socket_frame", fail)
    server = await rig.start()
    async with browser() as session, session.ws_connect(server.make_url("/video")) as socket:
        rig.video.publish(frame(1))
        async with asyncio.timeout(PATIENCE_S):
            assert (await socket.receive()).type in (aiohttp.WSMsgType.CLOSE, aiohttp.WSMsgType.CLOSED)


@pytest.mark.fault("a viewer of /stream.mjpg that does not read", "disconnected after 10 s, its place is free")
async def test_a_viewer_of_the_stream_that_does_not_read_is_disconnected(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(viewers, "ACK_TIMEOUT_S", 0.05)
    server = await rig.start()
    assert rig.app is not None
    counters = rig.app[COUNTERS]
    reader, writer = await asyncio.open_connection("127.0.0.1", server.port, limit=1024)
    writer.write(b"GET /stream.mjpg HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
    await reader.readuntil(b"\r\n\r\n")
    async with asyncio.timeout(5):
        number = 0
        while counters.video_clients:
            number += 1
            rig.video.publish(AnnotatedFrame(number, rig.clock(), bytes(1_000_000)))
            await asyncio.sleep(0.001)
    writer.close()
