"""Routes of the API, and the address of its definition."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from aiohttp import web

from hawk.web.services import SERVICES
from hawk.web.v1.answering import ROOT, Answer, answered, base_of, made
from hawk.web.v1.asked import Query, query_of
from hawk.web.v1.features import OPENAPI
from hawk.web.v1.table import OPERATIONS

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
    app.router.add_get(f"{ROOT}{DEFINITION}", definition)
    for each in OPERATIONS:
        if each.is_change:
            app.router.add_post(f"{ROOT}{each.route}", each.handler)
        else:
            app.router.add_get(f"{ROOT}{each.route}", each.handler)


@answered
async def definition(request: web.Request) -> web.StreamResponse:
    """The API's definition (OpenAPI 3.1)."""
    query_of(request, Query)
    kept, version, base = request.app[_DEFINITION], request.app[SERVICES].version, base_of(request)

    def make() -> Answer:
        from hawk.lots.text import json_text
        from hawk.web.v1.openapi import document

        kept.text = kept.text or json_text(document(OPERATIONS, f"{_ANYWHERE}{ROOT}", version))
        return Answer(kept.text.replace(_ANYWHERE, base), content_type=OPENAPI)

    return await made(request, make)
