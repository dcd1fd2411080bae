"""Lots and surveys for other programs: a survey as a file, and a lot as a feed in the words of a receiver.

Each is made on a thread of the store that reads, which nothing of a flight waits for. Its ETag is that of the bytes:
what a feed says changes with the time, too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Final

from aiohttp import hdrs, web

from hawk.exports.formats import FEEDS, Wanted
from hawk.lots.answers import SurveyGround
from hawk.lots.store import FILE_S
from hawk.lots.values import NotFoundError
from hawk.runtime.late import late_functions
from hawk.web.v1.answers import BUSY, Answer, answered, in_time, made, now_of, opened
from hawk.web.v1.parameters import FeedOptions, Query, query_of

if TYPE_CHECKING:
    from sqlalchemy import Connection

    from hawk.exports import feeds, files
    from hawk.lots.survey import pictures, private_ground
    from hawk.lots.survey.pictures import PictureFolder
    from hawk.model.poses import Ring
else:
    feeds, files, pictures, private_ground = map(
        late_functions,
        (
            "hawk.exports.feeds", "hawk.exports.files", "hawk.lots.survey.pictures", "hawk.lots.survey.private_ground",
        ),
    )  # fmt: skip

TILE_CACHING: Final = "private, max-age=86400"
"""A day: then a browser asks once whether the survey is there."""
_TILE_HEADERS: Final[Mapping[str, str]] = {
    hdrs.CACHE_CONTROL: TILE_CACHING,
    hdrs.VARY: f"{hdrs.ACCEPT_ENCODING}, {hdrs.COOKIE}",  # the next person at this browser asks again
}


@answered
async def survey_file(request: web.Request) -> web.StreamResponse:
    """A survey as a file: table, GeoJSON, GeoPackage, KMZ, picture, or mosaic and occupancy with a STAC item."""
    query_of(request, Query)
    survey, suffix = request.match_info["id"], f".{request.match_info['kind']}"
    store = await opened(request)

    def read(connection: Connection) -> tuple[str, bytes]:
        return files.made(connection, survey, pictures.pictures_of(store.path), suffix)

    content_type, data = await store.read(read, FILE_S)
    headers: dict[str, str] = {hdrs.CONTENT_DISPOSITION: f'attachment; filename="survey-{survey[:8]}{suffix}"'}
    return await made(request, lambda: Answer(data, content_type=content_type, headers=headers))


@answered
async def survey_ground(request: web.Request) -> web.StreamResponse:
    """Places of the tiles of a survey's picture."""
    query_of(request, Query)
    survey = request.match_info["id"]
    store = await opened(request)

    def read(connection: Connection) -> SurveyGround:
        return files.tiles_of(connection, survey, pictures.pictures_of(store.path))

    async with in_time(BUSY):
        found = await store.read(read)
    return await made(request, lambda: Answer(found))


@answered
async def survey_tile(request: web.Request) -> web.StreamResponse:
    """A tile of a survey's picture. A picture never changes: a browser keeps its tiles."""
    query_of(request, Query)
    key = int(request.match_info["row"]), int(request.match_info["column"])
    data = await _picture(request, lambda folder, survey, hidden: folder.tile(survey, key, hidden))
    if data is None:
        raise NotFoundError("row: there is no tile at this row and column")
    return await made(request, lambda: Answer(data, content_type="image/jpeg", headers=_TILE_HEADERS))


@answered
async def survey_whole(request: web.Request) -> web.StreamResponse:
    """All of a survey's picture in one, for a screen; 204 where there is none: it is asked for before that is known."""
    query_of(request, Query)
    data = await _picture(request, lambda folder, survey, hidden: folder.whole(survey, hidden))
    if data is None:
        return web.Response(status=web.HTTPNoContent.status_code)
    return await made(request, lambda: Answer(data, content_type="image/webp", headers=_TILE_HEADERS))


async def _picture(
    request: web.Request, read: Callable[[PictureFolder, str, Sequence[Ring]], bytes | None]
) -> bytes | None:
    """Return a picture out of the folder of a store's pictures by the id of the survey in the address."""
    survey = request.match_info["id"]
    store = await opened(request)
    async with in_time(BUSY):
        return await store.read(
            lambda connection: read(
                pictures.pictures_of(store.path), survey, private_ground.hidden_in(connection, survey)
            )
        )


@answered
async def feed(request: web.Request) -> web.StreamResponse:
    """A lot as a feed."""
    options, name, now = query_of(request, FeedOptions), request.match_info["feed"], now_of(request)
    wanted = Wanted(
        request.match_info["id"], options.survey, options.valid_s, options.begin, options.end, options.time_zone
    )  # fmt: skip
    async with in_time(BUSY):
        store = await opened(request)
        text = await store.read(lambda connection: feeds.feed_text(connection, name, wanted, now))
    return await made(request, lambda: Answer(text, content_type=FEEDS[name].content_type))
