"""Reads of a store with many lots: seconds until it is open, of the list of all lots, of all on a map, and of one lot.

All on a map are the page's answer, encoded and packed, beside all of them as GeoJSON features with their outlines.

``python -m benchmarks.many_lots [--lots N] [--surveys N] [--stalls N] [--keep DIR] [--json FILE]``

`benchmarks.many_lots_store` makes the store. Each figure stands beside that of the same rows with
``--reference`` lots, in the same run. The store is opened as desk and daemon open it. With over a hundred surveys of
each lot the calls of `benchmarks.archive` are timed, too, but for those over all lots.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from sqlalchemy import Connection, func, select

from benchmarks import archive_calls
from benchmarks.figures import Figure, Limit, Reference, Section, print_and_write
from benchmarks.many_lots_store import FLOWN_OFTEN, fill
from benchmarks.options import make_parser
from hawk.exports import features
from hawk.exports.lot_places import lot_places
from hawk.lots import lists
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import SURVEY
from hawk.lots.store import LotStore
from hawk.web.v1.answers import Answer, encoded

STALLS: Final = 40
REFERENCE: Final = 100
_FAST: Final = {"synchronous": 0}
_LIMITS: Final = {"open_s": 3.0, "map_s": 1.0, "list_part_s": 0.15, "lot_s": 0.15, "page_p99_s": 0.15}
_WORDS: Final = {
    "open_s": "the store is open",
    "first_s": "first lot, with the time zones of all",
    "list_s": "list of all lots",
    "list_part_s": "its slowest part of 100",
    "map_s": "all lots on a map, packed",
    "features_s": "all lots as GeoJSON features, packed",
    "lot_s": "one lot",
    "page_p99_s": "99 of 100 calls about one lot",
    "page_s": "its slowest call, in the middle",
}
_OF_ALL: Final = ("api: lots", "api: features")
_OF_ALL_LOTS: Final[Mapping[str, Callable[[Connection, int], object]]] = {
    "map_s": lambda connection, _: lot_places(connection),
    "features_s": lambda connection, lots: features.lots(connection, features.Choice(limit=lots)).features,
}
_ROUNDS: Final = 4


@dataclass(frozen=True, slots=True)
class Times:
    """Seconds of the reads, by key."""

    lots: int
    seconds: dict[str, float]


class _WholeDatabase(Database):
    """A store in which no damage is searched for: a desk does that beside its work, once for each start."""

    def _find_damage(self) -> None:
        self.is_searched.set()


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
    with closing(_WholeDatabase(path)) as store, store.reading() as connection:
        began = time.perf_counter()
        lists.lots(connection, lists.Asked(limit=1))
        began = at = timed("first_s", began)
        part = lists.lots(connection, lists.Asked())
        at = timed("list_part_s", at)
        while part.next is not None:
            part = lists.lots(connection, lists.Asked(after=part.next))
            at = timed("list_part_s", at)
        at = timed("list_s", began)
        for key, read in _OF_ALL_LOTS.items():
            encoded(Answer(read(connection, lots)), packs=True)
            at = timed(key, at)
        lists.lot(connection, part.items[-1].id)
        timed("lot_s", at)
        first = connection.execute(select(SURVEY.c.lot).where(SURVEY.c.seq == 1)).one()
        surveys = connection.execute(select(func.count()).where(SURVEY.c.lot == first.lot)).scalar_one()
    if surveys >= FLOWN_OFTEN:
        with closing(_WholeDatabase(path, _FAST)) as store:
            times = archive_calls.timed_calls(store, first.lot, _ROUNDS, _OF_ALL)
        every = np.array([each for some in times.values() for each in some]) / 1e3
        found["page_p99_s"] = float(np.percentile(every, 99))
        found["page_s"] = max(float(np.median(some)) for some in times.values()) / 1e3
    return Times(lots, found)


def figures(times: Times, reference: Times) -> Section:
    """Return the figures of a store beside those of one with fewer lots; of the map beside those of features."""
    beside = {key: Reference(f"{reference.lots} lots", value) for key, value in reference.seconds.items()}
    beside["map_s"] = Reference("as features", times.seconds["features_s"])
    each = [
        Figure(
            key, words, times.seconds[key], "s", beside[key],
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
    parser.add_argument("--keep", type=Path, help="folder of the stores: those that are there are not made again")
    options = parser.parse_args(arguments)
    found = []
    with contextlib.ExitStack() as stack:
        folder = options.keep or Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="hawk-many-lots-")))
        for lots in (options.reference, options.lots):
            path = folder / f"{lots}-{options.surveys}-{options.stalls}.db"
            if not path.exists():
                made = path.with_suffix(".part")
                made.unlink(missing_ok=True)
                fill(made, lots, options.surveys, options.stalls)
                made.rename(path)
            found.append(measure(path, lots))
    return print_and_write([figures(found[1], found[0])], options.json)


if __name__ == "__main__":
    sys.exit(main())
