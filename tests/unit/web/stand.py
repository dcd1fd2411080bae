"""A server with tokens of both roles, and clients of it."""

from __future__ import annotations

from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any

import aiohttp

from hawk.comm.protocol.authority import Role
from hawk.web.access.access import KEEPER
from hawk.web.access.tokens import TOKEN_FILE, rotate
from tests.unit.web.rig import Rig, Visitor, browser


class Stand:
    """A server with both roles, and clients of it."""

    def __init__(self, rig: Rig, folder: Path) -> None:
        self.rig = rig
        self.tokens = {role: rotate(folder / TOKEN_FILE, role) for role in Role}
        self._open = AsyncExitStack()
        self._pages: list[Visitor] = []

    async def browser(self, role: Role | None = None, **options: Any) -> aiohttp.ClientSession:
        """A browser that is logged in."""
        assert self.rig.server is not None
        session = await self._open.enter_async_context(browser(**options))
        if role is not None:
            await session.get(self.rig.server.make_url(f"/?token={self.tokens[role]}"))
        return session

    async def tool(self, role: Role, **headers: str) -> aiohttp.ClientSession:
        """A program with the token in the header."""
        return await self.browser(headers={"Authorization": f"Bearer {self.tokens[role]}", **headers})

    async def page(self, session: aiohttp.ClientSession, **options: Any) -> Visitor:
        assert self.rig.server is not None
        found = Visitor(await session.ws_connect(self.rig.server.make_url("/ws"), **options))
        found.welcome = await found.next("Welcome")
        self._pages.append(found)  # one that nobody refers to would be collected
        return found

    async def status(self, session: aiohttp.ClientSession, path: str = "/api/session") -> int:
        """Return the status of a request, without following redirects."""
        assert self.rig.server is not None
        async with session.get(self.rig.server.make_url(path), allow_redirects=False) as response:
            return response.status

    async def look(self) -> None:
        """Do what the server does every second."""
        assert self.rig.app is not None
        await self.rig.app[KEEPER].look()

    async def close(self) -> None:
        for page in self._pages:
            await page.socket.close()
        await self._open.aclose()
