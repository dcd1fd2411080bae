"""Documents of surveys and lots that drones send to a desk that collects: committed, then answered; lots that go back.

A drone has a token of its own. It opens the addresses here, and none that commands or changes anything else.
"""

from __future__ import annotations

import contextlib
import logging
import math
import re
from collections.abc import AsyncIterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Final

from aiohttp import hdrs, web

from hawk.lots.documents.parts import LARGEST_BYTES
from hawk.lots.store import FILE_S, LotStore
from hawk.runtime.late import late
from hawk.store.recording_request import ASKED, MOST_ASKED
from hawk.store.recording_requests import RecordingRequests
from hawk.web.access.access import access_of
from hawk.web.access.guesses import TokenGuesses, is_loopback_peer
from hawk.web.access.proxied import forwarding_header, is_secure
from hawk.web.area_file import sent_file
from hawk.web.services import SERVICES
from hawk.web.v1.answers import BUSY, answered, due_of, in_time, opened
from hawk.web.v1.bodies import LotState, SurveyState
from hawk.web.v1.changes import UNSURE, changed
from hawk.web.v1.desk.file_transfer import write_away
from hawk.web.v1.parameters import ChangedLots, Query, query_of
from hawk.web.v1.unknown import PATTERNS, ROOT

if TYPE_CHECKING:  # loaded on the store's threads
    from sqlalchemy import Connection

    from hawk.lots import queries
    from hawk.lots.documents import parts, source
else:
    queries = late("hawk.lots.queries")
    parts = late("hawk.lots.documents.parts")
    source = late("hawk.lots.documents.source")

_LOG = logging.getLogger(__name__)
GZIP: Final = "application/gzip"

FOR_DRONES_ALONE: Final = (
    "A drone's token sends surveys, lots and recordings of this drone, and pictures, and reads lots: nothing else."
)
FOR_DRONES: Final = (
    "This address is for drones and programs: send the token of one, "
    "which hawk-drone tokens rotate drone --name NAME makes."
)
BY_HTTPS: Final = (
    "Drones and programs send by HTTPS from another computer: set web.tls_certificate and web.tls_key here."
)
NOT_HERE: Final = "No surveys are collected here: start hawk-drone desk --collect."
ONE_AT_A_TIME: Final = "Another document or file is being sent: send this one after it."
READ_S: Final = 900.0
"""Real seconds in which a document must be there: 1 MB at 10 kbit a second."""
REFUSED: Final = web.AppKey("refused_arrivals", TokenGuesses)
"""Documents, files and requests of each drone that were refused for what they are; each makes the next one wait."""
MOST_SENT: Final = 8
"""Documents and files that are received at once; a document takes 32 MB of memory at most."""
_READ: Final = re.compile(f"{ROOT}/lots(/(?!.*/shares$).*)?")
_WRITTEN: Final = re.compile(
    f"{ROOT}/(?:(?P<kind>survey|lot)s/(?P<id>{PATTERNS['id']})/document|inbox/(?P<file>[^/]+)"
    f"|surveys/(?P<survey>{PATTERNS['id']})/recordings(?:/{PATTERNS['name']})?)"
)


@dataclass(slots=True)
class _Senders:
    """Names of the drones that send a document or a file now."""

    names: set[str] = field(default_factory=set)


_SENDERS: Final = web.AppKey("document_senders", _Senders)


def prepare(app: web.Application) -> None:
    """Make room for the names of drones that send."""
    app[_SENDERS] = _Senders()
    app[REFUSED] = TokenGuesses(app[SERVICES].monotonic)


def is_for_drones(request: web.Request) -> bool:
    """Return True for an address that a drone's token opens."""
    if request.method in (hdrs.METH_GET, hdrs.METH_HEAD):
        return _READ.fullmatch(request.path) is not None and hdrs.UPGRADE not in request.headers
    return sent(request) is not None


def sent(request: web.Request) -> re.Match[str] | None:
    """Return the ``kind`` and ``id``, or the ``file``, or the ``survey`` of recordings, of an address by which drones
    send; None for another one.
    """
    return _WRITTEN.fullmatch(request.path) if request.method == hdrs.METH_PUT else None


@answered
async def put(request: web.Request) -> web.StreamResponse:
    """Take the document of a survey in; the same one again is answered the same."""
    drone = checked_drone(request)
    async with _sent_document(request, drone) as (store, data):
        found = await store.collect(data, request.match_info["id"], drone)
    _LOG.info("survey %s of %s is here, state %d", found.survey, drone, found.state)
    return changed(SurveyState(survey=found.survey, state=found.state, lot=found.lot))


