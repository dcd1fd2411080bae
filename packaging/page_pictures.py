"""Write the pictures of the page's views for the documentation: ``python packaging/page_pictures.py [VIEW ...]``.

A browser opens the page over the made-up drone of ``packaging/fake_drone.py`` and does what a person would.
The pictures go to ``docs/images/view-NAME.jpg``; ``docs/page.md`` shows them.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import re
import shutil
import sys
import tempfile
from collections.abc import AsyncIterator, Awaitable, Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from playwright.async_api import Browser, Page, async_playwright, expect

ROOT: Final = Path(__file__).resolve().parent.parent
IMAGES: Final = ROOT / "docs" / "images"
FAKE_DRONE: Final = ROOT / "packaging" / "fake_drone.py"
DESK: Final = (1280, 800)
PHONE: Final = (390, 844)
JPEG_QUALITY: Final = 80
START_S: Final = 60.0
PATIENCE_MS: Final = 60_000

Steps = Callable[[Page], Awaitable[None]]


@dataclass(frozen=True, slots=True)
class View:
    """A view: the scene of the made-up drone, and the steps that lead to it."""

    name: str
    scene: str
    steps: tuple[Steps, ...] = ()
    size: tuple[int, int] = DESK
    theme: str = "light"
    has_lots: bool = False
    """The made-up drone keeps its lot in a store."""


async def _control(page: Page) -> None:
    await _press("Take control")(page)
    await expect(page.locator(".guided")).to_be_visible(timeout=PATIENCE_MS)


def _press(name: str) -> Steps:
    async def press(page: Page) -> None:
        await page.get_by_role("button", name=re.compile(f"^{name}")).locator("visible=true").first.click()

    return press


def _tab(name: str) -> Steps:
    async def choose(page: Page) -> None:
        await page.get_by_role("tab", name=name).click()

    return choose


def _seen(*stalls: str) -> Steps:
    async def wait(page: Page) -> None:
        for each in stalls:
            await expect(page.locator(each).first).to_be_visible(timeout=PATIENCE_MS)
        await page.wait_for_timeout(4000)  # tiles, plots and the trail are drawn one after the other

    return wait


async def _search_settings(page: Page) -> None:
    await page.locator(".all-settings summary").click()
    await page.get_by_label("Search settings").fill("battery")
    await page.get_by_label("Search settings").evaluate("field => field.scrollIntoView()")


async def _ask_move(page: Page) -> None:
    await page.keyboard.press("h")
    await _press("Move")(page)
    await page.locator(".ol").click(position={"x": 420, "y": 260})
    await expect(page.locator("hawk-slide button")).to_be_enabled(timeout=PATIENCE_MS)


async def _keys(page: Page) -> None:
    await page.keyboard.press("?")


async def _correct_plan(page: Page) -> None:
    await _press("Correct the plan")(page)
    await expect(page.locator("hawk-plan-chosen")).to_be_visible(timeout=PATIENCE_MS)
    for row, action in (("B", "Confirm"), ("E", "Confirm"), ("C", "")):
        await page.locator("hawk-plan-chosen select[name=row]").select_option(row)
        if action:
            await _press(action)(page)


COUNTED: Final = "hawk-counts [data-count]"
VIEWS: Final = (
    View("watching", "explore", (_seen(COUNTED),)),
    View("checks", "failed", (_control, _tab("Checks"))),
    View("before-flight", "ready", (_control,)),
    View("exploring", "explore", (_control, _seen(COUNTED))),
    View("move", "still", (_control, _ask_move)),
    View("cut-motors", "still", (_control, _press("Cut motors"))),
    View("messages", "still", (_control, _tab("Messages"))),
    View("stalls", "still", (_seen(COUNTED), _tab("Stalls"))),
    View("settings", "still", (_control, _tab("Settings"), _search_settings)),
    View("keys", "still", (_keys,)),
    View("result", "landed", (_seen("hawk-survey .hero"),)),
    View("plan", "still", (_seen(COUNTED), _tab("Stalls"), _correct_plan), has_lots=True),
    View("no-operator", "lost", (_seen(".banner"),)),
    View("outdoors", "explore", (_seen(COUNTED),), theme="outdoor"),
    View("dark", "explore", (_seen(COUNTED),), theme="dark"),
    View("phone", "still", (_seen(".ol"),), size=PHONE),
)


@contextlib.asynccontextmanager
async def _drone(view: View) -> AsyncIterator[str]:
    """Run the made-up drone; gives the page's address."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, str(FAKE_DRONE), view.scene, "--port", "0"]
        if view.has_lots:
            command += ["--lots", str(Path(folder) / "lots.db")]
        process = await asyncio.create_subprocess_exec(*command, stdout=asyncio.subprocess.PIPE)
        try:
            assert process.stdout is not None  # noqa: S101 - it is a pipe
            async with asyncio.timeout(START_S):
                address = await process.stdout.readline()
            yield address.decode().strip()
        finally:
            process.kill()
            await process.wait()


async def _photograph(browser: Browser, view: View, target: Path) -> None:
    async with _drone(view) as address:
        width, height = view.size
        page = await browser.new_page(viewport={"width": width, "height": height})
        page.set_default_timeout(PATIENCE_MS)
        stored = json.dumps({"theme": view.theme, "name": "Anna"})
        await page.add_init_script(f"localStorage.setItem('hawk-page', {json.dumps(stored)})")
        await page.goto(address)
        await expect(page.locator("hawk-glance").get_by_role("status")).not_to_be_empty(timeout=PATIENCE_MS)
        for step in view.steps:
            await step(page)
        await page.wait_for_timeout(1500)  # what a step has opened is drawn
        await page.screenshot(path=target, type="jpeg", quality=JPEG_QUALITY)
        await page.close()


async def _write(names: set[str]) -> None:
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(
            executable_path=shutil.which("chromium") or "/usr/bin/chromium",
            args=["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic"],
        )
        for view in VIEWS:
            if not names or view.name in names:
                target = IMAGES / f"view-{view.name}.jpg"
                await _photograph(browser, view, target)
                print(f"{target.relative_to(ROOT)}: {target.stat().st_size // 1000} kB", flush=True)
        await browser.close()


def main() -> int:
    """Write all pictures, or those that are named."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("views", nargs="*", choices=[[], *(view.name for view in VIEWS)], metavar="VIEW")
    asyncio.run(_write(set(parser.parse_args().views)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
