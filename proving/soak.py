"""Hours of surveys with the page open: does anything of the daemon or the page grow?

``python -m proving.soak --minutes 120 --speed 4 [--seed 1] [--out DIR] [--json FILE]``

A daemon flies surveys of a simulated drone, one after another, with a fresh battery each, and one page in a headless
browser shows video and map. Ctrl-C ends it early; what was sampled is judged all the same. Sampled four times a
minute, and printed once: memory of the daemon, heap of the page after a garbage collection, tasks, threads, open files,
sockets and queues. At the end the slopes after the warm-up are printed, and what is more than it was. The heap's slope
is that of the least in each five minutes: in flight the page holds a third more than after a landing. Recordings are
deleted after each flight: two hours of them are 20 GB. Status 1 when a limit is missed.

``python -m proving.soak --judge LOG`` judges the lines that a run has printed.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import re
import signal
import sys
import tempfile
import time
from collections.abc import AsyncIterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import fmean, median
from typing import Any, Final

import aiohttp
import numpy as np
import shapely
from playwright.async_api import CDPSession, async_playwright

from benchmarks.exploration import setups
from benchmarks.figures import BenchmarkError, Figure, Limit, Section, print_and_write
from benchmarks.options import make_parser
from benchmarks.stack import client, running
from benchmarks.whole_daemon import CHROMIUM
from hawk.comm.base_socket import ConnectionTimeout
from hawk.comm.protocol.heartbeat import Heartbeat
from hawk.sim.launch import FASTEST, SLOWEST, SPEED_HELP, SimulationOptions
from hawk.survey.client import DroneClient, LinkLostError
from hawk.survey.handset import SurveyStatus
from hawk.survey.operator import SurveyOperator, SurveyPlan
from hawk.survey.stack import SimulatedStack
from proving.lawnmower import LawnmowerOperator, Place, lanes

EXIT_FAILED: Final = 1
SAMPLE_S: Final = 15.0
LINE_EVERY: Final = 4
"""Samples for one printed line."""
WARM_UP_MIN: Final = 30.0
"""The page keeps half an hour of its plots; map, mosaic and the allocator's pools are full before. Of a shorter run it
is a third."""
ENGINE: Final = "--js-flags=--no-opt --no-maglev"
"""V8 without its optimizing compilers. Their code lies in the heap too: for hours it grows by some kB a flight, and
V8 drops it under pressure. What the page itself keeps is seen without it."""
FLOOR_MIN: Final = 5.0
"""Minutes of which the least heap counts: some ten flights, so that one of the samples is of a drone on the ground."""
LEAST_MIN: Final = 40.0
"""Minutes after the warm-up below which a slope says nothing: one flight more or less is more than the limit."""
MEMORY_SLOPE: Final = 1.0
"""Limit for the memory of daemon and page, per cent an hour."""
AGAIN_S: Final = 5.0
COUNTS: Final = ("tasks", "threads", "open_files", "open_sockets", "queued")
_WIDTHS: Final = (5, 7, 5, 7, 6)
FLAT: Final = {"tasks": 1.0, "threads": 0.0, "open_files": 1.0, "open_sockets": 1.0, "queued": 64.0}
"""By how much the median of the last third may be above that of the first third after the warm-up: a look at the
metrics is itself a task and a socket, and a queue holds what came within its last write."""
_LINE: Final = re.compile(
    r"^ *([\d.]+) +([\d.]+) +([\d.]+)" + r" +(\d+)" * len(COUNTS) + r" +(\d+) \+ (\d+) failed$", re.M
)
_SAMPLE: Final = re.compile(r"^hawk_(\w+)(?:\{[^}]*\})? (\S+)$", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Sample:
    """Readings of one moment. ``minute`` since the begin, ``heap_mb`` of the page, ``counts`` by name."""

    minute: float
    memory_mb: float
    heap_mb: float
    counts: Mapping[str, float]


@dataclass(slots=True)
class Flights:
    """Flights so far: finished, and with the reason those that were not."""

    finished: int = 0
    failed: list[str] = field(default_factory=list)


def main(arguments: Sequence[str] | None = None) -> int:
    """Fly, sample, print, write."""
    options = parser_of().parse_args(arguments)
    try:
        samples, flights = _measured(options)
    except (BenchmarkError, OSError) as error:
        print(f"soak: {error}", file=sys.stderr)
        return EXIT_FAILED
    found = figures(samples, flights)
    sections = [Section("soak", found, problem(samples, flights))]
    return print_and_write(sections, options.json)


def _measured(options: argparse.Namespace) -> tuple[list[Sample], Flights]:
    if options.judge is not None:
        try:
            return read_lines(options.judge.read_text())
        except (OSError, UnicodeDecodeError) as error:
            text = f"--judge {options.judge}: cannot be read ({error}); name the file that holds a run's lines"
            raise BenchmarkError(text) from error
    with contextlib.ExitStack() as stack:
        folder = options.out or Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="hawk-soak-")))
        folder.mkdir(parents=True, exist_ok=True)
        return asyncio.run(soak(options.minutes, options.speed, options.seed, folder))


def parser_of() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = make_parser("proving.soak", __doc__)
    parser.add_argument("--minutes", type=float, default=120.0, help="real minutes (default 120)")
    parser.add_argument("--speed", type=_speed, default=FASTEST, help=f"{SPEED_HELP} (default {FASTEST:g})")
    parser.add_argument("--seed", type=int, default=1, help="the world to fly over (default 1)")
    parser.add_argument("--out", type=Path, metavar="DIR", help="keep logs and journal here")
    parser.add_argument("--judge", type=Path, metavar="LOG", help="judge what a run has printed; nothing is flown")
    return parser


async def soak(minutes: float, speed: float, seed: int, folder: Path) -> tuple[list[Sample], Flights]:
    """Fly for that time; return the samples. Raises BenchmarkError."""
    stack = SimulatedStack(SimulationOptions(seed=seed, speed=speed), folder, None, None)
    flights = Flights()
    async with (
        running(stack, folder) as ready,
        aiohttp.ClientSession() as session,
        _page(ready.url) as heap,
    ):
        flying = asyncio.create_task(_fly_on(stack, ready.url, session, folder, flights), name="soak-flights")
        try:
            return await _sample_on(minutes, ready.url, session, heap, flying, flights), flights
        finally:
            flying.cancel()
            await asyncio.gather(flying, return_exceptions=True)


def figures(samples: Sequence[Sample], flights: Flights) -> list[Figure]:
    """Return slopes and growth after the warm-up, with limits where the run was long enough."""
    warm = after_warm_up(samples)
    judged = is_long_enough(warm)
    limit = Limit(highest=MEMORY_SLOPE) if judged else None
    found = [
        Figure("soak_minutes", "minutes after the warm-up", _span(warm)),
        Figure("soak_flights", "flights finished", float(flights.finished), limit=Limit(lowest=1.0)),
        Figure("soak_flights_failed", "flights that failed", float(len(flights.failed))),
        Figure("soak_memory_mb", "memory of the daemon, mean", _mean([s.memory_mb for s in warm]), "MB"),
        Figure("soak_memory_slope", "memory of the daemon", slope(warm, lambda s: s.memory_mb), "%/h", limit=limit),
        Figure("soak_heap_mb", "heap of the page, mean", _mean([s.heap_mb for s in warm]), "MB"),
        Figure("soak_heap_least_mb", "heap of the page, least", min((s.heap_mb for s in warm), default=None), "MB"),
        Figure("soak_heap_slope", "heap of the page", slope(floor(warm), lambda s: s.heap_mb), "%/h", limit=limit),
    ]
    for name in COUNTS:
        flat = Limit(highest=FLAT[name]) if judged else None
        text = f"{name.replace('_', ' ')}: last third above the first"
        found.append(Figure(f"soak_{name}_growth", text, growth(warm, name), limit=flat))
    return found


def problem(samples: Sequence[Sample], flights: Flights) -> str:
    """Return why the slopes say nothing, and the flights that failed; empty when all is well."""
    span = _span(after_warm_up(samples)) or 0.0
    short = f"VOID: {span:.0f} minutes after the warm-up, {LEAST_MIN:.0f} are needed"
    parts = [] if is_long_enough(after_warm_up(samples)) else [short]
    return "; ".join([*parts, *flights.failed[:5]])


def after_warm_up(samples: Sequence[Sample]) -> list[Sample]:
    """Return the samples after the warm-up."""
    if not samples:
        return []
    begin = min(WARM_UP_MIN, samples[-1].minute / 3)
    return [sample for sample in samples if sample.minute >= begin]


def is_long_enough(warm: Sequence[Sample]) -> bool:
    """Return True when slopes can be judged."""
    return (_span(warm) or 0.0) >= LEAST_MIN


def slope(samples: Sequence[Sample], of: Any) -> float | None:
    """Return the slope by least squares, per cent of the mean an hour; None with less than three samples."""
    if len(samples) < 3:
        return None
    hours = [sample.minute / 60 for sample in samples]
    values = [of(sample) for sample in samples]
    gradient, _ = np.polyfit(hours, values, 1)
    mean = fmean(values)
    return float(gradient / mean * 100) if mean else None


def floor(samples: Sequence[Sample]) -> list[Sample]:
    """Return the sample with the least heap of each `FLOOR_MIN` minutes; the last, shorter ones are left out."""
    windows: dict[int, list[Sample]] = {}
    for sample in samples:
        windows.setdefault(int((sample.minute - samples[0].minute) / FLOOR_MIN), []).append(sample)
    whole = int((_span(samples) or 0.0) / FLOOR_MIN)
    return [min(windows[index], key=lambda sample: sample.heap_mb) for index in sorted(windows) if index < whole]


def growth(samples: Sequence[Sample], name: str) -> float | None:
    """Return by how much the median count of the last third is above that of the first; None with too few samples.

    A thread or a socket that is there for one sample and gone in the next is not left behind.
    """
    third = len(samples) // 3
    if third == 0:
        return None
    counts = [sample.counts[name] for sample in samples]
    return median(counts[-third:]) - median(counts[:third])


def read_lines(text: str) -> tuple[list[Sample], Flights]:
    """Return the samples and flights of the lines that a run has printed. Raises BenchmarkError without any."""
    found = [match.groups() for match in _LINE.finditer(text)]
    if not found:
        raise BenchmarkError("no line of a soak is in it")
    samples = [
        Sample(float(minute), float(memory), float(heap), dict(zip(COUNTS, map(float, counts), strict=True)))
        for minute, memory, heap, *counts, _, _ in found
    ]
    finished, failed = map(int, found[-1][-2:])
    return samples, Flights(finished, [f"{failed} flights failed"] * bool(failed))


def read_metrics(text: str) -> dict[str, float]:
    """Return the values of a Prometheus text by name; those with labels are added up."""
    found: dict[str, float] = {}
    for name, value in _SAMPLE.findall(text):
        found[name] = found.get(name, 0.0) + float(value)
    return found


async def _sample_on(
    minutes: float,
    url: str,
    session: aiohttp.ClientSession,
    heap: CDPSession,
    flying: asyncio.Task[None],
    flights: Flights,
) -> list[Sample]:
    samples: list[Sample] = []
    begun = time.monotonic()
    ended = ended_by_hand()
    print("minute  memory   heap  tasks  threads  files  sockets  queued  flights", flush=True)
    while (elapsed := time.monotonic() - begun) < minutes * 60 and not ended.is_set():
        if flying.done():
            flying.result()
        sample = await _look(elapsed / 60, url, session, heap)
        if len(samples) % LINE_EVERY == 0:
            print(_line(sample, flights), flush=True)
        samples.append(sample)
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(max(0.0, min(SAMPLE_S, minutes * 60 - (time.monotonic() - begun)))):
                await ended.wait()
    return samples


def ended_by_hand() -> asyncio.Event:
    """Return an event that Ctrl-C and SIGTERM set."""
    ended = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, ended.set)
    return ended


def _line(sample: Sample, flights: Flights) -> str:
    counts = "  ".join(f"{sample.counts[name]:{width}.0f}" for name, width in zip(COUNTS, _WIDTHS, strict=True))
    done = f"{flights.finished:3d} + {len(flights.failed)} failed"
    return f"{sample.minute:6.1f}  {sample.memory_mb:6.1f}  {sample.heap_mb:5.2f}  {counts}  {done}"


async def _look(minute: float, url: str, session: aiohttp.ClientSession, heap: CDPSession) -> Sample:
    async with session.get(f"{url}metrics") as response:
        response.raise_for_status()
        values = read_metrics(await response.text())
    await heap.send("HeapProfiler.collectGarbage")
    answer = await heap.send("Performance.getMetrics")
    used = {metric["name"]: float(metric["value"]) for metric in answer["metrics"]}
    counts = {name: values[name] for name in COUNTS}
    return Sample(minute, values["resident_memory_bytes"] / 1e6, used["JSHeapUsedSize"] / 1e6, counts)


async def _fly_on(
    stack: SimulatedStack, url: str, session: aiohttp.ClientSession, folder: Path, flights: Flights
) -> None:
    """Fly one survey after another: by turns an exploration, and lanes over what is known by then."""
    while True:
        with contextlib.suppress(ConnectionTimeout):
            async with client(url) as drone:
                while await _fly(stack, session, drone, flights):
                    _delete_recordings(folder)
        await asyncio.sleep(AGAIN_S)


def _delete_recordings(folder: Path) -> None:
    for path in folder.rglob("*.mcap"):
        path.unlink()


async def _fly(stack: SimulatedStack, session: aiohttp.ClientSession, drone: DroneClient, flights: Flights) -> bool:
    """Fly once with a fresh battery; return False when the link was lost."""
    assert stack.address is not None
    async with session.post(f"{stack.address.http}/fault", json={"battery": 100.0}) as response:
        response.raise_for_status()
    plan = SurveyPlan(set_failsafes=True)
    explores = flights.finished % 2 == 0
    operator = SurveyOperator(drone, plan) if explores else LawnmowerOperator(drone, plan, lambda *_: None, _lanes)
    try:
        outcome = await operator.run()
    except (LinkLostError, BenchmarkError) as error:
        flights.failed.append(str(error))
        return not isinstance(error, LinkLostError)
    if outcome.status is SurveyStatus.DONE:
        flights.finished += 1
    else:
        flights.failed.append(outcome.reason)
        await asyncio.sleep(AGAIN_S)
    return True


def _lanes(beat: Heartbeat) -> list[Place]:
    """Return lanes over the ground inside the fence."""
    fence = shapely.Polygon([(point.north, point.east) for point in beat.fence])
    swath = setups.flown().swath
    start = (beat.north or 0.0, beat.east or 0.0)
    return lanes(fence.buffer(-swath.depth / 2), fence, beat.yaw or 0.0, swath, start)


@contextlib.asynccontextmanager
async def _page(url: str) -> AsyncIterator[CDPSession]:
    """Show the operator's page in a browser without a window; gives the connection to its debugger."""
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(
            executable_path=CHROMIUM, args=["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", ENGINE]
        )
        try:
            page = await browser.new_page(viewport={"width": 1440, "height": 900})
            await page.goto(url)
            debugger = await page.context.new_cdp_session(page)
            await debugger.send("Performance.enable")
            await debugger.send("HeapProfiler.enable")
            yield debugger
        finally:
            await browser.close()


def _speed(text: str) -> float:
    value = float(text)
    if not SLOWEST <= value <= FASTEST:
        raise argparse.ArgumentTypeError(f"must lie between {SLOWEST:g} and {FASTEST:g}")
    return value


def _span(samples: Sequence[Sample]) -> float | None:
    return samples[-1].minute - samples[0].minute if samples else None


def _mean(values: Sequence[float]) -> float | None:
    return fmean(values) if values else None


if __name__ == "__main__":
    sys.exit(main())
