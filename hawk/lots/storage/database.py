"""The file of the lots' store: SQLite in WAL mode, opened, checked, migrated, and read or written in transactions.

Everything here blocks on the disk. Writing belongs to one thread; any thread may read, on a connection of its own,
which a save never waits for. A file that is damaged or of a newer version is never written; before a migration a copy
of the file is kept beside it.
"""

from __future__ import annotations

import contextlib
import logging
import math
import secrets
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, cast
from urllib.parse import quote

from sqlalchemy import Connection, Engine, create_engine, event
from sqlalchemy.exc import DBAPIError
from sqlalchemy.pool import QueuePool, StaticPool

from hawk.lots.storage import digests
from hawk.lots.storage.damage_search import DamageSearch, damaged_parts, faults_of
from hawk.lots.storage.digests import Part, note_damaged, pass_over, seal, seal_everything, words_of
from hawk.lots.storage.schema import APPLICATION_ID, SCHEMA, VERSION
from hawk.lots.storage.schema_check import Schema, difference, schema_of
from hawk.lots.survey import last_surveys
from hawk.lots.values import LotStoreError, StoreBusyError, StoreFullError
from hawk.runtime.files import sync_folder
from hawk.runtime.late import late
from hawk.runtime.performance import uncollected

if TYPE_CHECKING:  # half of the time to load this module, seldom needed
    from alembic import config, script
    from alembic.runtime import environment, migration
else:
    config = late("alembic.config")
    script = late("alembic.script")
    environment = late("alembic.runtime.environment")
    migration = late("alembic.runtime.migration")

_LOG = logging.getLogger(__name__)

BUSY_S: Final = 5.0
"""Real seconds to wait for another program that writes the file."""
KEPT_READERS: Final = 2
"""Connections for reading that stay open; more are opened, and closed again, when more read at once."""
_STEPS: Final = 1000
"""Instructions of SQLite between two questions whether a read is over: some microseconds."""
_TAG: Final = "hawk.lots.tag"
_MAGIC: Final = b"SQLite format 3\0"
_HEADER_BYTES: Final = 100
_LARGEST_PAGE: Final = 65_536
"""The header's page size is 1 for it (sqlite.org/fileformat.html)."""
_REVISIONS: Final = Path(__file__).parent / "revisions"
TOO_LONG: Final = "The store of lots needs too long for this: ask for a shorter period, or again in some seconds."
"""Words for a read that was ended."""
_RESTORE: Final = "Nothing was written. Restore a backup: hawk-drone restore FILE"


