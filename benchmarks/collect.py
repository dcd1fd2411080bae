"""Documents of surveys that a desk takes in: surveys a second, with every commit on the disk, and a week at once.

``python -m benchmarks.collect [--week N] [--flight S] [--json FILE]``

Four drones send ten surveys each of a lot of 300 stalls; the first ones bring their lots. One process takes them in,
one after the other, as the address of the API does. Then a drone that had no link for a week sends ``--week`` surveys
to the desk itself over this computer's network, as its daemon does; at last it sends in flight, slowly, from a process
of its own, once its first documents are there. The pictures of surveys are not among them.
"""

from __future__ import annotations

import asyncio
import contextlib
import multiprocessing
import statistics
import sys
import tempfile
import time
import tracemalloc
from collections.abc import AsyncIterator, Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Final

from sqlalchemy import Connection, func, select

from benchmarks.figures import BenchmarkError, Figure, Limit, Section, print_and_write
from benchmarks.options import make_parser
from hawk.comm.protocol.authority import Role
from hawk.config.secrets import SecretUrl
from hawk.config.sections import CollectSettings
from hawk.daemon.lots.keeper import find_stalls
from hawk.lots import outbox
from hawk.lots.documents import parts, source
from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import DELIVERY, SURVEY
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
FLIGHT_S: Final = 60.0
FLIGHT_KBIT_S: Final = 100
"""Of a radio or a mobile network far out; `collect.kbit_s` of the settings is 0, nothing is sent in flight then."""
KBIT: Final = 300.0
"""A document of `STALLS` stalls has more."""
UPLINK_SHARE: Final = 0.01
UPLINK_MB: Final = 15.0
WARM: Final = 3
"""States that a drone has sent before its time in flight is taken: it has loaded what it needs by then."""
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


@contextlib.asynccontextmanager
async def _drone_and_desk(folder: Path, surveys: int) -> AsyncIterator[tuple[Path, CollectSettings, str]]:
    """Yield the folder of a drone that has these surveys, its settings and the name of its desk, which runs."""
    drone, desk, port = folder / "drone", folder / "desk", free_tcp_port()
    for each in (drone, desk):
        each.mkdir(parents=True)
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
        yield drone, CollectSettings(url=url, token_file=drone / "token"), desk_target(url, token)
    finally:
        process.terminate()
        await process.wait()


async def catch_up(folder: Path, surveys: int) -> tuple[float, float]:
    """Return the seconds until a desk has a drone's surveys, and the processor's seconds of its sender.

    Raises BenchmarkError when the desk has not all of them in time.
    """
    async with _drone_and_desk(folder, surveys) as (drone, settings, target):
        began, used = time.perf_counter(), time.process_time()
        async with _sending(drone, settings, SenderTimes(look_s=1.0), is_flown=False) as store:
            await _until(store, lambda c: outbox.due_state(c, target, time.time() + _LONGEST_S) is None, "all surveys")
        return time.perf_counter() - began, time.process_time() - used


async def in_flight(folder: Path, seconds: float, kbit_s: int) -> tuple[float, float]:
    """Return the share of a core, and the most memory (MB), that a sender takes which sends all the time in flight.

    Raises BenchmarkError when the desk has no first document in time.
    """
    async with contextlib.AsyncExitStack() as stack:
        surveys = SURVEYS + int(seconds * kbit_s / KBIT)
        drone, settings, target = await stack.enter_async_context(_drone_and_desk(folder, surveys))
        slow = settings.model_copy(update={"kbit_s": kbit_s})
        store = await stack.enter_async_context(_sending(drone, slow, SenderTimes(), is_flown=True))
        asked = select(func.count()).where(DELIVERY.c.target == target, DELIVERY.c.sent.is_not(None))
        await _until(store, lambda c: c.execute(asked).scalar_one() >= WARM, f"{WARM} states")
        began, used = time.perf_counter(), time.process_time()
        await asyncio.sleep(seconds)
        share = (time.process_time() - used) / (time.perf_counter() - began)
        tracemalloc.start()
        await asyncio.sleep(seconds / 2)
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
    return share, most / 1e6


