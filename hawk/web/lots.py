"""Lots and surveys that last, for page and tools: list, name, merge, split, move, undo.

Names are text: nothing of them is read as HTML, here or on the page. Everybody may read; operators may change. A value
that cannot be used is answered with 422 and a `LotRefusal` that names its field and the remedy.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import asdict
from typing import Any, Final

from aiohttp import hdrs, web

from hawk.comm.protocol.authority import Role
from hawk.lots.store import LotStore
from hawk.lots.values import LotInputError, LotStoreError, NotFoundError
from hawk.web.access.access import ACCESS
from hawk.web.services import SERVICES

READ_S: Final = 20.0
"""Real seconds in which the whole request must be there."""
FOR_OPERATORS: Final = "Lots are changed by operators: log in as operator."
NO_LOTS: Final = "There is no store of lots here."
_ID: Final = r"{id:[0-9a-f-]{36}}"
Body = Mapping[str, Any]


def add_routes(app: web.Application) -> None:
    """Add every route of this module."""
    app.router.add_get("/api/lots.json", all_lots)
    app.router.add_get(f"/api/lots/{_ID}.json", one_lot)
    app.router.add_post(f"/api/lots/{_ID}/name", _answered(rename))
    app.router.add_post(f"/api/lots/{_ID}/merge", _answered(merge))
    app.router.add_post(f"/api/lots/{_ID}/split", _answered(split))
    app.router.add_post(f"/api/surveys/{_ID}/move", _answered(move))
    app.router.add_post(f"/api/surveys/{_ID}/place", _answered(choose))
    app.router.add_post(r"/api/lot-changes/{seq:\d{1,9}}/undo", _answered(undo))


async def all_lots(request: web.Request) -> web.StreamResponse:
    """Every lot with its newest survey, the surveys that wait for "which lot is it?", and the last changes."""

    async def work(store: LotStore) -> object:
        from hawk.lots import reading

        return await store.read(reading.lots)

    return await _answer(request, work)


async def one_lot(request: web.Request) -> web.StreamResponse:
    """A lot with outline, surveys and stalls."""

    async def work(store: LotStore) -> object:
        from hawk.lots import reading

        return await store.read(lambda connection: reading.lot(connection, request.match_info["id"]))

    return await _answer(request, work)


async def rename(store: LotStore, request: web.Request, body: Body) -> object:
    """Name a lot: ``name``."""
    from hawk.lots import reading

    lot, who, now = request.match_info["id"], _who(request), _now(request)
    return asdict(await store.write(lambda c: reading.rename(c, lot, body.get("name"), who, now)))


async def merge(store: LotStore, request: web.Request, body: Body) -> object:
    """Merge the lot ``with`` into this one."""
    from hawk.lots import reading

    lot, who, now = request.match_info["id"], _who(request), _now(request)
    return asdict(await store.write(lambda c: reading.merge(c, lot, body.get("with"), who, now)))


async def split(store: LotStore, request: web.Request, body: Body) -> object:
    """Split the stalls within ``outline``, corners [latitude, longitude], off as a lot called ``name``."""
    from hawk.lots import reading

    lot, who, now = request.match_info["id"], _who(request), _now(request)
    return asdict(await store.write(lambda c: reading.split(c, lot, body, who, now)))


async def move(store: LotStore, request: web.Request, body: Body) -> object:
    """Move a survey to the lot ``lot``; null: to a new one, called ``name`` where that is given."""
    from hawk.lots import reading

    if "lot" not in body:
        raise LotInputError("lot", "is missing: name a lot, or write null for a new one")
    survey, who, now = request.match_info["id"], _who(request), _now(request)
    return asdict(await store.write(lambda c: reading.move(c, survey, body, who, now, store.register)))


async def choose(store: LotStore, request: web.Request, body: Body) -> object:
    """Register a survey whose place was not certain: ``place``, the number of one of its places, from 0."""
    from hawk.lots import reading

    survey, who, now = request.match_info["id"], _who(request), _now(request)
    return asdict(await store.write(lambda c: reading.choose(c, survey, body, who, now)))


async def undo(store: LotStore, request: web.Request, _: Body) -> object:
    """Undo a change, once."""
    from hawk.lots import changes

    seq, now = int(request.match_info["seq"]), _now(request)
    return {"seq": seq, "kind": await store.write(lambda c: changes.undo(c, seq, now))}


def _answered(
    change: Callable[[LotStore, web.Request, Body], Awaitable[object]],
) -> Callable[[web.Request], Awaitable[web.StreamResponse]]:
    """Return the handler of a change: for operators, with a JSON object as its body."""

    async def handle(request: web.Request) -> web.StreamResponse:
        access = request.get(ACCESS)
        if access is not None and access.role is not Role.OPERATOR:
            raise web.HTTPForbidden(text=FOR_OPERATORS)

        async def work(store: LotStore) -> object:
            return await change(store, request, await _body(request))

        return await _answer(request, work)

    return handle


async def _answer(request: web.Request, work: Callable[[LotStore], Awaitable[object]]) -> web.StreamResponse:
    """Return what some work gives, or its refusal: 422 for a value, 404 for an id, 409 for the store.

    The store is opened first: that loads SQLAlchemy on its thread, and imports on the loop cost nothing then.
    """
    headers = {hdrs.CACHE_CONTROL: "no-store"}
    try:
        store = _store(request)
        await store.open()
        return web.json_response(await work(store), headers=headers)
    except LotInputError as error:
        refusal, status = {"field": error.field, "reason": error.reason}, web.HTTPUnprocessableEntity.status_code
    except NotFoundError as error:
        refusal, status = _named(error), web.HTTPNotFound.status_code
    except LotStoreError as error:
        refusal, status = _named(error), web.HTTPConflict.status_code
    return web.json_response(refusal, status=status, headers=headers)


def _named(error: LotStoreError) -> dict[str, str]:
    field, separator, reason = str(error).partition(": ")
    is_field = bool(separator) and field.isidentifier()
    return {"field": field if is_field else "", "reason": reason if is_field else str(error)}


async def _body(request: web.Request) -> Body:
    """Return the JSON object that was sent. Raises LotInputError, and 413 or 408 for one that is large or late."""
    try:
        async with asyncio.timeout(READ_S):
            data = await request.read()
    except TimeoutError:
        raise web.HTTPRequestTimeout(text="The request did not come.") from None
    try:
        found = json.loads(data or b"{}")
    except (ValueError, RecursionError) as error:
        raise LotInputError("body", f"is no JSON: {error}") from error
    if not isinstance(found, dict):
        raise LotInputError("body", "must be a JSON object")
    return found


def _store(request: web.Request) -> LotStore:
    store = request.app[SERVICES].lots
    if store is None:
        raise NotFoundError(NO_LOTS)
    return store


def _who(request: web.Request) -> str:
    access = request.get(ACCESS)
    return Role.OPERATOR.value if access is None else access.role.value


def _now(request: web.Request) -> float:
    return request.app[SERVICES].wall()
