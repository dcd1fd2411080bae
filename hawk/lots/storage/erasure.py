"""Rows of the lots' store that hold something of a survey or of a lot, and their removal.

Changes and messages repeat columns as text: those about what is erased go, too, and can be undone no more. Of each id
that is erased its SHA-256 stays, so that a backup that is restored does not bring it back.
"""

from __future__ import annotations

import contextlib
import hashlib
import re
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from hawk.lots.change_log import Group, packed, unpacked
from hawk.lots.names import chosen_survey
from hawk.lots.storage.damage_search import damaged_parts
from hawk.lots.storage.database import BUSY_S, explained, read_only
from hawk.lots.storage.digests import seal
from hawk.lots.values import LotStoreError, NotFoundError, Placed, journal_of

_LOT_TABLES: Final = ("former", "label", "zone", "section", "dropped", "pin", "plan", "share", "lot_document")
"""Tables whose column ``lot`` is the lot's id."""
_ID: Final = re.compile(r"[0-9a-f]{8}-[0-9a-f-]{27}")
_IN_USE: Final = "is used by another program: end it, and erase again"
_AGAIN: Final = (
    "The file may still hold bytes of rows that are erased: erase again. The answer that there is no such lot or "
    "survey is right then, and the bytes are gone"
)


@dataclass(frozen=True, slots=True)
class Found:
    """Rows to erase. ``surveys``: number, id and origin of each; ``lots``: ids, the lot that was named first."""

    surveys: tuple[tuple[int, str, str], ...]
    lots: tuple[str, ...] = ()

    @property
    def ids(self) -> tuple[str, ...]:
        """Ids of the surveys."""
        return tuple(survey for _, survey, _ in self.surveys)

    @property
    def journals(self) -> tuple[str, ...]:
        """Names of the surveys' journals, which their recordings name, too."""
        return tuple(dict.fromkeys(journal_of(origin) for *_, origin in self.surveys))


def found_survey(store: sqlite3.Connection, survey: str) -> Found:
    """Return the rows of a survey by its id, or by the beginning of it. Raises NotFoundError."""
    chosen = chosen_survey(store.execute("SELECT id, ended FROM survey ORDER BY ended, seq").fetchall(), survey)
    return Found(tuple(store.execute("SELECT seq, id, origin FROM survey WHERE id = ?", (chosen,))))


def found_lot(store: sqlite3.Connection, lot: str) -> Found:
    """Return the rows of a lot by its id or name, with those that were merged into it, and deleted surveys.

    Raises NotFoundError, and LotStoreError for a name of many lots and for a lot that was merged into another one.
    """
    lots = _with_merged(store, _lot_of(store, lot))
    surveys = [row for each in lots for row in _surveys(store, each)]
    return Found((*surveys, *_deleted_surveys(store, lots)), tuple(lots))


def erase_rows(store: sqlite3.Connection, found: Found) -> None:
    """Remove the rows, and note their ids. Of a survey without its lot the stalls that it found stay: the lot's."""
    damaged = damaged_parts(store)
    note_erased(store, map(erased_id, (*found.ids, *found.lots)))
    _erase_surveys(store, found)
    rows: dict[str, set[int]] = {}
    texts = [*found.lots]
    for table in ("stall", "section"):
        asked = f"SELECT key, id FROM {table} WHERE lot = ?"  # noqa: S608 - our own words
        named = [row for each in found.lots for row in store.execute(asked, (each,))]
        rows[table] = {key for key, _ in named}
        texts += [each for _, each in named]
    _forget(store, rows, texts)
    for each in found.lots:
        _erase_ground(store, each)
    for each in found.lots[::-1]:
        store.execute("DELETE FROM lot WHERE id = ?", (each,))
    seal(store, damaged)


def erased_id(given: str) -> str:
    """Return what is kept of an id that is erased."""
    return hashlib.sha256(given.encode()).hexdigest()


def note_erased(store: sqlite3.Connection, erased: Iterable[str]) -> None:
    """Keep in a store what was erased, as of `erased_id`."""
    store.executemany("INSERT INTO erased (id) VALUES (?) ON CONFLICT DO NOTHING", [(each,) for each in erased])


def all_erased(store: sqlite3.Connection) -> set[str]:
    """Return what a store says of erasures, as of `erased_id`."""
    return {str(each) for (each,) in store.execute("SELECT id FROM erased")}


def erase_again(store: sqlite3.Connection) -> Found:
    """Remove what the store itself says was erased, and return it.

    A survey that was not erased, but is of a lot that was, waits for a person to say which lot it is of.
    """
    erased = all_erased(store)
    surveys = store.execute("SELECT seq, id, origin FROM survey").fetchall()
    lots = [each for (each,) in store.execute("SELECT id FROM lot") if erased_id(each) in erased]
    found = Found(tuple(row for row in surveys if erased_id(row[1]) in erased), tuple(lots))
    if found.surveys or found.lots:
        for each in found.lots:
            store.execute("UPDATE lot SET merged_into = NULL WHERE merged_into = ?1 OR id = ?1", (each,))
        erase_rows(store, found)
    return found


