"""Import of an owner's plan from a file: a preview, which writes nothing, and its taking within an edit.

The file is read in a process of its own (`hawk.lots.plan_files.child`), one at a time. Operators may import.
"""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Final

from aiohttp import web

from hawk.lots.store import FILE_S, LotStore
from hawk.lots.values import LotStoreError
from hawk.web.lot_answers import FOR_OPERATORS, ID, answer, answered, now_of
from hawk.web.refusals import Body, check_operator, role_of
from hawk.web.services import SERVICES

if TYPE_CHECKING:  # loaded where a plan is imported
    from sqlalchemy import Connection

    from hawk.lots.plan_import.choices import ImportAsked
    from hawk.lots.plan_import.previews import Preview, Previews

READ_S: Final = 120.0
"""Real seconds in which the file must be there."""
_PREVIEW: Final = "{preview:[0-9a-f]{32}}"


@dataclass(slots=True)
class Imports:
    """``previews`` that wait to be taken; the ``lock`` lets one file be read at a time."""

    previews: Previews | None = None
    lock: asyncio.Lock = field(default_factory=asyncio.Lock)


_IMPORTS: Final = web.AppKey("plan_imports", Imports)


def add_routes(app: web.Application) -> None:
    """Add every route of this module."""
    app[_IMPORTS] = Imports()
    app.router.add_post(f"/api/lots/{ID}/plan/import", preview)
    app.router.add_post(f"/api/lots/{ID}/plan/import/{_PREVIEW}/take", answered(take))
    app.router.add_post("/api/lots/import", preview)
    app.router.add_post(f"/api/lots/import/{_PREVIEW}/take", answered(begin))


async def preview(request: web.Request) -> web.StreamResponse:
    """The preview of an import: the body is the file, the choices are in the query."""
    check_operator(request, FOR_OPERATORS)
    return await answer(request, lambda store: previewed(store, request))


async def previewed(store: LotStore, request: web.Request) -> str:
    """Return the preview of an import as JSON text. Raises LotStoreError while another file is read."""
    imports = request.app[_IMPORTS]
    if imports.lock.locked():
        raise LotStoreError("import: another file is being read: send this one again in a minute")
    async with imports.lock:
        return await _preview(store, request)


async def _preview(store: LotStore, request: web.Request) -> str:
    from hawk.lots.plan_files.child import read_apart
    from hawk.lots.plan_import.previews import new_token

    asked = _asked(request)
    lot = request.match_info.get("id")
    packed = await read_apart(await _file(request), asked.file)
    token = new_token()
    preview = partial(_previewed, lot=lot, packed=packed, asked=asked, store=store, token=token)
    made, text = await store.read(preview, FILE_S)
    _previews(request).keep(token, made, _clock(request))
    return text


def _asked(request: web.Request) -> ImportAsked:
    from hawk.lots.plan_import.choices import asked_of

    pins = request.query.getall("pin", [])
    return asked_of({key: value for key, value in request.query.items() if key != "pin"}, pins)


def _previewed(
    connection: Connection, lot: str | None, packed: bytes, asked: ImportAsked, store: LotStore, token: str
) -> tuple[Preview, str]:
    """Return the preview and its answer, on a thread of the store."""
    from hawk.lots.plan.edits import check_lot
    from hawk.lots.plan_files.child import unpacked
    from hawk.lots.plan_import.previews import preview as previewed
    from hawk.lots.plan_import.previews import preview_json
    from hawk.lots.text import json_text

    if lot is not None:
        check_lot(connection, lot)
    made = previewed(connection, lot, unpacked(packed), asked, store.register)
    return made, json_text(preview_json(made, token))


async def take(store: LotStore, request: web.Request, body: Body) -> object:
    """Take a previewed plan within the ``edit``: one operation, which is undone and done again as others are."""
    from hawk.lots.plan_import.transfer import take as taken
    from hawk.lots.text import json_text

    lot, token, now = request.match_info["id"], request.match_info["preview"], now_of(request)
    previews = _previews(request)
    found = previews.of(token, lot, _clock(request))
    text = await store.write(lambda connection: json_text(taken(connection, found, body, now)))
    previews.drop(token)
    return text


async def begin(store: LotStore, request: web.Request, body: Body) -> object:
    """Make a lot called ``name`` of a previewed plan."""
    from hawk.lots.plan_import.transfer import begin as begun

    token, now = request.match_info["preview"], now_of(request)
    previews = _previews(request)
    found = previews.of(token, None, _clock(request))
    who = role_of(request)
    made = await store.write(lambda connection: begun(connection, found, body, who, now))
    previews.drop(token)
    return made


def _clock(request: web.Request) -> float:
    """Return seconds of a clock that never steps: a preview outlives a time that GNSS sets."""
    return request.app[SERVICES].monotonic()


def _previews(request: web.Request) -> Previews:
    from hawk.lots.plan_import.previews import Previews

    imports = request.app[_IMPORTS]
    imports.previews = imports.previews or Previews()
    return imports.previews


async def _file(request: web.Request) -> bytes:
    """Return the file that was sent. Raises 413 beyond what is read, 408 when it takes too long."""
    from hawk.lots.plan_files.values import LARGEST_BYTES

    data = bytearray()
    try:
        async with asyncio.timeout(READ_S):
            async for chunk in request.content.iter_any():
                data += chunk
                if len(data) > LARGEST_BYTES:
                    words = f"The file is too large: {LARGEST_BYTES // 1_000_000} MB are read at most."
                    refusal = web.HTTPRequestEntityTooLarge(LARGEST_BYTES, len(data), text=words)
                    refusal.force_close()
                    raise refusal
    except TimeoutError:
        raise web.HTTPRequestTimeout(text="The file did not come.") from None
    return bytes(data)
