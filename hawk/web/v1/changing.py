"""Handlers of changes: for operators, by the functions of `hawk.web.lots`, `hawk.web.plans` and `hawk.web.recordings`.

The body is checked by its model first; what the functions refuse themselves is a problem of the same form.
"""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable
from typing import Any, Final

from aiohttp import hdrs, web
from aiohttp.typedefs import Handler

from hawk.lots.plan.operations import NAMES
from hawk.lots.values import LotInputError
from hawk.web import recordings
from hawk.web.lot_answers import FOR_OPERATORS, Change, as_text, opened
from hawk.web.refusals import Body, body_of, check_operator
from hawk.web.v1.answering import JSON, Answer, answered, in_time, made
from hawk.web.v1.asked import Listed, Query, names_of, query_of, validated
from hawk.web.v1.bodies import Given

UNSURE: Final = "The store of lots is busy, and the change may have been made: look before it is sent again."


def changer(model: type[Given], change: Change) -> Handler:
    """Return the handler of a change of lots."""

    async def handle(request: web.Request) -> web.StreamResponse:
        check_operator(request, FOR_OPERATORS)
        body = await _checked(request, model)
        async with in_time(UNSURE):
            return changed(as_text(await change(await opened(request), request, body)))

    return answered(handle)


def of_recordings(model: type[Given], change: Callable[[web.Request, Body], Awaitable[dict[str, Any]]]) -> Handler:
    """Return the handler of a change of recordings."""

    async def handle(request: web.Request) -> web.StreamResponse:
        check_operator(request, recordings.FOR_OPERATORS)
        body = await _checked(request, model)
        async with in_time(UNSURE):
            return changed(json.dumps(await change(request, body)))

    return answered(handle)


@answered
async def listed(request: web.Request) -> web.StreamResponse:
    """The recordings, the oldest first."""
    query = query_of(request, Listed)
    async with in_time("The disk is busy: ask again in some seconds."):
        rows = await recordings.rows_of(request)
    first = 0
    if query.after is not None:
        names = [row["name"] for row in rows]
        if query.after not in names:
            raise LotInputError("after", "is no place in this list: write `next` of the part before, or leave it out")
        first = names.index(query.after) + 1
    part = rows[first : first + query.limit]
    following = part[-1]["name"] if first + query.limit < len(rows) else None
    return await made(request, lambda: Answer({"items": part, "next": following}, following))


async def _checked(request: web.Request, model: type[Given]) -> Body:
    """Return the body, which the model takes. Raises LotInputError."""
    query_of(request, Query)
    body = await body_of(request)
    try:
        json.dumps(body, ensure_ascii=False).encode()  # SQLite takes no half character
    except UnicodeEncodeError:
        raise LotInputError("body", "holds half a character: send text as UTF-8") from None
    validated(model.model_validate, body, names_of(model), NAMES)
    return body


def changed(text: str) -> web.Response:
    """Return the answer to a change."""
    return web.Response(text=text, content_type=JSON, headers={hdrs.CACHE_CONTROL: "no-store"})
