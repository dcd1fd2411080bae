"""The whole daemon and a receiver of its reports are killed with -9 in turn, while surveys appear in the store: each
report comes, and one that comes twice has the same id.

Three times in `make integration`; `make webhook-kills` does it fifty times, which takes minutes.
"""

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
from dataclasses import replace
from pathlib import Path

import pytest

from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.store import FILE
from hawk.sim.launch import free_udp_port
from tests.integration.sim_support import free_tcp_port
from tests.pace import PATIENCE_S
from tests.unit.lots.surveys import later, survey

pytestmark = [pytest.mark.integration]

ROOT = Path(__file__).parents[2]
RECEIVER = ROOT / "tests" / "unit" / "webhooks" / "killed_receiver.py"
KILLS = int(os.environ.get("WEBHOOK_KILLS", "3"))
A_LIFE = 6
IS_REPORT = "kind IN ('survey', 'layout')"
"""Surveys that appear before each start of the daemon: it sends them at once."""
END_S = 400.0
"""The longest wait between two tries of a report that has failed four times is five minutes."""
SETTINGS = """
[webhooks]
urls = ["http://127.0.0.1:{port}/"]
secret = "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw"
allow_private = true
"""


class Programs:
    """The daemon of a store and the receiver, which can be killed and started again; ``received``: its file."""

    def __init__(self, folder: Path) -> None:
        self.store = folder / "store"
        self.received = folder / "received.txt"
        self.received.touch()
        self._folder = folder
        self._port = 0
        self._stored = 0
        self._running: dict[str, asyncio.subprocess.Process] = {}

    async def start_receiver(self) -> None:
        made = await asyncio.create_subprocess_exec(
            sys.executable, str(RECEIVER), str(self._port), str(self.received), stdout=asyncio.subprocess.PIPE
        )
        self._running["receiver"] = made
        assert made.stdout is not None
        async with asyncio.timeout(PATIENCE_S):
            self._port = int(await made.stdout.readline())

    async def start_daemon(self) -> None:
        config = self._folder / "config.toml"
        config.write_text(SETTINGS.format(port=self._port))
        command = [sys.executable, "-m", "hawk.cli", "run", "--config", str(config), "--store", str(self.store)]
        command += ["--port", str(free_tcp_port()), "--camera", f"http://127.0.0.1:{free_tcp_port()}/"]
        with (self._folder / "daemon.log").open("ab") as log:
            self._running["daemon"] = await asyncio.create_subprocess_exec(
                *command, "--autopilot", f"udpin://127.0.0.1:{free_udp_port()}", stdout=log, stderr=log
            )

    async def kill(self, name: str) -> None:
        made = self._running[name]
        assert made.returncode is None or name == "daemon", f"the {name} ended by itself"
        if made.returncode is None:
            made.kill()
        await made.wait()

    async def end(self) -> None:
        for made in self._running.values():
            if made.returncode is None:
                made.kill()
            await made.wait()

    def store_surveys(self, count: int) -> None:
        """Store surveys of the lot that have just ended, as a flight's keeper does."""
        self.store.mkdir(exist_ok=True)
        database = Database(self.store / FILE)
        for _ in range(count):
            self._stored += 1
            ended = time.time()
            one = replace(later(survey(), self._stored), began=ended - 600, ended=ended)
            with database.writing() as connection:
                save(connection, one)
        database.close()

    async def until_more(self, lines: int) -> None:
        """Wait until the receiver has got more than N messages."""
        async with asyncio.timeout(PATIENCE_S):
            while len(self.received.read_text().splitlines()) <= lines:  # noqa: ASYNC110 - another program's file
                await asyncio.sleep(0.02)

    def unsent(self) -> int:
        """Return the number of messages that the daemon has not noted as sent."""
        with closing(sqlite3.connect(self.store / FILE)) as opened:
            sent = "LEFT JOIN delivery ON message = outbox.seq"
            asked = f"SELECT count(*) FROM outbox {sent} WHERE {IS_REPORT} AND delivery.sent IS NULL"  # noqa: S608
            return int(opened.execute(asked).fetchone()[0])


@asynccontextmanager
async def programs(folder: Path) -> AsyncIterator[Programs]:
    made = Programs(folder)
    try:
        yield made
    finally:
        await made.end()


@pytest.mark.timeout(300 + 40 * KILLS + END_S)
async def test_no_report_is_lost_and_doubles_have_the_same_id(tmp_path: Path) -> None:
    chance = random.Random(39)
    async with programs(tmp_path) as running:
        await running.start_receiver()
        killed = 0
        while killed < KILLS:
            got = len(running.received.read_text().splitlines())
            running.store_surveys(A_LIFE)
            await running.start_daemon()
            await running.until_more(got)
            for name in ("receiver", "daemon"):
                await asyncio.sleep(chance.uniform(0.0, 0.15))  # a moment that nothing else decides
                await running.kill(name)
                killed += 1
                if name == "receiver":
                    await running.start_receiver()
        await running.start_daemon()
        async with asyncio.timeout(END_S):
            while running.unsent():  # noqa: ASYNC110 - another program's file
                await asyncio.sleep(0.2)
    with closing(sqlite3.connect(running.store / FILE)) as opened:
        surveys = {row[0] for row in opened.execute("SELECT id FROM survey")}
        messages = opened.execute(f"SELECT count(*) FROM outbox WHERE {IS_REPORT}").fetchone()[0]  # noqa: S608
    bodies: dict[str, str] = {}
    for line in running.received.read_text().splitlines():
        named, body = line.split(" ", 1)
        assert bodies.setdefault(named, body) == body
    reported = {each["survey"] for body in bodies.values() if "survey" in (each := json.loads(body)["data"])}
    assert len(surveys) == A_LIFE * ((KILLS + 1) // 2)
    assert reported == surveys
    assert len(bodies) == messages
