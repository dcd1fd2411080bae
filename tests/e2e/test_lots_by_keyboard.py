"""The lots on the page, by keyboard alone: what a survey proposes, and a survey whose place is not certain."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from playwright.async_api import Browser, Page, expect

from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.values import Doubtful, FinishedSurvey, PossiblePlace
from hawk.model.plans import Outline
from hawk.model.poses import GlobalPose
from tests.e2e.test_page_by_keyboard import faults, in_words, opened
from tests.e2e.watching import watch
from tests.unit.lots import whole
from tests.unit.lots.repaints import by_place, flown, repainted
from tests.unit.lots.surveys import DATUM

pytestmark = [pytest.mark.e2e, pytest.mark.asyncio(loop_scope="session")]

HERE = GlobalPose(48.137, 11.575, 0.0)
"""Place of the made-up drone."""


def here(given: FinishedSurvey) -> FinishedSurvey:
    """Return a survey of the lot as one about the made-up drone."""

    def moved(outline: Outline) -> Outline:
        north, east = HERE.latitude - DATUM.latitude, HERE.longitude - DATUM.longitude
        return Outline(tuple(tuple((a + north, b + east) for a, b in ring) for ring in outline.polygons))

    return replace(given, datum=HERE, outline=moved(given.outline), seen_ground=moved(given.seen_ground))


def doubtful(known: object, found: object) -> Doubtful:
    del known, found
    return Doubtful("two places fit alike", (PossiblePlace(0.0, 0.0, 0.0, 20.0), PossiblePlace(0.0, 2.78, 0.0, 19.0)))


@pytest.fixture
def store(tmp_path: Path) -> Path:
    """A lot that was painted again before its second survey; the third one is in doubt."""
    path = tmp_path / "lots.db"
    made = Database(path)
    with made.writing() as connection:
        save(connection, here(flown(1)))
        save(connection, here(repainted(2)), by_place)
        save(connection, here(repainted(3)), doubtful)
    made.close()
    return path


async def press_by_key(page: Page, name: str) -> None:
    await page.get_by_role("button", name=name, exact=True).focus()
    await page.keyboard.press("Enter")


async def test_a_repaint_is_shown_and_taken_over_and_a_doubt_is_answered(
    browser: Browser, fake: Any, store: Path, screenshots: Path
) -> None:
    _, address = await fake("ready", "--stalls", "20", "--lots", str(store))
    page = await opened(browser, address)
    errors = watch(page)
    await press_by_key(page, "Show survey")
    await expect(page.get_by_text("18 stalls begin, 20 stalls end")).to_be_visible()  # the store opens
    await expect(page.get_by_role("img", name="Place 2")).to_be_visible()
    await press_by_key(page, "Show on the map")
    await expect(page.get_by_role("button", name="Show on the map")).to_have_attribute("aria-pressed", "true")
    found = await faults(page, "lot-changes", screenshots)
    await page.set_viewport_size({"width": 390, "height": 844})
    found |= await faults(page, "lot-changes-phone", screenshots)
    await page.set_viewport_size({"width": 1440, "height": 900})
    await press_by_key(page, "Take over")
    await expect(page.get_by_text("18 stalls begin")).to_have_count(0)
    await press_by_key(page, "Here: place 1")
    await expect(page.get_by_text("Where was this survey?")).to_have_count(0)
    await page.screenshot(path=screenshots / "lots-after.png")
    assert not found, in_words(found)
    assert not errors
    opened_store = Database(store)
    with opened_store.reading() as connection:
        lot = whole.lot(connection, whole.lots(connection)[0]["id"])
    opened_store.close()
    assert (len(lot["stalls"]), len(lot["layouts"])) == (58, 2)
    assert [each["placed"] for each in lot["surveys"]] == ["first", "registered", "registered"]
