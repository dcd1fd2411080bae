"""The lots' store for the event loop, on threads that nothing of a flight waits for: one writes, some read.

A save waits for no read. A read ends when its time is over; where too many wait, the next one is refused.

The file is opened by the first call, and again after a call that failed: a disk that was full, or a backup that was
restored, needs no new start of the program. SQLAlchemy is loaded on these threads.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import sys
import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeVar

from hawk.lots.documents.arrival import Arrival, ArrivalKind
from hawk.lots.values import LotInputError, LotStoreError, Register, Saved, StoreBusyError
from hawk.model.lot_map import EncodedTile, TileKey
from hawk.runtime.late import late
from hawk.runtime.process import set_niceness

if TYPE_CHECKING:  # loaded on the store's threads
    from sqlalchemy import Connection

    from hawk.lots import ingest, known_lot, outbox
    from hawk.lots.documents import arrival_log, collection, lot_document, lot_return, survey_document
    from hawk.lots.documents.collection import DocumentOutcome, LotOutcome
    from hawk.lots.documents.lot_return import LotAnswer, LotQuery
    from hawk.lots.storage import backup, database
    from hawk.lots.storage.backup import FlightLock
    from hawk.lots.storage.database import Database
    from hawk.lots.survey import landing, last_surveys, pictures, private_ground, round_share
    from hawk.lots.survey.landing import LandingFacts
else:
    backup = late("hawk.lots.storage.backup")
    database = late("hawk.lots.storage.database")
    landing = late("hawk.lots.survey.landing")
    last_surveys = late("hawk.lots.survey.last_surveys")
    outbox = late("hawk.lots.outbox")
    pictures = late("hawk.lots.survey.pictures")
    private_ground = late("hawk.lots.survey.private_ground")
    round_share = late("hawk.lots.survey.round_share")
    ingest = late("hawk.lots.ingest")
    known_lot = late("hawk.lots.known_lot")
    arrival_log = late("hawk.lots.documents.arrival_log")
    collection = late("hawk.lots.documents.collection")
    lot_document = late("hawk.lots.documents.lot_document")
    lot_return = late("hawk.lots.documents.lot_return")
    survey_document = late("hawk.lots.documents.survey_document")

_LOG = logging.getLogger(__name__)
T = TypeVar("T")

FILE: Final = "lots.db"
"""Name of the store in the folder of the daemon's files."""
READS: Final = 2
"""Reads at once. They share the interpreter: more make each slower."""
MOST_READS: Final = 32
"""Reads that run or wait; the next one is refused. A page asks for about ten at once."""
READ_S: Final = 10.0
"""Real seconds that a read may wait and run."""
FILE_S: Final = 60.0
"""The same for one that makes a file, or compares plans."""
OPEN_S: Final = 2.0
"""Real seconds to search for damage while the file is opened: a store of some hundred lots is searched by then."""
_BUSY: Final = "The store of lots is busy: ask again in some seconds."
_AHEAD_S: Final = 86_400.0
"""Seconds by which a survey from elsewhere may be ahead of this computer's clock: zones and clocks that run fast."""
_NICENESS: Final = (15,)
"""The threads, and those that they start, step back behind every other one of the program."""


