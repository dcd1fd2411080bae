"""A process of its own that samples beside a benchmark: says ``ready``, samples until its standard input ends, then
prints one JSON object. It goes first on the processor where it may, as the daemon does: it measures when
things happened, not when it found time to look.

``python -m benchmarks.probe idle``: an asyncio loop that does nothing else: its lag, and the jitter of a 5 Hz timer.
``python -m benchmarks.probe heartbeats URL``: a client of the daemon: when its heartbeats arrive.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import sys
import time
from collections.abc import Sequence
from typing import Any
from urllib.parse import urlsplit

from benchmarks.figures import BenchmarkError, interval_jitter
from hawk.comm.base_socket import BaseSocket
from hawk.runtime.performance import LoopLag, percentile
from hawk.runtime.process import LOOP_NICENESS, set_niceness, set_session_niceness

HEARTBEAT_S = 0.2
"""Heartbeats come at 5 Hz."""
_STOP_S = 10.0


class Probe:
    """Starts a probe and ends it; for the benchmark's side."""

    def __init__(self, *arguments: str) -> None:
        self._arguments = arguments
        self._process: asyncio.subprocess.Process | None = None

    async def start(self) -> None:
        """Start and wait until it samples. Raises BenchmarkError."""
        self._process = await asyncio.create_subprocess_exec(
            sys.executable, "-m", "benchmarks.probe", *self._arguments,
            stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE, start_new_session=True,
        )  # fmt: skip
        assert self._process.stdout is not None
        if await self._process.stdout.readline() != b"ready\n":
            await self.close()
            raise BenchmarkError(f"the probe {self._arguments[0]} did not start; see its message above")

    async def finish(self) -> dict[str, Any]:
        """End the sampling and return what was found. Raises BenchmarkError."""
        assert self._process is not None
        assert self._process.stdin is not None
        self._process.stdin.close()
        try:
            async with asyncio.timeout(_STOP_S):
                output, _ = await self._process.communicate()
            return dict(json.loads(output))
        except (TimeoutError, ValueError) as error:
            raise BenchmarkError(f"the probe {self._arguments[0]} did not answer") from error

    async def close(self) -> None:
        """End the process if it still runs."""
        if self._process is not None and self._process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                self._process.kill()
            await self._process.wait()


async def idle() -> dict[str, Any]:
    """Sample an idle loop, real milliseconds."""
    lag = LoopLag()
    ticks: list[float] = []
    sampling = asyncio.create_task(lag.run(), name="probe-lag")
    ticking = asyncio.create_task(_tick(ticks), name="probe-timer")
    await _until_asked_to_end()
    await _end(sampling, ticking)
    summary = lag.summary()
    jitter = interval_jitter(ticks, HEARTBEAT_S)
    return {
        "lag_p50_ms": summary.p50_ms,
        "lag_p99_ms": summary.p99_ms,
        "lag_max_ms": summary.max_ms,
        "samples": summary.samples,
        "jitter_p99_ms": percentile(jitter, 99),
    }


def is_heartbeat(text: str) -> bool:
    """Return True for a heartbeat as the drone sends it; it is not read, which would delay the next arrival."""
    return '"Type":"Heartbeat"' in text


async def heartbeats(url: str) -> dict[str, Any]:
    """Take the arrival of each heartbeat at a client that does nothing with it."""
    address = urlsplit(url)
    arrivals: list[float] = []
    socket = BaseSocket(address.hostname or "127.0.0.1", address.port or 3000)
    try:
        await socket.connect(10.0)
        reading = asyncio.create_task(_read(socket, arrivals), name="probe-read")
        await _until_asked_to_end()
        await _end(reading)
    finally:
        await socket.close()
    jitter = interval_jitter(arrivals, HEARTBEAT_S)
    span = arrivals[-1] - arrivals[0] if len(arrivals) > 1 else 0.0
    return {
        "jitter_p50_ms": percentile(jitter, 50),
        "jitter_p99_ms": percentile(jitter, 99),
        "rate_hz": (len(arrivals) - 1) / span if span > 0 else None,
        "samples": len(arrivals),
    }


def main(arguments: Sequence[str]) -> int:
    """Run one probe."""
    set_niceness(LOOP_NICENESS)
    set_session_niceness(LOOP_NICENESS)
    match list(arguments):
        case ["idle"]:
            found = asyncio.run(idle())
        case ["heartbeats", url]:
            found = asyncio.run(heartbeats(url))
        case _:
            print(__doc__, file=sys.stderr)
            return 2
    print(json.dumps(found), flush=True)
    return 0


async def _tick(ticks: list[float]) -> None:
    loop = asyncio.get_running_loop()
    due = loop.time()
    while True:
        ticks.append(time.perf_counter())
        due += HEARTBEAT_S
        await asyncio.sleep(due - loop.time())


async def _read(socket: BaseSocket, arrivals: list[float]) -> None:
    while True:
        text = await socket.receive()
        if is_heartbeat(text):
            arrivals.append(time.perf_counter())


async def _until_asked_to_end() -> None:
    """Say that the sampling is on, and wait for the end of standard input."""
    loop = asyncio.get_running_loop()
    ended = asyncio.Event()

    def look() -> None:
        if not os.read(0, 1024):
            ended.set()

    loop.add_reader(0, look)
    print("ready", flush=True)
    await ended.wait()
    loop.remove_reader(0)


async def _end(*tasks: asyncio.Task[None]) -> None:
    for task in tasks:
        task.cancel()
    for result in await asyncio.gather(*tasks, return_exceptions=True):
        if isinstance(result, Exception):
            raise result


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
