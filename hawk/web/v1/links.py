"""Links to a lot, for those who may change it: their list. The links themselves are read by `hawk.web.links`."""

from __future__ import annotations

from aiohttp import web

from hawk.web.lot_answers import now_of, opened
from hawk.web.v1.answering import BUSY, Answer, answered, in_time, made
from hawk.web.v1.asked import Query, query_of


@answered
async def listed(request: web.Request) -> web.StreamResponse:
    """The links to a lot, without their tokens. One ends without a change of the store: the ETag is the answer's."""
    query_of(request, Query)
    lot, now = request.match_info["id"], now_of(request)
    async with in_time(BUSY):
        store = await opened(request)
        from hawk.lots import shares

        found = await store.read(lambda connection: shares.shares(connection, lot, now))
    return await made(request, lambda: Answer(found))
