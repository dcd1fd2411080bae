"""Links by which others read one lot, without a login: the token opens the addresses below `SHARED` alone.

No picture that was taken, no recording, no person, no drone. Guesses are slowed and logged as those of a login are, and
apart from them; a link that has ended, was taken back, or whose maker may not read its lot any more is none.
"""

from __future__ import annotations

import asyncio
import math
import re
from typing import TYPE_CHECKING, Final

from aiohttp import hdrs, web

from hawk.lots.store import LotStore
from hawk.lots.values import NotFoundError
from hawk.runtime.late import late_functions
from hawk.web.access.access import BOOK
from hawk.web.access.guesses import LINK_GUESSES, network_of
from hawk.web.access.paced_log import PacedLog
from hawk.web.v1.answers import BUSY, Answer, answered, in_time, made, now_of, opened
from hawk.web.v1.parameters import Query, query_of
from hawk.web.v1.unknown import ROOT

if TYPE_CHECKING:
    from hawk.lots import shares
else:
    shares = late_functions("hawk.lots.shares")

LINK_LOG = web.AppKey("link_log", PacedLog)
"""Log of wrong links."""
SHARED: Final = f"{ROOT}/shared/"
"""Beginning of the addresses that need no login."""
WRONG_TOKEN_S: Final = 0.5
"""Real seconds that the answer to a wrong token takes."""
NO_SUCH_LINK: Final = "share: this link has ended, or was taken back; ask for another one"
_OPEN: Final = re.compile(rf"/shared|{SHARED}.+|/archive(-[\w-]+)?\.(js|css|ftl)|/[\w-]+\.woff2|/icon\.svg")


def is_for_links(request: web.BaseRequest) -> bool:
    """Return True for what a shared link needs: its page, which holds nothing, and the reads by its token."""
    return request.method in (hdrs.METH_GET, hdrs.METH_HEAD) and _OPEN.fullmatch(request.path) is not None


async def lot_of(store: LotStore, request: web.Request) -> str:
    """Return the lot that the link in the address opens. Raises NotFoundError and 429."""
    token = request.match_info["token"]
    guesses, address, now = request.app[LINK_GUESSES], network_of(request.remote), now_of(request)
    wait = guesses.wait_s(address)
    if wait > 0:
        raise web.HTTPTooManyRequests(
            text=f"Too many wrong links came from your address: wait {math.ceil(wait)} s.",
            headers={hdrs.RETRY_AFTER: str(math.ceil(wait))},
        )
    lots_of = request.app[BOOK].lots_of
    lot, was_one = await store.read(lambda c: (shares.lot_of(c, token, now, lots_of), shares.was_link(c, token)))
    if lot is None:
        if not was_one:
            number = guesses.wrong(address, token)
            request.app[LINK_LOG].warning("wrong link to a lot from %s, its %d.", address, number)
        await asyncio.sleep(WRONG_TOKEN_S)
        raise NotFoundError(NO_SUCH_LINK)
    return lot


@answered
async def listed(request: web.Request) -> web.StreamResponse:
    """The links to a lot, without their tokens. One ends without a change of the store: the ETag is the answer's."""
    query_of(request, Query)
    lot, now, lots_of = request.match_info["id"], now_of(request), request.app[BOOK].lots_of
    async with in_time(BUSY):
        found = await (await opened(request)).read(lambda connection: shares.shares(connection, lot, now, lots_of))
    return await made(request, lambda: Answer(found))
