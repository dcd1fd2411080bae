"""A manager's desk: the surveys of a lot over two days, by clicks, on paper, and by a link."""

from __future__ import annotations

import re
from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path

import pytest
import pytest_asyncio
from playwright.async_api import Browser, Locator, Page, expect

from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.store import FILE
from hawk.model.lot_map import StallState
from tests.e2e.desk import desk_of
from tests.e2e.hands import new_page, press, shows
from tests.e2e.test_plan_by_clicks import Store, at, done
from tests.e2e.watching import watch
from tests.unit.stats.test_panel import register, seen

pytestmark = [pytest.mark.e2e, pytest.mark.asyncio(loop_scope="session")]

BEGAN = 1_794_823_200.0
"""A Monday, 2026-11-16 at 10:00 UTC."""
FLOWN = ((0, 4), (2, 12), (4, 8), (24, 5), (26, 14), (28, 9))
"""Hours after that, and the number of taken stalls."""


def fill(folder: Path) -> None:
    """Write a store of one lot with six surveys."""
    store = Database(folder / FILE)
    for number, (hours, taken) in enumerate(FLOWN):
        one = seen(dict.fromkeys(range(1, taken + 1), StallState.TAKEN))
        at = BEGAN + 3600 * hours
        stalls = tuple(replace(stall, looked_at=at) for stall in one.stalls)
        with store.writing() as connection:
            save(connection, replace(one, name=f"{number:06d}-X", began=at - 600, ended=at, stalls=stalls), register)
    store.close()


