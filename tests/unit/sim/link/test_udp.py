from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

import pytest

from hawk.sim.link.udp import PEER_TIMEOUT_S, UdpLink, UdpUrl


class Peer(asyncio.DatagramProtocol):
    """A plain UDP socket."""

    def __init__(self) -> None:
        self.heard: asyncio.Queue[bytes] = asyncio.Queue()
        self.transport: asyncio.DatagramTransport | None = None

    @property
    def port(self) -> int:
        assert self.transport is not None
        return int(self.transport.get_extra_info("sockname")[1])

    def datagram_received(self, data: bytes, addr: tuple[object, ...]) -> None:
        self.heard.put_nowait(data)
        self.last = addr

    async def take(self) -> bytes:
        async with asyncio.timeout(5.0):
            return await self.heard.get()


@pytest.fixture
async def peer() -> AsyncIterator[Peer]:
    made = Peer()
    transport, _ = await asyncio.get_running_loop().create_datagram_endpoint(lambda: made, ("127.0.0.1", 0))
    made.transport = transport
    yield made
    transport.close()


@pytest.mark.parametrize(
    ("text", "url"),
    [
        ("udpout:127.0.0.1:14550", UdpUrl("udpout", "127.0.0.1", 14550)),
        ("udpin://0.0.0.0:0", UdpUrl("udpin", "0.0.0.0", 0)),
    ],
)
def test_urls(text: str, url: UdpUrl) -> None:
    assert UdpUrl.parse(text) == url
    assert UdpUrl.parse(str(url)) == url


@pytest.mark.parametrize(
    "text", ["tcp:1.2.3.4:5", "udpout:host", "udpout::14550", "udpin:host:99999", "udpin:host:x", ""]
)
def test_wrong_urls_say_what_is_expected(text: str) -> None:
    with pytest.raises(ValueError, match="udpout:HOST:PORT"):
        UdpUrl.parse(text)


async def test_sends_to_its_peer_and_hears_the_answer(peer: Peer) -> None:
    heard: asyncio.Queue[bytes] = asyncio.Queue()
    link = UdpLink(heard.put_nowait)
    await link.open(UdpUrl("udpout", "127.0.0.1", peer.port))
    link.send([b"one", b"two"])
    assert [await peer.take(), await peer.take()] == [b"one", b"two"]
    assert peer.transport is not None
    peer.transport.sendto(b"answer", peer.last)
    async with asyncio.timeout(5.0):
        assert await heard.get() == b"answer"
    link.send([b"three"])
    assert await peer.take() == b"three"
    assert peer.heard.empty()
    link.close()


async def test_nobody_there_is_no_fault() -> None:
    link = UdpLink(lambda _: None)
    probe = UdpLink(lambda _: None)
    free = await probe.open(UdpUrl("udpin", "127.0.0.1", 0))
    probe.close()
    await asyncio.sleep(0)
    await link.open(UdpUrl("udpout", "127.0.0.1", free.port))
    for _ in range(3):
        link.send([b"anyone?"])
        await asyncio.sleep(0)
    link.close()
    link.send([b"after the end"])


async def test_a_listener_answers_each_sender_until_it_is_silent(peer: Peer) -> None:
    now = 0.0
    heard: asyncio.Queue[bytes] = asyncio.Queue()
    link = UdpLink(heard.put_nowait, lambda: now)
    url = await link.open(UdpUrl("udpin", "127.0.0.1", 0))
    link.send([b"to nobody"])
    assert peer.transport is not None
    peer.transport.sendto(b"hello", ("127.0.0.1", url.port))
    async with asyncio.timeout(5.0):
        await heard.get()
    link.send([b"welcome"])
    assert await peer.take() == b"welcome"
    now = PEER_TIMEOUT_S + 0.1
    link.send([b"forgotten"])
    peer.transport.sendto(b"again", ("127.0.0.1", url.port))
    async with asyncio.timeout(5.0):
        await heard.get()
    link.send([b"back"])
    assert await peer.take() == b"back"
    link.close()
