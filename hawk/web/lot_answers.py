"""Answers of the addresses about lots: JSON of what the store says, or a refusal with its field and the remedy."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable, Mapping
from typing import Any, Final

from aiohttp import hdrs, web

from hawk.comm.protocol.authority import Role
from hawk.lots.store import LotStore
from hawk.lots.values import BeingEditedError, LotInputError, LotStoreError, NotFoundError, utc
from hawk.web.access.access import ACCESS
from hawk.web.services import SERVICES

READ_S: Final = 20.0
"""Real seconds in which the whole request must be there."""
FOR_OPERATORS: Final = "Lots are changed by operators: log in as operator."
NO_LOTS: Final = "There is no store of lots here."
ID: Final = r"{id:[0-9a-f-]{36}}"
"""Pattern of an id in a route."""
Body = Mapping[str, Any]


def answered(
    change: Callable[[LotStore, web.Request, Body], Awaitable[object]],
) -> Callable[[web.Request], Awaitable[web.StreamResponse]]:
    """Return the handler of a change: for operators, with a JSON object as its body."""

    async def handle(request: web.Request) -> web.StreamResponse:
        access = request.get(ACCESS)
        if access is not None and access.role is not Role.OPERATOR:
            raise web.HTTPForbidden(text=FOR_OPERATORS)

        async def work(store: LotStore) -> object:
            return await change(store, request, await _body(request))

        return await answer(request, work)

    return handle


async def answer(request: web.Request, work: Callable[[LotStore], Awaitable[object]]) -> web.StreamResponse:
    """Return what some work gives, or its refusal: 422 for a value, 404 for an id, 409 for the store.

    Text is JSON already: the plan of a large lot is encoded on the store's thread. A response is one. The store is
    opened first: that loads SQLAlchemy on its thread, and imports on the loop cost nothing then.
    """
    headers = {hdrs.CACHE_CONTROL: "no-store"}
    try:
        store = _store(request)
        await store.open()
        found = await work(store)
        if isinstance(found, web.StreamResponse):
            return found
        text = found if isinstance(found, str) else json.dumps(found)
        return web.json_response(text=text, headers=headers)
    except LotInputError as error:
        refusal, status = {"field": error.field, "reason": error.reason}, web.HTTPUnprocessableEntity.status_code
    except NotFoundError as error:
        refusal, status = _named(error), web.HTTPNotFound.status_code
    except BeingEditedError as error:
        refusal, status = _named(error) | {"who": error.who, "since": utc(error.since)}, web.HTTPConflict.status_code
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


def now_of(request: web.Request) -> float:
    """Return the time, UTC, Unix seconds."""
    return request.app[SERVICES].wall()