def _lot_of(store: sqlite3.Connection, lot: str) -> str:
    rows = store.execute("SELECT id, name, merged_into FROM lot WHERE id = ?1 OR name = ?1", (lot,)).fetchall()
    shown = [row for row in rows if row[2] is None] or rows
    if not shown:
        names = store.execute("SELECT name FROM lot WHERE merged_into IS NULL ORDER BY name")
        raise NotFoundError(f"--lot: there is no lot {lot!r}; there are: {', '.join(n for (n,) in names) or 'none'}")
    if len(shown) > 1:
        known = ", ".join(found for found, *_ in shown)
        raise LotStoreError(f"--lot: {len(shown)} lots are called {lot!r}: give the id of one ({known})")
    found, name, into = shown[0]
    if into is None:
        return str(found)
    while into is not None:
        found, name, into = store.execute("SELECT id, name, merged_into FROM lot WHERE id = ?", (into,)).fetchone()
    raise LotStoreError(f"--lot: {lot!r} was merged into {name!r}, which has its surveys: give that one ({found})")


def _with_merged(store: sqlite3.Connection, lot: str) -> list[str]:
    """Return a lot and those that were merged into it, the lot first."""
    found = [lot]
    for each in found:
        found += [one for (one,) in store.execute("SELECT id FROM lot WHERE merged_into = ?", (each,))]
    return found


def _surveys(store: sqlite3.Connection, lot: str) -> list[tuple[int, str, str]]:
    return store.execute("SELECT seq, id, origin FROM survey WHERE lot = ?", (lot,)).fetchall()


def _deleted_surveys(store: sqlite3.Connection, lots: Iterable[str]) -> list[tuple[int, str, str]]:
    """Return the surveys that persons deleted in some lots: their rows name no lot, but the changes still do.

    One whose change is gone goes, too: nobody can bring it back, and it may be of these lots.
    """
    homes: dict[int, str | None] = {}
    for (body,) in store.execute("SELECT body FROM change WHERE kind = 'delete' ORDER BY seq"):
        of_surveys = (group for group in _groups(body) or () if group.table == "survey")
        homes |= {seq: (group.before or {}).get("lot") for group in of_surveys for (seq,) in group.keys}
    gone = store.execute(
        "SELECT seq, id, origin FROM survey WHERE lot IS NULL AND placed = ?", (Placed.DELETED.value,)
    ).fetchall()
    wanted = {*lots, None}
    return [row for row in gone if homes.get(row[0]) in wanted]


def _erase_ground(store: sqlite3.Connection, lot: str) -> None:
    store.execute("DELETE FROM change WHERE lot = ?", (lot,))
    store.execute("DELETE FROM edit WHERE lot = ?", (lot,))
    stalls = "SELECT key FROM stall WHERE lot = ?"
    for table in ("observation", "former"):
        store.execute(f"DELETE FROM {table} WHERE stall IN ({stalls})", (lot,))  # noqa: S608 - our own words
    store.execute("DELETE FROM section_look WHERE section IN (SELECT id FROM section WHERE lot = ?)", (lot,))
    for table in _LOT_TABLES:
        store.execute(f"DELETE FROM {table} WHERE lot = ?", (lot,))  # noqa: S608 - our own words
    store.execute("DELETE FROM stall WHERE lot = ?", (lot,))
    store.execute("DELETE FROM layout WHERE lot = ?", (lot,))
    homeless = "lot = NULL, layout = NULL, north = NULL, east = NULL, turn = NULL, doubt = NULL, candidates = '[]'"
    waits = (Placed.UNDECIDED.value, lot)
    store.execute(f"UPDATE survey SET {homeless}, placed = ? WHERE lot = ?", waits)  # noqa: S608 - our own words


def _erase_surveys(store: sqlite3.Connection, found: Found) -> None:
    for seq, _, _ in found.surveys:
        store.execute("UPDATE stall SET first_survey = NULL, first_id = NULL WHERE first_survey = ?", (seq,))
        for table in ("observation", "looks", "dropped", "section_look", "document"):
            store.execute(f"DELETE FROM {table} WHERE survey = ?", (seq,))  # noqa: S608 - our own words
        store.execute("DELETE FROM survey WHERE seq = ?", (seq,))
    numbers = {seq for seq, _, _ in found.surveys}
    texts = [text for _, survey, origin in found.surveys for text in (survey, origin)]
    _forget(store, {"survey": numbers, "observation": numbers, "dropped": numbers}, texts)


