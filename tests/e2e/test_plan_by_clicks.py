"""A lot's plan corrected by clicks, keys and taps, over the real store: each change is found in it."""

from __future__ import annotations

import asyncio
import itertools
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import aiohttp
import pytest
from playwright.async_api import Browser, FileChooser, Locator, Page, expect

from tests.e2e.hands import button, is_within, new_page, prefer_hand, press, shows
from tests.e2e.test_page_by_keyboard import AXE, RUN_AXE, prefer
from tests.e2e.watching import watch
from tests.examples import nightly
from tests.pace import PATIENCE_S

pytestmark = [pytest.mark.e2e, pytest.mark.asyncio(loop_scope="session")]

DESK, PHONE, SMALL = {"width": 1440, "height": 900}, {"width": 390, "height": 844}, {"width": 320, "height": 568}
PIXEL = """([North, East]) => {
  const map = document.querySelector("hawk-map");
  const { left, top } = map.querySelector(".ol").getBoundingClientRect();
  const [x, y] = map.lot.pixelOf({ North, East });
  return [left + x, top + y];
}"""
"""Place on the screen of a place in metres north and east."""
Stall = Mapping[str, Any]


class Store:
    """The store of lots as programs see it."""

    def __init__(self, address: str) -> None:
        self.address = address

    async def get(self, path: str) -> Any:
        async with aiohttp.ClientSession() as session, session.get(self.address + path) as answer:
            return await answer.json()

    async def lot(self, path: str = "") -> Any:
        """Return what the API says of the first lot."""
        lot, *_ = (await self.get("api/v1/lots"))["items"]
        return await self.get(f"api/v1/lots/{lot['id']}{path}")

    async def layouts(self) -> Any:
        return (await self.lot("/layouts"))["items"]

    async def stalls(self) -> dict[str, Stall]:
        return {each["label"]: each for each in (await self.lot("/plan"))["stalls"]}


async def opened(browser: Browser, address: str, name: str = "Ann", size: Any = DESK, **context: Any) -> Page:
    """Open the page and the editor of the only lot."""
    page = await new_page(browser, viewport=size, **context)
    await page.add_init_script(path=AXE)
    stored = f"JSON.stringify({{theme: 'light', name: '{name}'}})"
    await page.add_init_script(f"localStorage.setItem('hawk-page', localStorage.getItem('hawk-page') ?? {stored})")
    await page.goto(address)
    await expect(page.locator("hawk-glance").get_by_role("status")).not_to_be_empty()
    return page


async def open_editor(page: Page) -> None:
    """Open the editor of the lot from the table of stalls."""
    tab = page.get_by_role("tab", name=re.compile("^(Stalls|Places)$")).locator("visible=true")
    await expect(tab.or_(button(page, "Menu")).first).to_be_visible()  # Fly is read after the page
    if not await tab.count():
        await press(page, "Menu")
    await tab.first.click()
    await press(page, "(Correct the plan|Corriger le plan)")
    await expect(page.locator(".plantools")).to_be_visible()
    await expect(page.get_by_text("No map yet")).to_have_count(0)  # it would cover the plan


async def correct(page: Page) -> None:
    """Open the plan that nobody edits."""
    await open_editor(page)
    await shows(page, "Nobody edits")


async def at(page: Page, place: Stall | tuple[float, float]) -> tuple[float, float]:
    """Return where a stall, or a place (metres north and east), is on the screen."""
    north, east = (place["north"], place["east"]) if isinstance(place, Mapping) else place
    x, y = await page.evaluate(PIXEL, [north, east])
    return x, y


def chosen(page: Page) -> Locator:
    return page.locator("hawk-plan-chosen").get_by_role("status")


async def done(page: Page) -> None:
    """Wait until the store has answered all that was asked for."""
    await page.wait_for_function("() => document.querySelector('hawk-app').model.plan.waiting === 0")


