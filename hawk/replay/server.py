"""Serves the page of a replay on this computer alone. It only reads: there is no drone, and nothing is commanded."""

from __future__ import annotations

import asyncio
import os
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import IO, Any, Final

from aiohttp import hdrs, web
from aiohttp.typedefs import Handler

from hawk.replay.flight import RecordedFlight
from hawk.replay.timeline import Piece, Shown, read_shown
from hawk.web.app import PAGE_DIRECTORY, Page
from hawk.web.security import add_headers

HOST: Final = "127.0.0.1"
_NAMES: Final = frozenset({"localhost", HOST})
_PAGE: Final = "replay.html"


class ReplayServer:
    """`start`, then `url`, then `close`."""

    def __init__(self, flight: RecordedFlight, shown: Shown, beside: IO[bytes], page: Page) -> None:
        """``beside``: the file with pictures and maps."""
        self._flight = flight
        self._shown = shown
        self._beside = beside
        self._page = page
        app = web.Application(middlewares=[_on_this_computer])
        app.on_response_prepare.append(add_headers)
        app.router.add_get("/", self._index)
        app.router.add_get("/api/replay.json", self._line)
        app.router.add_get(r"/api/replay/{kind:pictures|maps}/{number:\d{1,7}}", self._piece)
        app.router.add_get("/{path:.+}", page.handle)
        self._runner = web.AppRunner(app, access_log=None)
        self.url = ""

    async def start(self, port: int) -> None:
        """Listen on loopback; 0: on a free port. Raises OSError for an address that is in use."""
        await self._runner.setup()
        site = web.TCPSite(self._runner, HOST, port)
        await site.start()
        self.url = f"http://{HOST}:{self._runner.addresses[0][1]}/"

    async def close(self) -> None:
        """Stop listening."""
        await self._runner.cleanup()

    async def _index(self, request: web.Request) -> web.StreamResponse:
        return self._page.named(request, _PAGE)

    async def _line(self, _: web.Request) -> web.StreamResponse:
        flight, shown = self._flight, self._shown
        content: dict[str, Any] = {
            "name": flight.path.name,
            "utc": flight.utc,
            "maker": str(flight.maker),
            "damage": shown.damage,
            "seconds": round(shown.seconds, 2),
            "events": [{**asdict(event), "at": round(event.at, 2)} for event in shown.events],
            "track": [[round(at, 2), north, east, round(height, 2)] for at, north, east, height in shown.track],
            "pictures": [round(piece.at, 2) for piece in shown.pictures],
            "maps": [round(piece.at, 2) for piece in shown.maps],
        }
        return web.json_response(content)

    async def _piece(self, request: web.Request) -> web.StreamResponse:
        is_picture = request.match_info["kind"] == "pictures"
        pieces: list[Piece] = self._shown.pictures if is_picture else self._shown.maps
        number = int(request.match_info["number"])
        if number >= len(pieces):
            raise web.HTTPNotFound(text=f"This recording has {len(pieces)} of them.")
        piece = pieces[number]
        data = os.pread(self._beside.fileno(), piece.length, piece.offset)
        kind = "image/jpeg" if is_picture else "application/geo+json"
        headers = {hdrs.CONTENT_TYPE: kind, hdrs.CACHE_CONTROL: "private, max-age=3600"}
        return web.Response(body=data, headers=headers)


@web.middleware
async def _on_this_computer(request: web.Request, handler: Handler) -> web.StreamResponse:
    """Refuse another host's name: a page elsewhere could reach this server by it."""
    if request.host.rpartition(":")[0] not in _NAMES and request.host not in _NAMES:
        raise web.HTTPForbidden(text="Host: open the address that was printed")
    return await handler(request)


async def serve(path: Path, port: int) -> None:
    """Show a recording until the program is ended. Raises ReplayError, OSError."""
    flight = RecordedFlight(path)
    with tempfile.TemporaryFile(prefix="hawk-replay-") as beside:
        shown = await asyncio.get_running_loop().run_in_executor(None, read_shown, flight, beside)
        server = ReplayServer(flight, shown, beside, Page.load(PAGE_DIRECTORY))
        await server.start(port)
        try:
            print(f"hawk-drone replay: open {server.url} (Ctrl+C ends it)", flush=True)
            await asyncio.Event().wait()
        finally:
            await server.close()
