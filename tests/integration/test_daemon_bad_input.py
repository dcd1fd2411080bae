"""Whatever comes over the WebSocket: an answer that names the field; nothing is lost, and the heartbeats go on."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator
from typing import Any, Self

import aiohttp
import pytest
import pytest_asyncio

from hawk.comm.protocol.commands import MAX_MESSAGE_BYTES
from hawk.survey.stack import SimulatedStack
from hawk.web.ws import READ_LIMIT_BYTES
from tests.integration.daemon_support import operator, over_a_picture
from tests.pace import PATIENCE_S

pytestmark = [pytest.mark.integration, pytest.mark.asyncio(loop_scope="module")]

MOVE = '{"Type": "Compulsive Move", "Id": 7, "X": %s, "Y": 0}'
BAD: dict[str, tuple[str | bytes, list[str]]] = {
    "not JSON": ("{", ["not JSON"]),
    "empty": ("", ["not JSON"]),
    "no object": ("[1, 2]", ["message"]),
    "no type": ('{"Id": 7}', ["Type", "missing"]),
    "a type that is no text": ('{"Type": 5}', ["Type"]),
    "unknown type": ('{"Type": "Loop The Loop", "Id": 7}', ["Type", "Loop The Loop"]),
    "a message of ours": ('{"Type": "Ack", "Id": 7}', ["Type", "Ack"]),
    "unknown key": ('{"Type": "Hold", "Id": 7, "Fast": true}', ["Fast"]),
    "missing key": ('{"Type": "Compulsive Move", "Id": 7, "X": 1}', ["Y"]),
    "NaN": (MOVE % "NaN", ["X"]),
    "infinity": (MOVE % "-Infinity", ["X"]),
    "out of range": (MOVE % "1e9", ["X", "10000"]),
    "beyond numbers": (MOVE % "1e999", ["X"]),
    "a number as text": (MOVE % '"5"', ["X", "number"]),
    "a height of zero": ('{"Type": "Configure", "Id": 7, "Min": 0, "Des": 20, "Max": 30}', ["Min"]),
    "heights that fall": ('{"Type": "Configure", "Id": 7, "Min": 30, "Des": 20, "Max": 10}', ["Des", "Min"]),
    "above the ceiling": ('{"Type": "Configure", "Id": 7, "Min": 10, "Des": 20, "Max": 999}', ["Max", "ceiling"]),
    "an endless id": (json.dumps({"Type": "Hold", "Id": "i" * 65}), ["Id"]),
    "a kill without a token": ('{"Type": "Kill", "Id": 7}', ["Token"]),
    "a kill with another token": ('{"Type": "Kill", "Id": 7, "Token": "0123456789abcdef"}', ["Token"]),
    "nested without end": ("[" * 5000 + "]" * 5000, ["JSON"]),
    "half of a pair": ('{"Type": "Hold", "Id": "\\ud800"}', ["JSON"]),
    "an id of thousands of digits": ('{"Type": "Hold", "Id": ' + "9" * 5000 + "}", ["JSON", "number"]),
    "too large": (json.dumps({"Type": "Hold", "Id": 7, "Pad": "x" * MAX_MESSAGE_BYTES}), ["large", "16384"]),
    "binary": (b'{"Type": "Hold"}', ["binary", "JSON"]),
}
WRONG_STATE = {
    "Takeoff": "Arm first.",
    "Autonomous Explore": "Take off first.",
    "Land": "On the ground.",
    "Return To Launch": "Is at home.",
    "Disarm": "The motors are off.",
    "Resume": "Nobody else flies.",
    "Hold": "On the ground.",
}


class Wire:
    """A bare WebSocket: every answer in order, heartbeats apart."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self._socket = socket
        self.beats: list[int] = []

    async def send(self, message: str | bytes) -> None:
        if isinstance(message, bytes):
            await self._socket.send_bytes(message)
        else:
            await self._socket.send_str(message)

    async def answer(self) -> dict[str, Any]:
        while True:
            found = json.loads(await self._socket.receive_str(timeout=PATIENCE_S))
            if found["Type"] == "Heartbeat":
                self.beats.append(found["Sequence"])
            elif found["Type"] != "Welcome":
                return dict(found)

    async def until_beats(self, count: int) -> None:
        while len(self.beats) < count:
            found = json.loads(await self._socket.receive_str(timeout=PATIENCE_S))
            assert found["Type"] in ("Heartbeat", "Welcome")
            if found["Type"] == "Heartbeat":
                self.beats.append(found["Sequence"])

    async def closing(self) -> int | None:
        while (message := await self._socket.receive(timeout=PATIENCE_S)).type != aiohttp.WSMsgType.CLOSE:
            assert message.type is aiohttp.WSMsgType.TEXT, message
        return int(message.data)


