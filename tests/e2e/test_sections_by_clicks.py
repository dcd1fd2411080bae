"""A street counted by section: drawn along its kerb with a capacity, seen on the map, asked about, in the report."""

from __future__ import annotations

import re
from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path

import pytest
import pytest_asyncio
from playwright.async_api import Browser, Page, expect

from hawk.lots.ingest import save
from hawk.lots.plan_files.formats import read_plan
from hawk.lots.plan_import import transfer
from hawk.lots.plan_import.choices import asked_of
from hawk.lots.plan_import.previews import preview
from hawk.lots.storage.database import Database
from hawk.lots.store import FILE
from hawk.lots.survey.pictures import pictures_of
from tests.e2e.desk import desk_of
from tests.e2e.hands import new_page, press, shows
from tests.e2e.test_page_by_keyboard import AXE, RUN_AXE
from tests.e2e.test_plan_by_clicks import Store, done
from tests.e2e.watching import watch
from tests.unit.lots.plan_files.files import degrees, feature, geojson
from tests.unit.lots.test_training_set import mosaic
from tests.unit.stats.test_panel import register
from tests.unit.stats.test_section_use import MONDAY, flown_at

pytestmark = [pytest.mark.e2e, pytest.mark.asyncio(loop_scope="session")]

PARKED = ((3.0, 20.0, 30.0), (3.0, 9.0, 20.0, 30.0, 38.0), (9.0, 30.0))
"""Places of vehicles along the kerb, metres east, in three surveys, a day apart."""
KERB = ((12.0, 0.0), (12.0, 44.0))
DESK = {"width": 1440, "height": 900}
PHONE = {"width": 390, "height": 844}
ON_SCREEN = """([north, east]) => {
    const { left, top } = document.querySelector('hawk-survey-map .ol').getBoundingClientRect();
    const [x, y] = document.querySelector('hawk-survey-map').panes[0].map.pixelOf({ North: north, East: east });
    return [left + x, top + y]; }"""


@pytest_asyncio.fixture(loop_scope="session")
async def address(tmp_path: Path) -> AsyncIterator[str]:
    """A desk that serves a store of one lot with three surveys beside a street."""
    store = Database(tmp_path / FILE)
    for number, easts in enumerate(PARKED):
        with store.writing() as connection:
            saved = save(connection, flown_at(number, MONDAY + 86_400 * number, easts), register)
        pictures_of(tmp_path / FILE).write(saved.survey, mosaic())
    store.close()
    async with desk_of(tmp_path) as address:
        yield address


async def opened(browser: Browser, address: str, **options: object) -> tuple[Page, list[str]]:
    page = await new_page(browser, **{"locale": "en", "viewport": DESK, **options})
    await page.add_init_script(path=AXE)
    await page.add_init_script("localStorage.setItem('hawk-page', JSON.stringify({theme: 'light', name: 'Ann'}))")
    errors = watch(page)
    await page.goto(f"{address}#/lots")
    await page.wait_for_selector("hawk-survey-map[data-drawn=all]")
    return page, errors


async def click(page: Page, place: tuple[float, float]) -> None:
    await page.mouse.click(*(await page.evaluate(ON_SCREEN, list(place))))
    await page.wait_for_timeout(400)  # two quick clicks at one place are a double click


async def sections(address: str) -> dict[str, dict[str, object]]:
    return {each["name"]: each for each in (await Store(address).lot("/sections"))["items"]}


async def draw(page: Page, address: str) -> None:
    """Draw the section along the kerb, with 10 places; then say that it has 4, undo that, and do it again."""
    await press(page, "Edit plan")
    await shows(page, "Nobody edits")
    await press(page, "Zoom out")
    await page.wait_for_timeout(400)  # the map glides
    await press(page, "Section")
    form = page.locator("hawk-plan-section form").first
    for place in KERB:
        await click(page, place)
    await form.get_by_label("Name of the section").fill("Elm Street")
    await form.get_by_label("Places").fill("10")
    await form.get_by_label("Note").fill("permit")
    await press(page, "Add the section")
    await done(page)
    assert (await sections(address))["Elm Street"]["capacity"] == 10
    await page.locator("hawk-plan-section summary", has_text="Elm Street").click()
    row = page.locator("hawk-plan-section details form")
    await row.get_by_label("Places").fill("4")
    await press(page, "Change the section Elm Street")
    await done(page)
    await press(page, "Undo")
    await done(page)
    assert (await sections(address))["Elm Street"]["capacity"] == 10
    await press(page, "Redo")
    await done(page)
    drawn = (await sections(address))["Elm Street"]
    assert (drawn["capacity"], drawn["is_capacity_given"], drawn["note"]) == (4, True, "permit")


