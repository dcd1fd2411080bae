"""The page over a made-up drone, in every size: what keeps the flight safe is in reach, and the map is to be seen."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest
from playwright.async_api import Browser, Page, expect

from tests.e2e.hands import button, new_page, press, resize, shows, state_is

pytestmark = [pytest.mark.e2e, pytest.mark.asyncio(loop_scope="session")]

SIZES = ((640, 360), (667, 375), (390, 844), (360, 640), (1024, 600), (1440, 900))
"""Width and height: 1280 × 720 at 200 % zoom, a phone on its side, two phones, a small laptop, a desk."""
LEAST_MAP = 0.35
"""Of the window's shorter side."""
SAFETY = {"hold": "button.hold", "land": "button.land", "cut": "button.cut"}
HOME = {"home": '.guided [data-action="home"]'}

MEASURE = """(selectors) => {
  const shown = (selector) => [...document.querySelectorAll(selector)].find((each) => each.getClientRects().length > 0);
  const problems = [];
  for (const [name, selector] of Object.entries(selectors)) {
    const element = shown(selector);
    if (!element) { problems.push(`${name} is not there`); continue; }
    const { left, top, right, bottom } = element.getBoundingClientRect();
    if (left < 0 || top < 0 || right > innerWidth || bottom > innerHeight) problems.push(`${name} leaves the window`);
    for (const [x, y] of [[left, top], [right, top], [left, bottom], [right, bottom]]) {
      const within = [x + (x === left ? 12 : -12), y + (y === top ? 12 : -12)];
      if (!element.contains(document.elementFromPoint(...within))) problems.push(`${name} is covered`);
    }
  }
  for (const word of document.querySelectorAll(".guided .act b, .safety button, .cut, .slide .word")) {
    const isCut = word.clientWidth > 0 && word.scrollWidth > word.clientWidth + 1;
    if (isCut) problems.push(`"${word.innerText}" is cut off`);
  }
  const state = [...document.querySelectorAll(".cell.state .sub")].find((each) => each.getClientRects().length > 0);
  if (state.scrollHeight > state.clientHeight + 1) problems.push(`"${state.innerText}" is cut off`);
  const map = document.querySelector(".map").getBoundingClientRect();
  const confirm = shown(".confirm")?.getBoundingClientRect();
  const beside = !confirm || confirm.left >= map.right || confirm.right <= map.left;
  if (!beside && confirm.top < map.bottom && confirm.bottom > map.top) problems.push("the question covers the map");
  return { problems, map: Math.min(map.width, map.height) / Math.min(innerWidth, innerHeight) };
}"""


@pytest.mark.fault(
    "a small or zoomed window, a phone, a question open, no link",
    "Hold, Land, Cut motors and Return home are wholly in the window and uncovered; a question does not move "
    "Hold and Land; the map has 35 % of the shorter side",
)
async def test_safety_actions_and_map_in_every_size(browser: Browser, fake: Any, screenshots: Path) -> None:
    page = await new_page(browser, viewport={"width": 1440, "height": 900})
    _, ground = await fake("ready")
    await page.goto(ground)
    await press(page, "Take control")
    await expect(button(page, "Arm")).to_be_enabled()
    await everything_is_in_reach(page, "idle", SAFETY, screenshots)
    drone, air = await fake("still")
    await page.set_viewport_size({"width": 1440, "height": 900})
    await page.goto(air)
    await press(page, "Take control")
    await shows(page, "stalls so far")
    await expect(page.locator(HOME["home"])).to_be_visible()  # control has been given
    await everything_is_in_reach(page, "exploring", SAFETY | HOME, screenshots)
    await press(page, "Hold")
    await state_is(page, "Holding")
    before = await everything_is_in_reach(page, "hover", SAFETY | HOME, screenshots)
    await page.set_viewport_size({"width": 1440, "height": 900})
    await press(page, "Move")
    await page.locator(".ol").click(position={"x": 500, "y": 300})
    await expect(page.locator("hawk-slide button")).to_be_enabled()
    asked = await everything_is_in_reach(page, "move", SAFETY | {"slide": "hawk-slide button"}, screenshots)
    assert asked == before, "a question moves Hold or Land"
    await page.keyboard.press("Escape")
    await expect(page.locator("hawk-confirm")).to_have_count(0)
    drone.kill()
    await shows(page, "No word from the drone for")
    await everything_is_in_reach(page, "lost", SAFETY | HOME, screenshots)


