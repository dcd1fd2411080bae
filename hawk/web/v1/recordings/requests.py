"""Recordings of surveys that drones sent: a person at the desk asks, and the drone sends them by parts, on the ground.

A drone says what it has, and learns how much of it is here (`offer`). It sends the rest by parts (`put_part`) with the
`Content-Range` of RFC 9110 (14.5, partial PUT) and the `Repr-Digest` of RFC 9530. What came of a part that was cut
stays: the next one begins behind it.
"""

from __future__ import annotations

import asyncio
import base64
import logging
import re
from collections.abc import Callable, Mapping
from functools import partial
from http import HTTPStatus
from typing import TYPE_CHECKING, Final, TypeVar

from aiohttp import hdrs, web

from hawk.lots.documents.arrival import Arrival, ArrivalKind, Outcome
from hawk.runtime.late import late
from hawk.store.recording_request import NOTHING, Cause, OfferedRecording, Part, PartRefusedError
from hawk.store.recording_requests import PartWriter, RecordingRequests
from hawk.web.services import SERVICES
from hawk.web.v1.answers import BUSY, Answer, answered, in_time, made, now_of, opened
from hawk.web.v1.bodies import OfferState, RecordingOffer, RecordingsOfSurvey, RecordingState
from hawk.web.v1.changes import Body, body_of, changed
from hawk.web.v1.desk import arrivals
from hawk.web.v1.desk.documents import NOT_HERE, checked_drone, sending, without_deleted
from hawk.web.v1.desk.file_transfer import FULL, receive, write_away
from hawk.web.v1.parameters import Query, query_of
from hawk.web.v1.refusals import RefusedError

if TYPE_CHECKING:  # loaded on the store's threads
    from hawk.lots import queries
    from hawk.lots.queries import SurveyDrone
else:
    queries = late("hawk.lots.queries")

_LOG = logging.getLogger(__name__)

FOR_OPERATORS: Final = "Recordings are asked for by operators: log in as operator."
NOT_FLOWN: Final = "no drone has flown this survey and sent it here: there is nobody to ask"
ASK_LATER: Final = "was deleted: undo that, and ask then"
SEND_NONE: Final = "was deleted at the desk, and nobody asks for its recordings: send none"
NO_RANGE: Final = "must say which bytes of how many these are, as bytes 0-99/5000, and Content-Length how many"
NO_DIGEST: Final = "must be the SHA-256 of the whole recording, as sha-256=:BASE64: (RFC 9530)"
MOST_PARTS: Final = 4
"""Senders beside which a part is received: the other places are for documents."""
_RANGE: Final = re.compile(r"bytes ([0-9]{1,15})-([0-9]{1,15})/([0-9]{1,16})", re.ASCII)
_DIGEST: Final = re.compile(r"(?:^|,)\s*sha-256=:([A-Za-z0-9+/]{43}=):", re.ASCII)
_STATUSES: Final[Mapping[Cause, HTTPStatus]] = {
    "unasked": HTTPStatus.CONFLICT,
    "other": HTTPStatus.FORBIDDEN,
    "place": HTTPStatus.CONFLICT,
    "wrong": HTTPStatus.UNPROCESSABLE_ENTITY,
    "full": HTTPStatus.INSUFFICIENT_STORAGE,
}
T = TypeVar("T")


@answered
async def read(request: web.Request) -> web.StreamResponse:
    """The state of a survey's recordings here."""
    query_of(request, Query)
    survey = request.match_info["id"]
    async with in_time(BUSY):
        flown, requests = await _flown_by(request), request.app[SERVICES].recording_requests
        if requests is not None:
            await without_deleted(request, requests, [survey])
        found = await _state(request, survey, flown)
    return await made(request, lambda: Answer(found))


async def ask(request: web.Request, body: Body) -> object:
    """Ask for the recordings of the survey in the address, or take that back. Raises RefusedError, LotStoreError."""
    survey, requests = request.match_info["id"], _requests(request)
    flown = await _flown_by(request)
    if flown is None:
        raise RefusedError(HTTPStatus.CONFLICT, "survey", NOT_FLOWN)
    if body["asked"]:
        await _check_not_deleted(request, ASK_LATER)
        await _on_disk(request, partial(requests.ask, survey, flown.name, flown.journal, now_of(request)))
    else:
        await _on_disk(request, partial(requests.take_back, survey))
    return await _state(request, survey, flown)


