"""Recordings as films: the time line, pictures and maps of one, for the page that plays it.

A recording is read once, in a process of its own at a low priority (`hawk.replay.timeline`), and its time line is kept
while it is shown; pictures and maps are read out of the file as they are asked for. In flight nothing is read: disk and
processor are the flight's.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import tempfile
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Final

from aiohttp import hdrs, web

from hawk.formats import box
from hawk.replay.film import READER, PackedFilm, Piece
from hawk.runtime.supervision import done_while
from hawk.store.recordings import Recordings
from hawk.web.downloads import FILES, is_on_ground
from hawk.web.services import SERVICES
from hawk.web.v1.answers import GEOJSON, Answer, answered, in_time, made
from hawk.web.v1.parameters import Query, query_of
from hawk.web.v1.recordings.files import folder_of
from hawk.web.v1.refusals import RefusedError

FLYING: Final = ("recordings", "a recording is shown once the motors are off")
READING: Final = "The recording is being read: ask again in some seconds."
KEPT: Final = 2
"""Films that are kept: those of two people."""
KEPT_S: Final = 600.0
"""Real seconds after which a film that nobody asks for is forgotten."""
LIMITS: Final = box.Limits(memory_bytes=1_000_000_000, cpu_s=1_800, longest_s=3_600.0)
"""A minute of flight takes half a second: a day of it is read."""
CACHING: Final = "private, max-age=3600"
"""Pictures and maps of a recording do not change."""


FileKey = tuple[Path, int, int]
"""A recording as it is on the disk: its path, its size, and when it was changed, nanoseconds."""


@dataclass(slots=True)
class _Shown:
    """A film, or what makes it. ``beside``: the file with the pictures of a packed recording."""

    beside: Path
    reading: asyncio.Task[PackedFilm]
    asked: float = field(default_factory=time.monotonic)


class Films:
    """The films that are shown."""

    def __init__(self, read: Callable[[Path, Path], Awaitable[PackedFilm]]) -> None:
        """``read``: makes the film of a recording; the second path is that of a file for pictures."""
        self._read = read
        self._kept: dict[FileKey, _Shown] = {}
        self._one = asyncio.Lock()
        self._folder = tempfile.TemporaryDirectory(prefix="hawk-films-")

    async def of(self, key: FileKey) -> tuple[PackedFilm, Path]:
        """Return the film of a recording, and the file with the pictures of a packed one.

        Raises box.RefusedError, RefusedError in flight.
        """
        self._forget(key)
        shown = self._kept.pop(key, None)
        if shown is None:
            beside = Path(self._folder.name) / f"{time.monotonic_ns()}.beside"
            shown = _Shown(beside, asyncio.create_task(self._made(key[0], beside), name="film"))
        self._kept[key] = shown
        shown.asked = time.monotonic()
        try:
            return await asyncio.shield(shown.reading), shown.beside
        except asyncio.CancelledError:
            if shown.reading.cancelled():
                raise web.HTTPServiceUnavailable(text=READING, headers={hdrs.RETRY_AFTER: "2"}) from None
            raise
        except Exception:
            self._kept.pop(key, None)
            raise

    async def close(self) -> None:
        """End what is being read, and forget all."""
        for shown in list(self._kept.values()):
            shown.reading.cancel()
        await asyncio.gather(*(shown.reading for shown in self._kept.values()), return_exceptions=True)
        self._folder.cleanup()

    async def _made(self, path: Path, beside: Path) -> PackedFilm:
        async with self._one:
            return await self._read(path, beside)

    def _forget(self, wanted: FileKey) -> None:
        """Forget films that nobody asks for, and the oldest beyond `KEPT`; what is still being read is given up."""
        now = time.monotonic()
        others = [key for key in self._kept if key != wanted]
        old = [key for key in others if now - self._kept[key].asked > KEPT_S]
        for key in {*old, *others[: max(0, len(others) - KEPT + 1)]}:
            shown = self._kept.pop(key)
            shown.reading.cancel()
            with contextlib.suppress(OSError):
                shown.beside.unlink(missing_ok=True)


_FILMS: Final = web.AppKey("films", Films)


def prepare(app: web.Application) -> None:
    """Make room for films."""

    async def room(app: web.Application) -> AsyncIterator[None]:
        status = app[SERVICES].status
        films = app[_FILMS] = Films(partial(read_on_ground, lambda: is_on_ground(status.value)))
        yield
        await films.close()

    app.cleanup_ctx.append(room)


async def read_on_ground(is_down: Callable[[], bool], path: Path, beside: Path) -> PackedFilm:
    """Return the film of a recording, made in a process of its own; arming ends that.

    Raises RefusedError in flight, box.RefusedError.
    """
    reading = box.read_apart(READER, b"", {"recording": str(path), "beside": str(beside)}, LIMITS)
    if (found := await done_while(is_down, reading)) is None:
        raise RefusedError(web.HTTPConflict.status_code, *FLYING)
    return PackedFilm(found)


@answered
async def film(request: web.Request) -> web.StreamResponse:
    """The time line of a recording."""
    query_of(request, Query)
    async with in_time(READING):
        packed, _, _ = await _film_of(request)
    return await made(request, lambda: Answer(packed.text))


@answered
async def picture(request: web.Request) -> web.StreamResponse:
    """A picture of a recording."""
    return await _piece(request, PackedFilm.picture, "image/jpeg")


@answered
async def recorded_map(request: web.Request) -> web.StreamResponse:
    """The stalls of a recording as they were known at a time."""
    return await _piece(request, PackedFilm.map, GEOJSON)


async def _piece(
    request: web.Request, find: Callable[[PackedFilm, int], Piece | None], content_type: str
) -> web.StreamResponse:
    query_of(request, Query)
    async with in_time(READING):
        packed, path, beside = await _film_of(request)
        piece = find(packed, int(request.match_info["number"]))
        if piece is None:
            raise RefusedError(web.HTTPNotFound.status_code, "number", "the recording has none of this number")
        data = await request.app[FILES].run(partial(_bytes_of, beside if piece.is_beside else path, piece))
    headers: dict[str, str] = {hdrs.CACHE_CONTROL: CACHING}
    return await made(request, lambda: Answer(data, content_type=content_type, headers=headers))


async def _film_of(request: web.Request) -> tuple[PackedFilm, Path, Path]:
    """Return the film that a request asks for, its recording, and the file beside. Raises RefusedError, OSError."""
    if not is_on_ground(request.app[SERVICES].status.value):
        raise RefusedError(web.HTTPConflict.status_code, *FLYING)
    key = await request.app[FILES].run(partial(_key_of, folder_of(request), request.match_info["name"]))
    try:
        packed, beside = await request.app[_FILMS].of(key)
    except box.RefusedError as error:
        reason = "takes too much memory or time to be shown" if error.reason == box.TOO_MUCH else error.reason
        raise RefusedError(web.HTTPConflict.status_code, "recording", reason) from error
    return packed, key[0], beside


def _key_of(folder: Recordings, name: str) -> FileKey:
    path = folder.complete(name)
    about = path.stat()
    return path, about.st_size, about.st_mtime_ns


def _bytes_of(path: Path, piece: Piece) -> bytes:
    """Return a piece of a file. Raises OSError."""
    with path.open("rb") as file:
        return os.pread(file.fileno(), piece.length, piece.offset)
