"""Plans of lots, corrected by persons: who edits, operations with undo and redo, and the changes since a revision.

Everybody may read; operators may change. A value that cannot be used is answered with 422, its field and the remedy;
where another person edits, with 409, who it is, and since when.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from typing import TYPE_CHECKING, Any, Final

from aiohttp import web

from hawk.lots.store import LotStore
from hawk.lots.values import LotInputError
from hawk.web.lot_answers import ID, answer, answered, now_of
from hawk.web.refusals import Body

if TYPE_CHECKING:  # loaded on the store's thread
    from sqlalchemy import Connection

_LONGEST_NUMBER: Final = 9

Acting = Callable[["Connection", str, Mapping[str, Any], float], Mapping[str, Any]]


def add_routes(app: web.Application) -> None:
    """Add every route of this module."""
    app.router.add_get(f"/api/lots/{ID}/plan.json", plan)
    app.router.add_post(f"/api/lots/{ID}/edit", answered(open_edit))
    app.router.add_post(f"/api/lots/{ID}/edit/close", answered(close))
    app.router.add_post(f"/api/lots/{ID}/plan", answered(do))
    app.router.add_post(f"/api/lots/{ID}/plan/undo", answered(undo))
    app.router.add_post(f"/api/lots/{ID}/plan/redo", answered(redo))


async def plan(request: web.Request) -> web.StreamResponse:
    """The plan: all of it, those stalls that changed after the revision ``since``, or that of a version ``layout``."""

    async def work(store: LotStore) -> object:
        from hawk.lots import queries
        from hawk.lots.text import json_text

        lot, since, layout = request.match_info["id"], _number(request, "since"), _number(request, "layout")
        return await store.read(lambda connection: json_text(queries.plan(connection, lot, since, layout)))

    return await answer(request, work)


async def open_edit(store: LotStore, request: web.Request, body: Body) -> object:
    """Open an edit of the plan for the person ``who``, or go on with theirs; ``take_over`` closes another person's."""
    from hawk.lots.plan import edits

    return await _act(store, request, body, edits.open_edit)


async def close(store: LotStore, request: web.Request, body: Body) -> object:
    """Close the ``edit``: its version of the layout is final; ``why`` says the reason."""
    from hawk.lots.plan import edits

    return await _act(store, request, body, edits.close)


async def do(store: LotStore, request: web.Request, body: Body) -> object:
    """Do an ``operation`` within the ``edit``."""
    from hawk.lots.plan import edits

    return await _act(store, request, body, edits.do)


async def undo(store: LotStore, request: web.Request, body: Body) -> object:
    """Undo the newest operation of the ``edit``."""
    from hawk.lots.plan import edits

    return await _act(store, request, body, edits.undo)


async def redo(store: LotStore, request: web.Request, body: Body) -> object:
    """Do the operation of the ``edit`` again that was undone last."""
    from hawk.lots.plan import edits

    return await _act(store, request, body, edits.redo)


def _act(store: LotStore, request: web.Request, body: Body, acting: Acting) -> Awaitable[str]:
    from hawk.lots.text import json_text

    lot, now = request.match_info["id"], now_of(request)
    return store.write(lambda connection: json_text(acting(connection, lot, body, now)))


def _number(request: web.Request, name: str) -> int | None:
    given = request.query.get(name)
    if given is None:
        return None
    if not (given.isascii() and given.isdecimal() and len(given) <= _LONGEST_NUMBER):
        raise LotInputError(name, "must be a whole number, 0 or more")
    return int(given)