@pytest_asyncio.fixture(loop_scope="session", scope="module")
async def shared(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[str]:
    """A desk that serves it to tests that change nothing, or take their change back."""
    folder = tmp_path_factory.mktemp("desk")
    fill(folder)
    async with desk_of(folder) as address:
        yield address


@pytest_asyncio.fixture(loop_scope="session")
async def own(tmp_path: Path) -> AsyncIterator[str]:
    """A desk that serves it to one test."""
    fill(tmp_path)
    async with desk_of(tmp_path) as address:
        yield address


async def opened(browser: Browser, address: str, **options: object) -> tuple[Page, list[str]]:
    page = await new_page(browser, locale="en", timezone_id="Europe/Amsterdam", **options)
    errors = watch(page)
    await page.goto(address)
    return page, errors


async def middle_of_the_map(page: Page) -> list[float]:
    """Return north and east of what lies in the middle of the map, rounded to 10 cm, and its scale."""
    code = """() => { const { map } = document.querySelector('hawk-survey-map').panes[0];
        return [map.centre.North, map.centre.East, map.resolution].map((each) => Math.round(10 * each) / 10); }"""
    await page.wait_for_timeout(300)  # it glides to a stall
    found: list[float] = await page.evaluate(code)
    return found


async def drag(page: Page, target: Locator, pixels: float) -> None:
    """Drag something to the right by some pixels."""
    box = await target.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    await page.mouse.move(x, y)
    await page.mouse.down()
    await page.mouse.move(x + pixels, y + 20, steps=4)
    await page.mouse.up()


async def view(page: Page, name: str, part: str = "") -> None:
    await page.get_by_role("navigation", name="Views").get_by_role("link", name=name, exact=True).click()
    if part:
        await page.get_by_role("navigation").get_by_role("button", name=part, exact=True).click()


async def test_a_manager_reads_compares_and_shares_a_lot(browser: Browser, shared: str, screenshots: Path) -> None:
    page, errors = await opened(browser, shared, viewport={"width": 1280, "height": 900})
    await view(page, "Lots")
    main = page.get_by_role("main")
    await expect(
        main.get_by_role("region", name="Surveys by day and hour").get_by_role("button", name="Occupancy")
    ).to_have_count(len(FLOWN))
    await main.get_by_role("button", name="13:00, Occupancy 70.0 %").click()
    await expect(main.get_by_role("application")).to_have_attribute("aria-label", "6 free, 14 taken, 0 unclear")
    await page.keyboard.press("ArrowRight")
    await expect(main.get_by_role("application")).to_have_attribute("aria-label", "11 free, 9 taken, 0 unclear")
    await main.get_by_text("List of surveys").click()
    await expect(main.get_by_role("row")).to_have_count(1 + len(FLOWN))
    await main.get_by_role("button", name="2026-11-17 13:00").click()
    await expect(main.get_by_role("application")).to_have_attribute("aria-label", "6 free, 14 taken, 0 unclear")
    await page.screenshot(path=screenshots / "over-time-survey.png", full_page=True)

    ticks = main.get_by_role("region", name="Surveys by day and hour").get_by_role("button", name="Occupancy")
    await main.get_by_role("button", name="Delete survey").click()
    await expect(ticks).to_have_count(len(FLOWN))
    await main.get_by_role("button", name="Delete this survey").click()
    await expect(ticks).to_have_count(len(FLOWN) - 1)
    await page.reload()
    await main.get_by_role("button", name="Undo: Survey deleted").click()
    await expect(ticks).to_have_count(len(FLOWN))

    gone, _ = await opened(browser, f"{shared}#/lots/00000000-0000-4000-8000-000000000099")
    await expect(gone.get_by_role("alert")).to_contain_text("The lot of this address is not there")
    await gone.close()
    await view(page, "Compare")
    await expect(main).to_contain_text("5 more free of the 20 seen in both")
    changed = main.get_by_role("listitem").get_by_role("button", name="taken, now free")
    assert await changed.all_inner_texts() == [f"A {number}\ntaken, now free" for number in range(10, 15)]
    await changed.last.click()
    await expect(main.get_by_text("Stall A 14")).to_be_visible()
    place = await middle_of_the_map(page)
    swipe = page.get_by_role("slider")
    await swipe.press("End")
    await expect(swipe).to_have_attribute("aria-valuetext", re.compile("^0 % of the map shows Tue 17 Nov.* 15:00"))
    await swipe.press("PageDown")
    await drag(page, swipe, -200)
    for mode in ("Side by side", "Fade", "Swipe"):
        await main.get_by_role("button", name=mode, exact=True).click()
        await expect(main.locator(".ol")).to_have_count(2)
    assert await middle_of_the_map(page) == place
    await main.get_by_role("button", name="Before Tue").click()
    await main.get_by_role("button", name="11:00, Occupancy 20.0 %").click()
    await expect(main).to_contain_text("5 fewer free of the 20 seen in both")
    assert await middle_of_the_map(page) == place
    await page.reload()
    await expect(main).to_contain_text("5 fewer free of the 20 seen in both")
    await page.screenshot(path=screenshots / "over-time-compare.png", full_page=True)

    await view(page, "Lots", "Stalls")
    await main.get_by_role("button", name="A 6", exact=True).click()
    await expect(main.get_by_role("listitem")).to_have_count(len(FLOWN))
    await expect(main.locator(".pop")).to_contain_text("Stall A 6")

    await view(page, "Lots", "Links")
    await page.get_by_role("spinbutton", name="Days").fill("7")
    await page.get_by_role("button", name="Make a link").click()
    link = await page.get_by_role("textbox", name="Link").input_value()
    guest, guests_errors = await opened(browser, link)
    await expect(guest.get_by_role("button", name="Occupancy")).to_have_count(len(FLOWN))
    assert await guest.get_by_role("link", name="Recordings").count() == 0
    await guest.get_by_role("link", name="Compare").click()
    await expect(guest.get_by_role("main")).to_contain_text("5 more free of the 20 seen in both")
    await guest.get_by_role("slider").press("ArrowRight")
    assert await guest.get_by_role("button", name="Delete survey").count() == 0
    for _ in ("asked", "done"):
        await page.get_by_role("button", name="Take back").click()
    await expect(page.get_by_role("button", name="Take back")).to_have_count(0)  # then it is stored
    await guest.reload()
    await expect(guest.get_by_role("alert")).to_contain_text("This link has ended, or was taken back.")
    await expect(guest.get_by_role("navigation").get_by_role("link")).to_have_count(0)
    assert not errors
    assert [error for error in guests_errors if "404" not in error] == []


async def test_a_zone_is_drawn_by_clicks_and_by_keys_and_has_its_figures(
    browser: Browser, own: str, screenshots: Path
) -> None:
    page, errors = await opened(browser, own, viewport={"width": 1280, "height": 900})
    await page.add_init_script("localStorage.setItem('hawk-page', JSON.stringify({theme: 'light', name: 'Ann'}))")
    await page.reload()
    await press(page, "Correct the plan")
    await shows(page, "Nobody edits")
    stalls = await Store(own).stalls()
    five = [stalls[f"A {number}"] for number in range(1, 6)]
    south, north = min(s["north"] for s in five) - 4, max(s["north"] for s in five) + 4
    west, east = min(s["east"] for s in five) - 1.2, max(s["east"] for s in five) + 1.2
    await press(page, "Zone")
    for corner in ((south, west), (south, east), (north, east), (north, west)):
        await page.mouse.click(*await at(page, corner))
    panel = page.locator("hawk-plan-drawn")
    await panel.get_by_label("Name of the zone").fill("West")
    await panel.get_by_label("Kind").select_option("disabled")
    await press(page, "Add the zone")
    await done(page)
    await expect(panel).to_contain_text("West")
    await page.screenshot(path=screenshots / "zone-drawn.png")

    await page.locator(".ol").focus()
    for arrows in ("ArrowRight", "ArrowDown", "ArrowLeft"):
        await page.keyboard.press("Enter")
        await page.keyboard.press(arrows)
        await page.wait_for_timeout(400)  # the map glides
    await panel.get_by_label("Name of the zone").fill("Middle")
    await page.keyboard.press("Enter")
    await done(page)
    assert {each["name"]: each["kind"] for each in (await Store(own).lot("/plan"))["named_zones"]} == {
        "West": "disabled", "Middle": "disabled",
    }  # fmt: skip
    await page.get_by_role("button", name="Remove the zone Middle").click()
    await done(page)
    await page.get_by_role("button", name="Undo", exact=True).click()
    await page.get_by_role("button", name="Redo", exact=True).click()
    await done(page)
    await press(page, "Close the edit")
    await shows(page, "The plan is closed as version")

    await view(page, "Report")
    await page.get_by_role("button", name="Part of the lot").click()
    await page.get_by_role("checkbox", name="West", exact=True).check()
    await expect(page.get_by_role("main")).to_contain_text("of 5 stalls are taken on average")
    await page.screenshot(path=screenshots / "zone-asked.png", full_page=True)
    assert not errors


async def test_how_full_a_row_is_on_mornings_is_asked_by_words_by_mouse_and_by_keys(
    browser: Browser, shared: str, screenshots: Path
) -> None:
    page, errors = await opened(browser, f"{shared}#/report", viewport={"width": 1280, "height": 900})
    main = page.get_by_role("main")
    answer = main.locator(".answer")
    await expect(answer).to_contain_text(
        re.compile(r"From 6 surveys on 2 days, 16\s*–\s*17 November 2026, Amsterdam time\.")
    )
    await page.get_by_role("button", name="Part of the lot").click()
    await page.get_by_role("checkbox", name="A", exact=True).check()
    await page.keyboard.press("Escape")
    await page.get_by_role("button", name="Days of the week").click()
    await page.get_by_role("button", name="Mon–Fri").click()
    await page.get_by_role("button", name="Hours of the day").click()
    await page.get_by_role("button", name="11–15").click()
    await page.get_by_role("button", name="Done").click()
    await expect(answer).to_contain_text("From 4 surveys on 2 days")
    await expect(answer).to_contain_text("Nobody flew at 12 or 14.")
    figures = main.get_by_role("region", name="The figures behind it").get_by_role("row")
    await expect(figures.last).to_contain_text("All, each survey once")
    await expect(main.get_by_role("gridcell", selected=True)).to_have_count(20)
    command = main.get_by_role("region", name="In a terminal")
    await expect(command).to_contain_text("--row A --weekday mon-fri --hour 11-15")
    asked = page.url
    assert asked.endswith("?part=row.A&days=mon-fri&hours=11-15")
    shown = await answer.inner_text()
    await page.goto("about:blank")
    await page.goto(asked)
    await expect(answer).to_have_text(shown, use_inner_text=True)
    await page.screenshot(path=screenshots / "asked.png", full_page=True)

    await main.get_by_role("gridcell", name="Monday 11:00–12:00").drag_to(
        main.get_by_role("gridcell", name="Tuesday 13:00–14:00")
    )
    await expect(page).to_have_url(asked.replace("mon-fri&hours=11-15", "mon-tue&hours=11-14"))
    await main.get_by_role("gridcell", name="Tuesday 13:00–14:00").focus()
    for keys in ("ArrowLeft", "ArrowLeft", "Shift+ArrowRight", "Enter"):
        await page.keyboard.press(keys)
    await expect(page).to_have_url(asked.replace("mon-fri&hours=11-15", "tue&hours=11-13"))
    await expect(main.get_by_role("gridcell", selected=True)).to_have_count(2)
    await main.get_by_role("button", name="The whole week").click()
    await main.get_by_role("button", name="24 hours").click()
    await expect(main.get_by_role("gridcell")).to_have_count(168)
    assert not errors


async def test_the_map_of_a_survey_stays_where_buttons_and_keys_bring_it(browser: Browser, shared: str) -> None:
    page, errors = await opened(browser, f"{shared}#/lots")
    await page.wait_for_selector("hawk-survey-map[data-drawn=all]")
    sizes = []
    for step in ("", "Zoom in", "Zoom in", "+"):
        if step == "+":
            await page.locator("hawk-survey-map .ol").press(step)
        elif step:
            await press(page, step)
        await page.wait_for_timeout(600)
        sizes.append(await page.evaluate("() => document.querySelector('hawk-survey-map').panes[0].map.resolution"))
    assert sizes[0] > sizes[1] > sizes[2], sizes
    assert sizes[3] < 0.7 * sizes[0], "a key keeps what the buttons did"
    await press(page, "Whole lot")
    await page.wait_for_timeout(600)
    size = await page.evaluate("() => document.querySelector('hawk-survey-map').panes[0].map.resolution")
    assert size == pytest.approx(sizes[0], rel=0.01)
    assert not errors


async def test_the_plan_is_corrected_on_the_map_of_a_survey(browser: Browser, own: str, screenshots: Path) -> None:
    page, errors = await opened(browser, f"{own}#/lots")
    before = await Store(own).stalls()
    await press(page, "Edit plan")
    await shows(page, "Nobody edits")
    where = await page.evaluate(
        """() => { const { panes: [pane] } = document.querySelector('hawk-survey-map');
        const stall = pane.source.stalls.find(({ label }) => label === 'A 3');
        const { left, top } = document.querySelector('hawk-survey-map .ol').getBoundingClientRect();
        const [x, y] = pane.map.pixelOf({ North: stall.north, East: stall.east });
        return [left + x, top + y]; }"""
    )
    await page.mouse.click(*where)
    await expect(page.locator("hawk-plan-chosen")).to_contain_text("A 3")
    await page.keyboard.press("Delete")
    await done(page)
    await page.screenshot(path=screenshots / "plan-on-a-survey.png")
    assert set(before) - set(await Store(own).stalls()) == {"A 3"}
    await press(page, "Close the edit")
    await expect(page.locator(".about")).to_contain_text(f"of {len(before)} stalls")  # of the layout of its time
    await expect(page.locator("hawk-changes")).to_contain_text("Plan")
    assert errors == []


async def test_the_question_asked_is_the_report_printed(browser: Browser, shared: str, screenshots: Path) -> None:
    page, errors = await opened(browser, f"{shared}#/report?part=row.A&days=mon-fri&hours=11-15")
    await page.get_by_role("button", name="The report: print it or download it").click()
    frame = page.frame_locator("iframe")
    await expect(frame.locator("body")).to_contain_text("row A")
    await expect(frame.locator("body")).to_contain_text("Europe/Amsterdam")
    async with page.expect_download() as saved:
        await page.get_by_role("button", name="Workbook").click()
    assert (await saved.value).suggested_filename.endswith(".xlsx")
    await expect(page.locator("archive-document").get_by_role("status")).to_contain_text(".xlsx is saved")
    await page.get_by_role("combobox", name="Paper").select_option("letter")
    await expect(page.locator("iframe")).to_have_attribute("src", re.compile("paper=letter"))
    await page.screenshot(path=screenshots / "over-time-paper.png", full_page=True)
    await page.goto(f"{shared}#/report?part=row.Z&show=document")
    await page.reload()
    await expect(page.get_by_role("alert")).to_contain_text("The lot has no row, zone or kind of this name")
    assert [
        each for each in errors if "Framing" not in each and "Failed to load" not in each and "script" not in each
    ] == []
