"""The operator page over many stalls: its first paint, and frames a second of its map while it is moved.

``python -m benchmarks.map_frames [--stalls 2100] [--seconds 4] [--gpu] [--json FILE]``

The real page over a made-up drone that knows a field of stalls, in Chromium without a window. Each case moves the map
with the pointer by a few pixels a frame, from within the page, and counts the frames that the browser draws; it draws
60 a second at most. Two cases show the plan of the lot while it is corrected: the map is moved, and with every frame
another stall is chosen. The last case turns the map, as it does while the
drone's nose is up. Without ``--gpu`` the processor draws everything. The first paint is that of a browser that never
saw the page (First Contentful Paint, https://w3c.github.io/paint-timing/), beside a page of one word.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import sys
import tempfile
from collections.abc import AsyncIterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Any, Final, Literal

import numpy as np
from playwright.async_api import Browser, Page, ViewportSize, async_playwright

from benchmarks.figures import BenchmarkError, Figure, Limit, Reference, Section, print_and_write
from benchmarks.options import make_parser
from benchmarks.whole_daemon import CHROMIUM

ROOT: Final = Path(__file__).resolve().parent.parent
FAKE_DRONE: Final = ROOT / "packaging" / "fake_drone.py"
LEAST_FPS: Final = {False: 40.0, True: 58.0}
"""Without and with a GPU; 60 is what the screen shows, and a frame may be missed."""
LOAD_S: Final = 120.0
STEP_PX: Final = 7
FIRST_PAINT_MS: Final = 1000.0
LOADS: Final = 5
SIZE: Final = ViewportSize(width=1440, height=900)
WORD: Final = "data:text/html,word"
PAINTED: Final = "() => performance.getEntriesByName('first-contentful-paint')[0]?.startTime"

MOVE: Final = """async ({ seconds, step, how }) => {
  const map = document.querySelector(".ol-viewport");
  const box = map.getBoundingClientRect();
  const send = (target, type, x, buttons) => target.dispatchEvent(new PointerEvent(type, {
    bubbles: true, pointerId: 1, isPrimary: true, pointerType: "mouse", button: 0, buttons,
    clientX: x, clientY: box.top + box.height / 2 }));
  const middle = box.left + box.width / 2;
  const app = document.querySelector("hawk-app");
  const stalls = [...app.model.plan.plan.stalls.keys()];
  const frame = () => new Promise((resolve) => requestAnimationFrame(resolve));
  const times = [];
  let [x, dx] = [middle, step];
  if (how === "moved") send(map, "pointerdown", x, 1);
  const began = await frame();
  while (performance.now() - began < seconds * 1000) {
    times.push(await frame());
    if (how === "chosen") {
      app.model.plan.choose([stalls[times.length % stalls.length]]);
      continue;
    }
    if (how === "turned") {
      app.model.flight.heartbeat.Yaw += 0.05;
      app.model.dispatchEvent(new Event("change"));
      continue;
    }
    if (Math.abs(x + dx - middle) > 500) dx = -dx;
    x += dx;
    send(document, "pointermove", x, 1);
  }
  if (how === "moved") send(document, "pointerup", x, 0);
  return times;
}"""


@dataclass(frozen=True, slots=True)
class Case:
    """One look at the map: presses of Zoom in after Whole lot (below 0: Zoom out), and the change with each frame."""

    key: str
    text: str
    zoom: int
    how: Literal["moved", "chosen", "turned"] = "moved"
    has_plan: bool = False
    """The lot's plan is corrected."""


CASES: Final = (
    Case("far", "whole field and around, moved", -2),
    Case("whole", "whole field, moved", 0),
    Case("near", "some rows, moved", 2),
    Case("nearest", "a few stalls, moved", 5),
    Case("plan", "whole field with its plan, moved", 0, has_plan=True),
    Case("plan_chosen", "whole field with its plan, another stall chosen", 0, "chosen", has_plan=True),
    Case("turned", "whole field, turned with the drone", 0, "turned"),
)


def figures_of(case: Case, times: Sequence[float], limit: float | None) -> list[Figure]:
    """Return frames a second and the frames that came late, from the times (milliseconds) of a case's frames.

    Raises:
        BenchmarkError: The browser drew too few frames to say anything.
    """
    if len(times) < 10:
        raise BenchmarkError(f"{case.text}: {len(times)} frames")
    intervals = [later - earlier for earlier, later in pairwise(times)]
    rate = 1e3 * len(intervals) / sum(intervals)
    lowest = None if limit is None else Limit(lowest=limit)
    return [
        Figure(f"{case.key}_fps", f"{case.text}: frames", rate, "1/s", limit=lowest),
        Figure(f"{case.key}_frame_ms_p95", "time between two of them, p95", float(np.percentile(intervals, 95)), "ms"),
        Figure(f"{case.key}_frame_ms_max", "longest", max(intervals), "ms"),
    ]