class Database:
    """An open store.

    ``is_read_only``: it is of a newer version, or damaged as a whole, named in ``notice``. ``damaged``: parts that
    readers pass over, named in ``damage`` and ``notice``. ``is_searched``: set when no more damage is searched for.
    ``has_more_newest``: rows of `hawk.lots.survey.last_surveys` may be left for the next transactions. ``stale``: lots
    whose row is damaged: readers pass it over until a transaction has made it again.
    """

    def __init__(
        self,
        path: Path,
        pragmas: Mapping[str, int] | None = None,
        wall: Callable[[], float] = time.time,
        patience_s: float | None = None,
    ) -> None:
        """Open the file, make it when there is none, migrate an older one. Raises LotStoreError.

        Args:
            path: The file.
            pragmas: SQLite's, set on every connection beside ours.
            wall: UTC, Unix seconds: SQL's ``hawk_now()``, by which a survey's time has been.
            patience_s: Real seconds to search for damage until it is open; a thread searches what is left of a large
                store, and logs what it finds. Meanwhile one survey or lot that is read is compared by itself
                (`check_whole`). None: all is searched.
        """
        self.path = path
        self.damage, self._migrated = "", ""
        self.damaged: tuple[Part, ...] = ()
        self.stale: frozenset[str] = frozenset()
        self._patience_s = patience_s
        self._search = DamageSearch()
        self.is_searched = threading.Event()
        self._is_closing = threading.Event()
        self._beside: threading.Thread | None = None
        self._pragmas = dict(pragmas or {})
        self._wall = wall
        with explained(path):
            version = self._version()
        self.is_read_only = version > VERSION
        self.notice = _newer(path, version) if self.is_read_only else ""
        self.has_left_wal, self.has_more_newest = False, not self.is_read_only
        self._file = self.path.stat().st_ino
        self._engine = self._open()
        if not self.is_read_only:
            with explained(path), self._engine.connect():
                pass  # the file is in WAL mode before somebody reads it
        self._readers = self._open_readers()
        self._opened, self._watch = secrets.token_hex(4), threading.Lock()
        self._watching: sqlite3.Connection | None = None
        try:
            if version < VERSION:
                self._migrate(version)
            if not self.is_read_only:
                self._find_damage()
        except BaseException:
            self.close()
            raise

    @contextlib.contextmanager
    def reading(self, is_over: Callable[[], bool] | None = None) -> Iterator[Connection]:
        """Give a connection within one consistent view; no garbage is collected meanwhile.

        Args:
            is_over: Asked again and again while SQLite works; True ends the read.

        Raises LotStoreError, and StoreBusyError for a read that was ended.
        """
        with uncollected(), explained(self.path), self._readers.connect() as connection:
            connection.info[_TAG] = self._tag()
            if not self.is_read_only:
                note_damaged(connection, self.damaged)
            with _ended(_raw(connection), is_over), connection.begin():
                yield connection

    @contextlib.contextmanager
    def writing(self) -> Iterator[Connection]:
        """Give a connection in a transaction: all of it is written, or nothing. Raises LotStoreError."""
        if self.is_read_only:
            raise LotStoreError(self.notice)
        with explained(self.path):
            stale = self.stale if self.is_searched.is_set() else frozenset()  # until then the search may find more
            with self._engine.connect() as connection, connection.begin():
                note_damaged(connection, self.damaged)
                digests.forget(raw := _raw(connection), stale)
                yield connection
                self.has_more_newest = last_surveys.renew(connection, digests.lots_of(raw, self.damaged))
                seal(raw, self.damaged)
            if stale:
                self.stale = frozenset()
                self._readers.dispose()  # those that are opened from now on see these rows
            self.put_into_file()

    @property
    def is_replaced(self) -> bool:
        """True when another file has the name of the one that is open."""
        try:
            return self.path.stat().st_ino != self._file
        except OSError:
            return True

    def close(self) -> None:
        """Close the file. SQLite removes the WAL when the last one that may write it goes: readers go before."""
        self._is_closing.set()
        if self._beside is not None:
            self._beside.join()
        self._readers.dispose()
        with self._watch:
            if self._watching is not None:
                self._watching.close()
                self._watching = None
        self._engine.dispose()

    def _version(self) -> int:
        """Return the version of a file that is whole; make the file first when there is none."""
        if not self.path.exists():
            if self.path.with_name(f"{self.path.name}-wal").exists():
                raise LotStoreError(f"{self.path} is missing beside its -wal. {_RESTORE}")
            make(self.path)
        return check(self.path, looks_at_pages=False)

    def _open(self) -> Engine:
        def connect() -> sqlite3.Connection:
            opened = read_only(self.path) if self.is_read_only else sqlite3.connect(self.path, timeout=BUSY_S)
            return self._prepared(opened, {} if self.is_read_only else _WRITTEN)

        engine = create_engine("sqlite://", creator=connect, poolclass=StaticPool)
        event.listen(engine, "begin", lambda connection: connection.exec_driver_sql("BEGIN IMMEDIATE"))
        return engine

    def _open_readers(self) -> Engine:
        """Make the connections that read: none waits for another one, or for the one that writes."""

        def connect() -> sqlite3.Connection:
            opened = self._prepared(read_only(self.path, check_same_thread=False), {})
            if self.damaged or self.stale:
                pass_over(opened, [*self.damaged, *(Part(digests.LAST, lot) for lot in self.stale)])
            return opened

        pool = {"pool_size": KEPT_READERS, "max_overflow": -1, "pool_use_lifo": True}
        engine = create_engine("sqlite://", creator=connect, poolclass=QueuePool, **pool)
        event.listen(engine, "begin", lambda connection: connection.exec_driver_sql("BEGIN"))
        return engine

    def _prepared(self, opened: sqlite3.Connection, pragmas: Mapping[str, int | str]) -> sqlite3.Connection:
        opened.isolation_level = None  # SQLAlchemy begins the transactions
        opened.create_function("hawk_now", 0, self._wall, deterministic=True)  # once a statement
        for name, value in {**_SAFE, **pragmas, **self._pragmas}.items():
            opened.execute(f"PRAGMA {name} = {value}")
        return opened

    def _find_damage(self) -> None:
        until = math.inf if self._patience_s is None else time.monotonic() + self._patience_s
        if not self._search_on(lambda: time.monotonic() >= until):
            self._beside = threading.Thread(target=self._search_beside, name="lots-search", daemon=True)
            self._beside.start()
        else:
            self.is_searched.set()

    def _search_beside(self) -> None:
        try:
            self._search_on(self._is_closing.is_set)
        except LotStoreError as error:
            self.notice, self.is_read_only = str(error), True
        if self.is_read_only or self.damage:
            _LOG.error("the store of lots: %s", self.notice)
        self.is_searched.set()

    def _search_on(self, is_over: Callable[[], bool]) -> bool:
        """Search for damage until all was read, which is True. Raises LotStoreError for a file that is damaged."""
        with explained(self.path), contextlib.closing(read_only(self.path)) as opened:
            opened.execute("BEGIN")
            is_done = self._search.go_on(opened, is_over)
            words = words_of(opened, found := tuple(sorted(self._search.found)))
        if self._search.faults:
            raise LotStoreError(f"{self.path} is damaged: {self._search.faults}. {_RESTORE}")
        if self._search.stale != self.stale:
            self.stale, self.has_more_newest = frozenset(self._search.stale), True
            self._readers.dispose()
        if found != self.damaged:
            self.notice = ". ".join(each for each in (self._migrated, f"{self.path}: {words}") if each)
            self.damage, self.damaged, self._opened = words, found, secrets.token_hex(4)
            self._readers.dispose()  # those that are opened from now on see nothing of it
        return is_done

    def _tag(self) -> str:
        """Return a text that differs after every change of the file, by any program, and between runs.

        One connection counts them for all readers (sqlite.org/pragma.html#pragma_data_version). It is asked before a
        reader's view begins: a change in between is in the view, and makes another tag for the next one.
        """
        with self._watch:
            watching = self._watching = self._watching or read_only(self.path, check_same_thread=False)
            return f"{self._opened}-{watching.execute('PRAGMA data_version').fetchone()[0]}"

    def _migrate(self, version: int) -> None:
        """Keep a copy of the file, and bring it to the newest version in one transaction."""
        kept = free_name(self.path, f"version-{version}")
        with explained(self.path):
            copy(self.path, kept)
        with self.writing() as connection:
            migrate(connection)
        self._migrated = f"{self.path} was of version {version} and is of version {VERSION} now; {kept} is a copy of it"
        self.notice = self._migrated

    def put_into_file(self) -> None:
        """Move what was committed from the WAL into the file: a WAL that is cut loses without an error.

        It waits for nobody: what a reader still needs stays in the WAL, and ``has_left_wal`` is True.
        """
        with contextlib.suppress(DBAPIError), self._engine.connect() as connection:
            cursor = _raw(connection).cursor()
            cursor.execute("PRAGMA busy_timeout = 0")
            self.has_left_wal = bool(cursor.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchone()[0])
            cursor.execute(f"PRAGMA busy_timeout = {_SAFE['busy_timeout']}")


