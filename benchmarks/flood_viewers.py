"""Viewers that flood a daemon: a program of its own, so that it can leave the processor to those that are measured.

``python -m benchmarks.flood_viewers URL COUNT NICENESS`` sends until standard input ends and prints its counts as JSON.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import json
import math
import sys
from dataclasses import asdict, dataclass
from typing import Any, Final

import aiohttp

from hawk.runtime.process import set_niceness, set_session_niceness

CORNERS: Final = 69
RETRY_S: Final = 0.1


@dataclass(slots=True)
class Counts:
    """Counts of all viewers."""

    sent: int = 0
    answered: int = 0
    refused_as_too_many: int = 0
    disconnected: int = 0


def valid_commands() -> list[str]:
    """Return valid commands of every cost that a viewer may send, as JSON: asked, refused, or acted on at once."""
    turns = [2 * math.pi * k / CORNERS for k in range(CORNERS)]
    corners = [
        {"Latitude": 43.26 + 0.002 * math.cos(turn), "Longitude": -79.92 + 0.002 * math.sin(turn)} for turn in turns
    ]
    commands: list[dict[str, Any]] = [
        {"Type": "Check Fence", "Corners": corners, "Ceiling": 80.0},
        {"Type": "Set Fence", "Corners": corners, "Ceiling": 80.0},
        {"Type": "Route Request", "X": 5.0, "Y": 5.0},
        {"Type": "Compulsive Move", "X": 5.0, "Y": 5.0},
        {"Type": "Autonomous Explore"},
        {"Type": "Arm"},
        {"Type": "Land"},
        {"Type": "Kill Request"},
        {"Type": "Heartbeat"},
    ]
    return [json.dumps(command | {"Id": number}) for number, command in enumerate(commands)]


async def flood(url: str, viewers: int, counts: Counts) -> None:
    """Send until it is cancelled."""
    async with asyncio.TaskGroup() as group:
        for number in range(viewers):
            group.create_task(_viewer(url, counts), name=f"viewer-{number}")


async def _viewer(url: str, counts: Counts) -> None:
    """Send without end, and connect again after each disconnection."""
    while True:
        with contextlib.suppress(aiohttp.ClientError, ConnectionError):
            async with aiohttp.ClientSession() as session, session.ws_connect(f"{url}ws", max_msg_size=0) as socket:
                sending = asyncio.create_task(_send(socket, counts), name="viewer-sends")
                try:
                    await _count(socket, counts)
                finally:
                    sending.cancel()
                    await asyncio.gather(sending, return_exceptions=True)
        await asyncio.sleep(RETRY_S)


async def _send(socket: aiohttp.ClientWebSocketResponse, counts: Counts) -> None:
    for text in itertools.cycle(valid_commands()):
        await socket.send_str(text)
        counts.sent += 1
        await asyncio.sleep(0)


async def _count(socket: aiohttp.ClientWebSocketResponse, counts: Counts) -> None:
    async for message in socket:
        if message.type is aiohttp.WSMsgType.TEXT and '"Type":"Heartbeat"' not in message.data[:200]:
            counts.answered += 1
            counts.refused_as_too_many += "Too many commands" in message.data
    counts.disconnected += socket.close_code == aiohttp.WSCloseCode.POLICY_VIOLATION


async def _until_input_ends(url: str, viewers: int) -> Counts:
    counts = Counts()
    flooding = asyncio.create_task(flood(url, viewers, counts), name="flood")
    reader = asyncio.StreamReader()
    protocol = asyncio.StreamReaderProtocol(reader)
    await asyncio.get_running_loop().connect_read_pipe(lambda: protocol, sys.stdin)
    await reader.read()
    flooding.cancel()
    await asyncio.gather(flooding, return_exceptions=True)
    return counts


def main() -> None:
    """Flood, and print the counts."""
    url, viewers, niceness = sys.argv[1:]
    set_niceness(int(niceness))
    set_session_niceness(int(niceness))
    print(json.dumps(asdict(asyncio.run(_until_input_ends(url, int(viewers))))))


if __name__ == "__main__":
    main()
