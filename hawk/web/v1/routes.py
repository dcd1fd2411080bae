"""Routes of the API."""

from __future__ import annotations

from aiohttp import web

from hawk.web.v1.answering import ROOT
from hawk.web.v1.table import OPERATIONS


def add_routes(app: web.Application) -> None:
    """Add every address of the table."""
    for each in OPERATIONS:
        if each.method == "GET":
            app.router.add_get(f"{ROOT}{each.route}", each.handler)
        else:
            app.router.add_route(each.method, f"{ROOT}{each.route}", each.handler)