class LotStore:
    """Saves surveys, reads lots, changes them. `close` at the end."""

    def __init__(
        self,
        path: Path,
        register: Register | None = None,
        pragmas: Mapping[str, int] | None = None,
        wall: Callable[[], float] = time.time,
    ) -> None:
        """Nothing is opened yet.

        Args:
            path: The file; it is made when there is none.
            register: Finds a survey's stalls among those of a known lot, on the store's thread; None: such surveys
                stay unregistered.
            pragmas: SQLite's, set on the connection.
            wall: UTC, Unix seconds.
        """
        self.path = path
        self.register = register
        self._pragmas = pragmas
        self._wall = wall
        self._database: Database | None = None
        self._lock: FlightLock | None = None
        self._executor = ThreadPoolExecutor(1, thread_name_prefix="lots", initializer=set_niceness, initargs=_NICENESS)
        self._readers = ThreadPoolExecutor(
            READS, thread_name_prefix="lots-read", initializer=set_niceness, initargs=_NICENESS
        )
        self._room = threading.BoundedSemaphore(MOST_READS)
        self._is_closing = threading.Event()

    @property
    def is_open(self) -> bool:
        """True once the file was opened: reading then loads no library."""
        return self._database is not None

    async def open(self) -> str:
        """Open the file; return words on what an operator should know of it, else nothing. Raises LotStoreError."""
        if self._database is not None:
            return self._database.notice  # a read waits for no save
        return await self._run(lambda: self._opened().notice)

    async def save(self, landed: LandingFacts) -> Saved:
        """Save a survey in one transaction. Raises LotStoreError; nothing is written then."""
        return await self._run(lambda: self._saved(landed))

    async def save_share(self, landed: LandingFacts, lot: str) -> Saved | None:
        """Save the share of one lot, by its id, in the map of a round; return None where no stall of it was seen.

        Raises LotStoreError; nothing is written then.
        """

        def work() -> Saved | None:
            known = {stall.known for stall in landed.current.stalls.values() if stall.known}
            with self._opened().reading() as connection:
                lot_of = known_lot.lots_of_stalls(connection, known)
            mine = round_share.share_of(landed, lot, lot_of)
            return None if mine is None else self._saved(mine)

        return await self._run(work)

    def _saved(self, landed: LandingFacts) -> Saved:
        survey = landing.finished(landed)
        with self._opened().writing() as connection:
            before = outbox.last(connection)
            saved = ingest.save(connection, survey, self.register)
            outbox.date(connection, before, self._wall())
        self._keep_picture(saved.survey, landed.current.mosaic)
        return saved

    async def collect(self, data: bytes, survey: str, drone: str) -> DocumentOutcome:
        """Take in the document of a survey that a drone has sent; it is committed, with its picture, then.

        Args:
            data: The document, as `hawk.lots.documents.parts` packs it.
            survey: Id that the document must have.
            drone: Name of the drone.

        Raises LotInputError, OtherDroneError, ErasedError, LotStoreError; nothing is written then.
        """

        def work() -> DocumentOutcome:
            document = survey_document.unpacked(data)
            if document.survey.id != survey:
                raise LotInputError("survey.id", f"must be the id of the address, {survey}")
            if document.survey.time_is_sure and document.survey.ended > self._wall() + _AHEAD_S:
                raise LotInputError("survey.ended", "is more than a day ahead: set the clock of drone and desk right")
            with self._opened().writing() as connection:
                found = collection.collect(connection, document, drone, self.register)
                kind, state = ArrivalKind.SURVEY, document.survey.state
                arrived = Arrival(drone, kind, survey, found.outcome, found.lot, state)
                arrival_log.note(connection, arrived, self._wall())
            if found.has_newer_picture:
                self._keep_picture(survey, document.pictures)
                with self._opened().writing() as connection:
                    collection.note_picture(connection, found.seq, document.survey.state)
            return found

        return await self._run(work)

    async def collect_lot(self, data: bytes, lot: str, drone: str) -> LotOutcome:
        """Take in the document of a lot that a drone has sent; it is committed then.

        Args:
            data: The document, as `hawk.lots.documents.parts` packs it.
            lot: Id of a lot that the document must have.
            drone: Name of the drone.

        Raises LotInputError, ErasedError, LotStoreError; nothing is written then.
        """

        def work() -> LotOutcome:
            document = lot_document.unpacked(data)
            if lot not in {each.id for each in document.lots}:
                raise LotInputError("lots", f"must have the lot of the address, {lot}")
            with self._opened().writing() as connection:
                found = collection.collect_lots(connection, document, drone)
                arrived = Arrival(drone, ArrivalKind.LOT, lot, found.outcome, lot, document.state)
                arrival_log.note(connection, arrived, self._wall())
                return found

        return await self._run(work)

    async def note(self, arrival: Arrival) -> None:
        """Note what came from a drone or a program, and wrote nothing else. Raises LotStoreError."""
        now = self._wall()
        await self.write(lambda connection: arrival_log.note(connection, arrival, now))

    async def take_back(self, data: bytes, asked: LotQuery) -> LotAnswer:
        """Take in a document of lots of the desk that this store is sent to. Raises LotInputError, LotStoreError."""

        def work() -> LotAnswer:
            document = lot_document.unpacked(data)
            with self._opened().writing() as connection:
                return lot_return.take_back(connection, document, asked, self._wall(), self.register)

        return await self._run(work)

    def _keep_picture(self, survey: str, mosaic: Mapping[TileKey, EncodedTile]) -> None:
        """Write the picture of a survey that is stored. An error is logged: nothing that is counted needs it."""
        try:
            folder, opened = pictures.pictures_of(self.path), self._opened()
            with opened.reading() as connection:
                hidden = private_ground.hidden_in(connection, survey)
            folder.write(survey, mosaic, hidden)
            if not opened.damaged:  # a backup may bring back surveys that are passed over
                with opened.reading() as connection:
                    folder.keep(pictures.worth_keeping(connection, folder.surveys(), survey))
        except (OSError, LotStoreError) as error:
            _LOG.warning("the picture of the survey is not kept: %s", error)

    async def read(self, query: Callable[[Connection], T], limit_s: float = READ_S) -> T:
        """Return what a query finds in one consistent view.

        Args:
            query: Runs on a thread that reads.
            limit_s: Real seconds after which it is ended, its wait for others among them.

        Raises LotStoreError, and StoreBusyError for a read that was ended, or that too many others came before.
        """
        until, given_up = time.monotonic() + limit_s, threading.Event()

        def is_over() -> bool:
            return given_up.is_set() or self._is_closing.is_set() or time.monotonic() > until

        def work() -> T:
            if is_over():
                raise StoreBusyError(_BUSY)
            with self._for_reading().reading(is_over) as connection:
                return query(connection)

        if not self._room.acquire(blocking=False):
            raise StoreBusyError(_BUSY)
        try:
            running = self._readers.submit(work)
        except RuntimeError:
            self._room.release()
            raise LotStoreError(f"{self.path}: the store is closed") from None
        running.add_done_callback(self._end_read)
        try:
            return await asyncio.wrap_future(running)
        finally:
            given_up.set()

    async def write(self, change: Callable[[Connection], T]) -> T:
        """Change the store in one transaction. Raises LotStoreError; nothing is written then."""

        def work() -> T:
            with self._opened().writing() as connection:
                return change(connection)

        return await self._run(work)

    async def fly(self, *, is_flown: bool) -> None:
        """Keep restores away while a survey is flown. A lock that cannot be taken is logged and stops nothing."""

        def work() -> None:
            self._lock = self._lock or backup.FlightLock(self.path)
            try:
                (self._lock.hold if is_flown else self._lock.release)()
            except OSError as error:
                _LOG.warning("%s: %s. Restore no backup while a survey is flown", self.path, error.strerror or error)

        await self._run(work)

    async def close(self) -> None:
        """Close the file. Reads are ended; a save that runs is waited for, those that wait behind it are dropped."""
        self._is_closing.set()

        def work() -> None:
            self._readers.shutdown(wait=True, cancel_futures=True)
            self._drop()
            if self._lock is not None:
                self._lock.release()

        with contextlib.suppress(LotStoreError):
            await self._run(work)
        self._executor.shutdown(wait=False, cancel_futures=True)

    async def _run(self, work: Callable[[], T]) -> T:
        return await asyncio.get_running_loop().run_in_executor(self._executor, self._guarded, work)

    def _guarded(self, work: Callable[[], T]) -> T:
        """Do some work; after an error of the store the file is opened again by the next call."""
        try:
            return work()
        except LotStoreError:
            raise
        except BaseException:
            self._drop()
            raise
        finally:
            self._go_on_renewing()

    def _go_on_renewing(self) -> None:
        """Keep the newest surveys that a transaction left, as an upgrade leaves them, behind the work that waits."""
        opened = self._database
        if opened is not None and opened.has_more_newest and not self._is_closing.is_set():
            opened.has_more_newest = False
            with contextlib.suppress(RuntimeError):  # the store is closed: the next one goes on
                self._executor.submit(self._guarded, self._renew)

    def _renew(self) -> None:
        with contextlib.suppress(LotStoreError):
            opened = self._opened()
            with opened.reading() as connection:
                is_due = bool(opened.stale) or last_surveys.has_more(connection)
            if is_due:  # a transaction that writes nothing ends every answer's ETag, too
                with opened.writing():
                    pass  # the end of each transaction keeps some

    def _for_reading(self) -> Database:
        """Return the open store, on a thread that reads: the one that writes opens it."""
        opened = self._database
        if opened is None or opened.is_replaced:
            return self._executor.submit(self._guarded, self._opened).result()
        return opened

    def _end_read(self, _: object) -> None:
        """Make room for the next read; move into the file what a save had to leave in the WAL for this one."""
        self._room.release()
        opened = self._database
        if opened is not None and opened.has_left_wal:
            with contextlib.suppress(RuntimeError):  # the store is closed: SQLite does it then
                self._executor.submit(self._tidy)

    def _tidy(self) -> None:
        if self._database is not None:
            self._database.put_into_file()

    def _opened(self) -> Database:
        if self._database is not None and self._database.is_replaced:
            self._drop()
        if self._database is None:
            self._database = database.Database(self.path, self._pragmas, self._wall, OPEN_S)
        return self._database

    def _drop(self) -> None:
        if self._database is not None:
            self._database.close()
            self._database = None


def check_there(store: Path) -> None:
    """Refuse a store that is not there. Raises LotStoreError."""
    if not store.exists():
        raise LotStoreError(f"{store}: there is no store of lots; name its folder by --store, and fly a survey first")


def show_damage(words: str) -> None:
    """Say on the terminal, beside what a command prints, what is damaged in the store."""
    if words:
        print(f"hawk-drone: {words}", file=sys.stderr)


def lots_file(folder: Path, named: Path | None = None) -> Path:
    """Return the store's file: the one that the settings name, else the one in the folder of the daemon's files."""
    return named or folder / FILE