def _forget(store: sqlite3.Connection, rows: Mapping[str, set[int]], texts: Sequence[str]) -> None:
    """Remove changes and messages that hold one of some texts, and changes of some ``rows``: numbers by their table.

    A change that only repeats observations of what is erased stays without these: it says which paint a lot has.
    """
    for seq, body in store.execute("SELECT seq, body FROM outbox").fetchall():
        if any(text in body for text in texts):
            store.execute("DELETE FROM outbox WHERE seq = ?", (seq,))
    _forget_arrivals(store, frozenset(texts))
    for seq, body in store.execute("SELECT seq, body FROM change").fetchall():
        groups = _groups(body)
        gone = [group for group in groups or () if _is_of(group, rows)]
        is_about = groups is None or any(group.table != "observation" for group in gone)
        if is_about or any(text in body for text in texts):
            store.execute("DELETE FROM change WHERE seq = ?", (seq,))
        elif gone:
            kept = packed(group for group in groups or () if group not in gone)
            store.execute("UPDATE change SET body = ? WHERE seq = ?", (kept, seq))


def _forget_arrivals(store: sqlite3.Connection, texts: frozenset[str]) -> None:
    """Remove arrivals that are about one of some texts, or whose reason names one of these ids."""
    for seq, name, lot, reason in store.execute("SELECT seq, name, lot, reason FROM arrival").fetchall():
        if not texts.isdisjoint((name, lot, *_ID.findall(reason))):
            store.execute("DELETE FROM arrival WHERE seq = ?", (seq,))


def _groups(body: str) -> tuple[Group, ...] | None:
    """Return what a change holds; None for a damaged one."""
    try:
        return unpacked(body)
    except (ValueError, KeyError, TypeError):
        return None


def _is_of(group: Group, rows: Mapping[str, set[int]]) -> bool:
    """Return whether a group is of some rows: by the first column of their keys, or by their survey."""
    wanted = rows.get(group.table, set())
    survey = (group.after or group.before or {}).get("survey")
    return survey in wanted or any(key[0] in wanted for key in group.keys)


@contextlib.contextmanager
def emptied(path: Path) -> Iterator[sqlite3.Connection]:
    """Give the store in a transaction; write the file again at its end, so that nothing of removed rows is left.

    No other program may have the file open: what a reader sees could not be removed. Raises LotStoreError.
    """
    with explained(path), _alone(path) as store:
        try:
            yield store
            store.execute("COMMIT")
        except BaseException as error:
            if store.in_transaction:  # SQLite itself rolls back where the disk fails
                store.execute("ROLLBACK")
            if isinstance(error, NotFoundError):  # a try before may have ended between its rows and the file
                _write_again(store, path)
            raise
        _write_again(store, path)


def counted(path: Path) -> int:
    """Return the number of surveys, 0 where the file cannot be read. Raises LotStoreError while others use it."""
    try:
        with _alone(path) as store:
            return int(store.execute("SELECT count(*) FROM survey").fetchone()[0])
    except sqlite3.Error:
        return 0


def ids_in(path: Path) -> set[str]:
    """Return what is to be kept of every id in a store, and of earlier erasures; none where it cannot be read."""
    try:
        with contextlib.closing(read_only(path)) as store:
            ids = [each for table in ("survey", "lot") for (each,) in store.execute(f"SELECT id FROM {table}")]  # noqa: S608
            return {erased_id(str(each)) for each in ids} | all_erased(store)
    except (sqlite3.Error, UnicodeError):
        return set()


@contextlib.contextmanager
def _alone(path: Path) -> Iterator[sqlite3.Connection]:
    """Give the store in a transaction, with all others kept away until it is closed. Raises LotStoreError."""
    with contextlib.closing(sqlite3.connect(path, timeout=BUSY_S, isolation_level=None)) as store:
        try:
            for pragma in ("locking_mode = EXCLUSIVE", "trusted_schema = OFF", "foreign_keys = ON"):
                store.execute(f"PRAGMA {pragma}")
            store.execute("PRAGMA secure_delete = ON")
            store.execute("BEGIN EXCLUSIVE")
        except sqlite3.OperationalError as error:
            if (error.sqlite_errorname or "").startswith("SQLITE_BUSY"):
                raise LotStoreError(f"{path} {_IN_USE}") from error
            raise
        yield store


def _write_again(store: sqlite3.Connection, path: Path) -> None:
    """Write the file without its free pages, and empty the WAL. Raises LotStoreError where bytes may be left."""
    try:
        with explained(path):
            store.execute("VACUUM")
            is_busy = store.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchone()[0]
    except LotStoreError as error:
        raise LotStoreError(f"{error}. {_AGAIN}") from error
    if is_busy:
        raise LotStoreError(f"{path} {_IN_USE}. {_AGAIN}")
