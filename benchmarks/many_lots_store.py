"""A store of many lots, written in bulk: one drawn lot goes through the product's writer, SQLite copies its rows.

The copies have their own ids, places and numbers, as if the lots were surveyed in turn: the first surveys of all lots,
then the second ones. Triggers and the index of the looks at a stall are made again behind the rows; what the triggers
note is written, too: the looks in one piece, digests, states, newest surveys.
"""

from __future__ import annotations

import re
import sqlite3
import tempfile
import uuid
from collections.abc import Callable
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np

from benchmarks import archive_calls
from benchmarks.archive import BIAS, drawn_lot, flight
from hawk.daemon.lots.keeper import find_stalls
from hawk.lots.ingest import save
from hawk.lots.registration.frames import Move
from hawk.lots.registration.georeference import about, ring_on_earth
from hawk.lots.storage.database import Database, make
from hawk.lots.storage.digests import Part, digest_of, selections
from hawk.lots.storage.outlines import outline_json, outline_of, pack_outline, unpack_outline
from hawk.lots.storage.schema import METADATA, PARTS
from hawk.model.plans import Outline

FLOWN_OFTEN: Final = 102
"""Surveys of a lot from which on they are written into the tables, without a registration."""
_FAST: Final = {"synchronous": 0}
_SURVEYED: Final = {
    "lot": 1,
    "layout": 1,
    "plan": 1,
    "survey": 1,
    "stall": 1,
    "observation": 2,
    "looks": 1,
    "outbox": 1,
    "last_survey": 1,
}
"""Tables that are copied, in the order of their references. 2: survey by survey, so that no row is sorted."""
_SURVEYS: Final = (
    ("survey", "seq"), ("observation", "survey"), ("looks", "survey"), ("stall", "first_survey"),
    ("last_survey", "survey"),
)  # fmt: skip
_STALLS: Final = (("stall", "key"), ("observation", "stall"))
_LOTS_A_ROW: Final = 100
_APART_DEG: Final = 0.01
"""Some 700 m: the product asks which lot it is where a neighbour is near."""
_LOOK: Final = np.dtype([("stall", "<u4"), ("rest", "V3")])
"""As `hawk.lots.survey.observations.pack_looks` writes it."""
_ID: Final = re.compile(r"[0-9a-f]{8}(?:-[0-9a-f]{4}){3}-[0-9a-f]{12}")
_AT_ONCE: Final = 20_000
_MADE_AGAIN: Final = "type = 'trigger' OR name = 'ix_observation_stall'"


def fill(path: Path, lots: int, surveys: int, size: int) -> None:
    """Make a store of many lots of ``size`` stalls with N surveys each."""
    with tempfile.TemporaryDirectory(prefix="hawk-drawn-lot-") as folder:
        drawn = Path(folder) / "drawn.db"
        draw(drawn, surveys, size)
        copy_lots(drawn, path, lots)


def draw(path: Path, surveys: int, size: int) -> None:
    """Make a store of one lot with its surveys by the product's writer, or into its tables where they are many."""
    rng = np.random.default_rng(1)
    stalls = drawn_lot(size, rng)
    with closing(Database(path, _FAST)) as store:
        if surveys >= FLOWN_OFTEN:
            archive_calls.fill(store, flight(1, stalls, Move(), rng), surveys - 1)
        for number in range(surveys if surveys < FLOWN_OFTEN else 0):
            with store.writing() as connection:
                save(connection, flight(number + 1, stalls, BIAS if number else Move(), rng), find_stalls)


def copy_lots(drawn: Path, path: Path, lots: int) -> None:
    """Make a store of N lots, the first one that of the store ``drawn``, the others as it is."""
    make(path)
    with closing(sqlite3.connect(path, isolation_level=None)) as store:
        for name, value in {"journal_mode": "OFF", "synchronous": "OFF", "cache_size": -1_000_000}.items():
            store.execute(f"PRAGMA {name} = {value}")
        store.execute("ATTACH ? AS drawn", (str(drawn),))
        again = store.execute(f"SELECT type, name, sql FROM main.sqlite_master WHERE {_MADE_AGAIN}").fetchall()  # noqa: S608
        store.execute("BEGIN")
        for kind, name, _ in again:
            store.execute(f"DROP {kind} {name}")
        _copy_rows(store, lots)
        _seal(store)
        for _, _, made in again:
            store.execute(made)
        store.execute("COMMIT")
    with closing(Database(path, _FAST, patience_s=0.0)):
        pass  # the file is in WAL mode, as a store that was written is