class Caller:
    """Opens bare WebSockets."""

    def __init__(self, url: str) -> None:
        self.url = url
        self._session = aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True))

    async def wire(self, *, autoclose: bool = True) -> Wire:
        return Wire(await self._session.ws_connect(f"{self.url}ws", autoclose=autoclose))

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self._session.close()


@pytest_asyncio.fixture(loop_scope="module", scope="module")
async def url(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[str]:
    """A daemon that has found its autopilot."""
    stack: SimulatedStack = over_a_picture(tmp_path_factory.mktemp("input"))
    try:
        found = (await stack.start()).url
        async with operator(found) as pilot:
            await pilot.until(lambda b: b.connected and bool(b.checks))
        yield found
    finally:
        await stack.stop()


@pytest_asyncio.fixture(loop_scope="module")
async def caller(url: str) -> AsyncIterator[Caller]:
    async with Caller(url) as made:
        yield made


async def in_control(caller: Caller) -> Wire:
    wire = await caller.wire()
    while True:
        await wire.send('{"Type": "Control", "Action": "Request", "Id": "control"}')
        if (await wire.answer())["Accepted"]:
            return wire
        await wire.until_beats(len(wire.beats) + 1)


@pytest.mark.parametrize("name", BAD)
async def test_bad_input_is_refused_with_the_field(caller: Caller, name: str) -> None:
    message, named = BAD[name]
    wire = await in_control(caller)
    await wire.send(message)
    refused = await wire.answer()
    assert refused["Type"] == "Ack"
    assert refused["Accepted"] is False
    for word in named:
        assert word in refused["Reason"], refused
    await wire.send('{"Type": "Control", "Action": "Release", "Id": "after"}')
    assert await wire.answer() == {"Type": "Ack", "Id": "after", "Accepted": True, "Reason": ""}


@pytest.mark.parametrize("command", WRONG_STATE)
async def test_a_command_in_the_wrong_state_is_refused_with_the_reason(caller: Caller, command: str) -> None:
    wire = await in_control(caller)
    await wire.send(json.dumps({"Type": command, "Id": command}))
    answer = await wire.answer()
    (said,) = answer.pop("Sentences")
    assert said["Text"] == WRONG_STATE[command]
    assert answer == {"Type": "Ack", "Id": command, "Accepted": False, "Reason": WRONG_STATE[command]}
    await wire.send('{"Type": "Control", "Action": "Release"}')
    assert (await wire.answer())["Accepted"]


async def test_all_of_it_at_once_loses_nothing_and_holds_up_no_heartbeat(caller: Caller) -> None:
    """After each piece of bad input a good one: every one is answered, and another client notices nothing."""
    watcher, wire = await caller.wire(), await in_control(caller)
    await watcher.until_beats(1)
    for number, (message, _) in enumerate(BAD.values()):
        await wire.send(message)
        await wire.send(json.dumps({"Type": "Heartbeat", "Id": f"good {number}"}))
    answers = [await wire.answer() for _ in range(2 * len(BAD))]
    assert [a["Id"] for a in answers if a["Accepted"]] == [f"good {number}" for number in range(len(BAD))]
    await watcher.until_beats(len(watcher.beats) + 5)
    await wire.until_beats(len(wire.beats) + 5)
    assert watcher.beats == sorted(set(watcher.beats))


async def test_a_flood_ends_the_flooders_connection_alone(caller: Caller) -> None:
    watcher, wire = await caller.wire(), await caller.wire(autoclose=False)
    await wire.send("x" * (READ_LIMIT_BYTES + 1))
    assert await wire.closing() == aiohttp.WSCloseCode.MESSAGE_TOO_BIG
    await watcher.until_beats(5)
    again = await caller.wire()
    await again.until_beats(2)
