"""The journal of an inbox: which flight each picture is of, and how far that flight is.

It lies beside the store of lots, not in the folder that others fill and clean. Every step is written before it is done:
a file is moved by the journal's row, so that an end at any moment leaves nothing that the next start does not find. A
picture is known by its digest for ever, also after a person has deleted its file.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Final, Self

from hawk.picture.inbox.flights import JOIN_S, Moment, Part

FILE: Final = "inbox.db"
"""Name of the journal in the folder of the store."""
PICTURES: Final = "pictures"
AGAIN: Final = "again"
"""Folders of a flight: for its pictures, and for copies of pictures that it has."""
_VERSION: Final = 1
_SCHEMA: Final = """
CREATE TABLE flight (
  id TEXT PRIMARY KEY, name TEXT NOT NULL, state TEXT NOT NULL, source TEXT NOT NULL, latitude REAL, longitude REAL,
  survey TEXT, known_as TEXT, parts INTEGER NOT NULL DEFAULT 1, tries INTEGER NOT NULL DEFAULT 0
);
CREATE INDEX flight_state ON flight (state);
CREATE TABLE picture (
  digest TEXT PRIMARY KEY, flight TEXT NOT NULL REFERENCES flight ON DELETE CASCADE, is_mapped INTEGER NOT NULL,
  kind TEXT, time REAL, latitude REAL, longitude REAL
);
CREATE INDEX picture_flight ON picture (flight);
CREATE INDEX picture_time ON picture (kind, time);
CREATE TABLE move (
  flight TEXT NOT NULL REFERENCES flight ON DELETE CASCADE, source BLOB NOT NULL, target TEXT NOT NULL, digest TEXT
);
CREATE INDEX move_flight ON move (flight);
"""


class State(StrEnum):
    """State of a flight."""

    MAPPING = "mapping"
    DONE = "done"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class Flight:
    """A flight. ``name``: of its folder. ``datum``: latitude and longitude of its first part's middle.

    ``source``: name of the film or orthophoto, "" for photographs. ``survey``: id in the store, "" before it is mapped.
    ``known_as``: name of the flight that has the same pictures, "" for one that is mapped. ``parts``: drops that it
    came in. ``tries``: how often its mapping ended by a signal.
    """

    id: str
    name: str
    state: State
    source: str
    datum: tuple[float, float] | None
    survey: str
    known_as: str
    parts: int
    tries: int


@dataclass(frozen=True, slots=True)
class Move:
    """A file that is to be moved from the inbox into a folder of the flight. ``digest``: None for no new picture."""

    source: str
    target: str
    digest: str | None


class Journal:
    """Reads and writes the journal. Each call is one transaction. All raise sqlite3.Error."""

    def __init__(self, store: Path) -> None:
        """Open the journal of a store's folder, which is made."""
        self._base = sqlite3.connect(store / FILE, isolation_level=None)
        self._base.execute("PRAGMA foreign_keys = ON")
        self._base.execute("PRAGMA synchronous = FULL")
        version = self._base.execute("PRAGMA user_version").fetchone()[0]
        if version == 0:
            self._base.executescript(f"BEGIN; {_SCHEMA} PRAGMA user_version = {_VERSION}; COMMIT;")
        elif version != _VERSION:
            raise sqlite3.DatabaseError(f"is of form {version}, written by another version of hawk: use that version")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._base.close()

    # -- what is known ------------------------------------------------------------------------------------------------

    def flight(self, flight: str) -> Flight | None:
        """Return the flight of an id."""
        return next(self._flights("id = ?", flight), None)

    def unfinished(self) -> list[Flight]:
        """Return the flights that are to be mapped, in the order in which they came."""
        return list(self._flights("state = ? ORDER BY rowid", State.MAPPING))

    def names(self) -> set[str]:
        """Return the names of unfinished flights: others are folders that are there."""
        return {flight.name for flight in self.unfinished()}

    def owners(self, digests: Iterable[str]) -> dict[str, str]:
        """Return the flight of each picture that is known, by digest."""
        found = {}
        for digest in digests:
            row = self._base.execute("SELECT flight FROM picture WHERE digest = ?", (digest,)).fetchone()
            if row is not None:
                found[digest] = str(row[0])
        return found

    def near(self, moments: Sequence[Moment]) -> dict[str, list[Moment]]:
        """Return the photographs about the time of others by the same camera, by flight."""
        found: dict[str, list[Moment]] = {}
        asked = "SELECT flight, kind, time, latitude, longitude FROM picture WHERE kind = ? AND time BETWEEN ? AND ?"
        for kind in dict.fromkeys(one.kind for one in moments):
            times = [one.time for one in moments if one.kind == kind]
            span = (kind, min(times) - JOIN_S, max(times) + JOIN_S)
            for flight, *moment in self._base.execute(asked, span):
                found.setdefault(flight, []).append(Moment(*moment))
        return found

    def is_mapped(self, flight: Flight) -> bool:
        """Return whether the survey in the store has all pictures of a flight."""
        asked = "SELECT 1 FROM picture WHERE flight = ? AND NOT is_mapped LIMIT 1"
        return bool(flight.survey) and self._base.execute(asked, (flight.id,)).fetchone() is None

    def count(self, flight: Flight) -> int:
        """Return the number of pictures of a flight."""
        asked = "SELECT count(*) FROM picture WHERE flight = ?"
        return int(self._base.execute(asked, (flight.id,)).fetchone()[0])

    def moves(self, flight: Flight) -> list[Move]:
        """Return the files that are still to be moved, or were moved last."""
        rows = self._base.execute("SELECT source, target, digest FROM move WHERE flight = ?", (flight.id,))
        return [Move(os.fsdecode(source), target, digest) for source, target, digest in rows]

    def _flights(self, where: str, *values: object) -> Iterator[Flight]:
        columns = (
            "id, name, state, source, latitude, longitude, coalesce(survey, ''), coalesce(known_as, ''), parts, tries"
        )
        for row in self._base.execute(f"SELECT {columns} FROM flight WHERE {where}", values).fetchall():  # noqa: S608
            number, name, state, source, latitude, longitude, *rest = row
            datum = None if latitude is None else (latitude, longitude)
            yield Flight(number, name, State(state), source, datum, *rest)

    # -- what changes -------------------------------------------------------------------------------------------------

    def add(self, part: Part, name: str, moves: Sequence[Move]) -> None:
        """Add a flight, whose pictures are of no other one from now on."""
        source = next((Path(move.target).name for move in moves if Path(move.source).name == part.source), "")
        with self._writing():
            latitude, longitude = part.datum or (None, None)
            self._base.execute("DELETE FROM flight WHERE id = ?", (part.id,))
            self._base.execute(
                "INSERT INTO flight (id, name, state, source, latitude, longitude) VALUES (?, ?, ?, ?, ?, ?)",
                (part.id, name, State.MAPPING, source, latitude, longitude),
            )
            self._take(part.id, part, moves)

    def add_copy(self, copy: str, name: str, of: Flight, moves: Sequence[Move]) -> None:
        """Add files whose pictures a flight has all: they are moved, and nothing is mapped. ``copy``: id."""
        with self._writing():
            self._base.execute(
                "INSERT INTO flight (id, name, state, source, survey, known_as) VALUES (?, ?, ?, '', ?, ?)",
                (copy, name, State.MAPPING, of.survey, of.name),
            )
            self._plan(copy, moves)

    def join(self, flight: Flight, part: Part, moves: Sequence[Move], *, has_others: bool) -> None:
        """Add a part to a flight, which is to be mapped again. ``has_others``: its other pictures are there."""
        with self._writing():
            if not has_others:
                self._base.execute("DELETE FROM picture WHERE flight = ?", (flight.id,))
            self._set(flight, state=State.MAPPING, parts=flight.parts + 1)
            self._take(flight.id, part, moves)

    def map_again(self, flight: Flight) -> None:
        """Have a flight mapped whose survey is no longer in the store."""
        with self._writing():
            self._set(flight, state=State.MAPPING, survey=None)
            self._base.execute("UPDATE picture SET is_mapped = 0 WHERE flight = ?", (flight.id,))

    def end_moves(self, flight: Flight, vanished: Iterable[str] = ()) -> None:
        """Note that the files were moved. ``vanished``: digests of pictures that were taken away before."""
        with self._writing():
            self._base.execute("DELETE FROM move WHERE flight = ?", (flight.id,))
            self._base.executemany(
                "DELETE FROM picture WHERE digest = ? AND flight = ?", [(each, flight.id) for each in vanished]
            )

    def note_survey(self, flight: Flight, survey: str) -> None:
        """Note that the store has the survey of all pictures of a flight."""
        with self._writing():
            self._set(flight, survey=survey, tries=0)
            self._base.execute("UPDATE picture SET is_mapped = 1 WHERE flight = ?", (flight.id,))

    def note_try(self, flight: Flight) -> None:
        """Note that the mapping of a flight ended by a signal."""
        with self._writing():
            self._set(flight, tries=flight.tries + 1)

    def end(self, flight: Flight, state: State, name: str) -> None:
        """Note that a flight is done or failed, in a folder of this name. A copy is forgotten: it has no pictures."""
        with self._writing():
            if flight.known_as:
                self._base.execute("DELETE FROM flight WHERE id = ?", (flight.id,))
            else:
                self._set(flight, state=state, name=name, tries=0)

    def forget(self, flight: Flight) -> None:
        """Forget a flight of which nothing is left."""
        with self._writing():
            self._base.execute("DELETE FROM flight WHERE id = ?", (flight.id,))

    @contextmanager
    def _writing(self) -> Iterator[None]:
        self._base.execute("BEGIN IMMEDIATE")
        try:
            yield
        except BaseException:
            if self._base.in_transaction:  # a full disk has ended it
                self._base.execute("ROLLBACK")
            raise
        self._base.execute("COMMIT")

    def _set(self, flight: Flight, **values: object) -> None:
        columns = ", ".join(f"{name} = ?" for name in values)
        self._base.execute(f"UPDATE flight SET {columns} WHERE id = ?", (*values.values(), flight.id))  # noqa: S608

    def _take(self, flight: str, part: Part, moves: Sequence[Move]) -> None:
        """Note the pictures of a part as a flight's, but those that are no more than copies of its own."""
        self._plan(flight, moves)
        new = {move.digest for move in moves if move.digest is not None}
        rows = []
        for one in part.pictures:
            if one.digest in new:
                moment = one.moment
                of = (None,) * 4 if moment is None else (moment.kind, moment.time, moment.latitude, moment.longitude)
                rows.append((one.digest, flight, *of))
        self._base.executemany("INSERT OR REPLACE INTO picture VALUES (?, ?, 0, ?, ?, ?, ?)", rows)

    def _plan(self, flight: str, moves: Sequence[Move]) -> None:
        rows = [(flight, os.fsencode(move.source), move.target, move.digest) for move in moves]
        self._base.executemany("INSERT INTO move VALUES (?, ?, ?, ?)", rows)
