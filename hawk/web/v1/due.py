"""When surveys of a lot are due by the settings. Nothing flies by itself: the page shows it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aiohttp import web

from hawk.lots.values import NotFoundError
from hawk.runtime.late import late_functions
from hawk.web.v1.answers import BUSY, Answer, answered, due_of, in_time, made, opened
from hawk.web.v1.bodies import DueList
from hawk.web.v1.parameters import Days, query_of

if TYPE_CHECKING:
    from hawk.lots import known_lot
else:
    known_lot = late_functions("hawk.lots.known_lot")


@answered
async def listed(request: web.Request) -> web.StreamResponse:
    """The moments at which surveys of a lot are due; one that has come and is not flown is among them."""
    query, lot = query_of(request, Days), request.match_info["id"]
    async with in_time(BUSY):
        store = await opened(request)
        found = await store.read(lambda connection: known_lot.newest_survey(connection, lot))
    if found is None:
        raise NotFoundError("lot: there is no lot with this id; reload the list")
    due = due_of(request)(lot, *found, query.days)
    return await made(request, lambda: Answer(DueList(items=due)))
