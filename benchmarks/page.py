"""Time until each view of the page can be used, served by a small computer, and pictures a second when a map is panned.

``python -m benchmarks.page [--flown] [--core N] [--memory 1024] [--repeats 5] [--out DIR] [--json FILE]``

The daemon, with a simulated drone on the ground, runs in a control group with one core and 1 GiB; Debian's Chromium,
the simulator and this program have the other cores. Its store has one lot of 2,000 stalls with 40 surveys of one day;
the two newest have a picture of 3 ha. A view is opened by its address, and can be used when what it is for is on the
screen (`VIEWS`), a map when its stalls and all of its picture at that zoom are: cold with nothing in the browser's
cache, warm after that. The page itself takes the time, two pictures of the browser later: who asks from outside learns
of it up to half a second late. The median of the repeats counts. Panning: the
survey's map is dragged for some seconds, and the browser's pictures are counted. Control groups need root.

``--flown`` measures what the views cost a flight instead: the lag of the daemon's loop while the drone hovers, a minute
each with nothing opened, with every view opened one after the other, and with the report asked for again and again.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import gzip
import json
import os
import shutil
import statistics
import sys
import tempfile
import time
from collections.abc import AsyncIterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

import aiohttp
import numpy as np
from playwright.async_api import Browser, BrowserContext, Error, Page, ViewportSize, async_playwright

from benchmarks.archive import drawn_lot, flight
from benchmarks.archive_calls import fill
from benchmarks.archive_files import ground
from benchmarks.figures import BenchmarkError, Figure, Limit, Reference, Section, print_and_write
from benchmarks.options import make_parser
from benchmarks.small.box import make_box, other_cores
from benchmarks.small.measure import LAG_MS, BoxedStack
from benchmarks.stack import performance, running
from hawk.lots.registration.frames import Move
from hawk.lots.storage.database import Database
from hawk.lots.store import lots_file
from hawk.lots.survey.pictures import pictures_of
from hawk.runtime.performance import WINDOW_S
from hawk.sim.launch import SimulationOptions
from proving.faults.fault import When
from proving.faults.pilot import Pilot

STALLS: Final = 2_000
SURVEYS: Final = 40
"""Of one day, every 20 minutes."""
REPEATS: Final = 5
PAN_S: Final = 4.0
VIEW_MS: Final = 60_000.0
"""Longest time for a view."""
SETTLE_MS: Final = 700.0
"""Until a window of the browser stands."""
_FIRST: Final = datetime(2026, 5, 11, 10, 0, tzinfo=UTC)
_EVERY_S: Final = 20 * 60.0
_SIZE: Final[ViewportSize] = {"width": 1440, "height": 900}
_MIB: Final = 2**20
FLIGHT: Final = "flight"
VIEWS: Final = {
    FLIGHT: ("#/fly", "hawk-bar .act"),
    "lots": ("#/lots/{lot}/{after}", "hawk-survey-map[data-drawn=all] .ol"),
    "compare": ("#/compare/{lot}/{before}/{after}", "hawk-survey-map[data-drawn=all] .ol"),
    "report": ("#/report/{lot}", ".ask .answer .large"),
    "recordings": ("#/recordings/{lot}", "archive-recordings :is(table, p):not([data-asking])"),
}
"""Address of each view, and what is drawn when it can be used."""
_WATCH: Final = """(() => {
  const sign = SIGN;
  const isThere = () => [...document.querySelectorAll(sign)].some((each) => each.getClientRects().length > 0);
  const taken = () => { window.__usable = performance.timeOrigin + performance.now(); };
  const look = () => {
    if (!isThere()) return;
    watch.disconnect();
    requestAnimationFrame(() => requestAnimationFrame(taken));
  };
  const watch = new MutationObserver(look);
  watch.observe(document, { subtree: true, childList: true, attributes: true });
})()"""
"""Takes the time (Unix milliseconds) when a sign is on the screen."""
OTHERS: Final = tuple(view for view in VIEWS if view != FLIGHT)
CALM: Final = "calm"
LOADS: Final = {CALM: "nothing opened", "views": "views opened", "report": "report.html asked for"}
"""Loads of the daemon in a minute of a flight, and their words."""
_SHOWN: Final = """() => JSON.stringify([
  document.visibilityState, document.querySelector('hawk-survey-map')?.dataset.drawn,
  document.body?.innerText.replaceAll(/\\s+/g, ' ').slice(0, 300)])"""
"""Words that a page shows, to say why it cannot be used."""
_COUNT: Final = """() => {
  window.__pictures = 0;
  const next = () => { window.__pictures += 1; requestAnimationFrame(next); };
  requestAnimationFrame(next);
}"""


@dataclass(frozen=True, slots=True)
class Site:
    """Address of the page, and ids of the lot and of its two newest surveys."""

    url: str
    lot: str
    before: str
    after: str

    def address(self, view: str) -> str:
        """Return the address of a view."""
        return self.url + VIEWS[view][0].format(lot=self.lot, before=self.before, after=self.after)


def store_with_a_day(folder: Path) -> tuple[str, str, str]:
    """Write the store below a daemon's folder; return the lot's id and those of its two newest surveys."""
    path = lots_file(folder, None)
    path.parent.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(STALLS)
    store = Database(path, {"synchronous": 0})
    try:
        first = flight(1, drawn_lot(STALLS, rng), Move(), rng)
        lot = fill(store, first, SURVEYS, lambda number: _FIRST.timestamp() + number * _EVERY_S)
    finally:
        store.close()
    before, after = (f"{SURVEYS - back:08d}-0000-4000-8000-000000000000" for back in (2, 1))
    picture = ground()
    for survey in (before, after):
        pictures_of(path).write(survey, picture)
    return lot, before, after


async def opened_ms(page: Page, address: str, sign: str) -> float:
    """Open an address and return the milliseconds until its sign is on the screen. Raises BenchmarkError."""
    await page.add_init_script(_WATCH.replace("SIGN", json.dumps(sign)))
    began = time.time()
    try:
        await page.goto(address, wait_until="commit", timeout=VIEW_MS)
        usable = await page.wait_for_function("() => window.__usable", timeout=VIEW_MS, polling=50)
    except Error as error:
        shown = await page.evaluate(_SHOWN)
        raise BenchmarkError(f"{address} did not show {sign}, but {shown}: {error}") from error
    return float(await usable.json_value()) - began * 1e3


async def view_ms(browser: Browser, site: Site, view: str, repeats: int) -> tuple[float, float]:
    """Return the medians of a view, cold and warm, milliseconds."""
    cold: list[float] = []
    warm: list[float] = []
    for _ in range(repeats):
        async with context_of(browser) as context:
            for times in (cold, warm):
                page = await window_of(context)
                times.append(await opened_ms(page, site.address(view), VIEWS[view][1]))
                await page.close()
    return statistics.median(cold), statistics.median(warm)


@contextlib.asynccontextmanager
async def context_of(browser: Browser) -> AsyncIterator[BrowserContext]:
    """Open a browser's window that has nothing in its cache."""
    context = await browser.new_context(viewport=_SIZE)
    try:
        yield context
    finally:
        await context.close()


