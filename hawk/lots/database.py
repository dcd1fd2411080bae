"""The file of the lots' store: SQLite in WAL mode, opened, checked, migrated, and read or written in transactions.

Everything here blocks on the disk and belongs to one thread. A file that is damaged or of a newer version is never
written; before a migration a copy of the file is kept beside it.
"""

from __future__ import annotations

import contextlib
import secrets
import sqlite3
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final
from urllib.parse import quote

from sqlalchemy import Connection, Engine, create_engine, event
from sqlalchemy.exc import DBAPIError
from sqlalchemy.pool import StaticPool

from hawk.lots.tables import APPLICATION_ID, VERSION
from hawk.lots.values import LotStoreError
from hawk.runtime.files import sync_folder
from hawk.runtime.garbage import uncollected

BUSY_S: Final = 5.0
"""Real seconds to wait for another program that writes the file."""
_MAGIC: Final = b"SQLite format 3\0"
_HEADER_BYTES: Final = 100
_LARGEST_PAGE: Final = 65_536
"""The header's page size is 1 for it (sqlite.org/fileformat.html)."""
_REVISIONS: Final = Path(__file__).parent / "revisions"
_RESTORE: Final = "Nothing was written. Restore a backup: hawk-drone restore FILE"


class Database:
    """An open store. ``is_read_only``: it is of a newer version, named in ``notice``."""

    def __init__(self, path: Path, pragmas: Mapping[str, int] | None = None) -> None:
        """Open the file, make it when there is none, migrate an older one. Raises LotStoreError.

        Args:
            path: The file.
            pragmas: SQLite's, set on every connection beside ours.
        """
        self.path = path
        self.notice = ""
        self._pragmas = dict(pragmas or {})
        with explained(path):
            version = self._version()
        self.is_read_only = version > VERSION
        if self.is_read_only:
            self.notice = (
                f"{path} is of version {version}, of a newer hawk-drone; this one knows version {VERSION}. It is only "
                f"read, and no survey is added. Install the newer hawk-drone again"
            )
        self._file = self.path.stat().st_ino
        self._engine = self._open()
        if version < VERSION:
            try:
                self._migrate(version)
            except BaseException:
                self.close()
                raise

    @contextlib.contextmanager
    def reading(self) -> Iterator[Connection]:
        """Give a connection within one consistent view; no garbage is collected meanwhile. Raises LotStoreError."""
        with uncollected(), explained(self.path), self._engine.connect() as connection, connection.begin():
            yield connection

    @contextlib.contextmanager
    def writing(self) -> Iterator[Connection]:
        """Give a connection in a transaction: all of it is written, or nothing. Raises LotStoreError."""
        if self.is_read_only:
            raise LotStoreError(self.notice)
        with explained(self.path):
            with self._engine.connect() as connection, connection.begin():
                yield connection
            self._put_into_file()

    @property
    def is_replaced(self) -> bool:
        """True when another file has the name of the one that is open."""
        try:
            return self.path.stat().st_ino != self._file
        except OSError:
            return True

    def close(self) -> None:
        """Close the file."""
        self._engine.dispose()

    def _version(self) -> int:
        """Return the version of a file that is whole; make the file first when there is none."""
        if not self.path.exists():
            if self.path.with_name(f"{self.path.name}-wal").exists():
                raise LotStoreError(f"{self.path} is missing beside its -wal. {_RESTORE}")
            make(self.path)
        return check(self.path)

    def _open(self) -> Engine:
        def connect() -> sqlite3.Connection:
            opened = read_only(self.path) if self.is_read_only else sqlite3.connect(self.path, timeout=BUSY_S)
            opened.isolation_level = None  # SQLAlchemy begins the transactions
            for name, value in {**_SAFE, **({} if self.is_read_only else _WRITTEN), **self._pragmas}.items():
                opened.execute(f"PRAGMA {name} = {value}")
            return opened

        begin = "BEGIN" if self.is_read_only else "BEGIN IMMEDIATE"
        engine = create_engine("sqlite://", creator=connect, poolclass=StaticPool)
        event.listen(engine, "begin", lambda connection: connection.exec_driver_sql(begin))
        return engine

    def _migrate(self, version: int) -> None:
        """Keep a copy of the file, and bring it to the newest version in one transaction."""
        kept = free_name(self.path, f"version-{version}")
        with explained(self.path):
            copy(self.path, kept)
        with self.writing() as connection:
            migrate(connection)
        self.notice = f"{self.path} was of version {version} and is of version {VERSION} now; {kept} is a copy of it"

    def _put_into_file(self) -> None:
        """Move what was committed from the WAL into the file: a WAL that is cut loses without an error."""
        with contextlib.suppress(DBAPIError), self._engine.connect() as connection:
            raw = connection.connection.dbapi_connection
            assert raw is not None  # noqa: S101 - it is connected
            raw.cursor().execute("PRAGMA wal_checkpoint(TRUNCATE)")