async def test_rows_are_numbered_as_painted_by_mouse_and_keys(
    browser: Browser, fake: Any, tmp_path: Path, screenshots: Path
) -> None:
    _, address = await fake("ready", "--lots", str(tmp_path / "lots.db"))
    store, page = Store(address), await opened(browser, address)
    errors = watch(page)
    await correct(page)
    before = await store.stalls()
    rows = {name: [label for label in before if label.startswith(f"{name} ")] for name in ("A", "B")}
    await shows(page, "labels are our guess")
    await page.mouse.dblclick(*await at(page, before["B 3"]))
    await page.keyboard.press("n")
    await page.keyboard.type("A")
    await page.keyboard.press("Enter")
    await done(page)
    after = await store.stalls()
    assert [after[f"A {label[2:]}"]["id"] for label in rows["B"]] == [before[label]["id"] for label in rows["B"]]
    assert {after[f"B {number}"]["id"] for number in range(1, len(rows["A"]) + 1)} == {
        before[label]["id"] for label in rows["A"]
    }
    await shows(page, "as painted")
    await page.screenshot(path=screenshots / "plan-labels.png")
    await press(page, "Number from the other end")
    await press(page, "Numbers [+]1")
    await done(page)
    last = await store.stalls()
    numbers = [int(label[2:]) for label in rows["B"]]
    assert [last[f"A {1 + max(numbers) + min(numbers) - number}"]["id"] for number in numbers] == [
        before[label]["id"] for label in rows["B"]
    ]
    for _ in range(3):
        await page.keyboard.press("Control+z")
    await done(page)
    assert await store.stalls() == before
    assert errors == []
    await page.context.close()


async def test_a_plan_is_corrected_by_mouse_and_keys(
    browser: Browser, fake: Any, tmp_path: Path, screenshots: Path
) -> None:
    _, address = await fake("ready", "--lots", str(tmp_path / "lots.db"))
    store, page = Store(address), await opened(browser, address)
    errors = watch(page)
    await correct(page)
    before = await store.stalls()
    row = [label for label in before if label.startswith("B ")]
    await page.mouse.dblclick(*await at(page, before["B 3"]))
    await expect(chosen(page)).to_have_text(f"{len(row)} stalls are chosen")
    await page.screenshot(path=screenshots / "plan-1-row.png")
    await press(page, "Confirm")
    await done(page)
    assert {label for label, each in (await store.stalls()).items() if each["is_confirmed"]} == set(row)

    await page.mouse.click(*await at(page, before["C 2"]))
    await expect(chosen(page)).to_have_text("C 2 is chosen")
    await page.keyboard.press("Delete")
    await done(page)
    assert before.keys() - (await store.stalls()).keys() == {"C 2"}
    await page.keyboard.press("Control+z")
    await done(page)
    assert (await store.stalls()).keys() == before.keys()
    await page.keyboard.press("Control+Shift+z")
    await done(page)
    assert before.keys() - (await store.stalls()).keys() == {"C 2"}

    await press(page, "Add row")
    for place in ((-30.0, 40.0), (-30.0, 50.1), (-35.05, 45.0)):
        await page.mouse.move(*await at(page, place))
        await page.mouse.click(*await at(page, place))
    await page.screenshot(path=screenshots / "plan-2-drawn.png")
    await press(page, "Add 4 stalls")
    await done(page)
    after = await store.stalls()
    new = [after[label] for label in after.keys() - before.keys()]
    assert [(round(each["width"], 1), round(each["length"], 1), each["is_confirmed"]) for each in new] == [
        (2.5, 5.0, True)
    ] * 4
    await page.screenshot(path=screenshots / "plan-3-added.png")

    await page.get_by_label("Reason, if any").fill("repainted")
    await press(page, "Close the edit")
    await shows(page, "The plan is closed as version 2")
    assert [(each["who"], each["why"]) for each in await store.layouts()][1:] == [("Ann", "repainted")]
    assert (await store.lot())["edit"] is None
    assert not errors


