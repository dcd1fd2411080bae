"""A picture of the ground under the page's map, from a folder on this computer; nothing is fetched from elsewhere.

The folder holds square tiles as ``{zoom}/{x}/{y}.png`` (or ``.jpg``, ``.jpeg``, ``.webp``), numbered as in XYZ or
"slippy map" tiles: Web Mercator, y from the north. QGIS writes such a folder with "Generate XYZ tiles (Directory)".
A folder of TMS tiles, y from the south, is known by its ``tilemapresource.xml`` (gdal2tiles) or ``metadata.json``.
"""

from __future__ import annotations

import asyncio
import json
import logging
import re
from collections.abc import AsyncIterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Final

from aiohttp import hdrs, web

from hawk.web.services import SERVICES

DEEPEST_ZOOM: Final = 23
"""A tile of 256 pixels there shows five metres: 2 cm a pixel at the equator."""
SUFFIXES: Final = {".png": "image/png", ".jpg": "image/jpeg", ".jpeg": "image/jpeg", ".webp": "image/webp"}
CACHING: Final = "private, max-age=3600"
LARGEST_TILE_BYTES: Final = 2_000_000
"""A tile of 512 pixels without any loss has 0.8 MB."""
_LOGGER = logging.getLogger(__name__)
TMS_FILE: Final = "tilemapresource.xml"
METADATA_FILE: Final = "metadata.json"
SEEMS_TMS: Final = (
    " The tiles seem to be numbered from the south (TMS): write metadata.json with "
    '{"scheme": "tms"} into the folder, or make them with gdal2tiles --xyz.'
)
_LARGEST_FILE_BYTES: Final = 1_000_000
_MERCATOR: Final = ("mercator", "900913", "3857")
_READER = web.AppKey("background_reader", ThreadPoolExecutor)


def add_routes(app: web.Application) -> None:
    """Add every route of this module, and the thread that reads the files."""
    app.cleanup_ctx.append(_reader)
    app.router.add_get("/api/background.json", background)
    app.router.add_get(r"/api/background/{zoom:\d{1,2}}/{x:\d{1,8}}/{y:\d{1,8}}", tile)


async def background(request: web.Request) -> web.StreamResponse:
    """Zooms of which there are tiles, lowest first; none without the setting."""
    folder = request.app[SERVICES].web.background_tiles
    reader = request.app[_READER]
    zooms = [] if folder is None else await asyncio.get_running_loop().run_in_executor(reader, zooms_in, folder)
    return web.json_response({"Zooms": zooms}, headers={hdrs.CACHE_CONTROL: "no-cache"})


async def tile(request: web.Request) -> web.StreamResponse:
    """One tile. Its path is made of three numbers, so that no request leaves the folder."""
    folder = request.app[SERVICES].web.background_tiles
    zoom, x, y = (int(request.match_info[name]) for name in ("zoom", "x", "y"))
    if folder is None:
        raise web.HTTPNotFound(text="No background tiles are set: [web] background_tiles.")
    loop = asyncio.get_running_loop()
    tiles = request.app[_TILES]
    found = await loop.run_in_executor(request.app[_READER], tiles.read, zoom, x, y)
    if found is None and tiles.problem:
        raise web.HTTPNotFound(text=f"There is no background tile {zoom}/{x}/{y}.{tiles.problem}")
    if found is None:  # beside the picture: the page asks for all ground in sight, and that is no error
        return web.Response(status=204, headers={hdrs.CACHE_CONTROL: CACHING})
    content_type, data = found
    return web.Response(body=data, content_type=content_type, headers={hdrs.CACHE_CONTROL: CACHING})


class Tiles:
    """Tiles of a folder, by their XYZ numbers. Used on the thread that reads."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._is_tms, self.problem = _numbering(folder)
        """``problem``: why no tile can be right, in words behind a space; empty when they can."""

    def read(self, zoom: int, x: int, y: int) -> tuple[str, bytes] | None:
        """Return type and bytes of a tile, None without one. Reports once that a folder seems to be numbered as TMS."""
        if self.problem:
            return None
        from_south = (1 << zoom) - 1 - y
        found = read_tile(self._folder, zoom, x, from_south if self._is_tms else y)
        if found is None and not self._is_tms and read_tile(self._folder, zoom, x, from_south) is not None:
            self.problem = SEEMS_TMS
            _LOGGER.warning("web.background_tiles: %s:%s", self._folder, self.problem)
        return found


_TILES = web.AppKey("background_tiles", Tiles)


def _numbering(folder: Path) -> tuple[bool, str]:
    """Return whether tiles are numbered from the south (OSGeo's TMS 1.0), and why none can be shown, else ""."""
    resource = _text_of(folder / TMS_FILE)
    if resource is not None:
        profile = re.search(r'profile\s*=\s*"([^"]*)"', resource)
        if profile is not None and not any(name in profile[1].lower() for name in _MERCATOR):
            return (
                True,
                f" The tiles are not in Web Mercator ({profile[1]}): make them with gdal2tiles --profile=mercator.",
            )
        return True, ""
    try:
        metadata = json.loads(_text_of(folder / METADATA_FILE) or "{}")
    except (json.JSONDecodeError, RecursionError):
        return False, ""
    scheme = metadata.get("scheme") if isinstance(metadata, dict) else None
    return isinstance(scheme, str) and scheme.lower() == "tms", ""


def _text_of(path: Path) -> str | None:
    try:
        with path.open("rb") as file:
            return file.read(_LARGEST_FILE_BYTES).decode("utf-8", "replace")
    except OSError:
        return None


def zooms_in(folder: Path) -> list[int]:
    """Return the zooms of a folder; empty when it cannot be read."""
    try:
        names = [each.name for each in folder.iterdir() if each.is_dir()]
    except OSError:
        return []
    return sorted({int(name) for name in names if name.isascii() and name.isdigit() and int(name) <= DEEPEST_ZOOM})


def read_tile(folder: Path, zoom: int, x: int, y: int) -> tuple[str, bytes] | None:
    """Return type and bytes of a tile; None when it is not there, cannot be read, or is too large for a tile."""
    stem = folder / str(zoom) / str(x)
    for suffix, content_type in SUFFIXES.items():
        try:
            with (stem / f"{y}{suffix}").open("rb") as file:
                data = file.read(LARGEST_TILE_BYTES + 1)
        except OSError:
            continue
        return (content_type, data) if len(data) <= LARGEST_TILE_BYTES else None
    return None


async def _reader(app: web.Application) -> AsyncIterator[None]:
    with ThreadPoolExecutor(1, thread_name_prefix="background") as executor:
        app[_READER] = executor
        folder = app[SERVICES].web.background_tiles
        loop = asyncio.get_running_loop()
        if folder is not None:
            app[_TILES] = await loop.run_in_executor(executor, Tiles, folder)
            if app[_TILES].problem:
                _LOGGER.warning("web.background_tiles: %s:%s", folder, app[_TILES].problem)
        if folder is not None and not await loop.run_in_executor(executor, zooms_in, folder):
            _LOGGER.warning("web.background_tiles: %s has no tiles ZOOM/X/Y.png; the map has no background", folder)
        yield