async def draw_by_keys(page: Page, address: str) -> None:
    """Draw an area by the middle of the map, without a pointer; remove it, and undo that."""
    form = page.locator("hawk-plan-section form").first
    await form.get_by_label("Shape").select_option("area")
    await page.locator(".ol").focus()
    for arrows in ("ArrowRight", "ArrowDown", "ArrowLeft"):
        await page.keyboard.press("Enter")
        await page.keyboard.press(arrows)
        await page.wait_for_timeout(400)  # the map glides
    await form.get_by_label("Name of the section").fill("Yard")
    await page.keyboard.press("Enter")
    await done(page)
    assert (await sections(address))["Yard"]["is_capacity_given"] is False
    await page.locator("hawk-plan-section summary", has_text="Yard").press("Enter")
    await page.get_by_role("button", name="Remove the section Yard").press("Enter")
    await done(page)
    assert set(await sections(address)) == {"Elm Street"}


async def test_a_street_is_drawn_counted_and_asked_about(browser: Browser, address: str, screenshots: Path) -> None:
    page, errors = await opened(browser, address)
    await draw(page, address)
    await page.screenshot(path=screenshots / "section-drawn.png")
    assert await page.evaluate(RUN_AXE) == []
    await draw_by_keys(page, address)
    await press(page, "Close the edit")
    await expect(page.locator("hawk-plan")).to_have_count(0)

    table = page.get_by_role("table", name="Sections")
    await expect(table.get_by_role("row", name="Elm Street")).to_contain_text("2 of 4 parked")
    await table.get_by_role("button", name="Elm Street").click()
    card = page.locator("[data-section]")
    await expect(card).to_contain_text(re.compile(r"\d to \d, 9 times in 10.*4 places, as a person says.*permit", re.S))
    await page.wait_for_timeout(400)
    await page.screenshot(path=screenshots / "section-card.png")
    assert await page.evaluate(RUN_AXE) == []
    asked = page.url
    await card.get_by_role("button", name="Close").click()
    await expect(card).to_have_count(0)
    await click(page, (10.8, 15.0))  # in the section, where no stall is
    await expect(card).to_contain_text("2 of 4 parked")
    assert page.url == asked
    full = (await Store(address).lot("/surveys"))["items"][1]["id"]
    await page.goto(
        f"{asked.partition('#')[0]}#/lots/{(await Store(address).lot())['id']}/{full}?section={asked[-36:]}"
    )
    await expect(card).to_contain_text("5 of 4 parked, over-full")
    await page.wait_for_timeout(400)
    await page.screenshot(path=screenshots / "section-over-full.png")
    await page.set_viewport_size(PHONE)  # type: ignore[arg-type]
    await page.wait_for_timeout(400)
    await page.screenshot(path=screenshots / "section-phone.png")
    await page.set_viewport_size(DESK)  # type: ignore[arg-type]
    await compared(page, screenshots)
    await asked_by_weekday(page, screenshots)
    assert not errors


async def compared(page: Page, screenshots: Path) -> None:
    """Both maps and the list show how the section changed; a press in the list opens its card."""
    await page.get_by_role("navigation", name="Views").get_by_role("link", name="Compare", exact=True).click()
    await page.wait_for_selector("hawk-survey-map[data-drawn=all]")
    row = page.get_by_role("table", name="Sections").get_by_role("row", name="Elm Street")
    await expect(row).to_contain_text(re.compile(r"5 \(\d to \d\).*2 \(\d to \d\)", re.S))
    await row.get_by_role("button", name="Elm Street").click()
    await expect(page.locator("[data-section]")).to_contain_text("5, then 2 of 4 parked")
    await expect(page).to_have_url(re.compile(r"section=[0-9a-f-]{36}"))
    await page.wait_for_timeout(400)
    await page.screenshot(path=screenshots / "section-compared.png")
    assert await page.evaluate(RUN_AXE) == []


