from __future__ import annotations

import asyncio
import json
import os
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.model import AnnotatedFrame
from hawk.web.ack_tap import AckTap
from hawk.web.app import WebServer
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


async def test_the_daemons_server_takes_acknowledgements_whole_or_in_pieces(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    taken: list[bool] = []
    take = AckTap.__call__

    def note(tap: AckTap, data: bytes) -> bool:
        taken.append(take(tap, data))
        return taken[-1]

    monkeypatch.setattr(AckTap, "__call__", note)
    rig.web = rig.web.model_copy(update={"port": 0})
    server = WebServer(rig.services(), rig.page)
    await server.start()
    try:
        reader, writer = await asyncio.open_connection("127.0.0.1", server.port)
        writer.write(
            f"GET /video HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        async with asyncio.timeout(PATIENCE_S):
            await reader.readuntil(b"\r\n\r\n")
            for number in range(1, 8):
                rig.video.publish(AnnotatedFrame(number, 0.5, b"\xff\xd8%d\xff\xd9" % number))
                head = await reader.readexactly(2)
                assert head[0] == 0x82
                body = await reader.readexactly(head[1])
                assert struct.unpack_from("<4sI", body) == (b"HWK1", number)
                answer = message(b'{"ack":%d}' % number, mask=os.urandom(4))
                for piece in (answer,) if number < 4 else (answer[:5], answer[5:]):
                    writer.write(piece)
                    await writer.drain()
                    await asyncio.sleep(0.01)  # so that each piece arrives alone
        writer.close()
        assert taken == [True] * 3 + [False] * 8
    finally:
        await server.close()
