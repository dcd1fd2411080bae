"""The simulated drone with its whole daemon, as measurements start and read it."""

from __future__ import annotations

import contextlib
import math
from collections.abc import AsyncIterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final
from urllib.parse import urlsplit

import aiohttp
from playwright.async_api import Error as BrowserError

from benchmarks.figures import BenchmarkError
from benchmarks.probe import Probe
from hawk.comm.base_socket import ConnectionTimeout, FailedToSend
from hawk.survey.client import DroneClient, LinkLostError
from hawk.survey.handset import SurveyError
from hawk.survey.stack import Ready, SimulatedStack, StackError

QUIET_CORES: Final = 0.2
"""Others that use more of the machine than this spoil the figures."""
FAULTS: Final = (
    StackError, SurveyError, LinkLostError, FailedToSend, ConnectionTimeout, BrowserError, aiohttp.ClientError, OSError,
)  # fmt: skip
"""Reasons for which a flight is not measured."""


@contextlib.asynccontextmanager
async def running(stack: SimulatedStack, folder: Path) -> AsyncIterator[Ready]:
    """Run simulator and daemon. Raises BenchmarkError, which names the folder of the logs, for every fault within."""
    try:
        yield await stack.start()
    except FAULTS as error:
        raise BenchmarkError(f"{error} (logs in {folder})") from error
    finally:
        await stack.stop()


@contextlib.asynccontextmanager
async def probed(url: str) -> AsyncIterator[dict[str, dict[str, Any]]]:
    """Let an idle loop and a client's heartbeats be sampled; their samples are there afterwards, by their names."""
    probes = {"idle": Probe("idle"), "heartbeats": Probe("heartbeats", url)}
    found: dict[str, dict[str, Any]] = {}
    try:
        for probe in probes.values():
            await probe.start()
        yield found
        found |= {name: await probe.finish() for name, probe in probes.items()}
    finally:
        for probe in probes.values():
            await probe.close()


def client(url: str) -> DroneClient:
    """Return a client of the daemon at an address; it is not connected yet."""
    place = urlsplit(url)
    return DroneClient(place.hostname or "127.0.0.1", place.port or 3000)


async def performance(url: str) -> dict[str, Any]:
    """Return the daemon's own account of the last minute. Raises aiohttp.ClientError."""
    timeout = aiohttp.ClientTimeout(total=30)
    async with aiohttp.ClientSession(timeout=timeout) as session, session.get(f"{url}api/performance") as response:
        response.raise_for_status()
        return dict(await response.json())


def void_by(reasons: Sequence[str], cores: Mapping[str, float]) -> str:
    """Return why figures do not count, empty when they do: the reasons, and others that used the machine meanwhile."""
    others = cores.get("others", math.inf)
    busy = [f"other programs used {others:.2f} cores meanwhile"] if others > QUIET_CORES else []
    return f"VOID: {'; '.join([*reasons, *busy])}" if reasons or busy else ""
