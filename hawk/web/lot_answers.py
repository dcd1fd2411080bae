"""Answers of the addresses about lots: JSON of what the store says, or a refusal with its field and the remedy."""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable
from typing import Final

from aiohttp import hdrs, web

from hawk.lots.store import LotStore
from hawk.lots.values import LotStoreError, NotFoundError
from hawk.web.refusals import Body, body_of, check_operator, refusal_of
from hawk.web.services import SERVICES

FOR_OPERATORS: Final = "Lots are changed by operators: log in as operator."
NO_LOTS: Final = "There is no store of lots here."
ID: Final = r"{id:[0-9a-f-]{36}}"
"""Pattern of an id in a route."""
Change = Callable[[LotStore, web.Request, Body], Awaitable[object]]
"""A change that a request asks for; it returns JSON values, or JSON text."""


def answered(change: Change) -> Callable[[web.Request], Awaitable[web.StreamResponse]]:
    """Return the handler of a change: for operators, with a JSON object as its body."""

    async def handle(request: web.Request) -> web.StreamResponse:
        check_operator(request, FOR_OPERATORS)

        async def work(store: LotStore) -> object:
            return await change(store, request, await body_of(request))

        return await answer(request, work)

    return handle


async def answer(request: web.Request, work: Callable[[LotStore], Awaitable[object]]) -> web.StreamResponse:
    """Return what some work gives, or its refusal: 422 for a value, 404 for an id, 409 for the store.

    Text is JSON already: the plan of a large lot is encoded on the store's thread. A response is one.
    """
    headers = {hdrs.CACHE_CONTROL: "no-store"}
    try:
        found = await work(await opened(request))
    except LotStoreError as error:
        refusal = refusal_of(error)
        return web.json_response(refusal.content, status=refusal.status, headers=headers)
    if isinstance(found, web.StreamResponse):
        return found
    return web.json_response(text=as_text(found), headers=headers)


def as_text(found: object) -> str:
    """Return JSON values as text; text is JSON already."""
    return found if isinstance(found, str) else json.dumps(found)


async def opened(request: web.Request) -> LotStore:
    """Return the store, open: that loads SQLAlchemy on its thread, and imports on the loop cost nothing then.

    Raises NotFoundError where there is none, LotStoreError.
    """
    store = request.app[SERVICES].lots
    if store is None:
        raise NotFoundError(NO_LOTS)
    await store.open()
    return store


def now_of(request: web.Request) -> float:
    """Return the time, UTC, Unix seconds."""
    return request.app[SERVICES].wall()
