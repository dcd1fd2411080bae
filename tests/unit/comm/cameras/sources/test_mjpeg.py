from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

import pytest
from aiohttp import web

from hawk.comm.cameras.sources.mjpeg import HttpMjpegSource
from hawk.comm.cameras.sources.source import CameraError, SourceFrame
from tests.manual_clock import ManualClock
from tests.unit.comm.cameras.pictures import StreamServer, Writer, forever, once, part, picture
from tests.unit.comm.cameras.sources.sources import first_frames

PICTURE = picture()


@pytest.fixture
async def servers() -> AsyncIterator[list[StreamServer]]:
    started: list[StreamServer] = []
    yield started
    for server in started:
        await server.close()


async def serve(servers: list[StreamServer], writer: Writer) -> tuple[StreamServer, str]:
    server = StreamServer(writer)
    servers.append(server)
    return server, await server.start()


async def first(source: HttpMjpegSource, count: int) -> list[SourceFrame]:
    return await first_frames(source, count, within_s=5)


@pytest.mark.fault("any number of bytes follows a JPEG's end", "left out; no picture is lost")
@pytest.mark.parametrize("behind", [b"\0" * 65, b"\0" * 4096, b"a trailer of the camera's maker", PICTURE[100:]])
@pytest.mark.parametrize("length", [None, -1])
async def test_bytes_behind_a_picture_s_end_are_left_out(
    servers: list[StreamServer], behind: bytes, length: int | None
) -> None:
    _, url = await serve(servers, forever(part(PICTURE + behind, length=length)))
    source = HttpMjpegSource(url, ManualClock(7.0))
    assert [frame.jpeg for frame in await first(source, 2)] == [PICTURE, PICTURE]
    assert source.torn == 0


async def test_pictures_come_with_arrival_and_stamp(servers: list[StreamServer]) -> None:
    _, url = await serve(servers, forever(part(PICTURE, stamp=1234.5), part(PICTURE)))
    source = HttpMjpegSource(url, ManualClock(7.0))
    found = await first(source, 2)
    assert found == [SourceFrame(PICTURE, 7.0, 1234.5), SourceFrame(PICTURE, 7.0, None)]


@pytest.mark.parametrize("stamp", ["", "soon", "nan", "inf"])
async def test_a_stamp_that_is_no_time_is_none(servers: list[StreamServer], stamp: str) -> None:
    data = part(PICTURE).replace(b"Content-Type", f"X-Timestamp: {stamp}\r\nContent-Type".encode(), 1)
    _, url = await serve(servers, forever(data))
    (frame,) = await first(HttpMjpegSource(url, ManualClock()), 1)
    assert frame.stamp is None


async def test_torn_pictures_are_counted(servers: list[StreamServer]) -> None:
    _, url = await serve(servers, forever(part(PICTURE[:100], length=None), part(PICTURE)))
    source = HttpMjpegSource(url, ManualClock())
    assert [frame.jpeg for frame in await first(source, 2)] == [PICTURE, PICTURE]
    assert source.torn >= 1


async def test_a_stream_that_ends_is_an_error_that_says_so(servers: list[StreamServer]) -> None:
    _, url = await serve(servers, once(part(PICTURE)))
    with pytest.raises(CameraError, match="the stream ended"):
        await first(HttpMjpegSource(url, ManualClock()), 2)


async def test_a_stream_that_is_silent_is_given_up(servers: list[StreamServer]) -> None:
    async def hang(response: web.StreamResponse, _: web.Request) -> None:
        await response.write(part(PICTURE))
        await asyncio.sleep(3600)

    _, url = await serve(servers, hang)
    with pytest.raises(CameraError, match="nothing came"):
        await first(HttpMjpegSource(url, ManualClock(), silence_s=0.1), 2)


async def test_nobody_there_is_an_error_with_the_address(unused_tcp_port: int) -> None:
    with pytest.raises(CameraError, match=f"127.0.0.1:{unused_tcp_port}"):
        await first(HttpMjpegSource(f"http://127.0.0.1:{unused_tcp_port}/stream", ManualClock()), 1)


async def test_another_answer_than_200_is_reported(servers: list[StreamServer]) -> None:
    server, url = await serve(servers, forever(part(PICTURE)))
    server.status = 401
    with pytest.raises(CameraError, match="answers 401 Unauthorized"):
        await first(HttpMjpegSource(url, ManualClock()), 1)


async def test_a_page_that_is_no_stream_names_the_remedy(servers: list[StreamServer]) -> None:
    server, url = await serve(servers, forever(b"<html>"))
    server.content_type = "text/html"
    with pytest.raises(CameraError, match=r"not an MJPEG stream.*name the address of the stream"):
        await first(HttpMjpegSource(url, ManualClock()), 1)


async def test_an_address_that_is_none_is_an_error() -> None:
    with pytest.raises(CameraError):
        await first(HttpMjpegSource("http://[nowhere/", ManualClock()), 1)


async def test_headers_are_sent(servers: list[StreamServer]) -> None:
    server, url = await serve(servers, forever(part(PICTURE)))
    await first(HttpMjpegSource(url, ManualClock(), {"Authorization": "Bearer secret"}), 1)
    assert server.requests[0].headers["Authorization"] == "Bearer secret"


async def test_what_a_library_says_about_an_address_holds_no_secret_of_it(servers: list[StreamServer]) -> None:
    async def garbled(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.write(b"HTTP/1.1 two hundred\r\n\r\n")  # aiohttp's error holds the whole address
        await writer.drain()
        writer.close()

    server = await asyncio.start_server(garbled, "127.0.0.1", 0)
    place = f"127.0.0.1:{server.sockets[0].getsockname()[1]}"
    async with server:
        with pytest.raises(CameraError, match=rf"^http://\*\*\*@{place}/\*\*\*: 400") as caught:
            await first(HttpMjpegSource(f"http://me:word@{place}/key-of-it?token=abcdefgh", ManualClock()), 1)
    assert not [each for each in ("word", "key-of-it", "abcdefgh") if each in str(caught.value)]