@pytest.mark.nightly
async def test_many_quick_clicks_over_2100_stalls_are_all_done(browser: Browser, fake: Any, tmp_path: Path) -> None:
    """Twenty are removed as fast as keys can be pressed, some brought back and moved: the store has them all."""
    _, address = await fake("still", "--stalls", "2100", "--lots", str(tmp_path / "lots.db"))
    store, page = Store(address), await opened(browser, address)
    errors = watch(page)
    await correct(page)
    before = await store.stalls()
    assert len(before) == 2100
    labels = sorted(before)[::105]
    for label in labels:  # the map may still grow or shrink while the edit begins
        await page.mouse.click(*await at(page, before[label]))
        await page.keyboard.press("Delete")
    await done(page)
    assert before.keys() - (await store.stalls()).keys() == set(labels)
    back = labels[-8:]
    for _ in back:
        await page.keyboard.press("Control+z")
    await done(page)
    assert before.keys() - (await store.stalls()).keys() == set(labels) - set(back)
    for label in back:
        await page.mouse.click(*await at(page, before[label]))
        await page.keyboard.press("ArrowUp")
        await page.keyboard.press("ArrowUp")
    await done(page)
    after = await store.stalls()
    assert {label for label in after if after[label] != before[label]} == set(back)
    for label in back:
        assert after[label]["north"] - before[label]["north"] == pytest.approx(0.2, abs=1e-4)
    assert not errors


async def test_a_second_person_sees_who_edits_and_takes_over(browser: Browser, fake: Any, tmp_path: Path) -> None:
    _, address = await fake("still", "--lots", str(tmp_path / "lots.db"))
    ann, bob = await opened(browser, address), await opened(browser, address, "Bob")
    await correct(ann)
    await correct(bob)  # looking locks nothing
    await press(ann, "Confirm all")
    await shows(ann, "You edit since")
    await shows(bob, "Ann edits since")
    for name in ("Choose", "Add row", "Add stall", "Undo"):
        await expect(button(bob, name)).to_be_disabled()
    await shows(bob, "166 stalls, 166 confirmed")
    await press(bob, "Take over")
    await shows(bob, "You edit since")
    await shows(ann, "Bob edits since")
    await bob.locator("hawk-plan-chosen select[name=row]").select_option("A")
    await press(bob, "Remove")
    await shows(ann, "144 stalls, 144 confirmed")
    layouts = await Store(address).layouts()
    assert [(each["who"], each["why"]) for each in layouts[1:]] == [
        ("Ann", "taken over by Bob"),
        ("Bob", "corrected by hand"),
    ]


async def test_a_phone_confirms_removes_and_adds_a_row(
    browser: Browser, fake: Any, tmp_path: Path, screenshots: Path
) -> None:
    _, address = await fake("still", "--lots", str(tmp_path / "lots.db"))
    store, page = Store(address), await opened(browser, address, size=PHONE, has_touch=True, is_mobile=True)
    await correct(page)
    before = await store.stalls()
    await page.screenshot(path=screenshots / "plan-phone-1.png")
    assert await is_within(button(page, "Confirm all"), PHONE)
    for size, is_left in itertools.product((SMALL, PHONE), (True, False)):
        await page.set_viewport_size(size)  # type: ignore[arg-type]
        await prefer_hand(page, is_left)
        for name in ("Hold", "Land", "Choose", "Add row", "Section", "Undo", "Redo", "Turn the map", "Layers"):
            assert await is_within(button(page, name), size), (size, is_left, name)
        wide = await page.evaluate("[document.querySelector('.map').clientWidth, document.body.scrollWidth]")
        assert wide == [size["width"]] * 2
    for label in ("D 2", "D 4"):
        await page.touchscreen.tap(*await at(page, before[label]))
    await expect(chosen(page)).to_have_text("2 stalls are chosen")
    await page.screenshot(path=screenshots / "plan-phone-2.png")
    await press(page, "Confirm")
    await done(page)
    assert {label for label, each in (await store.stalls()).items() if each["is_confirmed"]} == {"D 2", "D 4"}
    await press(page, "Remove")
    await done(page)
    assert before.keys() - (await store.stalls()).keys() == {"D 2", "D 4"}
    await press(page, "Add row")
    for place in ((-30.0, 30.0), (-30.0, 42.6), (-35.05, 36.0)):
        await page.touchscreen.tap(*await at(page, place))
    await page.screenshot(path=screenshots / "plan-phone-3.png")
    await press(page, "Add 5 stalls")
    await done(page)
    assert len(await store.stalls()) == len(before) - 2 + 5