@answered
async def offer(request: web.Request) -> web.StreamResponse:
    """Take in what a drone has of a survey; the answer says how much of it is here."""
    drone, requests = checked_drone(request), _requests(request)
    query_of(request, Query)
    body, survey = await body_of(request, RecordingOffer), request.match_info["id"]
    found = [OfferedRecording(each["name"], each["bytes"]) for each in body.get("recordings", [])]
    await _check_not_deleted(request, SEND_NONE)
    work = partial(requests.offer, survey, drone, body.get("answer", ""), found)
    received = await _on_disk(request, work)
    _LOG.info("%s offers %d recordings of survey %s %s", drone, len(found), survey, body.get("answer", ""))
    states = [RecordingState(name=each.name, stored=received[each.name], bytes=each.bytes) for each in found]
    return changed(OfferState(survey=survey, recordings=states if received else []))


@answered
async def put_part(request: web.Request) -> web.StreamResponse:
    """Write a part of a recording behind what is here; one that is here already changes nothing."""
    drone, requests = checked_drone(request), _requests(request)
    query_of(request, Query)
    survey, name, part = request.match_info["id"], request.match_info["name"], _part_of(request)
    async with sending(request, drone, MOST_PARTS):
        await _check_not_deleted(request, SEND_NONE)
        writer = await _on_disk(request, partial(requests.begin, survey, drone, name, part))
        if isinstance(writer, int):
            return changed(RecordingState(name=name, stored=writer, bytes=part.size))
        try:
            await receive(request, lambda chunk: _on_disk(request, partial(writer.write, chunk)))
        finally:  # also of a lost connection: what came stays
            await asyncio.shield(_on_disk(request, writer.close))
        await _check_not_deleted(request, SEND_NONE)
        is_whole = await _on_disk(request, partial(requests.finish, survey, writer.coming))
    if is_whole:
        await _note_whole(request, drone, writer)
    return changed(RecordingState(name=name, stored=writer.received, bytes=part.size))


async def _note_whole(request: web.Request, drone: str, writer: PartWriter) -> None:
    _LOG.info("%s sent recording %s of survey %s", drone, writer.coming.name, writer.survey)
    await arrivals.note(request, Arrival(drone, ArrivalKind.RECORDING, writer.survey, Outcome.TAKEN))


def _requests(request: web.Request) -> RecordingRequests:
    """Return the requests. Raises HTTPConflict where no surveys are collected."""
    requests = request.app[SERVICES].recording_requests
    if requests is None:
        raise web.HTTPConflict(text=NOT_HERE)
    return requests


async def _check_not_deleted(request: web.Request, words: str) -> None:
    """Refuse a survey that was deleted, and end its request. Raises RefusedError, LotStoreError."""
    if not await without_deleted(request, _requests(request), [request.match_info["id"]]):
        raise RefusedError(HTTPStatus.CONFLICT, "survey", words)


async def _flown_by(request: web.Request) -> SurveyDrone | None:
    store, survey = await opened(request), request.match_info["id"]
    return await store.read(lambda connection: queries.flown_by(connection, survey))


async def _state(request: web.Request, survey: str, flown: SurveyDrone | None) -> RecordingsOfSurvey:
    requests = request.app[SERVICES].recording_requests
    if requests is None or flown is None:
        found, drone = NOTHING, None
    else:
        found, drone = await _on_disk(request, partial(requests.progress, survey)), flown.name
    return RecordingsOfSurvey(
        survey=survey, drone=drone, state=found.state, stored=found.received, bytes=found.bytes,
        problem=found.problem,
    )  # fmt: skip


def _part_of(request: web.Request) -> Part:
    """Return the part that a request brings. Raises RefusedError."""
    given = _RANGE.fullmatch(request.headers.get(hdrs.CONTENT_RANGE, ""))
    if given is None or request.content_length != int(given[2]) + 1 - int(given[1]):
        raise RefusedError(HTTPStatus.UNPROCESSABLE_ENTITY, hdrs.CONTENT_RANGE, NO_RANGE)
    digest = _DIGEST.search(request.headers.get("Repr-Digest", ""))
    if digest is None:
        raise RefusedError(HTTPStatus.UNPROCESSABLE_ENTITY, "Repr-Digest", NO_DIGEST)
    return Part(int(given[1]), int(given[2]) + 1, int(given[3]), base64.b64decode(digest[1]).hex())


async def _on_disk(request: web.Request, work: Callable[[], T]) -> T:
    """Return what the thread that writes did. Raises RefusedError, OSError."""
    try:
        return await write_away(request, work)
    except PartRefusedError as error:
        raise RefusedError(_STATUSES[error.cause], error.named, error.reason) from error
    except OSError as error:
        if error.errno in FULL:
            words = "The desk's disk is full: make room there; it is tried again."
            raise RefusedError(HTTPStatus.INSUFFICIENT_STORAGE, "", words) from error
        raise
