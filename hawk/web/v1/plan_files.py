"""Import of an owner's plan from a file: a preview, which writes nothing, and its taking within an edit.

The file is read in a process of its own (`hawk.lots.plan_files.child`), one at a time. Operators may import.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Annotated, Final, Literal

from aiohttp import web
from pydantic import Field

from hawk.lots.store import FILE_S, LotStore
from hawk.lots.values import LotStoreError
from hawk.runtime.late import late_functions
from hawk.web.area_file import sent_file
from hawk.web.services import SERVICES
from hawk.web.v1.answers import answered, now_of, opened, text_of
from hawk.web.v1.changes import FOR_OPERATORS, Body, changed, who_of
from hawk.web.v1.parameters import AGAIN, Query
from hawk.web.v1.refusals import check_operator

if TYPE_CHECKING:
    from sqlalchemy import Connection

    from hawk.lots.plan import edits
    from hawk.lots.plan_files import child
    from hawk.lots.plan_import import choices, previews, transfer
    from hawk.lots.plan_import.choices import ImportAsked
    from hawk.lots.plan_import.previews import Preview, Previews
else:
    choices, previews, transfer = (
        late_functions(f"hawk.lots.plan_import.{name}") for name in ("choices", "previews", "transfer")
    )
    edits, child = late_functions("hawk.lots.plan.edits"), late_functions("hawk.lots.plan_files.child")

READ_S: Final = 120.0
"""Real seconds in which the file must be there."""
_LONGEST: Final = 200
_Text = Annotated[str, Field(max_length=_LONGEST)]
Switch = Literal["0", "1"]


class ImportChoices(Query):
    """Choices about a file with a plan, for the definition: `hawk.lots.plan_import.choices` reads and checks them."""

    name: Annotated[_Text | None, Field(description="name of the file, as it is shown")] = None
    layer: Annotated[_Text | None, Field(description="layer of the drawing that has the stalls")] = None
    units: Annotated[_Text | None, Field(description="unit of the drawing's lengths")] = None
    label: Annotated[_Text | None, Field(description="property with the labels")] = None
    crs: Annotated[_Text | None, Field(description="system of coordinates, as EPSG:25832")] = None
    pin: Annotated[
        list[str] | None,
        Field(
            description="point of the drawing and its place on Earth: x,y,latitude,longitude; again for a second one",
            json_schema_extra={AGAIN: True},
        ),
    ] = None
    replace: Annotated[Switch | None, Field(description="1: stalls that the file has not end")] = None
    rename: Annotated[Switch | None, Field(description="1: labels that other stalls keep get another number")] = None


@dataclass(slots=True)
class Imports:
    """``previews`` that wait to be taken; the ``lock`` lets one file be read at a time."""

    previews: Previews | None = None
    lock: asyncio.Lock = field(default_factory=asyncio.Lock)


_IMPORTS: Final = web.AppKey("plan_imports", Imports)


def prepare(app: web.Application) -> None:
    """Make room for previews that wait to be taken."""
    app[_IMPORTS] = Imports()


@answered
async def preview(request: web.Request) -> web.StreamResponse:
    """The preview of an import: the body is the file, the choices are in the query. Nothing is written."""
    check_operator(request, FOR_OPERATORS)
    store, imports = await opened(request), request.app[_IMPORTS]
    if imports.lock.locked():
        raise LotStoreError("import: another file is being read: send this one again in a minute")
    async with imports.lock:
        return changed(await _preview(store, request))


async def _preview(store: LotStore, request: web.Request) -> str:
    asked, lot = _asked(request), request.match_info.get("id")
    packed = await child.read_apart(await _file(request), asked.file)
    token = previews.new_token()
    preview = partial(_previewed, lot=lot, packed=packed, asked=asked, store=store, token=token)
    made, text = await store.read(preview, FILE_S)
    _previews(request).keep(token, made, _clock(request))
    return text


def _asked(request: web.Request) -> ImportAsked:
    pins = request.query.getall("pin", [])
    return choices.asked_of({key: value for key, value in request.query.items() if key != "pin"}, pins)


def _previewed(
    connection: Connection, lot: str | None, packed: bytes, asked: ImportAsked, store: LotStore, token: str
) -> tuple[Preview, str]:
    """Return the preview and its answer, on a thread of the store."""
    if lot is not None:
        edits.check_lot(connection, lot)
    made = previews.preview(connection, lot, child.unpacked(packed), asked, store.register)
    return made, text_of(previews.shown_preview(made, token))


async def take(request: web.Request, body: Body) -> object:
    """Take a previewed plan within the ``edit``: one operation, which is undone and done again as others are."""
    lot, now = request.match_info["id"], now_of(request)
    return await _take(request, lot, lambda connection, found: transfer.take(connection, found, body, now))


async def begin(request: web.Request, body: Body) -> object:
    """Make a lot called ``name`` of a previewed plan."""
    who, now = who_of(request), now_of(request)
    return await _take(request, None, lambda connection, found: transfer.begin(connection, found, body, who, now))


async def _take(
    request: web.Request, lot: str | None, work: Callable[[Connection, Preview], object]
) -> str:  # fmt: skip
    store, token, waiting = await opened(request), request.match_info["preview"], _previews(request)
    found = waiting.of(token, lot, _clock(request))
    text = await store.write(lambda connection: text_of(work(connection, found)))
    waiting.drop(token)
    return text


def _clock(request: web.Request) -> float:
    """Return seconds of a clock that never steps: a preview outlives a time that GNSS sets."""
    return request.app[SERVICES].monotonic()


def _previews(request: web.Request) -> Previews:
    imports = request.app[_IMPORTS]
    imports.previews = imports.previews or previews.Previews()
    return imports.previews


async def _file(request: web.Request) -> bytes:
    from hawk.lots.plan_files.values import LARGEST_BYTES

    words = f"The file is too large: {LARGEST_BYTES // 1_000_000} MB are read at most."
    return await sent_file(request, LARGEST_BYTES, READ_S, words)