_SAFE: Final[Mapping[str, int | str]] = {"foreign_keys": "ON", "trusted_schema": "OFF", "busy_timeout": 5000}
_WRITTEN: Final[Mapping[str, int | str]] = {"journal_mode": "WAL", "synchronous": "FULL"}


def read_only(path: Path) -> sqlite3.Connection:
    """Open a file that is there and never write it. Raises sqlite3.Error."""
    return sqlite3.connect(f"file:{quote(str(path.absolute()))}?mode=ro", uri=True, timeout=BUSY_S)


def check(path: Path) -> int:
    """Return the version of a file, after `PRAGMA quick_check`. Raises LotStoreError for one that is damaged."""
    with explained(path):
        _check_ends(path)
        with contextlib.closing(read_only(path)) as opened:
            found = opened.execute("PRAGMA quick_check(3)").fetchall()
            if found != [("ok",)]:
                words = "; ".join(" ".join(str(row[0]).split()) for row in found)
                raise LotStoreError(f"{path} is damaged: {words}. {_RESTORE}")
            if opened.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
                raise LotStoreError(f"{path} is no store of lots. Name another file: store.lots")
            return int(opened.execute("PRAGMA user_version").fetchone()[0])


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


def make(path: Path) -> None:
    """Make an empty store. A program that is killed meanwhile leaves none. Raises LotStoreError."""
    partial = path.with_name(f".{path.name}.new")
    with explained(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        partial.unlink(missing_ok=True)
        migrate_file(partial)
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
    """Bring the tables to a revision, within the transaction of the connection."""
    from alembic.config import Config  # half of the time to load this module, seldom needed
    from alembic.runtime.environment import EnvironmentContext
    from alembic.runtime.migration import MigrationStep
    from alembic.script import ScriptDirectory

    scripts = ScriptDirectory(str(_REVISIONS), version_locations=[str(_REVISIONS)])

    def steps(revision: Any, _: object) -> list[Any]:
        missing = reversed(list(scripts.iterate_revisions(target, revision or "base")))
        return [MigrationStep.upgrade_from_script(scripts.revision_map, script) for script in missing]

    with EnvironmentContext(Config(), scripts, fn=steps, destination_rev=target) as context:
        context.configure(connection=connection, transactional_ddl=True)
        context.run_migrations()


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
        raise LotStoreError(_words(path, error.orig)) from error
    except (sqlite3.Error, OSError, UnicodeDecodeError) as error:  # a damaged text in SQLite's own words
        raise LotStoreError(_words(path, error)) from error


def _words(path: Path, error: BaseException | None) -> str:
    if isinstance(error, OSError):
        return f"{path}: {error.strerror or error}. Look at disk and rights of the folder"
    name = getattr(error, "sqlite_errorname", "") or ""
    for begin, words in _REASONS.items():
        if name.startswith(begin):
            return f"{path} {words}"
    return f"{path}: {error} ({name or type(error).__name__}). Look at disk and rights of the folder"


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

    SQLite counts the changes of a connection, and those of other ones (sqlite.org/pragma.html#pragma_data_version).
    """
    opened = connection.info.setdefault("opened", secrets.token_hex(4))
    others = connection.exec_driver_sql("PRAGMA data_version").scalar_one()
    raw = connection.connection.dbapi_connection
    assert raw is not None  # noqa: S101 - it is connected
    return f"{opened}-{others}-{raw.total_changes}"