def place_of(datum: tuple[float, float], number: int) -> tuple[float, float]:
    """Return latitude and longitude of a lot from 0: rows of lots to the north of the first one and to its east."""
    row, column = divmod(number, _LOTS_A_ROW)
    return datum[0] + row * _APART_DEG, datum[1] + column * _APART_DEG


def _copy_rows(store: sqlite3.Connection, lots: int) -> None:
    datum = store.execute("SELECT latitude, longitude FROM drawn.lot").fetchone()
    stalls = store.execute("SELECT count(*) FROM drawn.stall").fetchone()[0]
    outlines: dict[tuple[int, str | bytes], str | bytes] = {}

    def outline(number: int, given: str | bytes) -> str | bytes:
        if (number, given) not in outlines:
            outlines[number, given] = _moved(given, datum, place_of(datum, number))
        return outlines[number, given]

    functions: dict[str, tuple[int, Callable[..., str | bytes | float]]] = {
        "own_text": (2, _own_text), "outline": (2, outline), "looks": (2, partial(_looks, stalls)),
        "north": (1, lambda n: place_of(datum, n)[0]), "east": (1, lambda n: place_of(datum, n)[1]),
    }  # fmt: skip
    for name, (count, function) in functions.items():
        store.create_function(f"bench_{name}", count, function, deterministic=True)
    store.execute("CREATE TEMP TABLE other (n INTEGER PRIMARY KEY)")
    store.executemany("INSERT INTO temp.other VALUES (?)", [(n,) for n in range(lots)])
    for table, loops in _SURVEYED.items():
        columns = METADATA.tables[table].columns.keys()
        values = ", ".join(_value(table, column, lots, stalls) for column in columns)
        source = f"drawn.{table} AS o CROSS JOIN temp.other"
        if loops > 1:
            source = f"drawn.survey AS s CROSS JOIN temp.other CROSS JOIN drawn.{table} AS o ON o.survey = s.seq"
        store.execute(f"INSERT INTO main.{table} ({', '.join(columns)}) SELECT {values} FROM {source}")  # noqa: S608


def _value(table: str, column: str, lots: int, stalls: int) -> str:
    if (table, column) in _SURVEYS or (table, column) == ("outbox", "seq"):
        return f"(o.{column} - 1) * {lots} + n + 1"
    if (table, column) in _STALLS:
        return f"o.{column} + n * {stalls}"
    if column in ("id", "lot", "survey_id") or (table, column) in (("outbox", "body"), ("survey", "candidates")):
        return f"bench_own_text(n, o.{column})"
    if column in ("outline", "seen_ground"):
        return f"bench_outline(n, o.{column})"
    return {
        "latitude": "bench_north(n)", "longitude": "bench_east(n)", "origin": "o.origin || ' ' || n",
        "name": "'Lot ' || (n + 1)", ("looks", "stalls"): "bench_looks(n, o.stalls)",
    }.get((table, column) if table == "looks" else column, f"o.{column}")  # fmt: skip


def _own_text(number: int, text: str) -> str:
    """Return a text with its ids replaced by those of a copy; the first lot has its own."""
    if number == 0:
        return text
    return _ID.sub(lambda found: str(uuid.uuid5(uuid.UUID(found[0]), str(number))), text)


def _looks(stalls: int, number: int, piece: bytes) -> bytes:
    table = np.frombuffer(piece, _LOOK).copy()
    table["stall"] += number * stalls
    return table.tobytes()


def _moved(given: str | bytes, datum: tuple[float, float], place: tuple[float, float]) -> str | bytes:
    """Return an outline, as text or packed, at another place."""
    outline = outline_of(given) if isinstance(given, str) else unpack_outline(given)
    polygons, holes = (
        tuple(ring_on_earth(place, about(datum, np.array(ring))[:, :2]) for ring in rings)
        for rings in (outline.polygons, outline.holes)
    )
    moved = Outline(polygons, holes)
    return outline_json(moved) if isinstance(given, str) else pack_outline(moved)


def _seal(store: sqlite3.Connection) -> None:
    """Store the digests of all parts."""
    for kind in ("lot", "outbox", "survey", "last"):
        table, key = next(iter(PARTS[kind].items()))
        asked = selections(store, kind)
        rows = store.execute(f"SELECT {key} FROM main.{table} ORDER BY {key}")  # noqa: S608 - our own words
        while some := rows.fetchmany(_AT_ONCE):
            store.executemany(
                "INSERT INTO main.digest (part, key, digest) VALUES (?, ?, ?)",
                [(kind, str(each), digest_of(store, Part(kind, str(each)), asked)) for (each,) in some],
            )