GROUND_SIZES = (*SIZES, (1280, 720), (1024, 768), (900, 900), (820, 1180))
"""The same, common screens, and a tablet."""
READABLE = """() => {
  const shown = (selector) => [...document.querySelectorAll(selector)].find((each) => each.getClientRects().length > 0);
  const failed = shown(".side .fix .h");
  if (!failed) return shown(".side .tabs") ? ["no failed check is in the panel"] : [];
  const { left, top, bottom } = failed.getBoundingClientRect();
  const isSeen = (y) => failed.contains(document.elementFromPoint(left + 30, y));
  return isSeen(top + 2) && isSeen(bottom - 2) ? [] : ["the failed check cannot be read"];
}"""

TOOLS = """() => [...document.querySelectorAll(".map .tools button")].filter((each) => {
  const { left, top, width, height } = each.getBoundingClientRect();
  const hit = document.elementFromPoint(left + width / 2, top + height / 2);
  return width > 0 && !each.contains(hit) && hit?.closest(".map");
}).map((each) => `${each.ariaLabel || each.title}: the map covers its own tool`)"""


async def test_the_remedy_of_a_failed_check_is_the_next_step_in_every_size(
    browser: Browser, fake: Any, screenshots: Path
) -> None:
    page = await new_page(browser, viewport={"width": 1440, "height": 900})
    _, ground = await fake("ground")
    await page.goto(ground)
    await page.set_viewport_size({"width": 390, "height": 844})
    await expect(page.locator(".toast.warning")).to_be_visible()  # a notice lies beside the tools
    for width, height in (*GROUND_SIZES, (360, 740), (390, 844), (412, 915)):
        await resize(page, width, height)
        assert await page.evaluate(TOOLS) == [], f"{width}x{height}"
    await page.set_viewport_size({"width": 1440, "height": 900})
    await press(page, "Take control")
    remedy = {"remedy": '.guided [data-action="remedy"]'}
    await expect(page.locator(remedy["remedy"])).to_be_visible()
    found: dict[str, list[str]] = {}
    for width, height in GROUND_SIZES:
        await resize(page, width, height)
        problems = (await page.evaluate(MEASURE, SAFETY | remedy))["problems"] + await page.evaluate(READABLE)
        if problems:
            found[f"{width}x{height}"] = problems
            await page.screenshot(path=screenshots / f"ground-{width}x{height}.png")
    assert found == {}
    await page.set_viewport_size({"width": 390, "height": 844})
    await page.locator('.guided [data-action="arm"]').click()
    await expect(page.locator(".sheet .fix button")).to_be_focused()
    await page.get_by_role("dialog", name="Menu").get_by_role("button", name="Close").click()
    await page.locator(remedy["remedy"]).click()
    await expect(page.locator('.guided [data-action="arm"].primary')).to_be_enabled()


BUSY_AFTER_PRESS = """
document.addEventListener("pointerdown", () => {
  setTimeout(() => { const end = Date.now() + 1500; while (Date.now() < end); }, 0);
}, { once: true })"""
"""The page itself is busy from the press on: nothing that a busy computer delays comes between."""


async def everything_is_in_reach(page: Page, state: str, selectors: dict[str, str], screenshots: Path) -> list[Any]:
    """Look at every size; return where Hold and Land are in each."""
    found, places = {}, []
    for width, height in SIZES:
        await resize(page, width, height)
        measured = await page.evaluate(MEASURE, selectors)
        problems = measured["problems"]
        places.append([await page.locator(SAFETY[each]).bounding_box() for each in ("hold", "land")])
        if measured["map"] < LEAST_MAP:
            problems.append(f"the map has {measured['map']:.2f} of the shorter side")
        if problems:
            found[f"{state} {width}x{height}"] = sorted(set(problems))
            await page.screenshot(path=screenshots / f"{state}-{width}x{height}.png")
    assert found == {}
    return places


@pytest.mark.fault(
    '"Keep pressed 1 s to cut" is pressed for 0.2 s while the page is busy for 1.5 s',
    "the motors run on; the page says that it could not follow the press",
)
async def test_a_short_press_on_a_busy_page_does_not_cut_the_motors(browser: Browser, fake: Any) -> None:
    page = await new_page(browser, viewport={"width": 1440, "height": 900})
    _, air = await fake("still")
    await page.goto(air)
    await press(page, "Take control")
    await press(page, "Cut motors")
    cut = button(page, "Keep pressed 1 s to cut")
    await expect(cut).to_be_enabled()
    await cut.hover()
    await page.evaluate(BUSY_AFTER_PRESS)
    await page.mouse.down()
    await asyncio.sleep(0.2)
    await page.mouse.up()
    await shows(page, "too busy to follow the press")
    await state_is(page, "Exploring")
    await expect(page.get_by_text("Motors cut by you")).to_have_count(0)
