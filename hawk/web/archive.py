"""Reads of one lot over its surveys: for everyone who may see the page, and the same for a link that was shared.

``/api/lots/ID/…`` needs a login as every address does. ``/api/shared/TOKEN/…`` needs the token of a link alone, which
opens one lot: no picture, no recording, no person, no drone. Wrong tokens are slowed and logged as those of a login
are.
"""

from __future__ import annotations

import asyncio
import math
import re
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Any, Final

from aiohttp import hdrs, web

from hawk.lots.store import LotStore
from hawk.lots.values import NotFoundError
from hawk.web.access.guesses import GUESSES, network_of
from hawk.web.access.paced_log import PacedLog
from hawk.web.lot_answers import ID, answer, answered, now_of
from hawk.web.refusals import Body

if TYPE_CHECKING:  # loaded on the store's thread
    from sqlalchemy import Connection

LINK_LOG = web.AppKey("link_log", PacedLog)
"""Log of wrong links."""
SHARED: Final = "/api/shared/"
"""Beginning of the addresses that need no login."""
TOKEN: Final = r"{token:[A-Za-z0-9_-]{8,64}}"  # noqa: S105 - a pattern
WRONG_TOKEN_S: Final = 0.5
"""Real seconds that the answer to a wrong token takes."""
NO_SUCH_LINK: Final = "share: this link has ended, or was taken back; ask for another one"
_Read = Callable[["Connection", str, web.Request], Any]
_Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


_OPEN: Final = re.compile(rf"/shared|{SHARED}.+|/archive(-[\w-]+)?\.(js|css|ftl)|/[\w-]+\.woff2|/icon\.svg")


def is_for_links(request: web.BaseRequest) -> bool:
    """Return True for what a shared link needs: its page, which holds nothing, and the reads by its token."""
    return request.method in (hdrs.METH_GET, hdrs.METH_HEAD) and _OPEN.fullmatch(request.path) is not None


def add_routes(app: web.Application) -> None:
    """Add every route of this module."""
    reads: dict[str, _Handler] = {
        "surveys.json": surveys,
        "statistics.json": statistics,
        "heat.json": heat,
        "between.json": between,
        r"stalls/{stall:[0-9a-f-]{36}}/looks.json": looks,
        r"surveys/{survey:[0-9a-f-]{36}}.geojson": survey_file,
    }
    for place in (f"/api/lots/{ID}", f"{SHARED}{TOKEN}"):
        for name, handler in reads.items():
            app.router.add_get(f"{place}/{name}", handler)
    app.router.add_get(f"/api/lots/{ID}/shares.json", shares)
    app.router.add_post(f"/api/lots/{ID}/shares", answered(share))
    app.router.add_post(f"/api/shares/{ID}/take-back", answered(take_back))


async def surveys(request: web.Request) -> web.StreamResponse:
    """Surveys of a lot in a period, the newest first: counts, share of taken stalls, why one is left out."""

    def read(connection: Connection, lot: str, request: web.Request) -> Any:
        from hawk.stats.listing import surveys_json

        return surveys_json(connection, lot, _period(request))

    return await _read(request, read)


async def statistics(request: web.Request) -> web.StreamResponse:
    """Statistics of a lot ``from`` a day ``to`` another one, ``by`` hour, row, zone or kind."""

    def read(connection: Connection, lot: str, request: web.Request) -> Any:
        from hawk.stats.answering import statistics as answering
        from hawk.stats.shown import figures_json

        return figures_json(answering(connection, lot, _period(request), request.query.get("by")))

    return await _read(request, read)


async def heat(request: web.Request) -> web.StreamResponse:
    """Share of the surveys of a period in which each stall of a lot was taken."""

    def read(connection: Connection, lot: str, request: web.Request) -> Any:
        from hawk.stats.stalls import heat_json

        return heat_json(connection, lot, _period(request))

    return await _read(request, read)


