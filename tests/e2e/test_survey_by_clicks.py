from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from playwright.async_api import Browser, expect

from hawk.survey.stack import SimulatedStack
from tests.e2e.hands import confirm, new_page, press, take_off, visible
from tests.e2e.watching import watch

pytestmark = [pytest.mark.e2e, pytest.mark.alone, pytest.mark.nightly, pytest.mark.asyncio(loop_scope="session")]


async def test_a_whole_survey_is_flown_with_clicks_only(
    stack: SimulatedStack, browser: Browser, screenshots: Path
) -> None:
    ready = await stack.start()
    page = await new_page(browser, viewport={"width": 1440, "height": 900})
    errors = watch(page)
    await page.goto(ready.url)
    await expect(visible(page, "SIMULATION")).to_be_visible()
    await press(page, "Take control")
    await take_off(page)
    await page.screenshot(path=screenshots / "1-taking-off.png")
    await confirm(page, "Explore")
    await expect(visible(page, "Exploring")).to_be_visible()
    await page.screenshot(path=screenshots / "2-exploring.png")
    again = page.get_by_role("button", name=re.compile("^Explore")).first
    await expect(again).not_to_have_attribute("aria-pressed", "true", timeout=240_000)  # nothing is left to see
    await expect(visible(page, "Explored: ")).to_be_visible()
    await page.screenshot(path=screenshots / "3-explored.png")
    await press(page, "Return home")
    await expect(visible(page, "On the ground")).to_be_visible(timeout=120_000)
    await page.screenshot(path=screenshots / "4-landed.png")

    status = await stack.status()
    assert status["landed"]
    assert status["disarmed"]
    assert not status["crashed"]
    assert status["excursions"] == 0
    found = json.loads(await (await page.request.get(f"{ready.url}api/stalls.geojson")).text())["features"]
    assert stack.truth is not None
    assert len(found) >= 0.8 * len(stack.truth.stalls)
    assert not errors
