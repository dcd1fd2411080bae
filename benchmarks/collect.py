"""Documents of surveys that a desk takes in: surveys a second, with every commit on the disk.

``python -m benchmarks.collect [--json FILE]``

Four drones send ten surveys each of a lot of 300 stalls; the first ones bring their lots. One process takes them in,
one after the other, as the address of the API does. The pictures of surveys are not among them.
"""

from __future__ import annotations

import asyncio
import statistics
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from sqlalchemy import select

from benchmarks.figures import Figure, Limit, Section, print_and_write
from benchmarks.options import make_parser
from hawk.daemon.lots.keeper import find_stalls
from hawk.lots.documents import parts, source
from hawk.lots.ingest import save
from hawk.lots.schema import SURVEY
from hawk.lots.storage.database import Database
from hawk.lots.store import FILE, LotStore
from tests.unit.lots.surveys import later, survey

STALLS: Final = 300
DRONES: Final = 4
SURVEYS: Final = 10
LEAST_PER_S: Final = 20.0

Sent = tuple[str, str, bytes]
"""Name of a drone, id of a survey, and its document."""


def documents(folder: Path) -> list[Sent]:
    """Return the documents of all drones, each in the order of its surveys."""
    found: list[Sent] = []
    for number in range(DRONES):
        store = Database(folder / f"{number}.db", {"synchronous": 0})
        for day in range(SURVEYS):
            with store.writing() as connection:
                given = later(survey(stalls=STALLS, seed=SURVEYS * number + day), day + 1, 24.0 * day)
                save(connection, given, find_stalls)
        with store.reading() as connection:
            for named in connection.execute(select(SURVEY.c.id).order_by(SURVEY.c.seq)).scalars():
                packed = parts.packed(source.document_of(connection, named, {}))
                found.append((f"Drone {number}", named, packed))
        store.close()
    return found


async def measure(folder: Path, sent: Sequence[Sent]) -> tuple[float, float]:
    """Return surveys a second, and the processor's seconds of each."""
    store = LotStore(folder / FILE, find_stalls)
    await store.open()
    began, used = time.perf_counter(), time.process_time()
    for drone, named, data in sent:
        await store.collect(data, named, drone)
    seconds, busy = time.perf_counter() - began, time.process_time() - used
    await store.close()
    return len(sent) / seconds, busy / len(sent)


def main(arguments: Sequence[str] | None = None) -> int:
    """Take documents in, and print a table; return 1 when a figure lies outside its limits."""
    options = make_parser("benchmarks.collect", __doc__).parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        sent = documents(Path(folder))
        per_s, cpu_s = asyncio.run(measure(Path(folder), sent))
    size = statistics.mean(len(data) for _, _, data in sent) / 1e3
    figures = [
        Figure("ingest_per_s", f"surveys of {STALLS} stalls a second", per_s, "", limit=Limit(lowest=LEAST_PER_S)),
        Figure("ingest_cpu_ms", "processor time of one", cpu_s * 1e3, "ms"),
        Figure("document_kb", "document of one, without its picture", size, "kB"),
    ]
    return print_and_write([Section("collect", figures)], options.json)


if __name__ == "__main__":
    sys.exit(main())