async def between(request: web.Request) -> web.StreamResponse:
    """Changes of a lot's stalls from the survey ``before`` to the survey ``after``."""

    def read(connection: Connection, lot: str, request: web.Request) -> Any:
        from hawk.stats.answering import changes
        from hawk.stats.shown import changes_json

        before, after = request.query.get("before", ""), request.query.get("after", "")
        return changes_json(changes(connection, lot, before, after, _period(request)))

    return await _read(request, read)


async def looks(request: web.Request) -> web.StreamResponse:
    """The newest looks at a stall of a lot."""

    def read(connection: Connection, lot: str, request: web.Request) -> Any:
        from hawk.stats.stalls import looks_json

        return looks_json(connection, lot, request.match_info["stall"])

    return await _read(request, read)


async def survey_file(request: web.Request) -> web.StreamResponse:
    """A survey of the lot as GeoJSON."""
    survey, suffix = request.match_info["survey"], ".geojson"

    async def work(store: LotStore) -> web.StreamResponse:
        from hawk.exports.files import made
        from hawk.exports.reading import survey_of
        from hawk.lots.pictures import pictures_of

        lot = await _lot(store, request)

        def read(connection: Connection) -> tuple[str, bytes]:
            return made(connection, survey_of(connection, lot, survey), pictures_of(store.path), suffix)

        content_type, data = await store.read(read)
        return web.Response(body=data, headers={hdrs.CONTENT_TYPE: content_type, hdrs.CACHE_CONTROL: "no-store"})

    return await answer(request, work)


async def shares(request: web.Request) -> web.StreamResponse:
    """The links to a lot, without their tokens."""

    async def work(store: LotStore) -> object:
        from hawk.lots import sharing

        lot, now = request.match_info["id"], now_of(request)
        return await store.read(lambda c: sharing.shares(c, lot, now))

    return await answer(request, work)


async def share(store: LotStore, request: web.Request, body: Body) -> object:
    """Make a link to a lot for ``days``; the answer alone holds its ``token``."""
    from hawk.lots import sharing

    lot, now = request.match_info["id"], now_of(request)
    return await store.write(lambda c: sharing.share(c, lot, body, now))


async def take_back(store: LotStore, request: web.Request, _: Body) -> object:
    """Let a link open nothing from now on."""
    from hawk.lots import sharing

    share_id, now = request.match_info["id"], now_of(request)
    return await store.write(lambda c: sharing.take_back(c, share_id, now))


async def _read(request: web.Request, read: _Read) -> web.StreamResponse:
    async def work(store: LotStore) -> object:
        from hawk.lots.text import json_text

        lot = await _lot(store, request)
        return await store.read(lambda c: json_text(read(c, lot, request)))

    return await answer(request, work)


async def _lot(store: LotStore, request: web.Request) -> str:
    """Return the lot that the address names, or that its link opens. Raises NotFoundError and 429."""
    token = request.match_info.get("token")
    if token is None:
        return request.match_info["id"]
    from hawk.lots import sharing

    guesses, address, now = request.app[GUESSES], network_of(request.remote), now_of(request)
    wait = guesses.wait_s(address)
    if wait > 0:
        raise web.HTTPTooManyRequests(
            text=f"Too many wrong links came from your address: wait {math.ceil(wait)} s.",
            headers={hdrs.RETRY_AFTER: str(math.ceil(wait))},
        )
    lot = await store.read(lambda c: sharing.lot_of(c, token, now))
    if lot is None:
        request.app[LINK_LOG].warning("wrong link to a lot from %s, its %d.", address, guesses.wrong(address))
        await asyncio.sleep(WRONG_TOKEN_S)
        raise NotFoundError(NO_SUCH_LINK)
    return lot


def _period(request: web.Request) -> Any:
    from hawk.stats.asked import period_of

    asked = request.query
    return period_of(asked.get("from"), asked.get("to"), asked.get("time_zone"))
