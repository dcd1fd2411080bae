"""The recordings on the drone's disk: list, mark "keep", download, delete.

Everybody may read the list; operators change it and download, since a recording holds the configuration. In flight
nothing is deleted or sent: the disk is the flight's.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from datetime import UTC, datetime
from functools import partial
from typing import Final, TypeVar

from aiohttp import web

from hawk.lots.values import LotInputError, LotStoreError
from hawk.store.recordings import Contents, NotThatRecordingError, Recordings, Stored
from hawk.web.downloads import FILES, is_on_ground, send_file
from hawk.web.services import SERVICES
from hawk.web.v1.answers import Answer, answered, in_time, made
from hawk.web.v1.bodies import Deleted, Kept, RecordedLot, Recording, RecordingList
from hawk.web.v1.changes import Body
from hawk.web.v1.desk.file_transfer import write_away
from hawk.web.v1.parameters import Listed, Query, query_of
from hawk.web.v1.refusals import RefusedError, check_operator

NONE_HERE: Final = ("recordings", "nothing is recorded here")
FLYING: Final = ("recordings", "wait until the motors are off")
FOR_OPERATORS: Final = "Recordings are changed and downloaded by operators: log in as operator."
T = TypeVar("T")


@answered
async def listed(request: web.Request) -> web.StreamResponse:
    """The recordings, the oldest first."""
    query = query_of(request, Listed)
    async with in_time("The disk is busy: ask again in some seconds."):
        rows = await _rows_of(request)
    first = 0
    if query.after is not None:
        names = [row.name for row in rows]
        if query.after not in names:
            raise LotInputError("after", "is no place in this list: write `next` of the part before, or leave it out")
        first = names.index(query.after) + 1
    part = rows[first : first + query.limit]
    following = part[-1].name if first + query.limit < len(rows) else None
    return await made(request, lambda: Answer(RecordingList(items=part, next=following), following))


@answered
async def download(request: web.Request) -> web.StreamResponse:
    """A recording, or the part of it that is asked for."""
    check_operator(request, FOR_OPERATORS)
    query_of(request, Query)
    _check_on_ground(request)
    path = await _run(request, partial(folder_of(request).complete, request.match_info["name"]))
    size = (await _run(request, path.stat)).st_size
    return await send_file(request, path, size)


async def keep(request: web.Request, body: Body) -> object:
    """Set the mark of the recording in the address, or take it away. Raises those of `Recordings.keep`."""
    folder, name, wanted = folder_of(request), request.match_info["name"], body["keep"]
    await _run(request, partial(folder.keep, name, is_kept=wanted))
    return Kept(name=name, keep=wanted)


async def delete(request: web.Request, _: Body) -> object:
    """Delete the recording in the address. Raises RefusedError in flight, and those of `Recordings.delete`."""
    _check_on_ground(request)
    name = request.match_info["name"]
    await _run(request, partial(folder_of(request).delete, name))
    return Deleted(name=name, deleted=True)


async def _rows_of(request: web.Request) -> list[Recording]:
    """Return every recording the oldest first. Raises RefusedError and OSError."""
    folder = folder_of(request)

    def read() -> list[tuple[Stored, Contents]]:
        found = []
        for one in folder.listed():
            with suppress(NotThatRecordingError):  # it went meanwhile
                found.append((one, Contents() if one.is_under_way else folder.contents(one.name)))
        return found

    found = await _run(request, read)
    lots, requests = await _lots(request), request.app[SERVICES].recording_requests
    origins = {} if requests is None else await write_away(request, requests.origins)

    def row(one: Stored, contents: Contents) -> Recording:
        origin = next(iter(origins.get(one.name, ())), None)
        lot = lots.get(contents.survey if origin is None else origin.survey)
        return _row(one, contents, lot, folder.ends(one), None if origin is None else origin.drone)

    return [row(one, contents) for one, contents in found]


def _check_on_ground(request: web.Request) -> None:
    if not is_on_ground(request.app[SERVICES].status.value):
        raise RefusedError(web.HTTPConflict.status_code, *FLYING)


def folder_of(request: web.Request) -> Recordings:
    """Return the folder of recordings. Raises RefusedError where nothing is recorded."""
    folder = request.app[SERVICES].recordings
    if folder is None:
        raise RefusedError(web.HTTPConflict.status_code, *NONE_HERE)
    return folder


async def _run(request: web.Request, work: Callable[[], T]) -> T:
    return await request.app[FILES].run(work)


async def _lots(request: web.Request) -> Mapping[str, Mapping[str, str]]:
    """Return id and name of the lot of each stored survey, by its id and its journal; nothing where the store is
    shut.
    """
    store = request.app[SERVICES].lots
    if store is None:
        return {}
    try:
        await store.open()
        from hawk.lots.queries import lots_of_surveys

        return await store.read(lots_of_surveys)
    except LotStoreError:
        return {}


def _row(
    one: Stored, contents: Contents, lot: Mapping[str, str] | None, ends: float | None, drone: str | None
) -> Recording:  # fmt: skip
    return Recording(
        name=one.name,
        bytes=one.bytes,
        began=_utc(one.began if contents.began is None else contents.began),
        seconds=None if contents.seconds is None else round(contents.seconds, 1),
        survey=contents.survey or None,
        lot=None if lot is None else RecordedLot.model_validate(lot),
        drone=drone,
        keep=one.is_kept,
        keep_end=_utc(ends),
        under_way=one.is_under_way,
    )


def _utc(seconds: float | None) -> datetime | None:
    return None if seconds is None else datetime.fromtimestamp(int(seconds), UTC)
