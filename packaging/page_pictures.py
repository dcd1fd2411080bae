"""Write the pictures of the page's views for the documentation: ``python packaging/page_pictures.py [VIEW ...]``.

A browser opens the page over the made-up drone of ``packaging/fake_drone.py`` and does what a person would.
The pictures go to ``docs/images/view-NAME.jpg``; ``docs/page.md`` shows them. A picture of a view of the lots over time
is a sheet: on a desk and on a phone, light in English, dark in French, and outdoors.
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
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray
from playwright.async_api import Browser, Page, async_playwright, expect

ROOT: Final = Path(__file__).resolve().parent.parent
IMAGES: Final = ROOT / "docs" / "images"
FAKE_DRONE: Final = ROOT / "packaging" / "fake_drone.py"
DESK: Final = (1280, 800)
PHONE: Final = (390, 844)
JPEG_QUALITY: Final = 80
START_S: Final = 60.0
PATIENCE_MS: Final = 60_000

SURVEYS: Final = 12
"""In the store of the views of lots over time."""
MOST_BYTES: Final = 120_000
SHEET_DESK: Final = (1440, 900)
SHEET_LOOKS: Final = (("light", "en"), ("dark", "fr"), ("outdoor", "en"))
"""Theme and language of the pictures of a sheet; the first one is the largest."""
ROWS: Final = (600, 293)
"""Heights of the rows of a sheet, pixels: the second row has as many pictures more as there are looks."""
GAP: Final = 13

Steps = Callable[[Page], Awaitable[None]]
Picture = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class View:
    """A view: the scene of the made-up drone, and the steps that lead to it."""

    name: str
    scene: str
    steps: tuple[Steps, ...] = ()
    size: tuple[int, int] = DESK
    theme: str = "light"


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
    View("plan", "still", (_seen(COUNTED), _tab("Stalls"), _correct_plan)),
    View("no-operator", "lost", (_seen(".banner"),)),
    View("outdoors", "explore", (_seen(COUNTED),), theme="outdoor"),
    View("dark", "explore", (_seen(COUNTED),), theme="dark"),
    View("phone", "still", (_seen(".ol"),), size=PHONE),
)


@dataclass(frozen=True, slots=True)
class Sheet:
    """A view of the lots over time: its address, what is seen when it is drawn, and the scene of the made-up drone."""

    name: str
    address: str
    sign: str
    scene: str = "ready"


MAP: Final = "hawk-survey-map[data-drawn=all]"
SHEETS: Final = (
    Sheet("lots", "#/lots/{lot}/{after}", MAP),
    Sheet("stalls-over-time", "#/lots/{lot}?show=stalls", MAP),
    Sheet("compare", "#/compare/{lot}/{before}/{after}", MAP),
    Sheet("report", "#/report/{lot}?part=row.A&days=mon-fri&hours=8-15", ".ask .answer .large"),
    Sheet("document", "#/report/{lot}?part=row.A&days=mon-fri&hours=8-15&show=document", "iframe"),
    Sheet("recordings", "#/recordings/{lot}", "archive-recordings table"),
    Sheet("film", "#/recordings/{lot}/{recording}?t=60", MAP),
    Sheet("lots-in-flight", "#/lots/{lot}/{after}", MAP, "still"),
)


@contextlib.asynccontextmanager
async def _drone(scene: str, surveys: int = 1) -> AsyncIterator[str]:
    """Run the made-up drone with a number of surveys in a store; gives the page's address."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, str(FAKE_DRONE), scene, "--port", "0"]
        command += ["--lots", str(Path(folder) / "lots.db"), "--surveys", str(surveys)]
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
    async with _drone(view.scene) as address:
        page = await _opened(browser, view.size, theme=view.theme)
        await page.goto(address)
        await expect(page.locator("hawk-glance").get_by_role("status")).not_to_be_empty(timeout=PATIENCE_MS)
        for step in view.steps:
            await step(page)
        await page.wait_for_timeout(1500)  # what a step has opened is drawn
        shown = await _shown(page)
        await page.close()
        _keep(target, shown)


