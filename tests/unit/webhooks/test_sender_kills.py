"""Sender and receiver are killed with -9 again and again: no report is lost, and doubles have the same id."""

from __future__ import annotations

import asyncio
import json
import os
import random
import sqlite3
import sys
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, closing
from pathlib import Path

import pytest

HERE = Path(__file__).parent
ROOT = HERE.parents[2]
KILLS = 50
SURVEYS = 300


async def started(name: str, *arguments: object) -> tuple[asyncio.subprocess.Process, str]:
    command = (sys.executable, str(HERE / name), *map(str, arguments))
    process = await asyncio.create_subprocess_exec(
        *command, stdout=asyncio.subprocess.PIPE, env={**os.environ, "PYTHONPATH": str(ROOT)}
    )
    assert process.stdout is not None
    async with asyncio.timeout(60):
        line = (await process.stdout.readline()).decode().strip()
    assert line, f"{name} did not start"
    return process, line


@asynccontextmanager
async def killed_at_the_end(processes: dict[str, asyncio.subprocess.Process]) -> AsyncIterator[None]:
    try:
        yield
    finally:
        for process in processes.values():
            if process.returncode is None:
                process.kill()
            await process.wait()


@pytest.mark.flight
@pytest.mark.timeout(600)
async def test_nothing_is_lost_and_doubles_have_the_same_id(tmp_path: Path) -> None:
    store, received, chance = tmp_path / "lots.db", tmp_path / "received.txt", random.Random(39)
    began = time.time()
    receiver, port = await started("killed_receiver.py", 0, received)
    running = {"receiver": receiver}
    async with killed_at_the_end(running):
        url = f"http://127.0.0.1:{port}/"
        arguments: dict[str, tuple[object, ...]] = {
            "receiver": (port, received),
            "sender": (store, url, SURVEYS, began),
        }
        running["sender"], _ = await started("killed_sender.py", *arguments["sender"])
        for number in range(KILLS):
            await asyncio.sleep(chance.uniform(0.01, 0.4))  # a moment that nothing else decides
            name = ("receiver", "sender")[number % 2]
            assert running[name].returncode is None, f"the {name} ended before {number} kills: store more surveys"
            running[name].kill()
            await running[name].wait()
            running[name], _ = await started(f"killed_{name}.py", *arguments[name])
        async with asyncio.timeout(300):
            assert await running["sender"].wait() == 0
    with closing(sqlite3.connect(store)) as opened:
        surveys = {row[0] for row in opened.execute("SELECT id FROM survey")}
        messages = opened.execute("SELECT count(*) FROM outbox").fetchone()[0]
    lines = [line.split(" ", 1) for line in received.read_text().splitlines()]
    bodies: dict[str, str] = {}
    for named, body in lines:
        assert bodies.setdefault(named, body) == body
    reported = {each["survey"] for body in bodies.values() if "survey" in (each := json.loads(body)["data"])}
    assert len(surveys) == SURVEYS
    assert reported == surveys
    assert len(bodies) == messages
