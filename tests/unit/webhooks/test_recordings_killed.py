"""A real desk and a real sender, killed while a recording is sent."""

from __future__ import annotations

import asyncio
import json
import os
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import aiohttp
import pytest

from hawk.comm.protocol.authority import Role
from hawk.web.access.tokens import TOKEN_FILE, rotate, rotate_drone
from tests.integration.sim_support import free_tcp_port
from tests.pace import PATIENCE_S
from tests.unit.comm.waiting import until
from tests.unit.lots.documents.drones import Drone
from tests.unit.lots.surveys import survey
from tests.unit.store.recorded import recorded

NAME = "20260501T100000Z.mcap"
SENDER = """
import asyncio, sys
from pathlib import Path
from hawk.webhooks import recordings
recordings.FIRST_PART = recordings.LEAST_PART = recordings.LARGEST_PART = 64_000
from proving.chaos.senders import send
asyncio.run(send(Path(sys.argv[1]), sys.argv[2], 1))
"""


class Programs:
    """A desk and a sender; each can be killed."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.port = folder, free_tcp_port()
        self.url = f"http://127.0.0.1:{self.port}/"
        self.running: dict[str, asyncio.subprocess.Process] = {}

    async def start(self, name: str) -> None:
        desk = ["-m", "hawk.cli", "desk", "--collect", "--port", str(self.port), "--store", str(self.folder / "desk")]
        command = desk if name == "desk" else ["-c", SENDER, str(self.folder / "drones"), self.url]
        with (self.folder / f"{name}.log").open("ab") as log:
            self.running[name] = await asyncio.create_subprocess_exec(
                sys.executable, *command, stdout=log, stderr=log, env={**os.environ}
            )

    async def kill(self, name: str) -> None:
        process = self.running.pop(name)
        process.kill()
        await process.wait()

    async def answered(self, token: str, method: str, path: str, **more: object) -> dict[str, object] | None:
        """Return the desk's answer; None while it is not there."""
        try:
            async with (
                aiohttp.ClientSession(headers={"Authorization": f"Bearer {token}"}) as session,
                session.request(method, self.url + path, json=more or None) as answer,
            ):
                return dict(json.loads(await answer.text())) if answer.status == 200 else None
        except aiohttp.ClientError:
            return None


async def eventually(asked: Callable[[], object]) -> None:
    """Wait until the desk answers what is asked."""
    async with asyncio.timeout(PATIENCE_S):
        while not await asked():  # type: ignore[misc]  # noqa: ASYNC110 - another process says it
            await asyncio.sleep(0.1)


@pytest.mark.slow
@pytest.mark.nightly
@pytest.mark.fault(
    "desk and sender are killed while a recording is sent",
    "it goes on from where it was, and is the same byte for byte",
)
async def test_a_recording_is_the_same_after_both_ends_were_killed(tmp_path: Path) -> None:
    desk, own = tmp_path / "desk", tmp_path / "drones" / "00"
    desk.mkdir()
    operator = rotate(desk / TOKEN_FILE, Role.OPERATOR)
    drone = Drone.at(own / "lots.db")
    named = drone.add(survey()).survey
    drone.store.close()
    data = recorded(own / "recordings" / NAME, survey().name, range(12_000), os.urandom(1000).hex())
    (own / "token").write_text(rotate_drone(desk / TOKEN_FILE, "Drone 1"))
    here, programs = desk / "recordings", Programs(tmp_path)

    def received() -> int:
        found = [*here.glob("requests/*/*.part"), *here.glob("*.mcap")]
        return sum(path.stat().st_size for path in found if path.exists())

    def is_more(than: int) -> bool:
        return received() > than

    try:
        for name in ("desk", "sender"):
            await programs.start(name)
        path = f"api/v1/surveys/{named}/recordings/ask"
        await eventually(lambda: programs.answered(operator, "POST", path, asked=True))
        reached = 0
        for name in ("sender", "desk"):
            await until(partial(is_more, reached), PATIENCE_S)
            await programs.kill(name)
            assert reached < received() < len(data), "killed in the middle"
            reached = received()
            await programs.start(name)
        await until(lambda: (here / NAME).is_file(), PATIENCE_S)
        assert (here / NAME).read_bytes() == data
        assert reached > 0
    finally:
        for name in list(programs.running):
            await programs.kill(name)
