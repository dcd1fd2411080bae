"""Log of what drones and programs send to a desk: what is refused, whatever refuses it, and files of the inbox.

What is taken is noted with it by the store. Refusals that must be waited after are noted no faster than that: neither
a drone nor a stranger fills the log, or the disk's time.
"""

from __future__ import annotations

import asyncio
import logging
from http import HTTPStatus
from typing import Final

from aiohttp import hdrs, web
from aiohttp.typedefs import Handler

from hawk.lots.documents.arrival import Arrival, ArrivalKind, Outcome
from hawk.lots.values import NEWER_FIELD, LotStoreError
from hawk.web.access.access import access_of
from hawk.web.access.guesses import network_of
from hawk.web.services import SERVICES
from hawk.web.v1.answers import ANSWER_S, REASON
from hawk.web.v1.desk.documents import REFUSED, sent
from hawk.web.v1.refusals import check_operator

_LOG = logging.getLogger(__name__)

FOR_OPERATORS: Final = "What came from drones is listed for operators: log in as operator."
UNKNOWN_TOKEN: Final = "A token that is not known here, or was removed, from {network}."  # noqa: S105 - words
NO_TOKEN: Final = "No token was sent, from {network}."  # noqa: S105 - words
LONGEST_NAME: Final = 200
_WRONG: Final = (
    HTTPStatus.UNAUTHORIZED, HTTPStatus.FORBIDDEN, HTTPStatus.REQUEST_ENTITY_TOO_LARGE,
    HTTPStatus.UNPROCESSABLE_ENTITY,
)  # fmt: skip
"""Refusals after which a sender has to wait: of what no drone of ours sends."""
_NOTED: Final = (
    *_WRONG, HTTPStatus.BAD_REQUEST, HTTPStatus.CONFLICT, HTTPStatus.GONE, HTTPStatus.LENGTH_REQUIRED,
    HTTPStatus.INSUFFICIENT_STORAGE,
)  # fmt: skip
"""Other statuses say nothing of what was sent: it comes again."""


def for_operators(listed: Handler) -> Handler:
    """Return the handler of the list, which refuses others than operators."""

    async def handle(request: web.Request) -> web.StreamResponse:
        check_operator(request, FOR_OPERATORS)
        return await listed(request)

    return handle


@web.middleware
async def note_refusals(request: web.Request, handler: Handler) -> web.StreamResponse:
    """Note each refusal of what drones and programs send, and of any request by their tokens, before it is answered."""
    try:
        answer = await handler(request)
    except web.HTTPException as refusal:
        await _note_refusal(request, refusal.status, refusal.text or refusal.reason)
        raise
    if answer.status in _NOTED:
        await _note_refusal(request, answer.status, answer.get(REASON, ""))
    return answer


async def _note_refusal(request: web.Request, status: int, words: str) -> None:
    services, access, found = request.app[SERVICES], access_of(request), sent(request)
    drone = "" if access is None else access.drone
    is_here = services.collects or services.inbox is not None
    if not is_here or not (drone or found):
        return
    refused, network = request.app[REFUSED], network_of(request.remote)
    sender = drone or network
    if status == HTTPStatus.TOO_MANY_REQUESTS or (status in _NOTED and refused.wait_s(sender) > 0):
        refused.pass_over(sender)
        return
    if status not in _NOTED:
        return
    times = 1 + refused.take_passed_over(sender)
    if status in _WRONG and words.partition(":")[0] != NEWER_FIELD:  # a newer drone is ours, and waits by itself
        refused.wrong(sender, str(refused.total))
    if status == HTTPStatus.UNAUTHORIZED:
        words = (UNKNOWN_TOKEN if hdrs.AUTHORIZATION in request.headers else NO_TOKEN).format(network=network)
    if found is None:
        kind, name = ArrivalKind.OTHER, _shown(f"{request.method} {request.rel_url.raw_path}")
    elif found["file"] is not None:
        kind, name = ArrivalKind.FILE, file_name(request)
    elif found["survey"] is not None:
        kind, name = ArrivalKind.RECORDING, found["survey"]
    else:
        kind, name = ArrivalKind(found["kind"]), found["id"]
    lot = name if kind is ArrivalKind.LOT else None
    await note(request, Arrival(drone, kind, name, Outcome.REFUSED, lot, reason=_shown(words), times=times))


async def note(request: web.Request, arrival: Arrival) -> None:
    """Note an arrival. An error of the store is logged: what came is answered as it is without the log."""
    store = request.app[SERVICES].lots
    if store is None:
        return
    try:
        async with asyncio.timeout(ANSWER_S):
            await store.note(arrival)
    except (LotStoreError, TimeoutError) as error:
        _LOG.warning("what came from %s is not in the log of arrivals: %s", arrival.sender or "a stranger", error)


def file_name(request: web.Request) -> str:
    """Return the name of a file for the inbox, behind that of its flight."""
    found = sent(request)
    assert found is not None  # noqa: S101 - the address is one of the inbox
    parts = (request.query.get("flight"), found["file"])
    return _shown("/".join(each for each in parts if each))


def _shown(text: str) -> str:
    """Return a text of a stranger, cut, without what cannot be shown."""
    return "".join(each if each.isprintable() else "?" for each in text[:LONGEST_NAME])
