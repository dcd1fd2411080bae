"""A person's actions on a page."""

from __future__ import annotations

import re
from typing import Any

from playwright.async_api import Browser, Locator, Page, expect

from tests.pace import PATIENCE_S

PATIENCE_MS = PATIENCE_S * 1e3


async def new_page(browser: Browser, **options: Any) -> Page:
    """Open an empty page in a context of its own, with these options, for people who have patience."""
    expect.set_options(timeout=PATIENCE_MS)
    context = await browser.new_context(**options)
    context.set_default_timeout(PATIENCE_MS)
    return await context.new_page()


def button(page: Page, name: str) -> Locator:
    """Return the first visible button whose name begins so."""
    return page.get_by_role("button", name=re.compile(f"^{name}")).locator("visible=true").first


async def press(page: Page, name: str) -> None:
    """Click a button as soon as a person could."""
    await button(page, name).click()


def visible(page: Page, text: str) -> Locator:
    """Return the first place that shows the text."""
    return page.get_by_text(text).locator("visible=true").first


async def shows(page: Page, text: str) -> None:
    """Wait until the text can be read."""
    await expect(visible(page, text)).to_be_visible()


async def state_is(page: Page, title: str) -> None:
    """Wait until the line that is read at a glance says so."""
    await expect(page.locator("hawk-glance").get_by_role("status")).to_have_text(title)


async def keep_pressed(page: Page, target: Locator, milliseconds: float) -> None:
    """Press the mouse on something and let go after so long."""
    await target.hover()
    await page.mouse.down()
    await page.wait_for_timeout(milliseconds)
    await page.mouse.up()


async def slide(page: Page, target: Locator) -> None:
    """Slide from the left end to the right one."""
    box = await target.bounding_box()
    assert box is not None
    middle = box["y"] + box["height"] / 2
    await page.mouse.move(box["x"] + 20, middle)
    await page.mouse.down()
    await page.mouse.move(box["x"] + box["width"] / 2, middle, steps=5)
    await page.mouse.move(box["x"] + box["width"] + 10, middle, steps=5)
    await page.mouse.up()


async def hold_enter(page: Page) -> None:
    """Keep Enter down until the slide has gone; press again where the page was too busy to follow, and says so."""
    over = "() => !document.querySelector('hawk-confirm') || document.querySelector('hawk-slide').missed"
    for _ in range(5):
        await page.keyboard.down("Enter")
        await page.wait_for_function(over)
        await page.keyboard.up("Enter")
        if not await page.locator("hawk-confirm").count():
            return
        await shows(page, "The page was busy: again")
    await expect(page.locator("hawk-confirm")).to_have_count(0)


async def confirm(page: Page, name: str) -> None:
    """Click a button that asks first, and slide. While checks fail, Arm shows them instead: a person waits for them."""
    await expect(button(page, name)).not_to_contain_text("failed")
    await press(page, name)
    track = page.locator("hawk-slide button")
    await expect(track).to_be_enabled()
    await slide(page, track)


async def take_off(page: Page) -> None:
    """Set failsafes, arm and take off; this person has control."""
    await press(page, "Set failsafes")
    await confirm(page, "Arm")
    await confirm(page, "Take off")


async def hover(page: Page) -> None:
    """Take off, and wait until it holds."""
    await take_off(page)
    await state_is(page, "Holding")


async def drawn(page: Page) -> None:
    """Wait until the page is drawn as it stands."""
    await page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


async def resize(page: Page, width: int, height: int) -> None:
    """Give the window a size, and wait until the page is drawn in it."""
    await page.set_viewport_size({"width": width, "height": height})
    await drawn(page)


async def prefer_hand(page: Page, is_left: bool) -> None:
    """Choose the hand that acts, and wait until the page stands so."""
    await page.evaluate(f"document.querySelector('hawk-app').model.prefer({{ leftHanded: {str(is_left).lower()} }})")
    await page.wait_for_function("(is) => document.documentElement.classList.contains('left') === is", arg=is_left)
    await drawn(page)


MIDDLE = """(target) => {
  const { left, top, width, height } = target.getBoundingClientRect();
  const there = document.elementFromPoint(left + width / 2, top + height / 2);
  return target.contains(there);
}"""


async def is_within(target: Locator, size: dict[str, int]) -> bool:
    """Return True when all of it is in sight, its middle is uncovered, and it is large enough for a finger."""
    box = await target.bounding_box()
    assert box is not None
    inside = box["x"] >= 0 and box["y"] >= 0
    inside = inside and box["x"] + box["width"] <= size["width"] and box["y"] + box["height"] <= size["height"]
    return inside and min(box["width"], box["height"]) >= 44 and bool(await target.evaluate(MIDDLE))