@contextlib.contextmanager
def _ended(raw: sqlite3.Connection, is_over: Callable[[], bool] | None) -> Iterator[None]:
    """End what SQLite does on a connection once it is over."""
    if is_over is None:
        yield
        return
    raw.set_progress_handler(is_over, _STEPS)
    try:
        yield
    finally:
        raw.set_progress_handler(None, 0)


def _raw(connection: Connection) -> sqlite3.Connection:
    return cast("sqlite3.Connection", connection.connection.dbapi_connection)


_SAFE: Final[Mapping[str, int | str]] = {"foreign_keys": "ON", "trusted_schema": "OFF", "busy_timeout": 5000}
_WRITTEN: Final[Mapping[str, int | str]] = {"journal_mode": "WAL", "synchronous": "FULL"}


def read_only(path: Path, *, check_same_thread: bool = True) -> sqlite3.Connection:
    """Open a file that is there and never write it. Raises sqlite3.Error."""
    address = f"file:{quote(str(path.absolute()))}?mode=ro"
    return sqlite3.connect(address, uri=True, timeout=BUSY_S, check_same_thread=check_same_thread)


def _newer(path: Path, version: int) -> str:
    return (
        f"{path} is of version {version}, of a newer hawk-drone; this one knows version {VERSION}. It is only "
        f"read, and no survey is added. Install the newer hawk-drone again"
    )


