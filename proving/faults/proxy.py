"""A UDP proxy between autopilot and daemon: cuts one direction, drops, delays, duplicates, reorders, changes, forges.

The autopilot's datagrams arrive at the port to which it sends (down); they leave for the daemon's port from a socket to
which the daemon answers (up). Delays are seconds of the drone's clock.
"""

from __future__ import annotations

import asyncio
import random
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Final
from urllib.parse import urlsplit

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.sim.launch import free_udp_port

HOST: Final = "127.0.0.1"
_V1, _V2 = 0xFE, 0xFD
_SIGNED = 0x01
_COMMANDS: Final = frozenset({"COMMAND_LONG", "COMMAND_INT"})
_NAMES: Final = {number: kind.msgname for number, kind in mavlink.mavlink_map.items()}

Address = tuple[str, int]


class Direction(StrEnum):
    """Direction of a datagram."""

    DOWN = "autopilot to daemon"
    UP = "daemon to autopilot"


@dataclass(frozen=True, slots=True)
class Rule:
    """Changes the datagrams of one direction that hold a message of these kinds (none named: all).

    ``share`` of them are met (0..1), at most ``times`` of them. ``copies`` more are sent; each datagram leaves after
    ``delay_s`` and up to ``jitter_s`` more, which reorders them. ``change`` replaces fields of the messages.
    """

    direction: Direction
    kinds: frozenset[str] = frozenset()
    drop: bool = False
    share: float = 1.0
    times: int | None = None
    copies: int = 0
    delay_s: float = 0.0
    jitter_s: float = 0.0
    change: Mapping[str, Any] = field(default_factory=dict)

    def meets(self, kinds: frozenset[str]) -> bool:
        """Return True when a datagram with messages of these kinds is meant."""
        return not self.kinds or not self.kinds.isdisjoint(kinds)


def kinds_of(data: bytes) -> Iterator[str]:
    """Yield the names of the MAVLink messages in a datagram (https://mavlink.io/en/guide/serialization.html)."""
    at = 0
    while at + 8 <= len(data):
        if data[at] == _V2 and at + 12 <= len(data):
            number = int.from_bytes(data[at + 7 : at + 10], "little")
            length = 12 + data[at + 1] + (13 if data[at + 2] & _SIGNED else 0)
        elif data[at] == _V1:
            number, length = data[at + 5], 8 + data[at + 1]
        else:
            return
        yield _NAMES.get(number, str(number))
        at += length


def commands_of(data: bytes) -> Iterator[int]:
    """Yield the numbers of the commands (COMMAND_LONG, COMMAND_INT) in a datagram.

    Both have the number in bytes 28 and 29 of their payload (https://mavlink.io/en/messages/common.html).
    """
    at = 0
    while at + 8 <= len(data) and data[at] in (_V1, _V2):
        head = 10 if data[at] == _V2 else 6
        signed = data[at] == _V2 and data[at + 2] & _SIGNED
        number = int.from_bytes(data[at + 7 : at + 10], "little") if data[at] == _V2 else data[at + 5]
        payload = data[at + head : at + head + data[at + 1]]
        if _NAMES.get(number) in _COMMANDS:
            yield int.from_bytes(payload[28:30], "little")
        at += head + data[at + 1] + 2 + (13 if signed else 0)


def message(kind: str, fields: Mapping[str, Any]) -> Any:
    """Return a message of that kind. Raises AttributeError, TypeError for kinds and fields that MAVLink lacks."""
    return getattr(mavlink, f"MAVLink_{kind.lower()}_message")(**fields)


def packed(kind: str, fields: Mapping[str, Any], system: int, component: int = 1) -> bytes:
    """Return a datagram with one message."""
    return bytes(message(kind, fields).pack(mavlink.MAVLink(None, srcSystem=system, srcComponent=component)))


