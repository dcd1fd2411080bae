"""A page beside the viewers, a process of its own: round trips of commands.

``python -m benchmarks.video.control URL SECONDS`` sends the operator's sign of life 20 times a second over ``/ws`` and
prints the milliseconds to each answer as a JSON list.
"""

from __future__ import annotations

import asyncio
import json
import sys
import time
from itertools import count
from typing import Final

import aiohttp

INTERVAL_S: Final = 0.05
PATIENCE_S: Final = 10.0


async def round_trips(url: str, seconds: float) -> list[float]:
    """Return the milliseconds of each round trip."""
    times: list[float] = []
    async with aiohttp.ClientSession() as session, session.ws_connect(f"{url}/ws") as socket:
        end = time.monotonic() + seconds
        for number in count(1):
            due = time.monotonic() + INTERVAL_S
            times.append(await _round_trip(socket, number))
            if due >= end:
                return times
            await asyncio.sleep(due - time.monotonic())
    raise AssertionError("unreachable")


async def _round_trip(socket: aiohttp.ClientWebSocketResponse, number: int) -> float:
    begun = time.perf_counter()
    await socket.send_str(json.dumps({"Type": "Heartbeat", "Id": number}))
    async with asyncio.timeout(PATIENCE_S):
        while True:
            found = json.loads(await socket.receive_str())
            if found["Type"] == "Ack" and found["Id"] == number:
                return (time.perf_counter() - begun) * 1e3


if __name__ == "__main__":
    print(json.dumps(asyncio.run(round_trips(sys.argv[1], float(sys.argv[2])))))
