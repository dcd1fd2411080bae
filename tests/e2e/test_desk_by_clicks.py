"""The desk: a store's lots on the page of a computer without a drone."""

from __future__ import annotations

import filecmp
import re
from collections.abc import AsyncIterator
from pathlib import Path

import aiohttp
import pytest
import pytest_asyncio
from playwright.async_api import Browser, expect

from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.store import FILE
from hawk.lots.survey.pictures import pictures_of
from tests.e2e.desk import desk_of
from tests.e2e.hands import MIDDLE, button, new_page, prefer_hand, press, shows
from tests.e2e.test_page_by_keyboard import AXE, RUN_AXE
from tests.e2e.test_plan_by_clicks import Store, at, chosen, done
from tests.e2e.watching import watch
from tests.pace import PATIENCE_S
from tests.unit.lots.surveys import survey
from tests.unit.lots.test_training_set import mosaic
from tests.unit.replay.recordings import flight, write

pytestmark = [pytest.mark.e2e, pytest.mark.asyncio(loop_scope="session")]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a store of one lot with a picture."""
    made = tmp_path_factory.mktemp("desk")
    store = Database(made / FILE)
    with store.writing() as connection:
        saved = save(connection, survey())
    store.close()
    pictures_of(made / FILE).write(saved.survey, mosaic())
    return made


@pytest_asyncio.fixture(loop_scope="session", scope="module")
async def address(folder: Path) -> AsyncIterator[str]:
    """A desk that serves it to all tests here: none of them reads what another one changes."""
    async with desk_of(folder) as address:
        yield address


async def test_a_plan_is_corrected_over_the_picture_of_a_survey(
    browser: Browser, address: str, screenshots: Path
) -> None:
    store = Store(address)
    page = await new_page(browser, viewport={"width": 1440, "height": 900})
    await page.add_init_script(path=AXE)
    await page.add_init_script("localStorage.setItem('hawk-page', JSON.stringify({theme: 'light', name: 'Ann'}))")
    errors = watch(page)
    pictures: set[str] = set()
    page.on("response", lambda answer: pictures.add(answer.url) if "api/mosaic/" in answer.url and answer.ok else None)
    await page.goto(address)
    await expect(page.get_by_role("region", name="Desk")).to_contain_text("No drone is here")
    flying = "hawk-bar, hawk-glance, hawk-video, hawk-counts, hawk-fence-button, hawk-heights-button"
    assert await page.locator(flying).count() == 0, "nothing to fly with"
    await press(page, "Correct the plan")
    await shows(page, "Nobody edits")
    before = await store.stalls()
    await page.mouse.click(*await at(page, before["A 3"]))
    await expect(chosen(page)).to_contain_text("A 3")
    await page.keyboard.press("Delete")
    await done(page)
    await page.screenshot(path=screenshots / "desk.png")
    assert set(before) - set(await store.stalls()) == {"A 3"}
    assert len(pictures) == len(mosaic()), "the picture of the survey lies under the plan"
    assert not errors
    assert await page.evaluate(RUN_AXE) == []
    await button(page, "Close").first.click()


async def test_lots_show_the_survey_over_its_picture(browser: Browser, address: str, screenshots: Path) -> None:
    page = await new_page(browser, viewport={"width": 1440, "height": 900})
    errors = watch(page)
    pictures: set[str] = set()
    page.on("response", lambda answer: pictures.add(answer.url) if "/ground/" in answer.url and answer.ok else None)
    await page.goto(f"{address}#/lots")
    map_of_survey = page.get_by_role("application")
    await expect(map_of_survey).to_have_attribute("aria-label", re.compile(r"free, \d+ taken"))
    await page.wait_for_function(
        "(count) => document.querySelector('hawk-survey-map')?.source?.stalls.length > count", arg=0
    )
    await page.wait_for_load_state("networkidle")
    assert [url.rpartition("/")[2] for url in pictures] == ["whole"], "one picture shows all of it"
    stall = await page.evaluate("document.querySelector('hawk-survey-map').source.ids[0]")
    await page.goto(f"{address}{(await page.evaluate('location.hash')).partition('?')[0]}?stall={stall}")
    await expect(page.locator("hawk-survey-map .pop canvas")).to_be_visible()
    await page.screenshot(path=screenshots / "lots-picture.png")
    assert not errors


async def test_recordings_of_its_folder_are_seen_and_downloaded(
    browser: Browser, address: str, folder: Path, tmp_path: Path
) -> None:
    (folder / "recordings").mkdir()
    recorded = write(folder / "recordings" / "20260504T000000Z.mcap", flight())
    page = await new_page(browser, viewport={"width": 1440, "height": 900})
    errors = watch(page)
    await page.goto(f"{address}#/recordings")
    await shows(page, "1 recording")
    async with page.expect_download() as began:
        await page.get_by_role("link", name="Download").click()
    await (await began.value).save_as(tmp_path / "downloaded")
    assert filecmp.cmp(tmp_path / "downloaded", recorded, shallow=False)
    await press(page, "Delete")
    assert recorded.exists(), "it asks once more"
    await press(page, "Delete")
    await expect(page.get_by_text("1 recording")).to_have_count(0)
    assert not recorded.exists()
    assert not errors


async def test_every_command_to_a_drone_is_refused(address: str) -> None:
    async with aiohttp.ClientSession() as session, session.ws_connect(f"{address}ws") as socket:
        welcome = await socket.receive_json(timeout=PATIENCE_S)
        assert welcome["Desk"] is True
        for number, command in enumerate(("Arm", "Takeoff", "Explore", "Kill")):
            await socket.send_json({"Type": command, "Id": number})
        answers: dict[int, dict[str, object]] = {}
        while len(answers) < 4:
            message = await socket.receive_json(timeout=PATIENCE_S)
            if message.get("Type") == "Ack":
                answers[message["Id"]] = message
        assert not any(answer["Accepted"] for answer in answers.values())


async def test_a_phone_on_its_side_gives_the_views_its_whole_width_to_both_hands(
    browser: Browser, address: str
) -> None:
    size = {"width": 844, "height": 390}
    page = await new_page(browser, viewport=size)
    for place, is_left in (("fly", True), ("lots", True), ("lots", False)):
        await page.goto(f"{address}#/{place}")
        shown = page.locator(".side" if place == "fly" else ".view .about")
        await expect(shown).to_be_visible()
        await prefer_hand(page, is_left)
        spans = await page.evaluate(
            "['main:not(.away)', '.view'].map((each) => document.querySelector(each)?.clientWidth)"
        )
        assert size["width"] in spans, (place, is_left, spans)
        for link in await page.locator(".top nav a").all() if place == "lots" else ():
            assert await link.evaluate(MIDDLE), (place, is_left, await link.inner_text())
