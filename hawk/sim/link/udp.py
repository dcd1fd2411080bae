"""The UDP socket of a MAVLink link."""

from __future__ import annotations

import asyncio
import ipaddress
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Final, cast

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.config.addresses import check_host, check_port
from hawk.sim.autopilot.options import Other

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


_SECOND_NORTH_DEG: Final = 0.002
"""The second copter flies this far north of where the world begins: 220 m."""


@dataclass(frozen=True, slots=True)
class _Kind:
    """MAVLink ids and the HEARTBEAT's fields (MAV_TYPE, MAV_AUTOPILOT, base_mode, custom_mode, MAV_STATE)."""

    system: int
    component: int
    heartbeat: tuple[int, int, int, int, int]


_KINDS: Final = {
    Other.TRACKER: _Kind(2, 1, (mavlink.MAV_TYPE_ANTENNA_TRACKER, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, 81, 10, 4)),
    Other.GIMBAL: _Kind(
        1, mavlink.MAV_COMP_ID_GIMBAL, (mavlink.MAV_TYPE_GIMBAL, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 4)
    ),
    Other.COPTER: _Kind(3, 1, (mavlink.MAV_TYPE_HEXAROTOR, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, 217, 3, 4)),
    Other.STATION: _Kind(
        255, mavlink.MAV_COMP_ID_MISSIONPLANNER, (mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 4)
    ),
}
"""The tracker is armed in AUTO, the second copter flies in AUTO; a gimbal is a component of the vehicle itself."""


class Others:
    """`present` of them are on the link. ``latitude`` and ``longitude`` (degrees) are where the world begins."""

    def __init__(self, latitude: float, longitude: float) -> None:
        self.present: frozenset[Other] = frozenset()
        self._place = round((latitude + _SECOND_NORTH_DEG) * 1e7), round(longitude * 1e7)
        self._encoders = {
            kind: mavlink.MAVLink(None, srcSystem=each.system, srcComponent=each.component)
            for kind, each in _KINDS.items()
        }

    def say(self, now: float, pack: Callable[[Any, mavlink.MAVLink], bytes]) -> list[bytes]:
        """Return the datagrams of one round; ``now`` is seconds of the simulation."""
        return [
            pack(message, self._encoders[kind])
            for kind in sorted(self.present)
            for message in self._messages(kind, int(now * 1000))
        ]

    def _messages(self, kind: Other, milliseconds: int) -> Iterator[Any]:
        yield mavlink.MAVLink_heartbeat_message(*_KINDS[kind].heartbeat, 3)
        if kind is Other.COPTER:
            yield mavlink.MAVLink_global_position_int_message(milliseconds, *self._place, 140_000, 40_000, 500, 0, 0, 0)
            yield mavlink.MAVLink_sys_status_message(0, 0, 0, 300, 14_800, 1500, 61, 0, 0, 0, 0, 0, 0)