def check(path: Path, remedy: str = _RESTORE, *, looks_at_pages: bool = True) -> int:
    """Return the version of a file that is whole, with the schema of a store of that version, as far as it is known.

    ``looks_at_pages``: all of the file is read; one of an earlier version is read in any case. Raises LotStoreError
    with the ``remedy``.
    """
    with explained(path):
        _check_ends(path)
        with contextlib.closing(read_only(path)) as opened:
            opened.execute("PRAGMA trusted_schema = OFF")
            if opened.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
                raise LotStoreError(f"{path} is no store of lots. Name another file: store.lots")
            version = int(opened.execute("PRAGMA user_version").fetchone()[0])
            if version <= VERSION:
                _check_schema(path, opened, version, remedy)
            if (looks_at_pages or version != VERSION) and (faults := faults_of(opened)):
                raise LotStoreError(f"{path} is damaged: {faults}. {remedy}")
            return version


def _check_schema(path: Path, opened: sqlite3.Connection, version: int, remedy: str) -> None:
    """Refuse a file with other tables, columns, indices or triggers than a store of its version has."""
    known = SCHEMA if version == VERSION else ""
    words = "it has no version" if version < 1 else difference(schema_of(opened), known, lambda: fresh_schema(version))
    if words:
        raise LotStoreError(f"{path} is damaged, or not made by this program: {words}. {remedy}")


@cache
def fresh_schema(version: int) -> Schema:
    """Return the schema of a fresh store of a version; all its migrations make it, once."""
    engine = create_engine("sqlite://", creator=lambda: sqlite3.connect(":memory:", isolation_level=None))
    try:
        with engine.begin() as connection:
            connection.exec_driver_sql("BEGIN")
            migrate(connection, f"{version:04d}")
            return schema_of(_raw(connection))
    finally:
        engine.dispose()


def _check_ends(path: Path) -> None:
    """Refuse a file that does not begin as SQLite's, or whose last page is cut: SQLite takes that for zeros."""
    with path.open("rb") as file:
        header = file.read(_HEADER_BYTES)
    if len(header) < _HEADER_BYTES or not header.startswith(_MAGIC):
        raise LotStoreError(f"{path} is damaged or no store of lots: it does not begin as one. {_RESTORE}")
    page = int.from_bytes(header[16:18], "big")
    wal = path.with_name(f"{path.name}-wal")
    if path.stat().st_size % (page if page > 1 else _LARGEST_PAGE) and not (wal.exists() and wal.stat().st_size):
        raise LotStoreError(f"{path} is damaged: its last page is cut. {_RESTORE}")