def paint_figures(page_ms: Sequence[float], word_ms: Sequence[float]) -> list[Figure]:
    """Return the first paint, from the times (milliseconds) of several loads of the page and of a page of one word."""
    reference = Reference("a page of one word", median(word_ms))
    return [
        Figure(
            "first_paint_ms", "first paint, median", median(page_ms), "ms", reference, Limit(highest=FIRST_PAINT_MS)
        ),
        Figure("first_paint_ms_max", "first paint, longest", max(page_ms), "ms"),
    ]


async def measure(stalls: int, seconds: float, *, gpu: bool) -> list[Figure]:
    """Measure the first paint and every case, one after the other."""
    async with _drone(stalls) as url, _browser(gpu=gpu) as browser:
        painted = [await _first_paint(browser, url) for _ in range(LOADS)]
        of_a_word = [await _first_paint(browser, WORD) for _ in range(LOADS)]
        figures = paint_figures(painted, of_a_word)
        page = await _shown(browser, url, stalls)
        for case in CASES:
            times = await _case(page, case, seconds)
            figures += figures_of(case, times, LEAST_FPS[gpu] if case.how == "moved" else None)
    return figures


async def _case(page: Page, case: Case, seconds: float) -> list[float]:
    await _show_plan(page, shown=case.has_plan)
    name = "Zoom in" if case.zoom > 0 else "Zoom out"
    await page.get_by_role("button", name="Whole lot").click()
    for _ in range(abs(case.zoom)):
        await page.wait_for_timeout(300)
        await page.get_by_role("button", name=name).click()
    if case.how == "turned":
        await page.get_by_role("button", name="Turn the map with the drone").click()
    await page.wait_for_timeout(1500)
    return list(await page.evaluate(MOVE, {"seconds": seconds, "step": STEP_PX, "how": case.how}))


async def _show_plan(page: Page, *, shown: bool) -> None:
    tools = page.locator(".plantools")
    if shown is (await tools.count() > 0):
        return
    if shown:
        await page.get_by_role("tab", name="Stalls").click()
        await page.get_by_role("button", name="Correct the plan").click()
        await tools.wait_for(timeout=LOAD_S * 1e3)
    else:
        await page.get_by_role("button", name="Leave the plan").click()


@contextlib.asynccontextmanager
async def _drone(stalls: int) -> AsyncIterator[str]:
    """Run the made-up drone with its lot in a store; gives the page's address."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, str(FAKE_DRONE), "still", "--port", "0", "--stalls", str(stalls)]
        command += ["--lots", str(Path(folder) / "lots.db")]
        drone = await asyncio.create_subprocess_exec(*command, cwd=ROOT, stdout=asyncio.subprocess.PIPE)
        try:
            assert drone.stdout is not None
            async with asyncio.timeout(LOAD_S):
                address = await drone.stdout.readline()
            yield address.decode().strip()
        finally:
            if drone.returncode is None:
                drone.kill()
            await drone.wait()


@contextlib.asynccontextmanager
async def _browser(*, gpu: bool) -> AsyncIterator[Browser]:
    flags = ["--headless=new", "--no-sandbox", "--disable-quic", "--enable-gpu" if gpu else "--disable-gpu"]
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(executable_path=CHROMIUM, args=flags)
        try:
            yield browser
        finally:
            await browser.close()


async def _first_paint(browser: Browser, url: str) -> float:
    """Return the time (milliseconds) from the request to the first paint, without anything kept of an earlier visit."""
    page = await browser.new_page(viewport=SIZE)
    try:
        await page.goto(url)
        found = await page.wait_for_function(PAINTED, timeout=LOAD_S * 1e3)
        return float(await found.json_value())
    finally:
        await page.close()


async def _shown(browser: Browser, url: str, stalls: int) -> Page:
    """Show the page until it knows every stall and has their pictures."""
    page = await browser.new_page(viewport=SIZE)
    known = _watch_stalls(page, stalls)
    await page.goto(url)
    async with asyncio.timeout(LOAD_S):
        await known.wait()
    await page.wait_for_load_state("networkidle")
    return page


def _watch_stalls(page: Page, count: int) -> asyncio.Event:
    """Return an event that is set when the page knows this number of stalls."""
    known: set[int] = set()
    all_known = asyncio.Event()

    def take(payload: str | bytes) -> None:
        message: dict[str, Any] = json.loads(payload) if isinstance(payload, str) else {}
        known.update(each["Id"] for each in (message.get("Occupancy Map") or {}).get("Stalls", ()))
        if len(known) >= count:
            all_known.set()

    page.on("websocket", lambda socket: socket.on("framereceived", take))
    return all_known


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print the table; return 1 when a limit is missed."""
    parser = make_parser("benchmarks.map_frames", __doc__)
    parser.add_argument("--stalls", type=int, default=2100)
    parser.add_argument("--seconds", type=float, default=4.0, help="of each case")
    parser.add_argument("--gpu", action="store_true", help="let the browser draw with the graphics card")
    options = parser.parse_args(arguments)
    figures = asyncio.run(measure(options.stalls, options.seconds, gpu=options.gpu))
    section = Section(f"map, {options.stalls} stalls, {'GPU' if options.gpu else 'no GPU'}", figures)
    return print_and_write([section], options.json, stalls=options.stalls, gpu=options.gpu)


if __name__ == "__main__":
    sys.exit(main())