@pytest.mark.parametrize("language", ["en", *nightly("fr")])
async def test_axe_finds_nothing_while_a_plan_is_corrected(
    browser: Browser, fake: Any, tmp_path: Path, screenshots: Path, language: str
) -> None:
    _, address = await fake("still", "--lots", str(tmp_path / "lots.db"))
    found = []
    for size in (DESK, PHONE):
        page = await opened(browser, address, size=size, locale=language)
        await open_editor(page)
        await expect(page.locator("hawk-plan-chosen select").first).to_be_visible()
        await page.locator("hawk-plan-chosen select[name=row]").select_option("B")
        await page.locator("hawk-plan-chosen summary").click()
        for theme in ("dark", "outdoor", "light"):
            await prefer(page, theme)
            found += await faults_of(page, screenshots / f"plan-axe-{language}-{size['width']}-{theme}.png")
        for tool in ("row", "stall", "area", "zone", "section"):
            await page.locator(f".plantools .{tool}").click()
            found += await faults_of(page, screenshots / f"plan-axe-{language}-{size['width']}-{tool}.png")
    assert not found, "\n".join(found)


async def faults_of(page: Page, picture: Path) -> list[str]:
    await page.screenshot(path=picture)
    return list(await page.evaluate(RUN_AXE))


async def test_a_plan_is_imported_by_clicks(browser: Browser, fake: Any, tmp_path: Path, screenshots: Path) -> None:
    """The lot's own export, its stalls with the owner's numbers."""
    _, address = await fake("ready", "--lots", str(tmp_path / "lots.db"))
    store, page = Store(address), await opened(browser, address)
    chooser: asyncio.Future[FileChooser] = asyncio.get_running_loop().create_future()
    # the browser takes some time until it hands a chooser over
    page.once("filechooser", lambda given: chooser.set_result(given))
    errors = watch(page)
    lot = await store.lot("/plan")
    for number, stall in enumerate(lot["stalls"], 1):
        stall["label"] = f"P{number}"
    owners = {stall["id"]: stall["label"] for stall in lot["stalls"]}
    file = tmp_path / "owner.json"
    file.write_text(json.dumps({**lot, "stalls": [*lot["stalls"], {"label": "no place"}]}), "utf-8")
    await correct(page)
    opener = page.locator("hawk-plan-import").get_by_role("button", name="Import a plan")
    await expect(opener).to_be_enabled()  # a disabled one takes no focus
    await opener.focus()
    await page.keyboard.press("Enter")
    async with asyncio.timeout(PATIENCE_S):
        await (await chooser).set_files(file)
    shown = page.locator("hawk-plan-import")
    await expect(shown).to_contain_text(f"0 begin, {len(owners)} change, 0 are so already, 0 end.")
    await expect(shown).to_contain_text("1 feature is left out")
    await page.screenshot(path=screenshots / "plan-import.png")
    assert not await faults_of(page, screenshots / "plan-import-axe.png")
    await press(page, "Take (the plan|it as it lies)")
    await expect(shown.get_by_role("button", name="Cancel")).to_have_count(0)
    await done(page)
    assert {each["id"]: label for label, each in (await store.stalls()).items()} == owners
    await page.keyboard.press("Control+z")
    await done(page)
    assert not {*await store.stalls()} & {*owners.values()}
    await page.keyboard.press("Control+Shift+z")
    await done(page)
    await press(page, "Close the edit")
    await shows(page, "The plan is closed as version 2")
    assert {each["id"]: label for label, each in (await store.stalls()).items()} == owners
    assert all(each["is_named"] for each in (await store.stalls()).values()), "they are as painted"
    assert not errors
