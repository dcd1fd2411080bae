from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import aiohttp
import pytest

from hawk.config.sections import WebSettings
from tests.unit.web.rig import Connect, Rig, Visitor
from tests.unit.web.stand import Stand


@pytest.fixture
async def rig() -> AsyncIterator[Rig]:
    made = Rig()
    yield made
    if made.server is not None:
        await made.server.close()


@pytest.fixture
async def connect(rig: Rig) -> AsyncIterator[Connect]:
    """Open pages: each call is a browser of its own unless a session is given."""
    sessions: list[aiohttp.ClientSession] = []
    pages: list[Visitor] = []  # one that nobody refers to would be collected

    async def open_page(session: aiohttp.ClientSession | None = None, **options: Any) -> Visitor:
        if rig.server is None:
            await rig.start()
        assert rig.server is not None
        if session is None:
            session = aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True))
            sessions.append(session)
        page = Visitor(await session.ws_connect(rig.server.make_url("/ws"), **options))
        page.welcome = await page.next("Welcome")
        pages.append(page)
        return page

    yield open_page
    for page in pages:
        await page.socket.close()
    for session in sessions:
        await session.close()


@pytest.fixture
async def stand(rig: Rig, tmp_path: Path) -> AsyncIterator[Stand]:
    """A server with tokens of both roles in its folder."""
    made = Stand(rig, tmp_path)
    rig.folder, rig.web = tmp_path, WebSettings()
    await rig.start()
    yield made
    await made.close()
