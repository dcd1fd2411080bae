from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.sim.launch import free_udp_port
from proving.faults.proxy import HOST, Direction, Proxy, Rule, commands_of, kinds_of, packed
from proving.faults.station import command_fields

LANDED = {"vtol_state": 0, "landed_state": 1}
FLYING = {"vtol_state": 0, "landed_state": 2}
BEAT = {"type": 2, "autopilot": 3, "base_mode": 81, "custom_mode": 4, "system_status": 3, "mavlink_version": 3}


class Peer(asyncio.DatagramProtocol):
    """One end of the link: notes what comes, and from where."""

    def __init__(self) -> None:
        self.heard: asyncio.Queue[tuple[bytes, tuple[str, int]]] = asyncio.Queue()
        self.transport: Any = None

    def connection_made(self, transport: Any) -> None:
        self.transport = transport

    def datagram_received(self, data: bytes, addr: Any) -> None:
        self.heard.put_nowait((data, addr))

    async def kind(self) -> str:
        """Wait for a datagram; return its message's name."""
        async with asyncio.timeout(5.0):
            return next(kinds_of((await self.heard.get())[0]))


class Line:
    """Autopilot, proxy and daemon on free ports."""

    def __init__(self, speed: float) -> None:
        self.proxy = Proxy(speed)
        self.autopilot, self.daemon = Peer(), Peer()

    async def open(self) -> None:
        loop = asyncio.get_running_loop()
        self._port = free_udp_port()
        url = await self.proxy.open(f"udpin://{HOST}:{self._port}")
        await loop.create_datagram_endpoint(lambda: self.autopilot, local_addr=(HOST, 0))
        await loop.create_datagram_endpoint(lambda: self.daemon, local_addr=(HOST, int(url.rpartition(":")[2])))

    def close(self) -> None:
        self.autopilot.transport.close()
        self.daemon.transport.close()
        self.proxy.close()

    def down(self, kind: str, fields: dict[str, Any]) -> None:
        self.autopilot.transport.sendto(packed(kind, fields, 1), (HOST, self._port))

    async def introduce(self) -> tuple[str, int]:
        """Let both ends hear each other; return where the daemon answers."""
        self.down("HEARTBEAT", BEAT)
        async with asyncio.timeout(5.0):
            _, proxy = await self.daemon.heard.get()
        self.daemon.transport.sendto(packed("HEARTBEAT", BEAT, 245), proxy)
        assert await self.autopilot.kind() == "HEARTBEAT"
        return proxy


@pytest.fixture
async def line() -> AsyncIterator[Line]:
    made = Line(speed=1.0)
    await made.open()
    yield made
    made.close()


def test_every_message_of_a_datagram_is_named() -> None:
    old = mavlink.MAVLink(None, srcSystem=1)
    first = bytes(mavlink.MAVLink_heartbeat_message(**BEAT).pack(old, force_mavlink1=True))
    data = first + packed("EXTENDED_SYS_STATE", LANDED, 1)
    assert list(kinds_of(data)) == ["HEARTBEAT", "EXTENDED_SYS_STATE"]


@pytest.mark.parametrize("data", [b"", b"\xfd", b"hello, this is no MAVLink", b"\xfd\x09\x00\x00"])
def test_what_is_no_mavlink_names_nothing(data: bytes) -> None:
    assert list(kinds_of(data)) == []


def test_every_command_of_a_datagram_is_numbered() -> None:
    place = {"target_system": 1, "target_component": 1, "frame": 6, "current": 0, "autocontinue": 0}
    values = {"param1": 0, "param2": 0, "param3": 0, "param4": 0, "x": 1, "y": 2, "z": 3}
    data = packed("HEARTBEAT", BEAT, 1) + packed("COMMAND_LONG", command_fields(176, 1.0, 6.0), 245)
    data += packed("COMMAND_INT", {**place, **values, "command": 192}, 245)
    old = mavlink.MAVLink(None, srcSystem=1)
    data += bytes(mavlink.MAVLink_command_long_message(**command_fields(400, 1.0)).pack(old, force_mavlink1=True))
    assert list(commands_of(data)) == [176, 192, 400]
    assert list(commands_of(b"hello")) == []


async def test_commands_are_counted_by_number_too(line: Line) -> None:
    proxy = await line.introduce()
    line.daemon.transport.sendto(packed("COMMAND_LONG", command_fields(176, 1.0, 6.0), 245), proxy)
    assert await line.autopilot.kind() == "COMMAND_LONG"
    assert line.proxy.passed[Direction.UP, "COMMAND 176"] == 1


