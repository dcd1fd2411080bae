"""Live pictures as other programs read them: a strict multipart parser, curl, OpenCV's FFmpeg, WebSocket clients."""

from __future__ import annotations

import asyncio
import itertools
import re
import shutil
import struct
from collections.abc import AsyncIterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager
from dataclasses import dataclass

import aiohttp
import cv2
import numpy as np
import pytest

from hawk.formats.image import decode
from hawk.model.pictures import AnnotatedFrame
from hawk.web.video.video_wire import WireCache, chunked_part, marked_sequence, part, ping_mark, plain_socket_frame
from tests.unit.web.rig import PATIENCE_S, Rig, browser

TOKEN = re.compile(rb"[!#$%&'*+.^_`|~0-9A-Za-z-]+")


def jpeg(number: int, width: int = 64) -> bytes:
    picture = np.full((36, width, 3), number * 40 % 255, np.uint8)
    encoded, data = cv2.imencode(".jpg", picture)
    assert encoded
    return bytes(data)


def frame(number: int, data: bytes | None = None) -> AnnotatedFrame:
    return AnnotatedFrame(number, 10.0 + number / 4, jpeg(number) if data is None else data)


@dataclass
class Part:
    headers: dict[str, str]
    body: bytes


def parse(body: bytes, boundary: str) -> list[Part]:
    """Read a multipart body (RFC 2046, 5.1.1) that was cut off behind a delimiter; anything else is an error.

    The delimiter is looked for in the bytes, and has to be where Content-Length says.
    """
    delimiter = b"--" + boundary.encode()
    assert body.startswith(delimiter + b"\r\n"), body[:40]
    parts, at = [], len(delimiter) + 2
    while at < len(body):
        end = body.index(b"\r\n\r\n", at)
        headers: dict[str, str] = {}
        for line in body[at:end].split(b"\r\n"):
            name, colon, value = line.partition(b": ")
            assert colon, line
            assert TOKEN.fullmatch(name), line
            assert name.decode().lower() not in headers, line
            headers[name.decode().lower()] = value.decode("ascii")
        begin = end + 4
        finish = body.index(b"\r\n" + delimiter + b"\r\n", begin)
        assert finish - begin == int(headers["content-length"])
        parts.append(Part(headers, body[begin:finish]))
        at = finish + 2 + len(delimiter) + 2
    return parts


def unchunk(data: bytes) -> bytes:
    """Return the content of whole chunks (RFC 9112, 7.1) without the end of the message."""
    content = b""
    while data:
        size, line_end, rest = data.partition(b"\r\n")
        assert line_end
        assert re.fullmatch(rb"[0-9a-f]+", size), size
        assert rest[int(size, 16) :][:2] == b"\r\n"
        content += rest[: int(size, 16)]
        data = rest[int(size, 16) + 2 :]
    return content


@asynccontextmanager
async def camera(rig: Rig, width: int = 64) -> AsyncIterator[None]:
    """Publish forty pictures a second."""

    async def publish() -> None:
        for number in itertools.count(1):
            rig.video.publish(frame(number, jpeg(number, width)))
            await asyncio.sleep(0.025)

    task = asyncio.create_task(publish())
    try:
        yield
    finally:
        task.cancel()


async def answer(rig: Rig, version: str) -> tuple[str, bytes]:
    """Return the head and the body of three pictures, as they are on the wire."""
    server = await rig.start()
    rig.video.publish(frame(1))
    reader, writer = await asyncio.open_connection("127.0.0.1", server.port)
    writer.write(f"GET /stream.mjpg HTTP/{version}\r\nHost: 127.0.0.1\r\n\r\n".encode())
    body = b""
    async with asyncio.timeout(PATIENCE_S):
        head = (await reader.readuntil(b"\r\n\r\n")).decode("ascii")
        for number in (1, 2, 3):
            whole = chunked_part(frame(number)) if version == "1.1" else part(frame(number))
            while whole not in body:
                more = await reader.read(65536)
                assert more, body[-200:]
                body += more
            rig.video.publish(frame(number + 1))
    writer.close()
    return head, body


@pytest.mark.parametrize("version", ["1.0", "1.1"])
async def test_a_strict_reader_finds_every_picture_in_the_stream(rig: Rig, version: str) -> None:
    head, body = await answer(rig, version)
    found = re.search(r"(?m)^Content-Type: multipart/x-mixed-replace; ?boundary=([\w'()+,./:=?-]{1,70})\r$", head)
    assert found, head
    assert ("Transfer-Encoding: chunked\r\n" in head) == (version == "1.1")
    parts = parse(unchunk(body) if version == "1.1" else body, found[1])
    assert [each.body for each in parts[:3]] == [jpeg(number) for number in (1, 2, 3)]
    for number, each in enumerate(parts[:3], 1):
        assert each.headers["content-type"] == "image/jpeg"
        assert float(each.headers["x-timestamp"]) == 10.0 + number / 4


