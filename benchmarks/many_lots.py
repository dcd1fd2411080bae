"""Reads of a store with many lots: seconds until it is open, of the list of all lots, of all on a map, and of one lot.

``python -m benchmarks.many_lots [--lots N] [--surveys N] [--stalls N] [--json FILE]``

A small lot with its surveys goes through the daemon's store and registration; the others are copies of its rows with
their own ids and places, and digests, in the same file. Each figure stands beside that of the same rows with
``--reference`` lots, in the same run. The store is opened as desk and daemon open it. With over a hundred surveys of
each lot the calls of `benchmarks.archive` are timed, too, but for those over all lots.
"""

from __future__ import annotations

import argparse
import asyncio
import sqlite3
import sys
import tempfile
import time
import uuid
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Final, cast

import numpy as np
from sqlalchemy import Connection, func, select

from benchmarks import archive_calls
from benchmarks.archive import BIAS, drawn_lot, flight
from benchmarks.figures import Figure, Limit, Reference, Section, print_and_write
from benchmarks.options import make_parser
from hawk.daemon.lots.keeper import find_stalls
from hawk.exports import features
from hawk.lots import lists
from hawk.lots.ingest import save
from hawk.lots.registration.frames import Move
from hawk.lots.schema import METADATA, SURVEY
from hawk.lots.storage.database import Database
from hawk.lots.store import LotStore

STALLS: Final = 40
REFERENCE: Final = 100
_FAST: Final = {"synchronous": 0}
_SEQUENCES: Final = {"survey": "seq", "stall": "key"}
_COPIED: Final = ("lot", "layout", "survey", "stall", "observation", "looks", "plan")
_OF_SURVEY: Final = (("survey", "seq"), ("observation", "survey"), ("looks", "survey"), ("stall", "first_survey"))
_OF_STALL: Final = (("stall", "key"), ("observation", "stall"))
_LIMITS: Final = {"open_s": 3.0, "map_s": 1.0, "list_part_s": 0.15, "lot_s": 0.15, "page_p99_s": 0.15}
_WORDS: Final = {
    "open_s": "the store is open",
    "first_s": "first lot, with the time zones of all",
    "list_s": "list of all lots",
    "list_part_s": "its slowest part of 100",
    "map_s": "all lots on a map",
    "lot_s": "one lot",
    "page_p99_s": "99 of 100 calls about one lot",
    "page_s": "its slowest call, in the middle",
}
_OF_ALL: Final = ("api: lots", "api: surveys", "api: features")
FLOWN_OFTEN: Final = 102
"""Surveys of a lot from which on its calls are timed; they are written into the tables."""
_ROUNDS: Final = 4


@dataclass(frozen=True, slots=True)
class Times:
    """Seconds of the reads, by key."""

    lots: int
    seconds: dict[str, float]


def fill(path: Path, lots: int, surveys: int, size: int = STALLS) -> None:
    """Make a store of many lots of ``size`` stalls with N surveys each."""
    rng = np.random.default_rng(1)
    stalls = drawn_lot(size, rng)
    with closing(Database(path, _FAST)) as store:
        if surveys >= FLOWN_OFTEN:
            archive_calls.fill(store, flight(1, stalls, Move(), rng), surveys - 1)
        for number in range(surveys if surveys < FLOWN_OFTEN else 0):
            with store.writing() as connection:
                save(connection, flight(number + 1, stalls, BIAS if number else Move(), rng), find_stalls)
        with store.writing() as connection:
            _copy(connection, lots)


def _copy(connection: Connection, lots: int) -> None:
    raw = cast("sqlite3.Connection", connection.connection.dbapi_connection)
    raw.create_function("own_id", 2, lambda n, of: str(uuid.uuid5(uuid.UUID(of), str(n))), deterministic=True)
    most = {table: raw.execute(f"SELECT max({key}) FROM {table}").fetchone()[0] for table, key in _SEQUENCES.items()}  # noqa: S608
    raw.execute("CREATE TEMP TABLE other AS WITH RECURSIVE o(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM o LIMIT ?)"
                " SELECT n FROM o", (lots - 1,))  # fmt: skip
    for table in _COPIED:
        columns = METADATA.tables[table].columns.keys()
        values = ", ".join(_value(table, column, most) for column in columns)
        raw.execute(f"INSERT INTO {table} ({', '.join(columns)}) SELECT {values} FROM {table}, other")  # noqa: S608


