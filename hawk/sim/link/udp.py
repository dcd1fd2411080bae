"""The UDP socket of a MAVLink link."""

from __future__ import annotations

import asyncio
import ipaddress
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, cast

from hawk.config.addresses import check_host, check_port

PEER_TIMEOUT_S = 10.0
"""Peers are answered for this long after their last datagram, real seconds."""
Address = tuple[str, int]


@dataclass(frozen=True, slots=True)
class UdpUrl:
    """``udpout:HOST:PORT`` sends there from a port of its own; ``udpin:HOST:PORT`` listens there."""

    scheme: str
    host: str
    port: int

    @classmethod
    def parse(cls, text: str) -> UdpUrl:
        """Read a URL (``//`` after the scheme is allowed). Raises ValueError with the expected form."""
        scheme, _, rest = text.partition(":")
        host, _, port = rest.removeprefix("//").rpartition(":")
        form = f"must be udpout:HOST:PORT or udpin:HOST:PORT, not {text!r}"
        if scheme not in ("udpout", "udpin") or not host:
            raise ValueError(form)
        try:
            return cls(scheme, check_host(host), check_port(port, least=1 if scheme == "udpout" else 0))
        except ValueError as error:
            raise ValueError(f"{form}: {error}") from None

    def __str__(self) -> str:
        return f"{self.scheme}:{self.host}:{self.port}"


class UdpLink(asyncio.DatagramProtocol):
    """Sends every datagram to the fixed peer and to recent senders; passes incoming ones to ``receive``."""

    def __init__(self, receive: Callable[[bytes], None], monotonic: Callable[[], float] = time.monotonic) -> None:
        self._receive = receive
        self._monotonic = monotonic
        self._transport: asyncio.DatagramTransport | None = None
        self._fixed: Address | None = None
        self._peers: dict[Address, float] = {}

    async def open(self, url: UdpUrl) -> UdpUrl:
        """Open the socket; return the URL with the port that is really used. Raises OSError."""
        loop = asyncio.get_running_loop()
        if url.scheme == "udpout":
            resolved = await loop.getaddrinfo(url.host, url.port, type=2, family=2)
            self._fixed = cast("Address", resolved[0][4][:2])
            local: Address = ("127.0.0.1" if ipaddress.ip_address(self._fixed[0]).is_loopback else "0.0.0.0", 0)  # noqa: S104
        else:
            local = (url.host, url.port)
        transport, _ = await loop.create_datagram_endpoint(lambda: self, local_addr=local)
        self._transport = transport
        port = url.port if url.scheme == "udpout" else transport.get_extra_info("sockname")[1]
        return UdpUrl(url.scheme, url.host, port)

    def send(self, datagrams: Iterable[bytes]) -> None:
        """Send to all peers."""
        if self._transport is None or self._transport.is_closing():
            return
        now = self._monotonic()
        for peer, heard in list(self._peers.items()):
            if now - heard > PEER_TIMEOUT_S:
                del self._peers[peer]
        peers = set(self._peers) | ({self._fixed} if self._fixed else set())
        for data in datagrams:
            for peer in peers:
                self._transport.sendto(data, peer)

    def close(self) -> None:
        """Close the socket."""
        if self._transport is not None:
            self._transport.close()

    def datagram_received(self, data: bytes, addr: tuple[Any, ...]) -> None:
        """Take a datagram."""
        self._peers[(addr[0], addr[1])] = self._monotonic()
        self._receive(data)

    def error_received(self, exc: Exception) -> None:
        """Ignore errors of peers that do not listen."""