@answered
async def put_lot(request: web.Request) -> web.StreamResponse:
    """Take the document of a lot in; the same one again is answered the same."""
    drone, lot = checked_drone(request), request.match_info["id"]
    async with _sent_document(request, drone) as (store, data):
        found = await store.collect_lot(data, lot, drone)
    _LOG.info("lot %s of %s is here, state %d%s", lot, drone, found.state, ", another plan" * found.keeps_plan)
    return changed(LotState(lot=lot, state=found.state, keeps_plan=found.keeps_plan))


@answered
async def changed_lots(request: web.Request) -> web.StreamResponse:
    """Answer with the lots that changed after a state, as one document."""
    query, access = query_of(request, ChangedLots), access_of(request)
    drone = "" if access is None else access.drone
    if query.seen and not drone:
        raise web.HTTPForbidden(text=FOR_DRONES)
    store = await opened(request)
    writer = drone if query.seen else None

    moments = due_of(request)

    def work(connection: Connection) -> bytes:
        lots = source.changed_lots(connection, query.after, query.limit, writer)
        due = source.lots_due(connection, moments, writer)
        return parts.packed(lots.model_copy(update={"due": due}))

    async with in_time(BUSY):
        data = await store.read(work, FILE_S)
    headers: dict[str, str] = {hdrs.CACHE_CONTROL: "no-store"}
    requests = request.app[SERVICES].recording_requests
    if drone and requests is not None:
        waiting = await write_away(request, partial(requests.waiting, drone))
        if asked := await without_deleted(request, requests, waiting):
            headers[ASKED] = ", ".join(asked[:MOST_ASKED])
    return web.Response(body=data, content_type=GZIP, headers=headers)


async def without_deleted(request: web.Request, requests: RecordingRequests, surveys: Sequence[str]) -> list[str]:
    """End the requests for surveys that were deleted; return the other surveys. Raises LotStoreError."""
    store = await opened(request)
    async with in_time(BUSY):
        deleted = await store.read(lambda connection: queries.deleted_among(connection, surveys)) if surveys else set()
    for each in deleted:
        with contextlib.suppress(OSError):  # a full disk: it is ended the next time
            await write_away(request, partial(requests.take_back, each))
    return [each for each in surveys if each not in deleted]


@contextlib.asynccontextmanager
async def _sent_document(request: web.Request, drone: str) -> AsyncIterator[tuple[LotStore, bytes]]:
    """Give the store and the bytes that a drone sends, one document at a time. Raises HTTPServiceUnavailable."""
    query_of(request, Query)
    if not request.app[SERVICES].collects:
        raise web.HTTPConflict(text=NOT_HERE)
    async with sending(request, drone):
        words = f"The document is too large: {LARGEST_BYTES // 1_000_000} MB are read at most."
        data = await sent_file(request, LARGEST_BYTES, READ_S, words)
        store = await opened(request)
        async with in_time(UNSURE):
            yield store, data


@contextlib.asynccontextmanager
async def sending(request: web.Request, drone: str, most: int = MOST_SENT) -> AsyncIterator[None]:
    """Let a drone send one document or file at a time, beside fewer than ``most``. Raises HTTPServiceUnavailable."""
    senders = request.app[_SENDERS].names
    if drone in senders or len(senders) >= most:
        raise web.HTTPServiceUnavailable(text=ONE_AT_A_TIME, headers={hdrs.RETRY_AFTER: "5"})
    senders.add(drone)
    try:
        yield
    finally:
        senders.discard(drone)


def checked_drone(request: web.Request) -> str:
    """Return the name of the drone that sends. Raises HTTPForbidden, HTTPTooManyRequests."""
    access = access_of(request)
    if access is None or not access.drone:
        raise web.HTTPForbidden(text=FOR_DRONES)
    is_near = is_loopback_peer(request.remote) and forwarding_header(request) is None
    if not is_secure(request) and not is_near:
        raise web.HTTPForbidden(text=BY_HTTPS)
    if (wait := math.ceil(request.app[REFUSED].wait_s(access.drone))) > 0:
        words = f"Too much that you sent was refused: wait {wait} s, then send the next."
        raise web.HTTPTooManyRequests(text=words, headers={hdrs.RETRY_AFTER: str(wait)})
    return access.drone
