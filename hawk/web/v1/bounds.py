"""Bounds of operations for a role that is for some lots: what is not theirs is answered as what is not there.

An operation without a bound is refused to them, and so is every address beside the API that a view of lots does not
need.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache, wraps
from typing import TYPE_CHECKING, Final

from aiohttp import hdrs, web
from aiohttp.typedefs import Handler

from hawk.lots.plan.values import ID
from hawk.lots.values import NotFoundError
from hawk.runtime.late import late_functions
from hawk.web.access.access import access_of
from hawk.web.v1.answers import BUSY, answered, in_time, opened
from hawk.web.v1.operations import Bound, Operation
from hawk.web.v1.parameters import Query
from hawk.web.v1.unknown import ROOT

if TYPE_CHECKING:  # loaded on the store's thread
    from sqlalchemy import Connection

    from hawk.lots import reach
else:
    reach = late_functions("hawk.lots.reach")

FOR_ALL_LOTS: Final = "This needs a login for all lots: yours is for some lots alone."
_NOT_THEIRS: Final[Mapping[str, str]] = {
    "lot": "lot: there is no lot with this id; reload the list",
    "survey": "survey: there is none with this id; reload the list",
    "stall": "stall: there is none with this id; read the stalls of the lot again",
    "share": "share: there is no link with this id; reload the list",
    "change": "change: there is none with this number; reload the list",
}
"""Kind of a thing -> the words of the store for one that is not there."""
_ASKED: Final[Mapping[str, str]] = {
    "lot": "lot", "survey": "survey", "stall": "stall", "before": "survey", "after": "survey",
}  # fmt: skip
"""Parameter that holds an id -> kind of the thing."""
_BESIDE: Final = re.compile(r"/|/api/session|/logout|/docs(/.*)?|/[\w-]+\.(js|css|ftl|woff2|svg)")
"""Addresses beside the API: of the page, its files and its documentation, which hold nothing of a lot or a drone."""


def check_reach(request: web.Request) -> None:
    """Refuse a role for some lots all but the API, which has bounds, and the page. Raises HTTPForbidden."""
    access = access_of(request)
    if access is None or access.lots is None:
        return
    is_api = request.path.startswith(f"{ROOT}/")
    if hdrs.UPGRADE in request.headers or not (is_api or _BESIDE.fullmatch(request.path)):
        raise web.HTTPForbidden(text=FOR_ALL_LOTS)


def bounded(operation: Operation) -> Handler:
    """Return the handler of an operation, which a role for some lots reaches within its bound alone."""

    async def handle(request: web.Request) -> web.StreamResponse:
        access = access_of(request)
        if access is not None and access.lots is not None:
            await _check(request, operation, access.lots)
        return await operation.handler(request)

    return wraps(operation.handler)(answered(handle))


async def _check(request: web.Request, operation: Operation, lots: frozenset[str]) -> None:
    """Refuse what is not bounded, or not theirs. Raises HTTPForbidden, NotFoundError, HTTPServiceUnavailable."""
    if operation.bound in (None, Bound.LINK):
        raise web.HTTPForbidden(text=FOR_ALL_LOTS)
    named = _named(request, operation)
    if not named:
        return

    def check(connection: Connection) -> None:
        within = reach.lots_within(connection, lots)
        for kind, key in named:
            if reach.lot_of(connection, kind, key) not in within:
                raise NotFoundError(_NOT_THEIRS[kind])

    async with in_time(BUSY):
        await (await opened(request)).read(check)


def _named(request: web.Request, operation: Operation) -> list[tuple[str, str]]:
    """Return kind and id of all that a request names: in the path first, then in the query."""
    assert operation.bound is not None  # noqa: S101 - it was looked at before
    kind, path = operation.bound.value, request.match_info
    field = "seq" if operation.bound is Bound.CHANGE else "id"
    found = [(kind, path[field])] if kind in _NOT_THEIRS else []
    found += [("survey", path["survey"])] if "survey" in path else []
    asked = ids_asked(operation.query)
    return found + [(asked[name], key) for name, key in request.query.items() if name in asked]


@cache
def ids_asked(query: type[Query]) -> Mapping[str, str]:
    """Return the parameters of a model that hold ids, with the kinds of what they name. Raises KeyError for another."""
    known = query.model_json_schema()["properties"] if query.model_fields else {}
    return {name: _ASKED[name] for name, schema in known.items() if ID in str(schema)}
