"""Answers of the API: JSON of what the store says, with an ETag and packed, or a problem of one form (RFC 9457).

What the store says is read, encoded and packed on its threads, which nothing of a flight waits for. An answer that
the client has already, by its ETag, costs the store two numbers. The ETag is of one address: what the client has of
another one says nothing about this, which may not be there.
"""

from __future__ import annotations

import asyncio
import contextlib
import gzip
import hashlib
import json
import logging
import threading
from collections import OrderedDict
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime
from functools import wraps
from http import HTTPStatus
from typing import TYPE_CHECKING, Any, Final

from aiohttp import hdrs, web
from aiohttp.typedefs import Handler
from pydantic_core import to_json

from hawk.config.sections import DUE_DAYS
from hawk.lots.answers import SpokenSentence
from hawk.lots.store import LotStore
from hawk.lots.values import LotInputError, LotStoreError, NotFoundError
from hawk.model.sentences import parts_of
from hawk.runtime.late import late_functions
from hawk.store.recordings import NotThatRecordingError
from hawk.web.access.access import access_of
from hawk.web.access.proxied import is_secure, prefix_of
from hawk.web.downloads import FILES
from hawk.web.services import SERVICES
from hawk.web.v1.parameters import Q, Request, query_of
from hawk.web.v1.refusals import REFUSALS, refusal_of
from hawk.web.v1.unknown import NOTHING, ROOT, Wrong, not_there, wrong_form

if TYPE_CHECKING:
    from sqlalchemy import Connection

    from hawk.lots.storage import database
    from hawk.lots.survey import observations
else:
    database = late_functions("hawk.lots.storage.database")
    observations = late_functions("hawk.lots.survey.observations")

_LOG = logging.getLogger(__name__)

JSON: Final = "application/json"
PROBLEM: Final = "application/problem+json"
GEOJSON: Final = "application/geo+json"
OPENAPI: Final = "application/vnd.oai.openapi+json;version=3.1"
ANSWER_S: Final = 30.0
"""Real seconds after which a request that the store has not answered is given up."""
_AT_ONCE: Final = 20
"""Surveys whose looks are put in one piece in one transaction: 0.1 s, after which a flight's survey may be stored."""
LEAST_PACKED_BYTES: Final = 1000
"""Shorter answers are one packet of the network in any case."""
_LEVEL: Final = 4
"""Of gzip: a list of stalls is 8 times smaller, in 2 ms a megabyte less than at level 9."""
MOST_KEPT_BYTES: Final = 8_000_000
"""Of the answers that are kept: the stalls of 60 surveys of a lot of 2,000 stalls."""
MINUTE_S: Final = 60.0
BUSY: Final = "The store of lots is busy: ask again in some seconds."
NO_LOTS: Final = "There is no store of lots here."
ANYTHING: Final = "*"
"""In ``If-None-Match``: whatever there is; whether there is something is read."""
REASON: Final = web.ResponseKey("reason", str)
"""Words of a problem, for a log of those that sent it."""
CACHING: Final = "private, no-cache"
"""A browser keeps the answer, and asks each time whether it is still right."""


@dataclass(frozen=True, slots=True)
class Answer:
    """An answer before it is encoded: a value of its model, JSON values, text that is JSON already, or the bytes of a
    file, which are not packed.

    ``next``: the place at which the next part of a list begins.
    """

    content: object = field(repr=False)
    next: str | None = None
    content_type: str = JSON
    headers: Mapping[str, str] = field(default_factory=dict)


Read = Callable[["Connection", Request[Any]], Answer]
"""Reads what a request asks for, on a thread of the store."""
Prepare = Callable[[LotStore, Request[Any]], Awaitable[None]]
"""Does what a reading needs and may not do itself."""
LotOf = Callable[[LotStore, web.Request], Awaitable[str]]
"""Returns the id of the lot that a request may read."""


@dataclass(frozen=True, slots=True)
class _Packed:
    status: int
    tag: str
    answer: Answer | None = field(default=None, repr=False)
    body: bytes = field(default=b"", repr=False)
    is_packed: bool = False


