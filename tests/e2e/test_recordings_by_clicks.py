"""A flight is watched again: on the page of the drone that flew it, and from its file alone."""

from __future__ import annotations

import asyncio
import os
import re
import sys
from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path

import pytest
import pytest_asyncio
from playwright.async_api import Browser, Page, expect

from hawk.survey.stack import SimulatedStack
from tests.e2e.hands import button, confirm, hover, new_page, press, shows
from tests.e2e.test_page_by_keyboard import AXE, RUN_AXE
from tests.e2e.watching import watch
from tests.forked import start_program
from tests.pace import PATIENCE_S
from tests.unit.replay.recordings import flight, write

pytestmark = [pytest.mark.e2e, pytest.mark.asyncio(loop_scope="session")]

FOUND = "() => document.querySelector('hawk-app').model.flight.heartbeat.Free > 3"
SHOWN = "document.querySelector('archive-film').player.at"


async def watch_again(page: Page, screenshots: Path) -> None:
    """Play the film that is open, jump, and read what it says of a moment."""
    bar = page.get_by_role("region", name="Film of the flight")
    slider = bar.get_by_role("slider")
    await expect(page.get_by_role("heading", name="Recording, not live")).to_be_visible()
    began = await page.evaluate(SHOWN)
    await bar.get_by_role("combobox").select_option(label="16 ×")
    await bar.get_by_role("button", name="Play").click()
    await page.wait_for_function(f"(began) => {SHOWN} > began + 2", arg=began)
    await page.keyboard.press("Space")
    await expect(bar.get_by_role("button", name="Play")).to_be_visible()
    await expect(page).to_have_url(re.compile(r"\?t=\d"))
    await (
        page.get_by_role("region", name="Messages")
        .get_by_role("listitem")
        .filter(has_text="Exploring")
        .get_by_role("button")
        .first.click()
    )
    exploring = await page.evaluate(SHOWN)
    await page.keyboard.press("ArrowRight")
    await page.wait_for_function(f"(before) => {SHOWN} > before + 4", arg=exploring)
    await expect(page.get_by_text("until it must return")).to_be_visible()
    await slider.focus()
    await page.keyboard.press("End")
    await expect(page.get_by_text(re.compile(r"\d of \d+ stalls seen at this moment"))).to_be_visible()
    picture = page.get_by_role("img", name=re.compile("Recorded, "))
    await expect(picture).to_have_js_property("complete", True)
    assert await picture.evaluate("each => each.naturalWidth") > 0
    await page.screenshot(path=screenshots / "recording.png")
    assert await page.evaluate(RUN_AXE) == []


@pytest.mark.alone
async def test_a_flight_is_watched_again_where_it_was_flown(
    stack: SimulatedStack, browser: Browser, screenshots: Path
) -> None:
    ready = await stack.start()
    page = await new_page(browser, viewport={"width": 1440, "height": 900})
    await page.add_init_script(path=AXE)
    errors = watch(page)
    await page.goto(ready.url)
    await press(page, "Take control")
    await hover(page)
    await confirm(page, "Explore")
    await page.wait_for_function(FOUND)
    views = page.get_by_role("navigation", name="Views")
    await views.get_by_role("link", name="Recordings").click()
    await shows(page, "Under way")
    await press(page, "Land")
    await shows(page, "Landed")
    await views.get_by_role("link", name="Fly").click()
    await views.get_by_role("link", name="Recordings").click()
    await press(page, "Watch the flight of")
    await watch_again(page, screenshots)

    address = page.url
    await page.goto(address)
    await expect(page.get_by_role("region", name="Film of the flight")).to_be_visible()
    assert await page.evaluate(SHOWN) == pytest.approx(float(address.partition("t=")[2]), abs=0.2), "it can be sent"
    await views.get_by_role("link", name="Lots").click()
    await press(page, "Watch the flight of")
    await expect(page).to_have_url(re.compile(r"#/recordings/[0-9a-f-]{36}/\d{8}T\d{6}Z.mcap$"))
    await press(page, "Back to week")
    await expect(page.get_by_role("region", name="Surveys by day and hour")).to_be_visible()
    await page.locator("hawk-time-bar .tick.on").click()
    await expect(page.get_by_role("region", name="Film of the flight")).to_be_visible()
    await press(page, "All recordings")
    await shows(page, "1 recording,")
    assert not errors


@pytest_asyncio.fixture(loop_scope="session")
async def replayed(tmp_path: Path) -> AsyncIterator[Callable[[Path], Awaitable[str]]]:
    """Start ``hawk-drone replay`` for a file; return the address that it names."""
    started: list[asyncio.subprocess.Process] = []

    async def start(path: Path) -> str:
        process = await start_program(
            *(sys.executable, "-m", "hawk.cli", "replay", str(path), "--port", "0"),
            stdout=asyncio.subprocess.PIPE,
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
        )
        started.append(process)
        assert process.stdout is not None
        async with asyncio.timeout(PATIENCE_S):
            await process.stdout.readline()
            return (await process.stdout.readline()).decode().split()[-1]

    yield start
    for process in started:
        process.terminate()
        async with asyncio.timeout(PATIENCE_S):
            assert await process.wait() == 0


async def test_one_recording_is_shown_alone(
    browser: Browser, replayed: Callable[[Path], Awaitable[str]], tmp_path: Path
) -> None:
    path = write(tmp_path / "monday morning.mcap", flight(4, 3))
    page = await new_page(browser, viewport={"width": 390, "height": 844})
    errors = watch(page)
    await page.goto(await replayed(path))
    await expect(page.get_by_role("region", name="Film of the flight")).to_be_visible()
    await expect(page.get_by_role("navigation", name="Views").get_by_role("link")).to_have_text(["Recordings"])
    await expect(button(page, "Back to week")).to_have_count(0)
    await press(page, "All recordings")
    await press(page, "Delete")
    await press(page, "Delete")
    await shows(page, "is shown alone")
    assert path.exists()
    refused = "Failed to load resource"  # there are no lots here, and nothing is deleted
    assert not [each for each in errors if not each.startswith(refused)]
