"""The report of the use of lots as a file: by a lot's id, by several, or by the token of a link.

It is read on a thread of the store, as every answer is. PDF and workbook take seconds of work: a process of its own
writes them, one at a time, and none in flight, where the page still shows the document.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

from aiohttp import hdrs, web
from aiohttp.typedefs import Handler

from hawk.formats import box
from hawk.lots.store import FILE_S
from hawk.lots.values import LotStoreError, StoreBusyError
from hawk.report.options import CONTENT_TYPES, MOST_LOTS, Form, Kind
from hawk.runtime.late import late_functions
from hawk.web.downloads import is_on_ground
from hawk.web.services import SERVICES
from hawk.web.v1.answers import Answer, LotOf, answered, keep_missing_looks, made, opened, request_of
from hawk.web.v1.parameters import LotsReportQuery, ReportQuery
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
A_LOT: Final = box.Limits(memory_bytes=10_000_000, cpu_s=6, longest_s=10)
"""Addition for each further lot of a report: 50 take 77 s of the processor and .4 GB (docs/results/report.md)."""
LOOK_S: Final = 0.5
"""Real seconds between two looks whether the one who asked for a file is still there."""
MOST_WAITING: Final = 4
"""Files that are written or wait; the next one is refused."""
_BUSY: Final = "report: others are being written: ask again in a minute"
_FLYING: Final = "cannot be written as this file in flight: take report.html now, or this once the motors are off"
_LOTS_FLYING: Final = "over several lots is not made in flight: ask for one lot, or once the motors are off"
_TOO_MUCH: Final = "takes more memory or time than it may: ask for a shorter period or fewer lots, or print report.html"
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
        if kind != "html":
            _check_ground(request, _FLYING)
        store = await opened(request)
        if lot_of is not None:
            asked = replace(asked, path={**asked.path, "id": await lot_of(store, request)})
        await keep_missing_looks(store, asked)
        form = Form(asked.query.language, asked.query.paper)
        has_ground = lot_of is None

        def read(connection: Connection) -> Prepared:
            return reads.report(connection, pictures.pictures_of(store.path), asked, kind, form, has_ground)

        return await _sent(request, kind, await store.read(read, FILE_S), asked.id[:8], LIMITS)

    return answered(handle)


def lots_handler(kind: Kind) -> Handler:
    """Return the handler of the address of a report over several lots."""

    async def handle(request: web.Request) -> web.StreamResponse:
        asked = request_of(request, LotsReportQuery)
        _check_ground(request, _LOTS_FLYING)
        store = await opened(request)
        lots = await store.read(lambda connection: reads.lots_of_report(connection, asked))
        for lot in lots[:MOST_LOTS]:
            await keep_missing_looks(store, replace(asked, path={"id": lot}))
        form = Form(asked.query.language, asked.query.paper)

        def read(connection: Connection) -> Prepared:
            return reads.report_of_lots(connection, pictures.pictures_of(store.path), lots, asked, kind, form)

        return await _sent(request, kind, await store.read(read, FILE_S), "lots", _limits_of(len(lots)))

    return answered(handle)


def _check_ground(request: web.Request, words: str) -> None:
    """Refuse what costs many seconds of the processor in flight. Raises RefusedError with the words."""
    if not is_on_ground(request.app[SERVICES].status.value):
        raise RefusedError(web.HTTPConflict.status_code, "report", words)


def _limits_of(lots: int) -> box.Limits:
    """Return the limits of a process that writes the report of some lots."""
    return box.Limits(
        memory_bytes=LIMITS.memory_bytes + (lots - 1) * A_LOT.memory_bytes,
        cpu_s=LIMITS.cpu_s + (lots - 1) * A_LOT.cpu_s, longest_s=LIMITS.longest_s + (lots - 1) * A_LOT.longest_s,
    )  # fmt: skip


async def _sent(
    request: web.Request, kind: Kind, file: Prepared, name: str, limits: box.Limits
) -> web.StreamResponse:  # fmt: skip
    """Return a prepared file, written where that is to be done. Raises StoreBusyError, LotStoreError."""
    data = file.data
    if file.maker is not None:
        data = await _while_wanted(request, _written(request.app[_QUEUE], file, limits))
    return await made(request, _answer(kind, data, file.policy, _name(kind, name)))


async def _while_wanted(request: web.Request, work: Coroutine[None, None, bytes]) -> bytes:
    """Return what work makes; it ends when who asked is gone, for others wait. Raises StoreBusyError then."""
    task = asyncio.create_task(work)
    try:
        while not (await asyncio.wait({task}, timeout=LOOK_S))[0]:
            if request.transport is None or request.transport.is_closing():
                raise StoreBusyError(_BUSY)
    finally:
        task.cancel()
    return task.result()


async def _written(queue: _Queue, file: Prepared, limits: box.Limits) -> bytes:
    """Return a file that a process of its own writes. Raises StoreBusyError, LotStoreError."""
    if queue.waiting >= MOST_WAITING:
        raise StoreBusyError(_BUSY)
    queue.waiting += 1
    try:
        async with asyncio.timeout(limits.longest_s), queue.lock:
            return await box.read_apart(file.maker or "", file.data, {}, limits)
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


def _name(kind: Kind, of: str) -> str:
    """Return how a browser shows a file, and what it calls it: a workbook is for another program."""
    return f'{"attachment" if kind == "xlsx" else "inline"}; filename="report-{of}.{kind}"'
