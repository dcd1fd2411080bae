"""Surveys for other programs: as files, ``/api/surveys/ID.csv`` and its like, and a lot's newest one as a feed in the
words of a receiver, ``/api/lots/ID/feeds/ngsi-ld``.

Each is made on a thread of the store that reads, which nothing of a flight waits for.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from aiohttp import hdrs, web

from hawk.exports.formats import CONTENT_TYPES
from hawk.lots.store import FILE_S, LotStore
from hawk.lots.values import LotInputError, NotFoundError
from hawk.web.lot_answers import ID, answer, now_of

if TYPE_CHECKING:  # loaded on the store's thread
    from sqlalchemy import Connection

KINDS: Final = "|".join(each.removeprefix(".") for each in CONTENT_TYPES)
"""Ends of names; ``zip`` holds the rasters."""


def add_routes(app: web.Application) -> None:
    """Add every route of this module."""
    app.router.add_get(f"/api/surveys/{ID}.{{kind:{KINDS}}}", survey_file)
    app.router.add_get(f"/api/lots/{ID}/feeds/cds-aggregates", aggregates)
    app.router.add_get(f"/api/lots/{ID}/feeds/{{feed}}", feed)


async def survey_file(request: web.Request) -> web.StreamResponse:
    """A survey as a file: table, GeoJSON, GeoPackage, KMZ, picture, or mosaic and occupancy with a STAC item."""
    survey, suffix = request.match_info["id"], f".{request.match_info['kind']}"

    async def work(store: LotStore) -> web.StreamResponse:
        from hawk.exports.files import made
        from hawk.lots.survey.pictures import pictures_of

        content_type, data = await store.read(lambda c: made(c, survey, pictures_of(store.path), suffix), FILE_S)
        headers = {
            hdrs.CONTENT_TYPE: content_type,
            hdrs.CONTENT_DISPOSITION: f'attachment; filename="survey-{survey[:8]}{suffix}"',
            hdrs.CACHE_CONTROL: "no-store",
        }
        return web.Response(body=data, headers=headers)

    return await answer(request, work)


async def feed(request: web.Request) -> web.StreamResponse:
    """The newest registered survey of a lot in a receiver's words; a state is unknown after ``valid_s`` seconds."""
    lot, name = request.match_info["id"], request.match_info["feed"]

    async def work(store: LotStore) -> web.StreamResponse:
        from hawk.exports.feeds import FEEDS, VALID_S, valid_at
        from hawk.exports.records import read_survey, survey_of
        from hawk.lots.text import json_text

        if name not in FEEDS:
            raise NotFoundError(f"feed: there is none called {name}; there are {', '.join([*FEEDS, 'cds-aggregates'])}")
        valid_s, now = _seconds(request.query.get("valid_s", str(VALID_S))), now_of(request)

        def made(connection: Connection) -> str:
            survey = valid_at(read_survey(connection, survey_of(connection, lot)), now, valid_s)
            return json_text(FEEDS[name].make(survey))

        text = await store.read(made)
        headers = {hdrs.CONTENT_TYPE: FEEDS[name].content_type, hdrs.CACHE_CONTROL: "no-store"}
        return web.Response(body=text.encode(), headers=headers)

    return await answer(request, work)


async def aggregates(request: web.Request) -> web.StreamResponse:
    """A lot's occupancy hour by hour in a period as CDS aggregates, a table; -1 where nobody flew."""
    lot, query = request.match_info["id"], request.query

    async def work(store: LotStore) -> web.StreamResponse:
        from hawk.stats.aggregates import CONTENT_TYPE, cds_aggregates
        from hawk.stats.panel import read_panel
        from hawk.stats.period import period_of

        period = period_of(query.get("from"), query.get("to"), query.get("time_zone"))
        text = await store.read(lambda connection: cds_aggregates(read_panel(connection, lot, period)))
        headers = {hdrs.CONTENT_TYPE: CONTENT_TYPE, hdrs.CACHE_CONTROL: "no-store"}
        return web.Response(body=text.encode(), headers=headers)

    return await answer(request, work)


def _seconds(given: str) -> float:
    try:
        value = float(given)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise LotInputError("valid_s", f"must be a positive number of seconds, not {given}")
    return value