def _value(table: str, column: str, most: dict[str, int]) -> str:
    if (table, column) in _OF_SURVEY:
        return f"{column} + n * {most['survey']}"
    if (table, column) in _OF_STALL:
        return f"{column} + n * {most['stall']}"
    if column == "id" or column == "lot":
        return f"own_id(n, {column})"
    return {
        ("lot", "latitude"): "latitude + n % 1000 * .002", ("lot", "longitude"): "longitude + n / 1000 * .003",
        ("lot", "name"): "'Lot ' || n", ("survey", "origin"): "origin || ' ' || n",
    }.get((table, column), column)  # fmt: skip


def measure(path: Path, lots: int) -> Times:
    """Time the reads of a store."""
    found: dict[str, float] = {}

    def timed(key: str, began: float) -> float:
        now = time.perf_counter()
        found[key] = max(found.get(key, 0.0), now - began)
        return now

    async def opened() -> None:
        store = LotStore(path)
        began = time.perf_counter()
        await store.open()
        timed("open_s", began)
        await store.close()

    asyncio.run(opened())
    with closing(Database(path, patience_s=0.0)) as store, store.reading() as connection:
        began = time.perf_counter()
        lists.lots(connection, lists.Asked(limit=1))
        began = at = timed("first_s", began)
        part = lists.lots(connection, lists.Asked())
        at = timed("list_part_s", at)
        while part.next is not None:
            part = lists.lots(connection, lists.Asked(after=part.next))
            at = timed("list_part_s", at)
        at = timed("list_s", began)
        features.lots(connection, features.Choice(limit=lots))
        at = timed("map_s", at)
        lists.lot(connection, part.items[-1].id)
        timed("lot_s", at)
        first = connection.execute(select(SURVEY.c.lot).where(SURVEY.c.seq == 1)).one()
        surveys = connection.execute(select(func.count()).where(SURVEY.c.lot == first.lot)).scalar_one()
    if surveys >= FLOWN_OFTEN:
        with closing(Database(path, _FAST)) as store:
            times = archive_calls.timed_calls(store, first.lot, _ROUNDS)
        times = {name: some for name, some in times.items() if not name.startswith(_OF_ALL)}
        every = np.array([each for some in times.values() for each in some]) / 1e3
        found["page_p99_s"] = float(np.percentile(every, 99))
        found["page_s"] = max(float(np.median(some)) for some in times.values()) / 1e3
    return Times(lots, found)


def figures(times: Times, reference: Times) -> Section:
    """Return the figures of a store beside those of one with fewer lots."""
    few = f"{reference.lots} lots"
    each = [
        Figure(
            key, words, times.seconds[key], "s", Reference(few, reference.seconds[key]),
            Limit(highest=_LIMITS[key]) if key in _LIMITS else None,
        )
        for key, words in _WORDS.items()
        if key in times.seconds
    ]  # fmt: skip
    return Section(f"{times.lots} lots", tuple(each))


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print; return the exit status."""
    parser: argparse.ArgumentParser = make_parser("benchmarks.many_lots", __doc__)
    parser.add_argument("--lots", type=int, default=10_000, help="lots of the store (default 10000)")
    parser.add_argument("--surveys", type=int, default=1, help="surveys of each (default 1)")
    parser.add_argument("--stalls", type=int, default=STALLS, help=f"stalls of each (default {STALLS})")
    parser.add_argument("--reference", type=int, default=REFERENCE, help=f"lots to compare with (default {REFERENCE})")
    options = parser.parse_args(arguments)
    found = []
    with tempfile.TemporaryDirectory(prefix="hawk-many-lots-") as folder:
        for lots in (options.reference, options.lots):
            path = Path(folder) / f"{lots}.db"
            fill(path, lots, options.surveys, options.stalls)
            found.append(measure(path, lots))
    return print_and_write([figures(found[1], found[0])], options.json)


if __name__ == "__main__":
    sys.exit(main())
