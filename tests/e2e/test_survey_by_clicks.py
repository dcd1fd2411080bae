from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from playwright.async_api import Browser, Page, expect

from hawk.survey.stack import SimulatedStack
from tests.e2e.hands import confirm, new_page, press, shows, visible
from tests.e2e.watching import watch

pytestmark = [pytest.mark.e2e, pytest.mark.alone, pytest.mark.nightly, pytest.mark.asyncio(loop_scope="session")]


async def test_a_whole_survey_is_flown_with_clicks_only_and_flown_again(
    stack: SimulatedStack, browser: Browser, screenshots: Path
) -> None:
    ready = await stack.start()
    page = await new_page(browser, viewport={"width": 1440, "height": 900})
    errors = watch(page)
    await page.goto(ready.url)
    await expect(visible(page, "SIMULATION")).to_be_visible()
    await press(page, "Take control")
    await press(page, "Set failsafes")  # they last
    await fly_a_survey(page, screenshots, "first")
    status = await stack.status()
    assert status["landed"]
    assert status["disarmed"]
    assert not status["crashed"]
    assert status["excursions"] == 0
    found = json.loads(await (await page.request.get(f"{ready.url}api/stalls.geojson")).text())["features"]
    assert stack.truth is not None
    assert len(found) >= 0.8 * len(stack.truth.stalls)

    await shows(page, "1 survey")
    await press(page, "Survey again")
    await shows(page, "begin a new survey first; the earlier one stays stored")
    await confirm(page, "New survey")
    await press(page, "Survey again")
    await shows(page, "Lot 1 will be surveyed again by Explore.")
    await fly_a_survey(page, screenshots, "again")
    await shows(page, "2 surveys")
    lot, *_ = (await (await page.request.get(f"{ready.url}api/v1/lots")).json())["items"]
    surveys = (await (await page.request.get(f"{ready.url}api/v1/lots/{lot['id']}/surveys")).json())["items"]
    assert [each["placed"] for each in surveys] == ["first", "registered"]
    looks = await (await page.request.get(f"{ready.url}api/v1/surveys/{surveys[-1]['id']}")).json()
    assert looks["free"] + looks["taken"] >= 0.9 * len(found)
    assert not errors


async def fly_a_survey(page: Page, screenshots: Path, name: str) -> None:
    """Take off, explore until nothing is left to see, and land at home."""
    await confirm(page, "Arm")
    await confirm(page, "Take off")
    await page.screenshot(path=screenshots / f"{name}-1-taking-off.png")
    await confirm(page, "Explore")
    await expect(visible(page, "Exploring")).to_be_visible()
    await page.screenshot(path=screenshots / f"{name}-2-exploring.png")
    explore = page.get_by_role("button", name=re.compile("^Explore")).first
    await expect(explore).not_to_have_attribute("aria-pressed", "true", timeout=240_000)  # nothing is left to see
    await expect(visible(page, "Explored: ")).to_be_visible()
    await page.screenshot(path=screenshots / f"{name}-3-explored.png")
    await press(page, "Return home")
    await expect(visible(page, "On the ground")).to_be_visible(timeout=120_000)
    await page.screenshot(path=screenshots / f"{name}-4-landed.png")
