"""Pictures that programs send into the inbox of a desk, each file as it is, within limits.

A program has a token of its own, as a drone has. A thread of its own writes, and no answer comes before the file is
whole and on the disk.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from functools import partial
from http import HTTPStatus
from typing import Annotated, Final, TypeVar

from aiohttp import web
from pydantic import Field

from hawk.lots.documents.arrival import Arrival, ArrivalKind, Outcome
from hawk.store.inbox import InboxFolder, InboxFullError, NameTakenError, name_fault
from hawk.web.services import SERVICES
from hawk.web.v1.answers import answered
from hawk.web.v1.bodies import InboxFile
from hawk.web.v1.changes import changed
from hawk.web.v1.desk import arrivals
from hawk.web.v1.desk.documents import checked_drone, sending
from hawk.web.v1.desk.file_transfer import FULL, receive, write_away
from hawk.web.v1.parameters import Query, query_of
from hawk.web.v1.refusals import RefusedError

_LOG = logging.getLogger(__name__)

NOT_HERE: Final = (
    "No pictures are taken here: name the folder in inbox.folder of a desk's settings, and start it again."
)
NO_LENGTH: Final = "Content-Length: send the size of the file, as curl -T does: the inbox keeps room for it first."
T = TypeVar("T")


class InboxPlace(Query):
    """The place of a file in the inbox."""

    flight: Annotated[
        str | None, Field(max_length=200, description="folder of its flight; without it the inbox itself")
    ] = None


@answered
async def put(request: web.Request) -> web.StreamResponse:
    """Write a file into the inbox; the same file may come again, another one of its name is refused."""
    sender = checked_drone(request)
    folder = request.app[SERVICES].inbox
    if folder is None:
        raise web.HTTPConflict(text=NOT_HERE)
    name, flight = request.match_info["file"], query_of(request, InboxPlace).flight
    for field, given in (("file", name), ("flight", flight)):
        if given is not None and (fault := name_fault(given)):
            raise RefusedError(HTTPStatus.UNPROCESSABLE_ENTITY, field, fault)
    size = _size(request, folder)
    async with sending(request, sender):
        incoming = await _on_disk(request, partial(folder.begin, flight or "", name, size))
        try:
            await receive(request, lambda chunk: _on_disk(request, partial(incoming.write, chunk)))
            is_new = await _on_disk(request, incoming.finish)
        finally:  # also of a lost connection; a file that is whole stays
            await asyncio.shield(_on_disk(request, incoming.drop))
    _LOG.info("%s sent %s to the inbox, %d bytes", sender, name, size)
    outcome = Outcome.TAKEN if is_new else Outcome.KNOWN
    await arrivals.note(request, Arrival(sender, ArrivalKind.FILE, arrivals.file_name(request), outcome))
    return changed(InboxFile(name=name, flight=flight, bytes=size))


def _size(request: web.Request, folder: InboxFolder) -> int:
    """Return the size of the file in bytes. Raises HTTPLengthRequired, RefusedError."""
    size = request.content_length
    if size is None:
        raise web.HTTPLengthRequired(text=NO_LENGTH)
    if size == 0:
        raise RefusedError(HTTPStatus.UNPROCESSABLE_ENTITY, "file", "is empty: send it again once it is whole")
    if size > folder.quota.largest:
        most = f"{folder.quota.largest / 1e9:.3g}"
        words = f"is too large: {most} GB are taken at most (inbox.largest_gb); copy it into the folder"
        raise RefusedError(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "file", words)
    return size


async def _on_disk(request: web.Request, work: Callable[[], T]) -> T:
    """Return what the thread that writes did. Raises RefusedError."""
    try:
        return await write_away(request, work)
    except NameTakenError as error:
        words = f"{error} is in the inbox with other contents: name the flight of this one, as ?flight=monday-2"
        raise RefusedError(HTTPStatus.CONFLICT, "flight", words) from error
    except InboxFullError as error:
        raise RefusedError(HTTPStatus.INSUFFICIENT_STORAGE, "", str(error)) from error
    except OSError as error:
        if error.errno in FULL:
            words = "The disk of the inbox is full: make room there, then send the file again."
            raise RefusedError(HTTPStatus.INSUFFICIENT_STORAGE, "", words) from error
        words = f"The inbox cannot be written: {error.strerror or error}. See that hawk may write in inbox.folder."
        raise RefusedError(HTTPStatus.CONFLICT, "", words) from error
