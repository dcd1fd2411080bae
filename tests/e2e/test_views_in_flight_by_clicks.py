"""A plan is corrected while the drone flies, and other views are opened: the operator stays, and so does what keeps the
flight safe. One flight shows both."""

from __future__ import annotations

from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path

import pytest
import pytest_asyncio
from playwright.async_api import Browser, Dialog, Page, expect

from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.store import FILE
from hawk.model.poses import GlobalPose
from tests.e2e.hands import button, hover, new_page, press, shows, state_is
from tests.e2e.test_plan_by_clicks import Store, chosen, correct, done
from tests.e2e.watching import watch
from tests.integration.daemon_support import LOW_HEIGHTS, over_a_picture
from tests.unit.lots.surveys import box, survey

pytestmark = [pytest.mark.e2e, pytest.mark.asyncio(loop_scope="session")]

LONGER_THAN_PRESENCE_S = 30.0
"""Seconds of the drone: an operator who is not there is lost after 3 s, and 10 s later the drone flies home."""
NOW = "() => document.querySelector('hawk-app').model.flight.heartbeat.Time"


HERE = GlobalPose(43.2607, -79.9189, 0.0)
"""Beside the place where hawk-sim's drone stands."""


@pytest_asyncio.fixture(loop_scope="session")
async def url(tmp_path: Path) -> AsyncIterator[str]:
    """The page of a real daemon with a lot in its store."""
    stack = over_a_picture(tmp_path, LOW_HEIGHTS)
    ground = box(-14, -3, 20, 54, HERE)
    database = Database(tmp_path / "run" / "store" / FILE)
    with database.writing() as connection:
        save(connection, replace(survey(), datum=HERE, outline=ground, seen_ground=ground))
    database.close()
    try:
        yield (await stack.start()).url
    finally:
        await stack.stop()


async def later(page: Page, seconds: float = LONGER_THAN_PRESENCE_S) -> None:
    then = await page.evaluate(NOW) + seconds
    await page.wait_for_function(f"(then) => ({NOW})() > then", arg=then)


@pytest.mark.fault(
    "an operator in flight opens another view, presses reload, or goes back",
    "the drone holds on: the operator stays present, Hold, Return home and Land stay in reach, and the browser asks "
    "before the page goes",
)
async def test_no_view_ends_the_operators_presence(url: str, browser: Browser, screenshots: Path) -> None:
    page = await new_page(browser, viewport={"width": 1440, "height": 900})
    errors = watch(page)
    await page.goto(url)
    await press(page, "Take control")
    await hover(page)
    await the_plan_is_corrected(page, Store(url), screenshots)
    views = page.get_by_role("navigation", name="Views")
    for name in ("Lots", "Compare", "Report", "Recordings"):
        await views.get_by_role("link", name=name).click()
        await expect(page.get_by_role("main").locator(".page")).to_be_visible()
        for action in ("Hold", "Return home", "Land", "Cut motors"):
            await expect(button(page, action)).to_be_visible()
    await page.screenshot(path=screenshots / "views-in-flight.png")
    await later(page)
    await state_is(page, "Holding")

    asked: list[str] = []

    async def stay(dialog: Dialog) -> None:
        asked.append(dialog.type)
        await dialog.dismiss()

    page.on("dialog", stay)
    await page.evaluate("setTimeout(() => location.reload())")
    await page.wait_for_event("dialog")
    await state_is(page, "Holding")
    await page.go_back()
    await later(page, LONGER_THAN_PRESENCE_S / 2)  # flying home would have begun
    await state_is(page, "Holding")
    assert asked == ["beforeunload"], "the browser asks once, and going back within the page needs no question"

    await press(page, "Land")
    await shows(page, "Landed")
    await page.reload()
    assert asked == ["beforeunload"], "on the ground the page may go"
    assert not errors


async def the_plan_is_corrected(page: Page, store: Store, screenshots: Path) -> None:
    """The bar of the flight stays, and Hold is in reach."""
    await correct(page)
    await shows(page, "Placed by GNSS alone")
    before = await store.stalls()
    await page.mouse.dblclick(*await at_stall(page, "A 5"))
    await expect(chosen(page)).to_have_text("20 stalls are chosen")
    await press(page, "Confirm")
    await done(page)
    after = await store.stalls()
    assert {label for label in before if after[label]["is_confirmed"]} == {f"A {n}" for n in range(1, 21)}
    await page.screenshot(path=screenshots / "plan-in-flight.png")
    await press(page, "Hold")
    await press(page, "Move")
    await page.locator(".ol").click(position={"x": 300, "y": 300})
    await expect(page.locator("hawk-slide button")).to_be_visible()
    await press(page, "Cancel")
    await page.keyboard.press("Control+z")
    await done(page)
    assert await store.stalls() == before
    await press(page, "Close the edit")
    await shows(page, "The plan is as it was")


async def at_stall(page: Page, label: str) -> tuple[float, float]:
    """Return where a stall of the plan is on the screen, which may lie in another frame than the map's."""
    x, y = await page.evaluate(
        """(label) => {
          const map = document.querySelector("hawk-map");
          const { left, top } = map.querySelector(".ol").getBoundingClientRect();
          const far = [-1e4, -1e4, 1e4, 1e4];
          const { north, east } = map.plan.editor.layer.within(far).find((stall) => stall.label === label);
          const [x, y] = map.lot.pixelOf({ North: north, East: east });
          return [left + x, top + y];
        }""",
        label,
    )
    return x, y
