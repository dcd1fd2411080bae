"""Routes of the API, and the address of its definition."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Final

from aiohttp import hdrs, web
from aiohttp.typedefs import Handler

from hawk.web.services import SERVICES
from hawk.web.v1 import plan_files, reports
from hawk.web.v1.answers import KEPT, OPENAPI, Answer, KeptAnswers, answered, base_of, made, text_of
from hawk.web.v1.bounds import bounded
from hawk.web.v1.desk import documents, file_transfer
from hawk.web.v1.parameters import Query, query_of
from hawk.web.v1.recordings import films
from hawk.web.v1.table import OPERATIONS
from hawk.web.v1.unknown import ROOT

DEFINITION: Final = "/openapi.json"
"""Address of the definition below that of the API."""
_ANYWHERE: Final = "http://hawk.invalid"


@dataclass(slots=True)
class _Definition:
    """The definition as text, once it was asked for: making it takes a tenth of a second."""

    text: str | None = None


_DEFINITION: Final = web.AppKey("api_definition", _Definition)


def add_routes(app: web.Application) -> None:
    """Add every address of the table, and that of the definition."""
    app[_DEFINITION] = _Definition()
    app[KEPT] = KeptAnswers()
    plan_files.prepare(app)
    documents.prepare(app)
    file_transfer.prepare(app)
    reports.prepare(app)
    films.prepare(app)
    app.router.add_routes(_routes())


@cache
def _routes() -> Sequence[web.RouteDef]:
    """Return all routes; other methods of an address come behind its own."""
    found: dict[str, dict[str, Handler]] = {DEFINITION: {hdrs.METH_GET: definition}}
    for each in OPERATIONS:
        found.setdefault(each.route, {})[each.method] = bounded(each)
    add = {hdrs.METH_GET: web.get, hdrs.METH_PUT: web.put}
    return [
        route
        for path, handlers in found.items()
        for route in (
            *(add.get(method, web.post)(f"{ROOT}{path}", handler) for method, handler in handlers.items()),
            web.route(hdrs.METH_ANY, f"{ROOT}{path}", _refuser(handlers)),
        )
    ]


def _refuser(handlers: Mapping[str, Handler]) -> Handler:
    """Return the handler of other methods, which names those that there are: the page has an answer to every GET."""
    allowed = {*handlers, *({hdrs.METH_HEAD} if hdrs.METH_GET in handlers else set())}

    async def refuse(request: web.Request) -> web.StreamResponse:
        raise web.HTTPMethodNotAllowed(request.method, sorted(allowed))

    return refuse


@answered
async def definition(request: web.Request) -> web.StreamResponse:
    """The API's definition (OpenAPI 3.1)."""
    query_of(request, Query)
    kept, version, base = request.app[_DEFINITION], request.app[SERVICES].version, base_of(request)

    def make() -> Answer:
        from hawk.web.v1.openapi import document

        kept.text = kept.text or text_of(document(OPERATIONS, f"{_ANYWHERE}{ROOT}", version))
        return Answer(kept.text.replace(_ANYWHERE, base), content_type=OPENAPI)

    return await made(request, make)