class KeptAnswers:
    """The newest answers of the store, encoded: while nothing changes in it, nobody waits for the same one twice.

    Any thread of the store uses it.
    """

    def __init__(self, most_bytes: int = MOST_KEPT_BYTES) -> None:
        self._most_bytes = most_bytes
        self._found: OrderedDict[tuple[str, bool], _Packed] = OrderedDict()
        self._bytes = 0
        self._lock = threading.Lock()

    def get(self, tag: str, *, packs: bool) -> _Packed | None:
        """Return the answer with this tag, for a client that unpacks gzip or not; None where it is not kept."""
        with self._lock:
            found = self._found.get((tag, packs))
            if found is not None:
                self._found.move_to_end((tag, packs))
            return found

    def put(self, packed: _Packed, *, packs: bool) -> None:
        """Keep an answer in place of those that nobody has asked for the longest."""
        with self._lock:
            before = self._found.pop((packed.tag, packs), None)
            self._bytes += len(packed.body) - (0 if before is None else len(before.body))
            self._found[packed.tag, packs] = packed
            while self._bytes > self._most_bytes:
                self._bytes -= len(self._found.popitem(last=False)[1].body)


KEPT: Final = web.AppKey("kept_answers", KeptAnswers)


def reader(
    query: type[Q],
    read: Read,
    prepare: Prepare | None = None,
    bad_parameter: int = HTTPStatus.UNPROCESSABLE_ENTITY,
    lot_of: LotOf | None = None,
    *,
    is_timed: bool = False,
) -> Handler:
    """Return the handler of an address that reads the store.

    ``bad_parameter``: status for a parameter that cannot be used. ``lot_of``: finds the lot of an address that has no
    id in it, and which is all that may be read. ``is_timed``: the answer says when surveys are due.
    """

    async def handle(request: web.Request) -> web.StreamResponse:
        given = request_of(request, query)
        known, packs = request.headers.get(hdrs.IF_NONE_MATCH, ""), accepts_gzip(request)
        kept, place = request.app[KEPT], _place_of(request, given.base, is_timed=is_timed)

        def tag_of(connection: Connection) -> str:
            return f'W/"{database.version_of(connection)}-{place}"'

        def look(connection: Connection) -> _Packed | None:
            tag = tag_of(connection)
            if known.strip() != ANYTHING and is_known(known, tag):
                return _Packed(HTTPStatus.NOT_MODIFIED, tag)
            return kept.get(tag, packs=packs)

        def work(connection: Connection, asked: Request[Q]) -> _Packed:
            found = look(connection) if prepare is None else None
            if found is None:
                answer = read(connection, asked)
                sent = encoded(answer, packs=packs)
                found = _Packed(HTTPStatus.OK, tag_of(connection), replace(answer, content=None), *sent)
                kept.put(found, packs=packs)
            return _Packed(HTTPStatus.NOT_MODIFIED, found.tag) if is_known(known, found.tag) else found

        async with in_time(BUSY):
            store, asked = await opened(request), given
            if lot_of is not None:
                lot = await lot_of(store, request)
                asked = replace(given, path={**given.path, "id": lot}, lots=frozenset({lot}))
            if prepare is not None:
                if (found := await store.read(look)) is not None:
                    return _response(request, found)
                await prepare(store, asked)
            return _response(request, await store.read(lambda connection: work(connection, asked)))

    return answered(handle, bad_parameter)


async def opened(request: web.Request) -> LotStore:
    """Return the store, open: that loads SQLAlchemy on its thread, and imports on the loop cost nothing then.

    Raises NotFoundError where there is none, LotStoreError.
    """
    store = request.app[SERVICES].lots
    if store is None:
        raise NotFoundError(NO_LOTS)
    await store.open()
    return store


def now_of(request: web.Request) -> float:
    """Return the time, UTC, Unix seconds."""
    return request.app[SERVICES].wall()


def due_of(request: web.Request) -> Callable[[str, str, float | None, int], list[datetime]]:
    """Return the function that says when surveys of a lot are due: its id and name, the time of its newest survey, and
    within how many days from now. It does not hold the request.
    """
    due, now = request.app[SERVICES].due, now_of(request)
    return lambda lot, name, last, days: [] if due is None else due(lot, name, last, now, days)


def next_due_of(request: web.Request) -> Callable[[str, str, float | None], datetime | None]:
    """Return the function that says when the next survey of a lot is due, in `DUE_DAYS` at most."""
    due = due_of(request)
    return lambda lot, name, last: next(iter(due(lot, name, last, DUE_DAYS)), None)


