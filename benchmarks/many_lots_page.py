"""Time until the page's map of all lots is drawn, of a desk with many lots.

``python -m benchmarks.many_lots_page [--lots N] [--stalls N] [--repeats N] [--json FILE]``

`benchmarks.many_lots_store` makes a store of one survey a lot, which a desk serves to Debian's Chromium: all pins are
on the screen, two pictures of the browser later, with nothing in its cache. The first time the desk has just begun, and
knows no lot's time zone yet. Once it has searched its store for damage, a lot is renamed before each time, so that the
desk reads them all again; then the map is opened once more. Medians count.
"""

from __future__ import annotations

import argparse
import asyncio
import shutil
import statistics
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import aiohttp
from playwright.async_api import Browser, async_playwright

from benchmarks.collect import until_served
from benchmarks.figures import BenchmarkError, Figure, Limit, Reference, Section, print_and_write
from benchmarks.many_lots import STALLS
from benchmarks.many_lots_store import fill
from benchmarks.options import make_parser
from benchmarks.page import context_of, opened_ms, window_of
from benchmarks.processes import OURS, cpu_time
from hawk.lots.store import FILE
from tests.integration.sim_support import free_tcp_port

PAINT_S: Final = 1.0
REPEATS: Final = 5
_SEARCHED_S: Final = 120.0
_IDLE_CORE: Final = 0.02
_IDLE_TIMES: Final = 4
_ADDRESS: Final = "#/lots?show=all"
_DRAWN: Final = "archive-all-lots[data-drawn=all] .ol canvas"


@dataclass(frozen=True, slots=True)
class Paints:
    """Seconds until the map is drawn: of a desk that has just begun, after changes of its lots, and without one."""

    first: float
    changed: Sequence[float]
    again: Sequence[float]


async def measure(folder: Path, repeats: int) -> Paints:
    """Open the map of the store in a folder. Raises BenchmarkError."""
    executable = shutil.which("chromium")
    if executable is None:
        raise BenchmarkError("Chromium is not there: make setup browser")
    port = free_tcp_port()
    command = [sys.executable, "-m", "hawk.cli", "desk", "--store", str(folder), "--port", str(port)]
    with (folder / "desk.log").open("wb") as log:
        desk = await asyncio.create_subprocess_exec(*command, stdin=asyncio.subprocess.DEVNULL, stdout=log, stderr=log)
    try:
        await until_served(port)
        async with async_playwright() as playwright:
            browser = await playwright.chromium.launch(executable_path=executable, args=["--no-sandbox"])
            url = f"http://127.0.0.1:{port}/"
            first = await _paint_s(browser, url)
            await _until_idle(desk.pid)
            changed, again = [], []
            for number in range(repeats):
                await _rename(url, f"Lot {number}")
                changed.append(await _paint_s(browser, url))
                again.append(await _paint_s(browser, url))
            await browser.close()
            return Paints(first, changed, again)
    finally:
        desk.terminate()
        await desk.wait()


async def _paint_s(browser: Browser, url: str) -> float:
    async with context_of(browser) as context:
        return await opened_ms(await window_of(context), f"{url}{_ADDRESS}", _DRAWN) / 1e3


async def _until_idle(desk: int) -> None:
    """Wait until the desk has searched its store for damage, which it does beside its answers. Raises TimeoutError."""
    async with asyncio.timeout(_SEARCHED_S):
        idle = 0
        while idle < _IDLE_TIMES:  # beside other programs the search may stand still for a second
            before = cpu_time(root=desk)
            await asyncio.sleep(1.0)
            idle = idle + 1 if cpu_time(root=desk).cores_since(before)[OURS] < _IDLE_CORE else 0


async def _rename(url: str, name: str) -> None:
    """Change a lot, as a person does. Raises ClientResponseError."""
    async with aiohttp.ClientSession(f"{url}api/v1/", raise_for_status=True) as session:
        async with session.get("lots?limit=1") as answer:
            (lot,) = (await answer.json())["items"]
        await session.post(f"lots/{lot['id']}/name", json={"name": name})


def figures(lots: int, times: Paints) -> Section:
    """Return the figures of all times that the map was opened."""
    changed, again = statistics.median(times.changed), statistics.median(times.again)
    limit, usual = Limit(highest=PAINT_S), Reference("nothing changed", again)
    return Section(
        f"page of {lots} lots",
        [
            Figure("map_paint_s", "all lots on the map are drawn, after a change", changed, "s", usual, limit),
            Figure("map_paint_again_s", "the same where nothing changed", again, "s", limit=limit),
            Figure("map_paint_first_s", "the same of a desk that has just begun", times.first, "s", usual),
        ],
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print; return the exit status."""
    parser: argparse.ArgumentParser = make_parser("benchmarks.many_lots_page", __doc__)
    parser.add_argument("--lots", type=int, default=10_000, help="lots of the store (default 10000)")
    parser.add_argument("--stalls", type=int, default=STALLS, help=f"stalls of each (default {STALLS})")
    parser.add_argument("--repeats", type=int, default=REPEATS, help=f"times that it is opened (default {REPEATS})")
    parser.add_argument("--out", type=Path, metavar="DIR", help="keep the store here, or use the one that is here")
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory(prefix="hawk-many-lots-") as made:
        folder = options.out or Path(made)
        folder.mkdir(parents=True, exist_ok=True)
        if not (folder / FILE).exists():
            fill(folder / FILE, options.lots, 1, options.stalls)
        try:
            times = asyncio.run(measure(folder, options.repeats))
        except BenchmarkError as error:
            print(f"page: {error}", file=sys.stderr)
            return 1
    return print_and_write([figures(options.lots, times)], options.json)


if __name__ == "__main__":
    sys.exit(main())
