"""The page over a made-up drone, by keyboard alone, and judged by axe-core: every view, every theme."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from playwright.async_api import Browser, Page, expect

from tests.e2e.hands import button, hold_enter, new_page, press, shows, state_is
from tests.examples import nightly

pytestmark = [pytest.mark.e2e, pytest.mark.asyncio(loop_scope="session")]

PAGE = Path(__file__).resolve().parents[2] / "hawk" / "web" / "page"
AXE = PAGE / "node_modules" / "axe-core" / "axe.min.js"
THEMES = ("light", "dark", "outdoor")
TABS = ("Checks", "Messages", "Flight", "Stalls", "Settings")
DESK, PHONE = {"width": 1440, "height": 900}, {"width": 390, "height": 844}
RUN_AXE = """async () => {
  const values = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice", "experimental"];
  const { violations } = await axe.run(document, { runOnly: { type: "tag", values }, resultTypes: ["violations"] });
  return violations.flatMap(({ id, help, nodes }) => nodes.map((node) => `${id}: ${help}: ${node.html.slice(0, 160)}`));
}"""


async def opened(browser: Browser, address: str, size: Any = DESK, theme: str = "light") -> Page:
    page = await new_page(browser, viewport=size)
    # the page's own policy allows no script but the page's: axe is read before that applies
    await page.add_init_script(path=AXE)
    await page.add_init_script(f"localStorage.setItem('hawk-page', JSON.stringify({{theme: '{theme}', name: 'ana'}}))")
    await page.goto(address)
    await expect(page.locator("hawk-glance").get_by_role("status")).not_to_be_empty()
    return page


CONTRAST = """async () => {
  const runOnly = { type: "rule", values: ["color-contrast"] };
  const { violations } = await axe.run(document, { runOnly, resultTypes: ["violations"] });
  return violations.flatMap(({ id, nodes }) => nodes.map((node) => `${id}: ${node.html.slice(0, 160)}`));
}"""


async def faults(page: Page, view: str, screenshots: Path) -> dict[str, list[str]]:
    await page.screenshot(path=screenshots / f"axe-{view}.png")
    found = await page.evaluate(RUN_AXE)
    return {view: found} if found else {}


async def faults_in_themes(page: Page, theme: str, view: str, screenshots: Path) -> dict[str, list[str]]:
    """Return what axe finds in a view, and what is hard to read in the other themes, which differ in colours alone."""
    found = await faults(page, f"{theme}-{view}", screenshots)
    for other in THEMES:
        if other != theme:
            await prefer(page, other)
            if unreadable := await page.evaluate(CONTRAST):
                found[f"{other}-{view}"] = unreadable
    await prefer(page, theme)
    return found


async def prefer(page: Page, theme: str) -> None:
    """Choose a theme, and wait until the page has it."""
    await page.evaluate(f"document.querySelector('hawk-app').model.prefer({{ theme: '{theme}' }})")
    await expect(page.locator("html")).to_have_attribute("data-theme", theme)


def in_words(found: dict[str, list[str]]) -> str:
    return "\n".join(f"{view}: {one}" for view, all_of_it in found.items() for one in all_of_it)


@pytest.mark.parametrize("theme", [THEMES[0], *nightly(*THEMES[1:])])
async def test_axe_finds_nothing_on_any_view(browser: Browser, fake: Any, screenshots: Path, theme: str) -> None:
    found: dict[str, list[str]] = {}
    for scene in ("ground", "still"):
        _, address = await fake(scene)
        page = await opened(browser, address, theme=theme)
        found |= await faults_in_themes(page, theme, f"{scene}-watching", screenshots)
        await press(page, "Take control")
        await expect(page.locator(".guided")).to_be_visible()
        for name in TABS:
            tab = page.get_by_role("tab", name=name)
            if await tab.count():
                await tab.click()
                found |= await faults_in_themes(page, theme, f"{scene}-{name}", screenshots)
        await page.keyboard.press("?")
        await expect(page.locator(".keylist")).to_be_visible()
        found |= await faults_in_themes(page, theme, f"{scene}-keys", screenshots)
        await page.close()
    assert not found, in_words(found)


async def test_axe_finds_nothing_while_something_is_asked(browser: Browser, fake: Any, screenshots: Path) -> None:
    _, address = await fake("still")
    page = await opened(browser, address)
    await press(page, "Take control")
    await press(page, "Cut motors")
    await expect(page.locator(".kill")).to_be_visible()
    found = await faults(page, "cut-motors", screenshots)
    await page.keyboard.press("Escape")
    await page.keyboard.press("h")
    await state_is(page, "Holding")
    await press(page, "Move")
    await page.locator(".ol").click(position={"x": 500, "y": 300})
    await expect(page.locator("hawk-slide button")).to_be_enabled()
    found |= await faults(page, "move", screenshots)
    await page.keyboard.press("Escape")
    assert not found, in_words(found)


async def test_a_flight_begins_by_keyboard_alone(browser: Browser, fake: Any) -> None:
    _, address = await fake("ready")
    page = await opened(browser, address)
    await expect(button(page, "Take control")).to_be_visible()
    await page.keyboard.press("Tab")
    await expect(page.locator(".skip")).to_be_focused()
    await page.keyboard.press("Enter")
    await expect(button(page, "Take control")).to_be_focused()
    await page.keyboard.press("Enter")
    await expect(button(page, "Arm")).to_be_focused()
    await page.keyboard.press("Enter")
    for name in ("Take off", "Explore"):
        await expect(page.locator("hawk-slide button")).to_be_focused()
        await hold_enter(page)
        await expect(button(page, name)).to_be_focused()
        await page.keyboard.press("Enter")
    await expect(page.locator("hawk-slide button")).to_be_focused()
    await hold_enter(page)
    await shows(page, "Exploring")
    await page.keyboard.press("h")
    await state_is(page, "Holding")


async def test_letters_are_no_keys_while_somebody_types(browser: Browser, fake: Any) -> None:
    _, address = await fake("still")
    page = await opened(browser, address)
    await press(page, "Take control")
    await page.get_by_role("tab", name="Settings").click()
    name = page.get_by_role("textbox", name="Your name").locator("visible=true").first
    await name.fill("")
    await name.press_sequentially("h?e")
    await expect(name).to_have_value("h?e")
    await expect(page.locator(".keylist")).to_have_count(0)
    await expect(page.locator("hawk-confirm")).to_have_count(0)