def _place_of(request: web.Request, base: str, *, is_timed: bool) -> str:
    """Return the part of an ETag that an address gives; one ``is_timed`` differs each minute where there is a schedule.

    ``base``: address of the server, which answers hold.
    """
    lots = lots_of(request)
    theirs = "" if lots is None else f" for {sorted(lots)}"  # who may read others gets another answer
    place = hashlib.sha256(f"{base}{request.path_qs}{theirs}".encode()).hexdigest()[:12]
    has_clock = is_timed and request.app[SERVICES].due is not None
    return f"{place}-{now_of(request) // MINUTE_S:.0f}" if has_clock else place


@contextlib.asynccontextmanager
async def in_time(words: str) -> AsyncIterator[None]:
    """Give work up after `ANSWER_S`. Raises HTTPServiceUnavailable with the words."""
    try:
        async with asyncio.timeout(ANSWER_S):
            yield
    except TimeoutError:
        raise web.HTTPServiceUnavailable(text=words, headers={hdrs.RETRY_AFTER: "5"}) from None


async def made(request: web.Request, make: Callable[[], Answer]) -> web.Response:
    """Return an answer that is no part of the store, made and packed on the thread that makes files: its ETag is that
    of the bytes.
    """
    packs = accepts_gzip(request)

    def work() -> _Packed:
        answer = make()
        body, is_packed = encoded(answer, packs=packs)
        return _Packed(HTTPStatus.OK, f'W/"{hashlib.sha256(body).hexdigest()[:16]}"', answer, body, is_packed)

    packed = await request.app[FILES].run(work)
    if is_known(request.headers.get(hdrs.IF_NONE_MATCH, ""), packed.tag):
        packed = _Packed(HTTPStatus.NOT_MODIFIED, packed.tag)
    return _response(request, packed)


def answered(handle: Handler, bad_value: int = HTTPStatus.UNPROCESSABLE_ENTITY) -> Handler:
    """Return the handler, its refusals as problems; ``bad_value``: the status for a value that cannot be used."""

    @wraps(handle)
    async def within(request: web.Request) -> web.StreamResponse:
        try:
            return await handle(request)
        except (*REFUSALS, OSError) as error:
            refusal = refusal_of(error)
            if isinstance(error, LotInputError):
                return problem(bad_value, refusal.reason, refusal.field, refusal.more)
            kind = "recording" if isinstance(error, NotThatRecordingError) else refusal.field
            meant = not_there(_template(request), kind, refusal.reason)
            return problem(refusal.status, meant.reason, meant.field, refusal.more)

    return within


def _template(request: web.Request) -> str:
    """Return the address of a request with the names of its fields in place of their values; "" without a route."""
    resource = request.match_info.route.resource
    return "" if resource is None else resource.canonical


def problem(
    status: int, detail: str, named: str = "", more: Mapping[str, str] | None = None
) -> web.Response:  # fmt: skip
    """Return a problem: ``detail`` says what is wrong and the remedy, ``named`` is the field that is meant."""
    response = web.Response(status=status, body=_problem(status, detail, named, more), content_type=PROBLEM)
    response.headers[hdrs.CACHE_CONTROL] = "no-store"
    response[REASON] = f"{named}: {detail}" if named else detail
    return response


def _problem(status: int, detail: str, named: str = "", more: Mapping[str, str] | None = None) -> bytes:
    content = {"type": "about:blank", "title": HTTPStatus(status).phrase, "status": status, "detail": detail}
    sentences = [SpokenSentence.of(each).model_dump() for each in parts_of(detail)]
    return json.dumps({**content, "field": named, **(more or {}), "sentences": sentences}).encode()


@web.middleware
async def problems(request: web.Request, handler: Handler) -> web.StreamResponse:
    """Give every refusal of an address of this API the form of a problem: that of a door before it, too."""
    if not (request.path == ROOT or request.path.startswith(f"{ROOT}/")):
        return await handler(request)
    try:
        return await handler(request)
    except web.HTTPException as refusal:
        if refusal.status in _NO_ROUTE and not _template(request).startswith(ROOT):
            found = wrong_form(request.path, _templates(request.app)) or Wrong("", NOTHING)
            return problem(HTTPStatus.NOT_FOUND, found.reason, found.field)
        if refusal.status >= HTTPStatus.BAD_REQUEST:
            refusal.body = _problem(refusal.status, refusal.text or refusal.reason)
            refusal.content_type, refusal.charset = PROBLEM, None
        raise
    except Exception:
        _LOG.exception("%s %s failed", request.method, _without_token(request))
        return problem(HTTPStatus.INTERNAL_SERVER_ERROR, "The drone's program has an error here: see its log.")


