"""A desk that collects, behind its server, with two drones and what the first one has to send."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import aiohttp

from hawk.comm.protocol.authority import Role
from hawk.lots.documents import parts, survey_document
from hawk.lots.store import LotStore
from tests.unit.lots.documents.drones import Drone, tile
from tests.unit.web.stand import Stand

ONE, OTHER = "Drone 1", "Drone 2"


@dataclass
class Centre:
    """A desk that collects, with two drones, and what the first one has to send."""

    stand: Stand
    store: LotStore
    folder: Path
    tokens: dict[str, str]
    drone: Drone

    def url(self, path: str) -> str:
        assert self.stand.rig.server is not None
        return str(self.stand.rig.server.make_url(path))

    def documents(self) -> list[survey_document.SurveyDocument]:
        return [self.drone.document(each.survey.id, {(0, 0): tile()}) for each in self.drone.documents()]

    @asynccontextmanager
    async def tool(self, token: str) -> AsyncIterator[aiohttp.ClientSession]:
        async with aiohttp.ClientSession(headers={"Authorization": f"Bearer {token}"}) as session:
            yield session

    async def put(self, data: bytes, named: str, token: str = "", **headers: str) -> tuple[int, Any]:
        given = token or self.tokens[ONE]
        async with (
            self.tool(given) as session,
            session.put(self.url(f"/api/v1/surveys/{named}/document"), data=data, headers=headers) as answer,
        ):
            text = await answer.text()
            return answer.status, json.loads(text) if text else None

    async def arrivals(self, **query: str) -> list[dict[str, Any]]:
        """Return the arrivals, the oldest first, as an operator reads them."""
        async with (
            await self.stand.tool(Role.OPERATOR) as operator,
            operator.get(self.url("/api/v1/documents"), params=query) as answer,
        ):
            assert answer.status == 200
            return list(reversed((await answer.json())["items"]))

    async def send(self, document: survey_document.SurveyDocument, token: str = "") -> tuple[int, Any]:
        return await self.put(parts.packed(document), document.survey.id, token)