@pytest_asyncio.fixture(loop_scope="session")
async def street(tmp_path: Path) -> AsyncIterator[str]:
    """A desk that serves a lot of one section, which a file brought, with two surveys that found no stall."""
    kerb = feature(degrees(KERB), "LineString", name="Élm Street", side="right", kind="parallel", capacity=4)
    chosen = asked_of({}, ())
    store = Database(tmp_path / FILE)
    with store.writing() as connection:
        found = preview(connection, None, read_plan(geojson([kerb]), chosen.file), chosen, None)
        transfer.begin(connection, found, {"name": "Street"}, "Ann", MONDAY - 1e6)
    for number, easts in enumerate(PARKED[:2]):
        flown = flown_at(number, MONDAY + 86_400 * number, easts)
        with store.writing() as connection:
            saved = save(connection, replace(flown, stalls=(), outline=flown.seen_ground))
        pictures_of(tmp_path / FILE).write(saved.survey, mosaic())
    store.close()
    async with desk_of(tmp_path) as address:
        yield address


async def test_a_lot_of_sections_alone_opens_in_every_view(browser: Browser, street: str, screenshots: Path) -> None:
    page, errors = await opened(browser, street)
    main = page.get_by_role("main")
    await expect(main.locator("p.large")).to_contain_text("5 of 4 parked, over-full")
    await page.screenshot(path=screenshots / "street-lots.png")
    assert await page.evaluate(RUN_AXE) == []
    views = page.get_by_role("navigation", name="Views")
    await views.get_by_role("link", name="Compare", exact=True).click()
    await expect(main.locator("p.large")).to_contain_text("3, then 5 of 4 parked")
    await page.wait_for_selector("hawk-survey-map[data-drawn=all]")
    await page.wait_for_timeout(400)
    await page.screenshot(path=screenshots / "street-compared.png")
    assert await page.evaluate(RUN_AXE) == []
    await views.get_by_role("link", name="Report", exact=True).click()
    await expect(main.locator(".answer")).to_contain_text("100 % taken")
    await expect(main.locator(".answer")).to_contain_text("4 places")
    await page.screenshot(path=screenshots / "street-asked.png", full_page=True)
    assert await page.evaluate(RUN_AXE) == []
    assert not errors


async def asked_by_weekday(page: Page, screenshots: Path) -> None:
    """The section is a part of the lot that is asked about, by its places."""
    await page.get_by_role("navigation", name="Views").get_by_role("link", name="Report", exact=True).click()
    await page.get_by_role("button", name="Part of the lot").click()
    await page.get_by_role("checkbox", name="A", exact=True).check()
    await page.get_by_role("checkbox", name="Elm Street", exact=True).check()
    await page.keyboard.press("Escape")
    await expect(page).to_have_url(re.compile(r"part=section\.Elm\+Street$"))
    answer = page.get_by_role("main").locator(".answer")
    await expect(answer).to_contain_text("83 % taken")
    await expect(answer).to_contain_text(re.compile(r"3\.3 vehicles \([23]\.\d to [45]\.\d\)"))
    await expect(answer).to_contain_text("are parked on 4 places on average. Fullest on Tuesdays")
    await expect(page.get_by_role("gridcell", name="Tuesday 11:00–12:00: 125 %")).to_have_count(1)
    await expect(page.get_by_role("region", name="In a terminal")).to_contain_text("--section 'Elm Street'")
    await page.screenshot(path=screenshots / "section-asked.png", full_page=True)
    assert await page.evaluate(RUN_AXE) == []


@pytest.mark.nightly
async def test_sections_are_drawn_in_french(browser: Browser, address: str, screenshots: Path) -> None:
    page, errors = await opened(browser, address, locale="fr")
    await press(page, "Modifier le plan")
    await shows(page, "Personne ne modifie")
    await page.locator("hawk-survey-map").get_by_role("button", name="Réduire").click()
    await page.wait_for_timeout(400)  # the map glides
    await press(page, "Section")
    for place in KERB:
        await click(page, place)
    form = page.locator("hawk-plan-section form").first
    await form.get_by_label("Nom de la section").fill("Rue de l’Orme")
    await press(page, "Ajouter la section")
    await done(page)
    await page.screenshot(path=screenshots / "section-french.png")
    assert (await sections(address))["Rue de l’Orme"]["capacity"] == 8
    assert await page.evaluate(RUN_AXE) == []
    assert not errors
