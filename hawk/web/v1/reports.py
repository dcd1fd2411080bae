"""The report of a lot's use as a file: by the lot's id, or by the token of a link.

It is read on a thread of the store, as every answer is. PDF and workbook take seconds of work: a process of its own
writes them, one at a time, and none in flight, where the page still shows the document.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

from aiohttp import hdrs, web
from aiohttp.typedefs import Handler

from hawk.formats import box
from hawk.lots.store import FILE_S
from hawk.lots.values import LotStoreError, StoreBusyError
from hawk.report.options import CONTENT_TYPES, Form, Kind
from hawk.runtime.late import late_functions
from hawk.web.downloads import is_on_ground
from hawk.web.services import SERVICES
from hawk.web.v1.answers import Answer, LotOf, answered, keep_missing_looks, made, opened, request_of
from hawk.web.v1.parameters import ReportQuery
from hawk.web.v1.refusals import RefusedError

if TYPE_CHECKING:
    from sqlalchemy import Connection

    from hawk.lots.survey import pictures
    from hawk.report.files import Prepared
    from hawk.web.v1 import reads
else:
    reads, pictures = late_functions("hawk.web.v1.reads"), late_functions("hawk.lots.survey.pictures")

LIMITS: Final = box.Limits(memory_bytes=1_000_000_000, cpu_s=60, longest_s=FILE_S)
"""Of the process that writes a file: the largest lot takes a third (docs/results/report.md)."""
MOST_WAITING: Final = 4
"""Files that are written or wait; the next one is refused."""
_BUSY: Final = "report: others are being written: ask again in a minute"
_FLYING: Final = "cannot be written as this file in flight: take report.html now, or this once the motors are off"
_TOO_MUCH: Final = "takes more memory or time than it may: ask for a shorter period, or print report.html"
FRAMED: Final = "SAMEORIGIN"
"""X-Frame-Options of the document: the page of this server shows it in a frame."""


@dataclass(slots=True)
class _Queue:
    """The ``lock`` lets one file be written at a time; ``waiting``: how many are written or wait."""

    lock: asyncio.Lock = field(default_factory=asyncio.Lock)
    waiting: int = 0


_QUEUE: Final = web.AppKey("report_queue", _Queue)


def prepare(app: web.Application) -> None:
    """Make room for files that are written."""
    app[_QUEUE] = _Queue()


def handler(kind: Kind, lot_of: LotOf | None = None) -> Handler:
    """Return the handler of an address; ``lot_of`` finds the lot of one that has no id in it: a link's.

    A link shows no picture that was taken.
    """

    async def handle(request: web.Request) -> web.StreamResponse:
        asked = request_of(request, ReportQuery)
        if kind != "html" and not is_on_ground(request.app[SERVICES].status.value):
            raise RefusedError(web.HTTPConflict.status_code, "report", _FLYING)
        store = await opened(request)
        if lot_of is not None:
            asked = replace(asked, path={**asked.path, "id": await lot_of(store, request)})
        await keep_missing_looks(store, asked)
        form = Form(asked.query.language, asked.query.paper)
        has_ground = lot_of is None

        def read(connection: Connection) -> Prepared:
            return reads.report(connection, pictures.pictures_of(store.path), asked, kind, form, has_ground)

        file = await store.read(read, FILE_S)
        data = file.data if file.maker is None else await _written(request.app[_QUEUE], file)
        return await made(request, _answer(kind, data, file.policy, _name(kind, asked.id)))

    return answered(handle)


async def _written(queue: _Queue, file: Prepared) -> bytes:
    """Return a file that a process of its own writes. Raises StoreBusyError, LotStoreError."""
    if queue.waiting >= MOST_WAITING:
        raise StoreBusyError(_BUSY)
    queue.waiting += 1
    try:
        async with asyncio.timeout(FILE_S), queue.lock:
            return await box.read_apart(file.maker or "", file.data, {}, LIMITS)
    except TimeoutError:
        raise StoreBusyError(_BUSY) from None
    except box.RefusedError as error:
        reason = error.reason if error.field == "report" else _TOO_MUCH
        raise LotStoreError(f"report: {reason}") from error
    finally:
        queue.waiting -= 1


def _answer(kind: Kind, data: bytes, policy: str, name: str) -> Callable[[], Answer]:
    headers: Mapping[str, str] = {hdrs.CONTENT_DISPOSITION: name}
    if kind == "html":
        headers = {**headers, "Content-Security-Policy": policy, "X-Frame-Options": FRAMED}
        return lambda: Answer(data.decode(), content_type=CONTENT_TYPES[kind], headers=headers)
    return lambda: Answer(data, content_type=CONTENT_TYPES[kind], headers=headers)


def _name(kind: Kind, lot: str) -> str:
    """Return how a browser shows a file, and what it calls it: a workbook is for another program."""
    return f'{"attachment" if kind == "xlsx" else "inline"}; filename="report-{lot[:8]}.{kind}"'
