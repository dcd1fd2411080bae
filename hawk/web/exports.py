"""Surveys as files for other programs: ``/api/surveys/ID.csv`` and its like, for viewers and operators.

Each file is made on the store's thread, which nothing of a flight waits for.
"""

from __future__ import annotations

from typing import Final

from aiohttp import hdrs, web

from hawk.lots.store import LotStore
from hawk.web.lot_answers import ID, answer

KINDS: Final = "csv|geojson|gpkg|kmz|png|zip"
"""Ends of names; ``zip`` holds the rasters."""


def add_routes(app: web.Application) -> None:
    """Add every route of this module."""
    app.router.add_get(f"/api/surveys/{ID}.{{kind:{KINDS}}}", survey_file)


async def survey_file(request: web.Request) -> web.StreamResponse:
    """A survey as a file: table, GeoJSON, GeoPackage, KMZ, picture, or mosaic and occupancy with a STAC item."""
    survey, suffix = request.match_info["id"], f".{request.match_info['kind']}"

    async def work(store: LotStore) -> web.StreamResponse:
        from hawk.exports.files import made
        from hawk.lots.pictures import pictures_of

        content_type, data = await store.read(lambda c: made(c, survey, pictures_of(store.path), suffix))
        headers = {
            hdrs.CONTENT_TYPE: content_type,
            hdrs.CONTENT_DISPOSITION: f'attachment; filename="survey-{survey[:8]}{suffix}"',
            hdrs.CACHE_CONTROL: "no-store",
        }
        return web.Response(body=data, headers=headers)

    return await answer(request, work)