async def _until(store: LotStore, is_so: Callable[[Connection], bool], what: str) -> None:
    """Wait until a drone's store says that the desk has something. Raises BenchmarkError."""
    began = time.perf_counter()
    while not await store.read(is_so):
        if time.perf_counter() - began > _LONGEST_S:
            raise BenchmarkError(f"the desk has not {what} after {_LONGEST_S:g} s")
        await asyncio.sleep(0.2)


def in_flight_alone(folder: Path, seconds: float, kbit_s: int) -> tuple[float, float]:
    """Return `in_flight` of a process of its own: what this one holds is no part of a drone's."""
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        return pool.submit(_run_in_flight, folder, seconds, kbit_s).result()


def _run_in_flight(folder: Path, seconds: float, kbit_s: int) -> tuple[float, float]:
    return asyncio.run(in_flight(folder, seconds, kbit_s))


async def until_served(port: int) -> None:
    """Wait until somebody serves a port of this computer. Raises TimeoutError."""
    async with asyncio.timeout(_LONGEST_S):
        while True:
            with contextlib.suppress(OSError):
                _, writer = await asyncio.open_connection("127.0.0.1", port)
                writer.close()
                return
            await asyncio.sleep(0.1)


@contextlib.asynccontextmanager
async def _sending(
    folder: Path, settings: CollectSettings, times: SenderTimes, *, is_flown: bool
) -> AsyncIterator[LotStore]:
    """Yield the store of a drone that sends, as its daemon does."""
    store = LotStore(folder / FILE, find_stalls)
    await store.open()
    sender = DocumentSender(store, settings, time.time, lambda: is_flown, lambda *_: None, times)
    running = asyncio.create_task(sender.run())
    try:
        yield store
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
        await store.close()


def main(arguments: Sequence[str] | None = None) -> int:
    """Take documents in, and print a table; return 1 when a figure lies outside its limits."""
    parser = make_parser("benchmarks.collect", __doc__)
    parser.add_argument("--week", type=int, default=WEEK, metavar="N", help=f"surveys without a link (default {WEEK})")
    parser.add_argument("--flight", type=float, default=FLIGHT_S, metavar="S", help=f"(default {FLIGHT_S:g})")
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        sent = documents(Path(folder))
        per_s, cpu_s = asyncio.run(measure(Path(folder), sent))
        catch_up_s, sender_s = asyncio.run(catch_up(Path(folder) / "week", options.week))
        share, most_mb = in_flight_alone(Path(folder) / "flight", options.flight, FLIGHT_KBIT_S)
    size = statistics.mean(len(data) for _, _, data in sent) / 1e3
    figures = [
        Figure("ingest_per_s", f"surveys of {STALLS} stalls a second", per_s, "", limit=Limit(lowest=LEAST_PER_S)),
        Figure("ingest_cpu_ms", "processor time of one", cpu_s * 1e3, "ms"),
        Figure("document_kb", "document of one, without its picture", size, "kB"),
        Figure("catch_up_s", f"{options.week} surveys of a week without a link are at the desk", catch_up_s, "s",
               limit=Limit(highest=CATCH_UP_S)),
        Figure("sender_cpu_ms", "processor time of the drone for one of them", 1e3 * sender_s / options.week, "ms"),
        Figure("uplink_cpu", f"of a core, of a drone that sends at {FLIGHT_KBIT_S} kbit/s in flight", share, "",
               limit=Limit(highest=UPLINK_SHARE)),
        Figure("uplink_mb", "its memory for that, most", most_mb, "MB", limit=Limit(highest=UPLINK_MB)),
    ]  # fmt: skip
    return print_and_write([Section("collect", figures)], options.json)


if __name__ == "__main__":
    sys.exit(main())
