from __future__ import annotations

import asyncio
import json
import os
import struct
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.model.pictures import AnnotatedFrame
from hawk.web.app import WebServer
from hawk.web.video.video_wire import LEFT_S, AckTap
from hawk.web.ws import PING_INTERVAL_S
from tests.manual_clock import ManualClock
from tests.unit.web.rig import PATIENCE_S, Rig


def message(content: bytes, first: int = 0x81, mask: bytes = b"\x0a\xf1\x00\x7f") -> bytes:
    """A short message of a client."""
    masked = bytes(each ^ mask[index % 4] for index, each in enumerate(content))
    return bytes((first, 0x80 | len(content))) + mask + masked


def tapped(*pieces: bytes) -> tuple[list[int], list[bytes]]:
    """Return the sequences that were taken and the pieces that were passed on."""
    taken: list[int] = []
    tap = AckTap(taken.append)
    return taken, [piece for piece in pieces if not tap(piece)]


@given(st.integers(0, 2**32 - 1), st.binary(min_size=4, max_size=4), st.booleans())
def test_an_acknowledgement_of_any_mask_is_taken(sequence: int, mask: bytes, spaced: bool) -> None:
    text = json.dumps({"ack": sequence}, separators=(", ", ": ") if spaced else (",", ":")).encode()
    assert tapped(message(text, mask=mask)) == ([sequence], [])


def test_one_acknowledgement_in_a_while_is_left_to_aiohttp_so_that_it_hears_the_connection() -> None:
    clock = ManualClock()
    taken: list[int] = []
    tap = AckTap(taken.append, clock)
    seen = []
    for number in range(100):
        clock.advance(0.125)
        seen.append(tap(message(b'{"ack":%d}' % number)))
    left = [index for index, was_taken in enumerate(seen) if not was_taken]
    assert left[0] == round(LEFT_S / 0.125) - 1
    assert len(left) == 6
    assert LEFT_S < PING_INTERVAL_S / 2
    assert taken == [number for number in range(100) if number not in left]


@pytest.mark.parametrize(
    "other",
    [
        message(b'{"ack":"1"}'),
        message(b'{"ack":-1}'),
        message(b'{"ack":1.0}'),
        message(b'{"ack":12345678901}'),
        message(b'{"ack":1}', first=0x82),
        message(b'{"ack":1}', first=0xC1),
        message(b"mark", first=0x8A),
        message(b"", first=0x89),
        message(b"\x03\xe8", first=0x88),
    ],
)
def test_a_whole_message_of_another_kind_is_passed_on_and_the_next_one_taken(other: bytes) -> None:
    assert tapped(other, message(b'{"ack":7}')) == ([7], [other])


@pytest.mark.parametrize(
    "pieces",
    [
        (message(b'{"ack":7}')[:9], message(b'{"ack":7}')[9:]),
        (message(b'{"ack":7}') * 2,),
        (message(b'{"ac', first=0x01), message(b'k":7}', first=0x80)),
        (b"\x81",),
        (b"",),
        (b"\x81\xfe\x00\x80" + bytes(132),),
        (b"\x81\x09" + b'{"ack":7}',),
    ],
)
def test_after_a_piece_that_is_not_one_message_everything_is_passed_on(pieces: tuple[bytes, ...]) -> None:
    after = message(b'{"ack":8}')
    assert tapped(*pieces, after) == ([], [*pieces, after])


@asynccontextmanager
async def viewer_of(rig: Rig) -> AsyncIterator[tuple[asyncio.StreamReader, asyncio.StreamWriter]]:
    """A viewer of ``/video`` at the daemon's own server, after the handshake."""
    rig.web = rig.web.model_copy(update={"port": 0})
    server = WebServer(rig.services(), rig.page)
    await server.start()
    try:
        reader, writer = await asyncio.open_connection("127.0.0.1", server.port)
        writer.write(
            f"GET /video HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        await reader.readuntil(b"\r\n\r\n")
        yield reader, writer
        writer.close()
    finally:
        await server.close()


async def next_picture(reader: asyncio.StreamReader) -> int:
    """Return the sequence of the next picture; pings are passed over."""
    async with asyncio.timeout(PATIENCE_S):
        while True:
            head = await reader.readexactly(2)
            body = await reader.readexactly(head[1])
            if head[0] == 0x82:
                magic, sequence = struct.unpack_from("<4sI", body)
                assert magic == b"HWK1"
                return int(sequence)
            assert head[0] == 0x89


async def test_the_daemons_server_takes_acknowledgements_whole_or_in_pieces(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    taken: list[bool] = []
    take = AckTap.__call__

    def note(tap: AckTap, data: bytes) -> bool:
        taken.append(take(tap, data))
        return taken[-1]

    monkeypatch.setattr(AckTap, "__call__", note)
    async with viewer_of(rig) as (reader, writer):
        for number in range(1, 8):
            rig.video.publish(AnnotatedFrame(number, 0.5, b"\xff\xd8%d\xff\xd9" % number))
            assert await next_picture(reader) == number
            answer = message(b'{"ack":%d}' % number, mask=os.urandom(4))
            for piece in (answer,) if number < 4 else (answer[:5], answer[5:]):
                writer.write(piece)
                await writer.drain()
                await asyncio.sleep(0.01)  # so that each piece arrives alone
    assert taken == [True] * 3 + [False] * 8


@pytest.mark.slow
async def test_a_viewer_that_acknowledges_is_not_ended_for_a_late_pong(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hawk.web.video.video.PING_INTERVAL_S", 0.4)
    monkeypatch.setattr("hawk.web.video.video_wire.LEFT_S", 0.1)
    async with viewer_of(rig) as (reader, writer):
        for number in range(1, 31):
            rig.video.publish(AnnotatedFrame(number, 0.5, b"\xff\xd8%d\xff\xd9" % number))
            assert await next_picture(reader) == number
            writer.write(message(b'{"ack":%d}' % number))
            await asyncio.sleep(0.05)
