"""A file with an area, which a browser sends to be read: the page's editor takes what the settings' files take."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from concurrent.futures import ThreadPoolExecutor
from typing import Final

from aiohttp import hdrs, web

from hawk.comm.protocol.base import Spoken, Words
from hawk.formats.area_file import LARGEST_BYTES
from hawk.model.sentences import say, words_of
from hawk.web.services import SERVICES

KINDS: Final = ("fence", "outline")
READ_S: Final = 20.0
"""Real seconds in which the file must be there."""
_READER = web.AppKey("area_file_reader", ThreadPoolExecutor)


class FileRefusal(Spoken):
    """The reason why a file holds no area."""

    reason: Words


def add_routes(app: web.Application) -> None:
    """Add the route of this module, and the thread that reads the files: a large one takes tens of milliseconds."""
    app.cleanup_ctx.append(_reader)
    app.router.add_post("/api/area-file", area_file)


async def area_file(request: web.Request) -> web.StreamResponse:
    """GeoJSON of one Polygon for the editor of ``kind``; 422 with the reason for a file that holds none.

    The reason is text, and a `FileRefusal` for a client that accepts JSON.
    Nothing is stored and nothing changes: viewers may ask too.
    """
    kind = request.query.get("kind", KINDS[0])
    if kind not in KINDS:
        raise web.HTTPBadRequest(text=f"kind: must be {' or '.join(KINDS)}")
    data = await sent_file(request, LARGEST_BYTES, READ_S)
    read = request.app[SERVICES].read_area
    try:
        text = await asyncio.get_running_loop().run_in_executor(request.app[_READER], read, data, kind)
    except ValueError as error:
        return _refused(request, say("The file {fault}.", fault=words_of(error)))
    return web.Response(text=text, content_type="application/geo+json", headers={hdrs.CACHE_CONTROL: "no-store"})


def _refused(request: web.Request, reason: str) -> web.Response:
    if "application/json" not in request.headers.get(hdrs.ACCEPT, ""):
        return web.Response(status=web.HTTPUnprocessableEntity.status_code, text=reason)
    body = FileRefusal(reason=reason).to_json()
    return web.Response(status=web.HTTPUnprocessableEntity.status_code, text=body, content_type="application/json")


async def sent_file(request: web.Request, most_bytes: int, seconds: float, too_large: str | None = None) -> bytes:
    """Return the file that was sent. Raises 413, in these words, beyond ``most_bytes``; 408 after real ``seconds``."""
    data = bytearray()
    try:
        async with asyncio.timeout(seconds):
            async for chunk in request.content.iter_any():
                data += chunk
                if len(data) > most_bytes:
                    refusal = web.HTTPRequestEntityTooLarge(most_bytes, len(data), text=too_large)
                    refusal.force_close()
                    raise refusal
    except TimeoutError:
        raise web.HTTPRequestTimeout(text="The file did not come.") from None
    return bytes(data)


async def _reader(app: web.Application) -> AsyncIterator[None]:
    with ThreadPoolExecutor(1, thread_name_prefix="web-area-file") as executor:
        app[_READER] = executor
        yield
