"""The page of a replay: on this computer alone, and only to read."""

from __future__ import annotations

import json
import tempfile
from collections.abc import AsyncIterator
from pathlib import Path

import aiohttp
import pytest

from hawk.replay.flight import RecordedFlight
from hawk.replay.server import ReplayServer
from hawk.replay.timeline import read_shown
from hawk.web.app import Page
from tests.unit.replay.recordings import flight, jpeg, write


@pytest.fixture
async def server(tmp_path: Path) -> AsyncIterator[ReplayServer]:
    static = tmp_path / "static"
    static.mkdir()
    (static / "index.html").write_text("the drone's page")
    (static / "replay.html").write_text("the replay's page")
    (static / "replay.js").write_text("1")
    recorded = RecordedFlight(write(tmp_path / "20260504T103000Z.mcap", flight(3, 2)))
    with tempfile.TemporaryFile() as beside:
        made = ReplayServer(recorded, read_shown(recorded, beside), beside, Page.load(static))
        await made.start(0)
        yield made
        await made.close()


async def test_page_time_line_pictures_and_maps_are_served(server: ReplayServer) -> None:
    async with aiohttp.ClientSession(server.url) as session:
        async with session.get("/") as response:
            assert await response.text() == "the replay's page"
            assert "default-src 'self'" in response.headers["Content-Security-Policy"]
        async with session.get("/replay.js") as response:
            assert await response.text() == "1"
        async with session.get("/api/replay.json") as response:
            line = await response.json()
        assert (line["name"], line["maker"]) == (
            "20260504T103000Z.mcap",
            "hawk-drone 0.2.9, network 0123abcd",
        )
        assert (len(line["pictures"]), len(line["maps"]), len(line["track"])) == (3, 3, 1)
        async with session.get("/api/replay/pictures/2") as response:
            assert (response.content_type, await response.read()) == ("image/jpeg", jpeg())
        async with session.get("/api/replay/maps/1") as response:
            assert len(json.loads(await response.text())["features"]) == 2


async def test_nothing_is_changed_and_nothing_else_is_there(server: ReplayServer) -> None:
    async with aiohttp.ClientSession(server.url) as session:
        for path in ("/ws", "/api/lots.json", "/api/replay/pictures/9", "/api/replay/words/1", "/../config.toml"):
            async with session.get(path) as response:
                assert response.status == 404, path
        for path in ("/", "/api/replay.json", "/api/replay/maps/1"):
            async with session.post(path) as response:
                assert response.status == 405, path


@pytest.mark.parametrize("host", ["evil.example", "evil.example:3001", "192.168.1.2:3001", ""])
async def test_a_name_of_another_host_is_refused(server: ReplayServer, host: str) -> None:
    async with (
        aiohttp.ClientSession(server.url) as session,
        session.get("/api/replay.json", headers={"Host": host}) as response,
    ):
        assert response.status == 403