class Proxy:
    """One link. ``rules`` hold for every datagram; the first that meets it decides."""

    def __init__(
        self, speed: float, seed: int = 1, passes: Callable[[Direction, bytes], bool] = lambda *_: True
    ) -> None:
        """``speed``: the drone's seconds per real second. ``passes`` sees each datagram first; False drops it."""
        self.rules: tuple[Rule, ...] = ()
        self.passed: Counter[tuple[Direction, str]] = Counter()
        """Messages that arrived at the proxy, by direction and kind; commands by number too (``COMMAND 176``)."""
        self._passes = passes
        self._speed = speed
        self._rng = random.Random(seed)
        self._met: Counter[int] = Counter()
        self._autopilot: Address | None = None
        self._daemon: Address | None = None
        self._ends: list[asyncio.DatagramTransport] = []

    async def open(self, autopilot_url: str) -> str:
        """Take the place of the daemon at the autopilot's URL; return the URL at which the daemon is to listen."""
        port = urlsplit(autopilot_url).port or 0
        self._daemon = (HOST, free_udp_port())
        self._up = await self._end(self._from_daemon, 0)
        self._down = await self._end(self._from_autopilot, port)  # the autopilot sends from here on
        return f"udpin://{self._daemon[0]}:{self._daemon[1]}"

    def close(self) -> None:
        """Close every socket."""
        for end in self._ends:
            end.close()

    def use(self, *rules: Rule) -> None:
        """Put these rules in force, in place of those before."""
        self.rules = rules
        self._met.clear()

    async def forge(self, kind: str, fields: Mapping[str, Any], *, system: int = 1, foreign: bool = False) -> None:
        """Send the daemon a message as if the autopilot had; ``foreign``: from another socket than the link's."""
        end = await self._end(lambda *_: None, 0) if foreign else self._up
        assert self._daemon is not None
        end.sendto(packed(kind, fields, system), self._daemon)

    async def station(self, kind: str, fields: Mapping[str, Any], *, system: int = 255) -> None:
        """Send the autopilot a message from a second ground station."""
        assert self._autopilot is not None
        end = await self._end(lambda *_: None, 0)
        end.sendto(packed(kind, fields, system, 190), self._autopilot)

    async def _end(self, receive: Any, port: int) -> asyncio.DatagramTransport:
        made, _ = await asyncio.get_running_loop().create_datagram_endpoint(
            lambda: _End(receive), local_addr=(HOST, port)
        )
        self._ends.append(made)
        return made

    def _from_autopilot(self, data: bytes, sender: Address) -> None:
        self._autopilot = sender
        self._pass(Direction.DOWN, data)

    def _from_daemon(self, data: bytes, _: Address) -> None:
        self._pass(Direction.UP, data)

    def _pass(self, direction: Direction, data: bytes) -> None:
        kinds = frozenset(kinds_of(data))
        for kind in kinds:
            self.passed[direction, kind] += 1
        if not kinds.isdisjoint(_COMMANDS):
            self.passed.update((direction, f"COMMAND {number}") for number in commands_of(data))
        if not self._passes(direction, data):
            return
        rule = self._rule(direction, kinds)
        if rule is None:
            self._send(direction, data)
        elif not rule.drop:
            changed = _changed(data, rule.change) if rule.change else data
            for _ in range(1 + rule.copies):
                delay = rule.delay_s + self._rng.random() * rule.jitter_s
                asyncio.get_running_loop().call_later(delay / self._speed, self._send, direction, changed)

    def _rule(self, direction: Direction, kinds: frozenset[str]) -> Rule | None:
        for number, rule in enumerate(self.rules):
            if rule.direction is not direction or not rule.meets(kinds):
                continue
            if rule.times is not None and self._met[number] >= rule.times:
                continue
            if rule.share < 1.0 and self._rng.random() >= rule.share:
                continue
            self._met[number] += 1
            return rule
        return None

    def _send(self, direction: Direction, data: bytes) -> None:
        end, target = (self._up, self._daemon) if direction is Direction.DOWN else (self._down, self._autopilot)
        if target is not None and not end.is_closing():
            end.sendto(data, target)


class _End(asyncio.DatagramProtocol):
    def __init__(self, receive: Any) -> None:
        self._receive = receive

    def datagram_received(self, data: bytes, addr: Any) -> None:
        self._receive(data, addr)

    def error_received(self, exc: Exception) -> None:
        """A daemon that is down refuses datagrams: that is part of a fault."""


def _changed(data: bytes, change: Mapping[str, Any]) -> bytes:
    """Return a datagram with fields replaced in the messages that have them."""
    decoder = mavlink.MAVLink(None)
    out = bytearray()
    for found in decoder.parse_buffer(data) or []:
        values = {name: change.get(name, getattr(found, name)) for name in found.fieldnames}
        out += packed(found.get_type(), values, found.get_srcSystem(), found.get_srcComponent())
    return bytes(out)
