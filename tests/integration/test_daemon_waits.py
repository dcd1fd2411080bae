"""A camera and an autopilot that are not there yet: awaited, reported, and found when they come."""

from __future__ import annotations

import asyncio
import contextlib
import json
import sys
from collections.abc import AsyncIterator
from pathlib import Path
from urllib.parse import urlsplit

import aiohttp
import pytest

from hawk.comm.protocol.commands import Arm
from hawk.model.operation import StateName
from hawk.sim.launch import free_udp_port
from tests.integration.daemon_support import health, operator
from tests.integration.sim_support import free_tcp_port, small_picture
from tests.pace import PATIENCE_S
from tests.unit.daemon.full_pipe import full_pipe

pytestmark = pytest.mark.integration


@contextlib.asynccontextmanager
async def process(*arguments: str, stderr: int | None = None) -> AsyncIterator[asyncio.subprocess.Process]:
    """Run a module of ours; ended when left. It ends with status 0. ``stderr``: a descriptor, else the test's own."""
    made = await asyncio.create_subprocess_exec(
        sys.executable, "-m", *arguments, stdout=asyncio.subprocess.PIPE, stderr=stderr
    )
    try:
        yield made
    finally:
        made.terminate()
        async with asyncio.timeout(PATIENCE_S):
            await made.communicate()
    assert made.returncode == 0


async def line(made: asyncio.subprocess.Process) -> str:
    assert made.stdout is not None
    async with asyncio.timeout(PATIENCE_S):
        return (await made.stdout.readline()).decode()


@contextlib.asynccontextmanager
async def hawk_sim(folder: Path, autopilot_port: int) -> AsyncIterator[str]:
    """Run a simulated drone; gives the address of its camera."""
    world = [f"--world={small_picture(folder)}", "--metres-per-pixel=0.5"]
    links = [f"--mavlink=udpout:127.0.0.1:{autopilot_port}", "--http=127.0.0.1:0"]
    async with process("hawk.sim.cli", *world, *links) as made:
        yield json.loads(await line(made))["http"]


@contextlib.asynccontextmanager
async def passed_on(port: int, to: str) -> AsyncIterator[None]:
    """Serve on a port what another server serves."""
    place = urlsplit(to)

    async def pump(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with contextlib.suppress(ConnectionError):
            while data := await reader.read(65536):
                writer.write(data)
                await writer.drain()
        writer.close()

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        there, back = await asyncio.open_connection(place.hostname, place.port)
        await asyncio.gather(pump(reader, back), pump(there, writer))

    server = await asyncio.start_server(serve, "127.0.0.1", port)
    try:
        yield
    finally:
        server.close()
        await server.wait_closed()


async def test_what_is_absent_at_the_start_is_waited_for_and_found(tmp_path: Path) -> None:
    autopilot_port, camera_port, page_port = free_udp_port(), free_tcp_port(), free_tcp_port()
    links = ["--autopilot", f"udpin://127.0.0.1:{autopilot_port}", "--camera", f"http://127.0.0.1:{camera_port}/stream"]
    own = ["--port", str(page_port), "--store", str(tmp_path / "store")]
    async with contextlib.AsyncExitStack() as running:
        daemon = await running.enter_async_context(process("hawk.cli", "run", *links, *own))
        url = f"http://127.0.0.1:{page_port}/"
        assert await line(daemon) == f"hawk: open {url}\n"
        pilot = await running.enter_async_context(operator(url))

        alone = await pilot.until(lambda b: str(camera_port) in health(b, "camera").reason)
        assert not alone.connected
        assert not health(alone, "link").healthy
        assert health(alone, "link").reason
        assert alone.health_status == 1
        await pilot.take_control()
        assert "autopilot" in (await pilot.refusal(Arm())).lower()

        http = await running.enter_async_context(hawk_sim(tmp_path, autopilot_port))
        found = await pilot.until(lambda b: b.connected and health(b, "link").healthy)
        assert found.state == StateName.IDLE
        assert not health(found, "camera").healthy

        await running.enter_async_context(passed_on(camera_port, http))
        seen = await pilot.until(lambda b: health(b, "camera").healthy and health(b, "vision").healthy)
        assert seen.camera_age is not None
        assert await has_picture(url)


@pytest.mark.fault("standard error or the journal is not read")
async def test_a_log_that_nobody_reads_keeps_it_neither_from_starting_nor_from_ending(tmp_path: Path) -> None:
    page_port = free_tcp_port()
    settings = tmp_path / "config.toml"
    settings.write_text("[log]\nlevel = 'debug'\n")
    links = ["--autopilot", f"udpin://127.0.0.1:{free_udp_port()}", "--camera", f"http://127.0.0.1:{free_tcp_port()}/"]
    own = ["--config", str(settings), "--port", str(page_port), "--store", str(tmp_path / "store")]
    with full_pipe() as stderr:
        async with process("hawk.cli", "run", *links, *own, stderr=stderr) as daemon:
            url = f"http://127.0.0.1:{page_port}/"
            assert await line(daemon) == f"hawk: open {url}\n"
            async with operator(url) as pilot:
                beat = pilot.beat.sequence if pilot.drone.heartbeat else 0
                await pilot.until(lambda b: b.sequence > beat + 10)


async def has_picture(url: str) -> bool:
    """Return True when the daemon serves its camera's picture."""
    async with aiohttp.ClientSession() as session, session.get(f"{url}snapshot.jpg") as answer:
        return (await answer.read()).startswith(b"\xff\xd8")