def make(path: Path, fill: Callable[[sqlite3.Connection], object] | None = None) -> None:
    """Make an empty store in the place of what is there. A program that is killed meanwhile leaves that.

    Args:
        path: The file.
        fill: Writes into it before it is there.

    Raises LotStoreError.
    """
    partial = path.with_name(f".{path.name}.new")
    with explained(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        partial.unlink(missing_ok=True)
        migrate_file(partial)
        if fill is not None:
            with contextlib.closing(sqlite3.connect(partial)) as made, made:
                fill(made)
        partial.replace(path)
        sync_folder(path.parent)


def migrate_file(path: Path, target: str = "head") -> None:
    """Bring a file that nobody has open to a revision; it is made when there is none. Raises DBAPIError."""
    engine = create_engine("sqlite://", creator=lambda: sqlite3.connect(path, isolation_level=None))
    try:
        with engine.begin() as connection:
            connection.exec_driver_sql("BEGIN")
            connection.exec_driver_sql(f"PRAGMA application_id = {APPLICATION_ID}")
            migrate(connection, target)
    finally:
        engine.dispose()


def migrate(connection: Connection, target: str = "head") -> None:
    """Bring the tables to a revision, within the transaction of the connection. What is damaged stays so.

    Digests are made again, but for steps that say by ``CHANGES_NO_ROW`` that they leave the rows that were there: then
    a store of thousands of lots is not read, and none of its surveys and lots gets a new state, which would be sent.
    """
    logging.getLogger("alembic").setLevel(logging.WARNING)  # a new store is no news to an operator
    scripts = script.ScriptDirectory(str(_REVISIONS), version_locations=[str(_REVISIONS)])

    store = _raw(connection)
    version = int(store.execute("PRAGMA user_version").fetchone()[0])
    missing = [*scripts.iterate_revisions(target, f"{version:04d}" if version else "base")][::-1]
    keeps_rows = all(getattr(each.module, "CHANGES_NO_ROW", False) for each in missing)
    damaged = damaged_parts(store) if version and not keeps_rows else ()

    def steps(*_: object) -> list[Any]:
        return [migration.MigrationStep.upgrade_from_script(scripts.revision_map, each) for each in missing]

    with environment.EnvironmentContext(config.Config(), scripts, fn=steps, destination_rev=target) as context:
        context.configure(connection=connection, transactional_ddl=True)
        context.run_migrations()
    if keeps_rows:
        seal(store)
    elif target in ("head", f"{VERSION:04d}"):
        seal_everything(store, damaged)


def copy(source: Path, target: Path) -> None:
    """Copy a store, also while it is written, as one file that is whole or not there. Raises OSError, sqlite3.Error."""
    partial = target.with_name(f".{target.name}.new")
    partial.unlink(missing_ok=True)
    try:
        with contextlib.closing(read_only(source)) as opened, contextlib.closing(sqlite3.connect(partial)) as made:
            opened.backup(made)
            made.execute("PRAGMA journal_mode = DELETE")
        partial.replace(target)
        sync_folder(target.parent)
    finally:
        partial.unlink(missing_ok=True)


def free_name(path: Path, suffix: str) -> Path:
    """Return the first of PATH.SUFFIX, PATH.SUFFIX-2 and so on that is not there."""
    number, named = 1, path.with_name(f"{path.name}.{suffix}")
    while named.exists():
        number += 1
        named = path.with_name(f"{path.name}.{suffix}-{number}")
    return named


@contextlib.contextmanager
def explained(path: Path) -> Iterator[None]:
    """Turn errors of disk and SQLite into LotStoreError with the file and the remedy."""
    try:
        yield
    except DBAPIError as error:
        raise _explained(path, error.orig) from error
    except (sqlite3.Error, OSError, UnicodeDecodeError) as error:  # SQLite's own words may repeat a damaged text
        raise _explained(path, error) from error


def _explained(path: Path, error: BaseException | None) -> LotStoreError:
    if getattr(error, "sqlite_errorname", "") == "SQLITE_INTERRUPT":
        return StoreBusyError(TOO_LONG)
    if getattr(error, "sqlite_errorname", "") == "SQLITE_FULL":
        return StoreFullError(_words(path, error))
    return LotStoreError(_words(path, error))


def _words(path: Path, error: BaseException | None) -> str:
    if isinstance(error, UnicodeDecodeError) or str(error).startswith(_DAMAGE):
        return f"{path} is damaged: {ascii(str(error))[1:80]}. {_RESTORE}"
    if isinstance(error, OSError):
        return f"{path}: {error.strerror or error}. Look at disk and rights of the folder"
    name = getattr(error, "sqlite_errorname", "") or ""
    for begin, words in _REASONS.items():
        if name.startswith(begin):
            return f"{path} {words}"
    return f"{path}: {error} ({name or type(error).__name__}). Look at disk and rights of the folder"


_DAMAGE: Final = ("Could not decode to UTF-8", "malformed", "no such table", "no such column")
"""Beginnings of what SQLite and its driver say of a file whose bytes are wrong."""
_REASONS: Final = {
    "SQLITE_FULL": "cannot grow: the disk is full, nothing of this was written. Make room",
    "SQLITE_CORRUPT": f"is damaged. {_RESTORE}",
    "SQLITE_NOTADB": f"is damaged or no store of lots. {_RESTORE}",
    "SQLITE_BUSY": (
        "cannot be locked: another program writes it, or it lies on a share without locks (SMB, NFS). Try again; put "
        "the store on a disk of this computer"
    ),
    "SQLITE_READONLY": "cannot be written. Give this user the right to write file and folder",
    "SQLITE_CANTOPEN": "cannot be opened. Give this user the right to read and write file and folder",
    "SQLITE_IOERR": "cannot be read or written: the disk reports an error. Check the disk",
}
"""Beginning of SQLite's name of an error (sqlite.org/rescode.html) -> words behind the file's name."""


def version_of(connection: Connection) -> str:
    """Return a text that differs after every change of the store, by this program or another one, and between runs.

    ``connection``: one that reads, or writes.
    """
    tag = connection.info.get(_TAG)
    if tag is not None:
        return str(tag)
    opened = connection.info.setdefault("opened", secrets.token_hex(4))
    others = connection.exec_driver_sql("PRAGMA data_version").scalar_one()
    return f"{opened}-{others}-{_raw(connection).total_changes}"