_NO_ROUTE: Final = (HTTPStatus.NOT_FOUND, HTTPStatus.METHOD_NOT_ALLOWED)
"""Answers to an address that no route of this API matches: the page has an answer to every GET."""


def _without_token(request: web.Request) -> str:
    """Return the path of a request; the token of a link is in no log."""
    token = request.match_info.get("token")
    return request.path.replace(token, "{token}") if token else request.path


def _templates(app: web.Application) -> list[str]:
    found = (each.canonical for each in app.router.resources())
    return [each for each in found if each.startswith(f"{ROOT}/")]


def request_of(request: web.Request, query: type[Q]) -> Request[Q]:
    """Return a request without its connection. Raises LotInputError for a parameter."""
    return Request(
        dict(request.match_info), query_of(request, query), base_of(request), now_of(request), next_due_of(request),
        lots_of(request),
    )  # fmt: skip


def lots_of(request: web.Request) -> frozenset[str] | None:
    """Return the ids of the lots that the role of the client is for; None: all."""
    access = access_of(request)
    return None if access is None else access.lots


def base_of(request: web.BaseRequest) -> str:
    """Return the address of this server as the client has it, without a last slash."""
    scheme = "https" if is_secure(request) else "http"
    return f"{scheme}://{request.headers.get(hdrs.HOST, '')}{prefix_of(request)}"


def is_known(given: str, tag: str) -> bool:
    """Return True when the header ``If-None-Match`` names a tag, by the weak comparison (RFC 9110, 13.1.2)."""
    return given.strip() == ANYTHING or tag.removeprefix("W/") in [
        each.strip().removeprefix("W/") for each in given.split(",")
    ]


def accepts_gzip(request: web.BaseRequest) -> bool:
    """Return True when the client unpacks gzip."""
    for each in request.headers.get(hdrs.ACCEPT_ENCODING, "").lower().split(","):
        name, _, weight = each.partition(";")
        if name.strip() in ("gzip", "*"):
            return weight.strip().replace(" ", "") not in ("q=0", "q=0.0", "q=0.00", "q=0.000")
    return False


def encoded(answer: Answer, *, packs: bool) -> tuple[bytes, bool]:
    """Return an answer's bytes, and whether they are packed: ``packs`` allows it."""
    content = answer.content
    if isinstance(content, bytes):
        return content, False
    body = text_of(content).encode()
    is_packed = packs and len(body) >= LEAST_PACKED_BYTES
    return gzip.compress(body, _LEVEL, mtime=0) if is_packed else body, is_packed


def text_of(content: object) -> str:
    """Return an answer as JSON text; text is that already."""
    return content if isinstance(content, str) else to_json(content, by_alias=True).decode()


def _response(request: web.Request, packed: _Packed) -> web.Response:
    response = web.Response(status=packed.status, body=packed.body or None)
    response.headers[hdrs.ETAG] = packed.tag
    response.headers[hdrs.CACHE_CONTROL] = CACHING
    response.headers[hdrs.VARY] = hdrs.ACCEPT_ENCODING
    if packed.answer is None:
        return response
    response.headers[hdrs.CONTENT_TYPE] = packed.answer.content_type
    response.headers.update(packed.answer.headers)
    if packed.answer.next is not None:
        following = request.rel_url.update_query(after=packed.answer.next).without_query_params("token")
        response.headers[hdrs.LINK] = f'<{base_of(request)}{following}>; rel="next"'
    if packed.is_packed:
        response.headers[hdrs.CONTENT_ENCODING] = "gzip"
    return response


async def keep_missing_looks(store: LotStore, asked: Request[Any]) -> None:
    """Put the looks of a lot's archive in one piece a survey, once.

    A store of a newer version is only read: each question then takes longer.
    """
    found = await store.read(lambda connection: observations.missing_looks(connection, asked.id))
    with contextlib.suppress(LotStoreError):
        for first in range(0, len(found), _AT_ONCE):
            some = found[first : first + _AT_ONCE]
            await store.write(lambda connection, some=some: observations.keep_looks(connection, some))  # type: ignore[misc]
