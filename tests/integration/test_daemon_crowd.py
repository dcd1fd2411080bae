"""A crowd at the door of a real daemon: 4,100 requests that are never finished, from one address, without the token."""

from __future__ import annotations

import asyncio
import contextlib
import os
import resource
import socket
import stat
import sys
from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from hawk.comm.protocol.commands import Ack, OperatorHeartbeat
from hawk.sim.launch import free_udp_port
from hawk.survey.client import DroneClient
from tests.integration.daemon_support import Operator
from tests.integration.sim_support import free_tcp_port
from tests.pace import PATIENCE_S

pytestmark = [pytest.mark.integration, pytest.mark.alone]

CROWD = 4100
AT_ONCE = 100
HALF = b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX-Slow: "
TOKEN = "correct-horse-battery"
DESCRIPTORS = 512
"""Limit of the daemon; far fewer than the crowd wants."""
GROWTH_MB = 40.0
LOG_LINES = 40
BEATS_STILL = 10
"""Heartbeats, at 5 Hz."""


@dataclass(frozen=True)
class Daemon:
    """A daemon that waits for its autopilot; the page is open."""

    process: asyncio.subprocess.Process
    port: int
    log: Path
    store: Path

    @property
    def descriptors(self) -> int:
        return len(os.listdir(f"/proc/{self.process.pid}/fd"))

    @property
    def memory_mb(self) -> float:
        pages = int(Path(f"/proc/{self.process.pid}/statm").read_text().split()[1])
        return pages * resource.getpagesize() / 1e6


@pytest.fixture
async def daemon(tmp_path: Path) -> AsyncIterator[Daemon]:
    port, log, store = free_tcp_port(), tmp_path / "log", tmp_path / "store"
    links = ["--autopilot", f"udpin://127.0.0.1:{free_udp_port()}", "--camera", f"http://127.0.0.1:{free_tcp_port()}/"]
    own = ["--port", str(port), "--store", str(store)]
    limited = ["sh", "-c", f'ulimit -Sn {DESCRIPTORS}; exec "$@"', "limited"]
    with log.open("wb") as file:
        made = await asyncio.create_subprocess_exec(
            *limited, sys.executable, "-m", "hawk.cli", "run", *links, *own,
            stdout=asyncio.subprocess.PIPE, stderr=file, env={**os.environ, "HAWK_WEB__TOKEN": TOKEN},
        )  # fmt: skip
        try:
            assert made.stdout is not None
            async with asyncio.timeout(PATIENCE_S):
                line = (await made.stdout.readline()).decode()
            assert line.startswith("hawk: open "), line
            assert TOKEN not in line
            yield Daemon(made, port, log, store)
        finally:
            made.terminate()
            async with asyncio.timeout(PATIENCE_S):
                await made.communicate()
    assert made.returncode == 0


@pytest.fixture
def many_sockets() -> Iterator[None]:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, min(hard, CROWD + 500)), hard))
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


@contextlib.asynccontextmanager
async def operator(daemon: Daemon) -> AsyncIterator[Operator]:
    async with DroneClient("127.0.0.1", daemon.port, token=TOKEN) as drone:
        yield Operator(drone)


async def half_sent(port: int) -> socket.socket:
    made = socket.socket()
    made.setblocking(False)
    loop = asyncio.get_running_loop()
    await loop.sock_connect(made, ("127.0.0.1", port))
    with contextlib.suppress(ConnectionError):
        await loop.sock_sendall(made, HALF)
    return made


async def settled_memory(daemon: Daemon, pilot: Operator) -> float:
    """Return the memory, MB, once it has stood still for two seconds: the algorithms are loaded after the start."""
    last, still = daemon.memory_mb, 0
    while still < BEATS_STILL:
        await pilot.drone.next_heartbeat(PATIENCE_S)
        now = daemon.memory_mb
        still = still + 1 if abs(now - last) < 1.0 else 0
        last = now
    return last


@pytest.mark.fault(
    "4,100 half-sent HTTP requests without a token, from one address",
    "the operator's heartbeats are answered throughout, a new page opens; at most 128 connections of one "
    "address wait (here 90 descriptors of 512), 3 log lines",
)
@pytest.mark.usefixtures("many_sockets")
async def test_a_crowd_of_half_sent_requests_costs_the_operator_nothing(daemon: Daemon) -> None:
    crowd: list[socket.socket] = []
    try:
        async with operator(daemon) as pilot:
            await pilot.take_control()
            await pilot.until(lambda b: b.state == "Idle")
            before, most = await settled_memory(daemon, pilot), 0
            while len(crowd) < CROWD:
                crowd += await asyncio.gather(*(half_sent(daemon.port) for _ in range(AT_ONCE)))
                answer = await pilot.drone.ask(OperatorHeartbeat())
                assert isinstance(answer, Ack)
                assert answer.accepted
                most = max(most, daemon.descriptors)
            async with operator(daemon) as watcher:
                await watcher.until(lambda b: b.controller is not None)
            assert most < DESCRIPTORS - 100
            assert daemon.memory_mb - before < GROWTH_MB
    finally:
        for each in crowd:
            each.close()
    lines = daemon.log.read_text().splitlines()
    assert len(lines) < LOG_LINES, lines
    assert not [line for line in lines if "Traceback" in line]


@pytest.mark.fault(
    "the daemon is started by systemd",
    "the token is not in the journal, but in page-address, mode 0600",
)
async def test_the_token_is_in_a_file_of_this_user_and_not_in_the_log(daemon: Daemon) -> None:
    path = daemon.store / "page-address"
    assert path.read_text() == f"http://127.0.0.1:{daemon.port}/?token={TOKEN}\n"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert TOKEN not in daemon.log.read_text()