async def window_of(context: BrowserContext) -> Page:
    """Open a window, and wait until the browser has drawn its own parts of it."""
    page = await context.new_page()
    await page.wait_for_timeout(SETTLE_MS)
    return page


async def pan_fps(browser: Browser, site: Site) -> tuple[float, float]:
    """Return the pictures a second while the survey's map is dragged, and while nothing moves."""
    async with context_of(browser) as context:
        page = await window_of(context)
        await opened_ms(page, site.address("lots"), VIEWS["lots"][1])
        await page.wait_for_load_state("networkidle")
        await page.evaluate(_COUNT)
        still = await _pictures(page, asyncio.sleep(PAN_S / 2))
        return await _pictures(page, _drag(page)), still


async def _pictures(page: Page, work: object) -> float:
    began, before = time.perf_counter(), await page.evaluate("() => window.__pictures")
    await work  # type: ignore[misc]
    after = await page.evaluate("() => window.__pictures")
    return float(after - before) / (time.perf_counter() - began)


async def _drag(page: Page) -> None:
    """Drag the map in circles, as a hand does."""
    box = await page.locator("hawk-survey-map .ol").first.bounding_box()
    if box is None:
        raise BenchmarkError("the survey's map is not drawn")
    middle = np.array([box["x"] + box["width"] / 2, box["y"] + box["height"] / 2])
    await page.mouse.move(*middle.tolist())
    await page.mouse.down()
    ends = time.perf_counter() + PAN_S
    turn = 0.0
    while time.perf_counter() < ends:
        turn += 0.08
        await page.mouse.move(*(middle + 150 * np.array([np.sin(turn), 1 - np.cos(turn)])).tolist())
    await page.mouse.up()


@dataclass(frozen=True, slots=True)
class Minute:
    """A minute of a flight: the daemon's account, and the number of answers or views meanwhile."""

    performance: Mapping[str, Any]
    asked: int


async def flown_minutes(browser: Browser, site: Site) -> dict[str, Minute]:
    """Hover, and return a minute for each of `LOADS`. Raises BenchmarkError."""
    pilot = await Pilot.connect(site.url)
    try:
        await pilot.reach(When.HOVERING)
        return {load: await _minute(browser, site, load) for load in LOADS}
    finally:
        await pilot.close()


async def _minute(browser: Browser, site: Site, load: str) -> Minute:
    ends, asked = time.monotonic() + WINDOW_S, 0
    async with aiohttp.ClientSession() as session:
        while time.monotonic() < ends:
            if load == "views":
                async with context_of(browser) as context:
                    view = OTHERS[asked % len(OTHERS)]
                    await opened_ms(await context.new_page(), site.address(view), VIEWS[view][1])
            elif load == "report":
                async with session.get(f"{site.url}api/v1/lots/{site.lot}/report.html") as answer:
                    await answer.read()
            else:
                await asyncio.sleep(1.0)
                continue
            asked += 1
    return Minute(await performance(site.url), asked)