async def test_without_a_rule_both_directions_pass(line: Line) -> None:
    await line.introduce()
    assert line.proxy.passed == {(Direction.DOWN, "HEARTBEAT"): 1, (Direction.UP, "HEARTBEAT"): 1}


async def test_one_direction_is_cut_and_the_other_passes(line: Line) -> None:
    proxy = await line.introduce()
    line.proxy.use(Rule(Direction.DOWN, drop=True))
    line.down("HEARTBEAT", BEAT)
    line.daemon.transport.sendto(packed("HEARTBEAT", BEAT, 245), proxy)
    assert await line.autopilot.kind() == "HEARTBEAT"
    line.proxy.use()
    line.down("EXTENDED_SYS_STATE", LANDED)
    assert await line.daemon.kind() == "EXTENDED_SYS_STATE", "the HEARTBEAT before it was lost"


async def test_one_kind_is_lost_and_the_others_pass(line: Line) -> None:
    await line.introduce()
    line.proxy.use(Rule(Direction.DOWN, frozenset({"HEARTBEAT"}), drop=True))
    line.down("HEARTBEAT", BEAT)
    line.down("EXTENDED_SYS_STATE", LANDED)
    assert await line.daemon.kind() == "EXTENDED_SYS_STATE"


async def test_a_rule_meets_its_number_of_datagrams_and_no_more(line: Line) -> None:
    await line.introduce()
    line.proxy.use(Rule(Direction.DOWN, drop=True, times=2))
    for kind, fields in (("HEARTBEAT", BEAT), ("HEARTBEAT", BEAT), ("EXTENDED_SYS_STATE", LANDED)):
        line.down(kind, fields)
    assert await line.daemon.kind() == "EXTENDED_SYS_STATE"


async def test_copies_come_besides(line: Line) -> None:
    await line.introduce()
    line.proxy.use(Rule(Direction.DOWN, copies=2))
    line.down("HEARTBEAT", BEAT)
    assert [await line.daemon.kind() for _ in range(3)] == ["HEARTBEAT"] * 3


async def test_a_delayed_datagram_is_overtaken(line: Line) -> None:
    await line.introduce()
    line.proxy.use(Rule(Direction.DOWN, frozenset({"HEARTBEAT"}), delay_s=0.2))
    line.down("HEARTBEAT", BEAT)
    line.down("EXTENDED_SYS_STATE", LANDED)
    assert [await line.daemon.kind() for _ in range(2)] == ["EXTENDED_SYS_STATE", "HEARTBEAT"]


async def test_a_share_of_the_datagrams_is_lost_the_same_in_each_run() -> None:
    proxy = Proxy(1.0, seed=4)
    proxy.use(Rule(Direction.DOWN, drop=True, share=0.5))
    met = [proxy._rule(Direction.DOWN, frozenset()) is not None for _ in range(1000)]
    assert 430 < sum(met) < 570
    again = Proxy(1.0, seed=4)
    again.use(Rule(Direction.DOWN, drop=True, share=0.5))
    assert met == [again._rule(Direction.DOWN, frozenset()) is not None for _ in range(1000)]


async def test_fields_are_changed_and_the_rest_stays(line: Line) -> None:
    await line.introduce()
    line.proxy.use(Rule(Direction.DOWN, change={"landed_state": 1}))
    line.down("EXTENDED_SYS_STATE", FLYING)
    data, _ = await line.daemon.heard.get()
    (found,) = mavlink.MAVLink(None).parse_buffer(data)
    assert (found.landed_state, found.vtol_state, found.get_srcSystem()) == (1, 0, 1)


async def test_a_forged_message_comes_from_the_link_or_from_elsewhere(line: Line) -> None:
    proxy = await line.introduce()
    await line.proxy.forge("EXTENDED_SYS_STATE", LANDED)
    assert (await line.daemon.heard.get())[1] == proxy
    await line.proxy.forge("EXTENDED_SYS_STATE", LANDED, foreign=True, system=9)
    data, sender = await line.daemon.heard.get()
    assert sender != proxy
    assert mavlink.MAVLink(None).parse_buffer(data)[0].get_srcSystem() == 9


async def test_a_second_station_reaches_the_autopilot(line: Line) -> None:
    await line.introduce()
    await line.proxy.station("HEARTBEAT", BEAT)
    data, _ = await line.autopilot.heard.get()
    assert mavlink.MAVLink(None).parse_buffer(data)[0].get_srcSystem() == 255
