"""The API of plans as a page sees it, for the tests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import aiohttp

from hawk.lots.store import LotStore
from tests.unit.web.stand import Stand

Answer = tuple[int, dict[str, Any]]


@dataclass
class Plans:
    """The API as a page sees it. ``lot``: a drawn lot of three rows of ten."""

    stand: Stand
    store: LotStore
    session: aiohttp.ClientSession
    lot: str

    def address(self, path: str) -> Any:
        assert self.stand.rig.server is not None
        return self.stand.rig.server.make_url(f"/api/v1/lots/{self.lot}{path}")

    def change(self, done: dict[str, Any]) -> Any:
        return self.address("").with_path(f"/api/v1/changes/{done['seq']}/undo")

    async def get(self, path: str = "/plan") -> Answer:
        async with self.session.get(self.address(path)) as response:
            return response.status, await response.json(content_type=None)

    async def post(self, path: str, **body: object) -> Answer:
        async with self.session.post(self.address(path), json=body) as response:
            return response.status, await response.json(content_type=None)

    async def done(self, path: str, **body: object) -> dict[str, Any]:
        status, answer = await self.post(path, **body)
        assert status == 200, answer
        return answer

    async def opened(self, who: str = "Ann") -> str:
        return str((await self.done("/edit", who=who))["edit"])

    async def stalls(self) -> dict[str, dict[str, Any]]:
        return {each["label"]: each for each in (await self.get("/stalls?limit=1000"))[1]["items"]}