def lag_figures(minutes: Mapping[str, Minute]) -> list[Figure]:
    """Return the lag of the loop in each minute, with the minute without anything beside it."""
    rows = []
    for load, minute in minutes.items():
        for name in ("p50", "p99", "max"):
            calm = None if load == CALM else Reference(LOADS[CALM], minutes[CALM].performance[f"loop_lag_{name}_ms"])
            limit = Limit(highest=LAG_MS) if name == "p99" else None
            value = minute.performance[f"loop_lag_{name}_ms"]
            rows.append(Figure(f"flown_{load}_lag_{name}_ms", f"{LOADS[load]}: lag, {name}", value, "ms", calm, limit))
        rows.append(Figure(f"flown_{load}_asked", f"{LOADS[load]}: number", float(minute.asked)))
        rows.append(
            Figure(f"flown_{load}_fps", f"{LOADS[load]}: frames fused", minute.performance["vision_fps"], "1/s")
        )
    return rows


async def first_kb(browser: Browser, site: Site) -> float:
    """Return what a browser loads for the flight view, kB as sent with gzip; the drone's own data aside."""
    sent: dict[str, int] = {}
    async with context_of(browser) as context:
        page = await context.new_page()

        async def keep(response: object) -> None:
            url = response.url  # type: ignore[attr-defined]
            if "/api/" not in url:
                with contextlib.suppress(Exception):
                    sent[url] = len(gzip.compress(await response.body(), 9))  # type: ignore[attr-defined]

        page.on("response", lambda response: asyncio.ensure_future(keep(response)))
        await opened_ms(page, site.address(FLIGHT), VIEWS[FLIGHT][1])
        await page.wait_for_timeout(1_000)
    return sum(sent.values()) / 1e3


async def measure(folder: Path, options: argparse.Namespace) -> list[Figure]:
    """Serve the page from a small computer and return the figures. Raises BenchmarkError."""
    executable = shutil.which("chromium")
    if executable is None:
        raise BenchmarkError("Chromium is not there: make setup browser")
    cores = sorted(os.sched_getaffinity(0))
    core = cores[-1] if options.core is None else options.core
    ids = store_with_a_day(folder / "store")
    box = make_box(core, round(options.memory * _MIB))
    try:
        os.sched_setaffinity(0, other_cores(core, cores))
        stack = BoxedStack(SimulationOptions(seed=1), folder, box)
        async with running(stack, folder) as ready, async_playwright() as playwright:
            browser = await playwright.chromium.launch(executable_path=executable, args=["--no-sandbox"])
            site = Site(ready.url.split("#")[0], *ids)
            if options.flown:
                return lag_figures(await flown_minutes(browser, site))
            found = {view: await view_ms(browser, site, view, options.repeats) for view in VIEWS}
            panned, still = await pan_fps(browser, site)
            kilobytes = await first_kb(browser, site)
            await browser.close()
    finally:
        os.sched_setaffinity(0, cores)
        box.remove()
    return figures(found, panned, still, kilobytes)


def figures(found: dict[str, tuple[float, float]], panned: float, still: float, kilobytes: float) -> list[Figure]:
    """Return the figures with their limits."""
    others = {view: times for view, times in found.items() if view != FLIGHT}
    cold = max(others, key=lambda view: others[view][0])
    rows = [
        Figure("flight_cold_ms", "flight: usable, cold", found[FLIGHT][0], "ms", limit=Limit(highest=1_500)),
        Figure("flight_warm_ms", "flight: usable, warm", found[FLIGHT][1], "ms"),
        Figure("views_cold_ms_max", f"slowest other view, cold ({cold})", others[cold][0], "ms",
               limit=Limit(highest=700)),
    ]  # fmt: skip
    for view, (once, again) in others.items():
        rows += [
            Figure(f"{view}_cold_ms", f"{view}: cold", once, "ms"),
            Figure(f"{view}_warm_ms", f"{view}: warm", again, "ms"),
        ]
    return [
        *rows,
        Figure("pan_fps", f"a survey of {STALLS} stalls with its picture, panned", panned, "1/s",
               Reference("nothing moves", still), Limit(lowest=30)),
        Figure("first_kb", "bytes of the first view, gzip", kilobytes, "kB", limit=Limit(highest=300)),
    ]  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print, write; return 1 when it could not be measured or a limit is missed."""
    parser = make_parser("benchmarks.page", __doc__)
    parser.add_argument("--flown", action="store_true", help="measure the loop's lag in a flight instead")
    parser.add_argument("--core", type=int, metavar="N", help="core of the daemon (default: the last)")
    parser.add_argument("--memory", type=float, default=1024.0, metavar="MIB", help="memory of the group (1024)")
    parser.add_argument(
        "--repeats", type=int, default=REPEATS, metavar="N", help=f"times that a view is opened ({REPEATS})"
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="keep logs and store here")
    options = parser.parse_args(arguments)
    with contextlib.ExitStack() as stack:
        folder = options.out or Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="hawk-page-")))
        try:
            section = Section("page", asyncio.run(measure(folder, options)))
        except BenchmarkError as error:
            print(f"page: {error}", file=sys.stderr)
            return 1
    return print_and_write([section], options.json)


if __name__ == "__main__":
    sys.exit(main())
