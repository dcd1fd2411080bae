"""The recordings on the drone's disk, for page and tools: list, mark "keep", download, delete.

Everybody may read the list; operators change it and download, since a recording holds the configuration. In flight
nothing is deleted or sent: the disk is the flight's.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import Any, Final, TypeVar

from aiohttp import hdrs, web

from hawk.lots.values import LotInputError, LotStoreError, utc
from hawk.store.recordings import Contents, NotThatRecordingError, Recordings, Stored
from hawk.web.downloads import FILES, is_on_ground, send_file
from hawk.web.refusals import REFUSALS, Body, RefusedError, body_of, check_operator, refusal_of
from hawk.web.services import SERVICES

NAME: Final = r"{name:[0-9TZ-]{16,24}\.mcap}"
"""Pattern of a recording's name in a route."""
NONE_HERE: Final = ("recordings", "nothing is recorded here")
FLYING: Final = ("recordings", "wait until the motors are off")
FOR_OPERATORS: Final = "Recordings are changed and downloaded by operators: log in as operator."
T = TypeVar("T")
_Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


def add_routes(app: web.Application) -> None:
    """Add every route of this module."""
    app.router.add_get("/api/recordings.json", _answered(listed))
    app.router.add_get(f"/api/recordings/{NAME}", _answered(download, for_operators=True))
    app.router.add_post(f"/api/recordings/{NAME}/keep", _answered(keep, for_operators=True))
    app.router.add_post(f"/api/recordings/{NAME}/delete", _answered(delete, for_operators=True))


async def listed(request: web.Request) -> web.StreamResponse:
    """Every recording, the oldest first, with size, lot, length and mark."""
    rows = await rows_of(request)
    return _json({"recordings": rows, "bytes": sum(row["bytes"] for row in rows)})


async def rows_of(request: web.Request) -> list[dict[str, Any]]:
    """Return every recording as JSON values, the oldest first. Raises RefusedError and OSError."""
    folder = _folder(request)

    def read() -> list[tuple[Stored, Contents]]:
        found = []
        for one in folder.listed():
            with suppress(NotThatRecordingError):  # it went meanwhile
                found.append((one, Contents() if one.is_under_way else folder.contents(one.name)))
        return found

    found = await _run(request, read)
    lots = await _lots(request)
    return [_row(one, contents, lots.get(contents.survey)) for one, contents in found]


async def keep(request: web.Request) -> web.StreamResponse:
    """Set the mark "keep", or take it away."""
    return _json(await kept(request, await body_of(request)))


async def kept(request: web.Request, body: Body) -> dict[str, Any]:
    """Set the mark of the recording in the address, ``keep``. Raises LotInputError and those of `Recordings.keep`."""
    folder, name, wanted = _folder(request), request.match_info["name"], body.get("keep")
    if not isinstance(wanted, bool):
        raise LotInputError("keep", "send true or false")
    await _run(request, partial(folder.keep, name, is_kept=wanted))
    return {"name": name, "keep": wanted}


async def delete(request: web.Request) -> web.StreamResponse:
    """Delete a recording."""
    return _json(await deleted(request, {}))


async def deleted(request: web.Request, _: Body) -> dict[str, Any]:
    """Delete the recording in the address. Raises RefusedError in flight, and those of `Recordings.delete`."""
    _check_on_ground(request)
    name = request.match_info["name"]
    await _run(request, partial(_folder(request).delete, name))
    return {"name": name, "deleted": True}


async def download(request: web.Request) -> web.StreamResponse:
    """A recording, or the part of it that is asked for."""
    _check_on_ground(request)
    folder, name = _folder(request), request.match_info["name"]
    found = {one.name: one for one in await _run(request, folder.listed)}
    one = found.get(name)
    if one is None or one.is_under_way:
        raise RefusedError(404, name, "there is no complete recording of this name; the list has all")
    return await send_file(request, folder.folder / name, one.bytes)


def _answered(handler: _Handler, *, for_operators: bool = False) -> _Handler:
    """Return the handler with its refusals as JSON: ``field`` and ``reason``."""

    async def handle(request: web.Request) -> web.StreamResponse:
        if for_operators:
            check_operator(request, FOR_OPERATORS)
        try:
            return await handler(request)
        except (*REFUSALS, OSError) as error:
            refusal = refusal_of(error)
            return _json(refusal.content, refusal.status)

    return handle


def _check_on_ground(request: web.Request) -> None:
    if not is_on_ground(request.app[SERVICES].status.value):
        raise RefusedError(409, *FLYING)


def _json(content: Mapping[str, Any], status: int = 200) -> web.Response:
    return web.json_response(content, status=status, headers={hdrs.CACHE_CONTROL: "no-store"})


def _folder(request: web.Request) -> Recordings:
    folder = request.app[SERVICES].recordings
    if folder is None:
        raise RefusedError(409, *NONE_HERE)
    return folder


async def _run(request: web.Request, work: Callable[[], T]) -> T:
    return await request.app[FILES].run(work)


async def _lots(request: web.Request) -> Mapping[str, Mapping[str, str]]:
    """Return id and name of the lot of each stored survey, by the survey's name; nothing where the store is shut."""
    store = request.app[SERVICES].lots
    if store is None:
        return {}
    try:
        await store.open()
        from hawk.lots.queries import lots_of_surveys

        return await store.read(lots_of_surveys)
    except LotStoreError:
        return {}


def _row(one: Stored, contents: Contents, lot: Mapping[str, str] | None) -> dict[str, Any]:
    return {
        "name": one.name,
        "bytes": one.bytes,
        "began": None if one.began is None else utc(one.began),
        "seconds": None if contents.seconds is None else round(contents.seconds, 1),
        "survey": contents.survey or None,
        "lot": lot,
        "keep": one.is_kept,
        "under_way": one.is_under_way,
    }
