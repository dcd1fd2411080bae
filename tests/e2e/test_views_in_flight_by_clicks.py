"""Another view is opened while the drone flies: the operator stays, and so does what keeps the flight safe."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.async_api import Browser, Dialog, Page, expect

from hawk.survey.stack import SimulatedStack
from tests.e2e.hands import button, hover, new_page, press, shows, state_is
from tests.e2e.watching import watch

pytestmark = [pytest.mark.e2e, pytest.mark.alone, pytest.mark.asyncio(loop_scope="session")]

LONGER_THAN_PRESENCE_S = 30.0
"""Seconds of the drone: an operator who is not there is lost after 3 s, and 10 s later the drone flies home."""
NOW = "() => document.querySelector('hawk-app').model.flight.heartbeat.Time"


async def later(page: Page, seconds: float = LONGER_THAN_PRESENCE_S) -> None:
    then = await page.evaluate(NOW) + seconds
    await page.wait_for_function(f"(then) => ({NOW})() > then", arg=then)


@pytest.mark.fault(
    "an operator in flight opens another view, presses reload, or goes back",
    "the drone holds on: the operator stays present, Hold, Return home and Land stay in reach, and the browser asks "
    "before the page goes",
)
async def test_no_view_ends_the_operators_presence(stack: SimulatedStack, browser: Browser, screenshots: Path) -> None:
    ready = await stack.start()
    page = await new_page(browser, viewport={"width": 1440, "height": 900})
    errors = watch(page)
    await page.goto(ready.url)
    await press(page, "Take control")
    await hover(page)
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