@pytest.mark.slow
async def test_a_reader_that_looks_for_delimiters_need_not_wait_for_the_next_picture(rig: Rig) -> None:
    server = await rig.start()
    rig.video.publish(frame(1))
    reader, writer = await asyncio.open_connection("127.0.0.1", server.port)
    writer.write(b"GET /stream.mjpg HTTP/1.0\r\nHost: 127.0.0.1\r\n\r\n")
    async with asyncio.timeout(PATIENCE_S):
        await reader.readuntil(b"\r\n\r\n")
        await reader.readuntil(b"--hawkframe\r\n")
        whole = await reader.readuntil(b"\r\n--hawkframe\r\n")  # no second picture exists
    assert jpeg(1) in whole
    writer.close()


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("curl") is None, reason="curl is not installed")
async def test_curl_receives_the_stream(rig: Rig) -> None:
    server = await rig.start()
    async with camera(rig):
        process = await asyncio.create_subprocess_exec(
            "curl", "--silent", "--no-buffer", "--max-time", "2", str(server.make_url("/stream.mjpg")),
            stdout=asyncio.subprocess.PIPE,
        )  # fmt: skip
        output, _ = await process.communicate()
    assert process.returncode == 28  # its own --max-time
    whole = output[: output.rindex(b"--hawkframe\r\n") + len(b"--hawkframe\r\n")]
    parts = parse(whole, "hawkframe")
    assert len(parts) >= 10
    assert {decode(each.body).shape for each in parts} == {(36, 64, 3)}


async def test_ffmpeg_inside_opencv_plays_the_stream(rig: Rig) -> None:
    server = await rig.start()
    url = str(server.make_url("/stream.mjpg"))

    def play() -> list[tuple[int, ...]]:
        film = cv2.VideoCapture(url, cv2.CAP_FFMPEG)
        try:
            return [found.shape for is_there, found in (film.read() for _ in range(3)) if is_there]
        finally:
            film.release()

    with ThreadPoolExecutor(1) as executor:
        async with camera(rig, width=96), asyncio.timeout(30):
            shapes = await asyncio.get_running_loop().run_in_executor(executor, play)
    assert shapes == [(36, 96, 3)] * 3


async def test_head_asks_for_the_stream_and_gets_no_pictures(rig: Rig) -> None:
    server = await rig.start()
    rig.video.publish(frame(1))
    async with browser() as session, session.head(server.make_url("/stream.mjpg")) as response:
        assert response.status == 200
        assert response.content_type == "multipart/x-mixed-replace"
        async with asyncio.timeout(PATIENCE_S):
            assert await response.read() == b""


@pytest.mark.slow
@pytest.mark.parametrize("size", [4, 125, 126, 127, 65_535, 65_536, 100_000])
async def test_a_plain_message_is_one_jpeg_and_its_pong_asks_for_the_next(rig: Rig, size: int) -> None:
    """aiohttp's client reads the frames and answers pings by itself, as every WebSocket client does."""
    server = await rig.start()
    body = b"\xff\xd8" + bytes(size - 4) + b"\xff\xd9"
    async with browser() as session, session.ws_connect(server.make_url("/video?plain=1")) as socket:
        for number in (1, 2, 3):
            rig.video.publish(frame(number, body))
            async with asyncio.timeout(PATIENCE_S):
                assert await socket.receive_bytes() == body


async def test_a_plain_viewer_whose_pong_is_missing_or_wrong_receives_nothing_more(rig: Rig) -> None:
    server = await rig.start()
    async with (
        browser() as session,
        session.ws_connect(server.make_url("/video?plain=1"), autoping=False) as socket,
    ):
        rig.video.publish(frame(1))
        async with asyncio.timeout(PATIENCE_S):
            assert (await socket.receive()).type is aiohttp.WSMsgType.BINARY
            ping = await socket.receive()
            assert ping.type is aiohttp.WSMsgType.PING
            rig.video.publish(frame(2))
            for wrong in (b"", b"x", struct.pack(">I", 2), ping.data + b"0"):
                await socket.pong(wrong)
            await socket.send_str('{"ack": 1}')  # is no acknowledgement here
            await socket.ping(b"mine")
            answered = await socket.receive()
            assert (answered.type, answered.data) == (aiohttp.WSMsgType.PONG, b"mine")  # nothing came before it
            await socket.pong(ping.data)
            assert (await socket.receive()).data == frame(2).jpeg


def test_the_mark_of_a_ping_is_the_sequence_and_another_is_none() -> None:
    assert marked_sequence(ping_mark(frame(2**32 + 9, b""))) == 9
    assert marked_sequence(b"") is None
    assert marked_sequence(b"12345678") is None


def test_bytes_are_made_once_for_each_kind_and_old_ones_are_dropped() -> None:
    made = []

    def wire(each: AnnotatedFrame) -> bytes:
        made.append(each.sequence)
        return b"%d" % each.sequence

    cache = WireCache()
    frames = [frame(number, b"") for number in range(40)]
    for each in frames:
        assert cache.of(wire, each) is cache.of(wire, each)
        assert cache.of(plain_socket_frame, each) != cache.of(wire, each)
    assert made == list(range(40))
    assert len(cache._kept) <= 16