async def _ids(page: Page, address: str) -> dict[str, str]:
    """Return the ids that addresses of views have."""

    async def items(path: str, key: str = "items") -> list[Any]:
        answer = await page.request.get(f"{address}api/v1/{path}")
        found: list[Any] = (await answer.json())[key]
        return found

    lot = (await items("lots"))[0]["id"]
    after, before = (each["id"] for each in await items(f"lots/{lot}/statistics/surveys?newest=2", "surveys"))
    return {"lot": lot, "before": before, "after": after, "recording": (await items("recordings"))[0]["name"]}


async def _looks(browser: Browser, size: tuple[int, int], sheet: Sheet, address: str) -> list[Picture]:
    """Return the pictures of a view in a window of a size, in each theme and language."""
    found = []
    for theme, language in SHEET_LOOKS:
        page = await _opened(browser, size, theme=theme, language=language)
        await page.goto(address + sheet.address.format(**await _ids(page, address)))
        await expect(page.locator(sheet.sign).first).to_be_visible(timeout=PATIENCE_MS)
        await page.wait_for_load_state("networkidle")
        await page.wait_for_timeout(1500)
        found.append(await _shown(page))
        await page.close()
    return found


async def _opened(browser: Browser, size: tuple[int, int], **preferences: str) -> Page:
    """Return a page whose preferences are these."""
    page = await browser.new_page(viewport={"width": size[0], "height": size[1]})
    page.set_default_timeout(PATIENCE_MS)
    stored = json.dumps({"name": "Anna", **preferences})
    await page.add_init_script(f"localStorage.setItem('hawk-page', {json.dumps(stored)})")
    return page


async def _shown(page: Page) -> Picture:
    shown = np.frombuffer(await page.screenshot(), np.uint8)
    return np.asarray(cv2.imdecode(shown, cv2.IMREAD_COLOR), np.uint8)


def _beside(pictures: list[Picture], height: int) -> Picture:
    """Return pictures beside each other, all of one height."""
    found: list[Picture] = []
    for picture in pictures:
        width = round(picture.shape[1] * height / picture.shape[0])
        resized = cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA)
        found += [np.asarray(resized, np.uint8), np.full((height, GAP, 3), 255, np.uint8)]
    return np.concatenate(found[:-1], axis=1)


def _composed(desk: list[Picture], phone: list[Picture]) -> Picture:
    """Return a sheet: the first look large, the others below it."""
    rows = [_beside([desk[0], phone[0]], ROWS[0]), _beside([*desk[1:], *phone[1:]], ROWS[1])]
    width = max(row.shape[1] for row in rows)
    padded = [np.pad(row, ((0, GAP), (0, width - row.shape[1]), (0, 0)), constant_values=255) for row in rows]
    return np.concatenate(padded)[:-GAP]


def _small(picture: Picture) -> bytes:
    """Return a picture as JPEG, as good as it may be large."""
    for quality in range(JPEG_QUALITY, 20, -4):
        data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()
        if len(data) <= MOST_BYTES:
            return data
    raise SystemExit("a sheet is too large: make its rows lower")


async def _photograph_sheets(browser: Browser, sheets: list[Sheet], scene: str) -> None:
    async with _drone(scene, SURVEYS) as address:
        for sheet in sheets:
            found = [await _looks(browser, size, sheet, address) for size in (SHEET_DESK, PHONE)]
            target = IMAGES / f"view-{sheet.name}.jpg"
            _keep(target, _composed(*found))


def _keep(target: Path, picture: Picture) -> None:
    target.write_bytes(_small(picture))
    print(f"{target.relative_to(ROOT)}: {target.stat().st_size // 1000} kB", flush=True)


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
        for scene in {sheet.scene for sheet in SHEETS}:
            chosen = [sheet for sheet in SHEETS if sheet.scene == scene and (not names or sheet.name in names)]
            if chosen:
                await _photograph_sheets(browser, chosen, scene)
        await browser.close()


def main() -> int:
    """Write all pictures, or those that are named."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("views", nargs="*", choices=[[], *(view.name for view in (*VIEWS, *SHEETS))], metavar="VIEW")
    asyncio.run(_write(set(parser.parse_args().views)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
