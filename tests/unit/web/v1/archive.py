"""A store of two lots behind the API, as a viewer's and an operator's program see it, for the tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import aiohttp
from pydantic import TypeAdapter

from hawk.lots.ingest import save
from hawk.lots.store import LotStore
from hawk.lots.values import Saved
from tests.unit.lots.surveys import DATUM, box, later, survey
from tests.unit.web.stand import Stand

NOWHERE = "0" * 36
FAR = replace(DATUM, longitude=6.0)


@dataclass
class Archive:
    """``lot``: the first lot's id, ``far``: that of the other one; ``surveys``: ids of the first lot's surveys."""

    stand: Stand
    store: LotStore
    viewer: aiohttp.ClientSession
    operator: aiohttp.ClientSession
    lot: str
    far: str
    surveys: Sequence[str]

    def address(self, path: str) -> Any:
        assert self.stand.rig.server is not None
        return self.stand.rig.server.make_url(path if path.startswith("/api") else f"/api/v1{path}")

    def path_of(self, link: str) -> str:
        """Return the path of a link, which must lead to this server."""
        here = str(self.address("/"))
        assert link.startswith(here), link
        return f"/{link.removeprefix(here)}"

    async def ask(
        self, path: str, *, method: str = "GET", operator: bool = False, body: object = None, **headers: str
    ) -> aiohttp.ClientResponse:
        session = self.operator if operator else self.viewer
        given = {name.replace("_", "-"): value for name, value in headers.items()}
        response = await session.request(method, self.address(path), json=body, headers=given)
        await response.read()
        return response

    async def get(self, path: str) -> Any:
        response = await self.ask(path)
        assert response.status == 200, await response.text()
        return await response.json(content_type=None)

    async def done(self, path: str, **body: object) -> Any:
        """Return the answer of a change by an operator."""
        response = await self.ask(path, method="POST", operator=True, body=body)
        assert response.status == 200, await response.text()
        return await response.json(content_type=None)

    async def shown(self, path: str, model: type[Any]) -> Any:
        """Return an answer that the model takes."""
        found = await self.get(path)
        TypeAdapter(model).validate_python(found)
        return found

    async def items(self, path: str) -> list[dict[str, Any]]:
        """Return the items of all parts of a list."""
        found: list[dict[str, Any]] = []
        after = ""
        while True:
            part = await self.get(f"{path}{after}")
            found += part["items"]
            if part["next"] is None:
                return found
            after = f"{'&' if '?' in path else '?'}after={part['next']}"

    async def refused(self, path: str, **options: Any) -> tuple[int, dict[str, Any]]:
        """Return status and problem of a request that is refused."""
        response = await self.ask(path, **options)
        assert response.content_type == "application/problem+json", (response.status, await response.text())
        found = await response.json(content_type=None)
        assert found["status"] == response.status
        return response.status, found


@dataclass(frozen=True)
class Filled:
    """A store's file, and what `fill` says of it."""

    file: Path
    lot: str
    far: str
    surveys: list[str]


async def fill(store: LotStore) -> tuple[str, str, list[str]]:
    """Store three surveys of a lot, a day apart, and one of a lot far away; return ids of the lots and the surveys."""
    flown = [survey(), later(survey(seed=1), 2), later(survey(seed=2), 3, hours=48.0)]
    saved = [await _save(store, each) for each in flown]
    away = replace(later(survey(stalls=20), 4, hours=72.0), datum=FAR, outline=box(-5, -3, 9, 54, FAR))
    far = await _save(store, replace(away, seen_ground=box(-13, -15, 27, 78, FAR)))
    assert saved[0].lot is not None
    assert far.lot is not None
    return saved[0].lot, far.lot, [each.survey for each in saved]


async def _save(store: LotStore, given: Any) -> Saved:
    return await store.write(lambda connection: save(connection, given, store.register))
