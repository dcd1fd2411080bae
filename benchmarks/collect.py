"""Documents of surveys that a desk takes in: surveys a second, with every commit on the disk, and a week at once.

``python -m benchmarks.collect [--week N] [--json FILE]``

Four drones send ten surveys each of a lot of 300 stalls; the first ones bring their lots. One process takes them in,
one after the other, as the address of the API does. Then a drone that had no link for a week sends ``--week`` surveys
to the desk itself over this computer's network, as its daemon does. The pictures of surveys are not among them.
"""

from __future__ import annotations

import asyncio
import contextlib
import statistics
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from sqlalchemy import select

from benchmarks.figures import BenchmarkError, Figure, Limit, Section, print_and_write
from benchmarks.options import make_parser
from hawk.comm.protocol.authority import Role
from hawk.config.secrets import SecretUrl
from hawk.config.sections import CollectSettings
from hawk.daemon.lots.keeper import find_stalls
from hawk.lots import outbox
from hawk.lots.documents import parts, source
from hawk.lots.ingest import save
from hawk.lots.schema import SURVEY
from hawk.lots.storage.database import Database
from hawk.lots.store import FILE, LotStore
from hawk.web.access.tokens import TOKEN_FILE, rotate, rotate_drone
from hawk.webhooks.delivery import SenderTimes
from hawk.webhooks.documents import DocumentSender, desk_target
from tests.integration.sim_support import free_tcp_port
from tests.unit.lots.surveys import later, survey

STALLS: Final = 300
DRONES: Final = 4
SURVEYS: Final = 10
LEAST_PER_S: Final = 20.0
WEEK: Final = 140
"""Surveys of a drone that flies twenty times a day."""
CATCH_UP_S: Final = 120.0
_LONGEST_S: Final = 900.0

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


async def catch_up(folder: Path, surveys: int) -> tuple[float, float]:
    """Return the seconds until a desk has a drone's surveys, and the processor's seconds of its sender.

    Raises BenchmarkError when the desk has not all of them in time.
    """
    drone, desk, port = folder / "drone", folder / "desk", free_tcp_port()
    for each in (drone, desk):
        each.mkdir()
    base = Database(drone / FILE, {"synchronous": 0})
    for number in range(surveys):
        with base.writing() as connection:
            save(connection, later(survey(stalls=STALLS, seed=number), number + 1, 1.2 * number), find_stalls)
    base.close()
    rotate(desk / TOKEN_FILE, Role.OPERATOR)
    token, url = rotate_drone(desk / TOKEN_FILE, "Drone 1"), SecretUrl(f"http://127.0.0.1:{port}/")
    (drone / "token").write_text(token)
    command = [sys.executable, "-m", "hawk.cli", "desk", "--collect", "--store", str(desk), "--port", str(port)]
    with (folder / "desk.log").open("wb") as log:
        process = await asyncio.create_subprocess_exec(*command, stdout=log, stderr=log)
    try:
        await until_served(port)
        settings = CollectSettings(url=url, token_file=drone / "token")
        return await _sent(drone, settings, desk_target(url, token))
    finally:
        process.terminate()
        await process.wait()


async def until_served(port: int) -> None:
    """Wait until somebody serves a port of this computer. Raises TimeoutError."""
    async with asyncio.timeout(_LONGEST_S):
        while True:
            with contextlib.suppress(OSError):
                _, writer = await asyncio.open_connection("127.0.0.1", port)
                writer.close()
                return
            await asyncio.sleep(0.1)


async def _sent(folder: Path, settings: CollectSettings, target: str) -> tuple[float, float]:
    store = LotStore(folder / FILE, find_stalls)
    await store.open()
    sender = DocumentSender(store, settings, time.time, lambda: False, lambda *_: None, SenderTimes(look_s=1.0))
    began, used = time.perf_counter(), time.process_time()
    running = asyncio.create_task(sender.run())
    try:
        while await store.read(lambda c: outbox.due_state(c, target, time.time() + _LONGEST_S)) is not None:
            if time.perf_counter() - began > _LONGEST_S:
                raise BenchmarkError(f"the desk has not all surveys after {_LONGEST_S:g} s")
            await asyncio.sleep(0.2)
        return time.perf_counter() - began, time.process_time() - used
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
        await store.close()


def main(arguments: Sequence[str] | None = None) -> int:
    """Take documents in, and print a table; return 1 when a figure lies outside its limits."""
    parser = make_parser("benchmarks.collect", __doc__)
    parser.add_argument("--week", type=int, default=WEEK, metavar="N", help=f"surveys without a link (default {WEEK})")
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        sent = documents(Path(folder))
        per_s, cpu_s = asyncio.run(measure(Path(folder), sent))
        catch_up_s, sender_s = asyncio.run(catch_up(Path(folder), options.week))
    size = statistics.mean(len(data) for _, _, data in sent) / 1e3
    figures = [
        Figure("ingest_per_s", f"surveys of {STALLS} stalls a second", per_s, "", limit=Limit(lowest=LEAST_PER_S)),
        Figure("ingest_cpu_ms", "processor time of one", cpu_s * 1e3, "ms"),
        Figure("document_kb", "document of one, without its picture", size, "kB"),
        Figure("catch_up_s", f"{options.week} surveys of a week without a link are at the desk", catch_up_s, "s",
               limit=Limit(highest=CATCH_UP_S)),
        Figure("sender_cpu_ms", "processor time of the drone for one of them", 1e3 * sender_s / options.week, "ms"),
    ]  # fmt: skip
    return print_and_write([Section("collect", figures)], options.json)


if __name__ == "__main__":
    sys.exit(main())
