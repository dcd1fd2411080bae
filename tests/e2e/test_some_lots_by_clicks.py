"""A person with a role for some lots: the page shows these, and says why it shows no drone."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from playwright.async_api import Browser, expect

from hawk.comm.protocol.authority import Role
from hawk.lots import commands
from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.store import FILE
from hawk.lots.survey.pictures import pictures_of
from hawk.web.access.tokens import TOKEN_FILE, rotate, rotate_person
from tests.e2e.desk import desk_of
from tests.e2e.hands import new_page, press, shows
from tests.e2e.test_page_by_keyboard import AXE, RUN_AXE
from tests.e2e.watching import watch
from tests.unit.lots.surveys import box, later, survey
from tests.unit.lots.test_training_set import mosaic
from tests.unit.web.v1.archive import FAR

pytestmark = [pytest.mark.e2e, pytest.mark.asyncio(loop_scope="session")]


def fill(folder: Path) -> str:
    """Store a survey of "North" with its picture, and one of "South"; return Ada's token as operator of "North"."""
    away = replace(later(survey(stalls=20), 4, hours=72.0), datum=FAR, outline=box(-5, -3, 9, 54, FAR))
    away = replace(away, seen_ground=box(-13, -15, 27, 78, FAR))
    store = Database(folder / FILE)
    with store.writing() as connection:
        saved = [save(connection, each) for each in (survey(), away)]
        for each, name in zip(saved, ("North", "South"), strict=True):
            commands.rename(connection, each.lot or "", name, "operator", 0.0)
    store.close()
    pictures_of(folder / FILE).write(saved[0].survey, mosaic())
    rotate(folder / TOKEN_FILE, Role.OPERATOR)
    return rotate_person(folder / TOKEN_FILE, "Ada", Role.OPERATOR, [saved[0].lot or ""])


async def test_a_person_logs_in_sees_and_corrects_their_lot_and_no_other(
    browser: Browser, tmp_path: Path, screenshots: Path
) -> None:
    token = fill(tmp_path)
    async with desk_of(tmp_path) as address:
        page = await new_page(browser, viewport={"width": 1440, "height": 900})
        await page.add_init_script(path=AXE)
        errors, asked = watch(page), list[str]()
        page.on("request", lambda request: asked.append(request.url.removeprefix(address)))
        await page.goto(f"{address}login")
        await page.get_by_role("combobox").fill("operator")
        await page.get_by_role("textbox", name="Token").fill(token)
        await page.get_by_role("button", name="Log in").click()
        await shows(page, "You are logged in as Ada.")
        views = page.get_by_role("navigation", name="Views")
        assert await views.get_by_role("link").all_inner_texts() == ["Lots", "Compare", "Report"]
        await expect(page.get_by_role("application")).to_have_attribute("aria-label", re.compile(r"free, \d+ taken"))
        await expect(page.locator("hawk-top .lot")).to_contain_text("North")
        assert await page.get_by_text("South").count() == 0
        await page.screenshot(path=screenshots / "some-lots.png")
        await press(page, "Edit plan")
        await shows(page, "Nobody edits")
        await press(page, "Confirm all")
        await press(page, "Close the edit")
        await expect(page.locator("hawk-changes")).to_contain_text("Ada")
        await views.get_by_role("link", name="Report").click()
        await expect(page.get_by_role("main")).to_contain_text("stalls are taken")
        await page.keyboard.press("h")  # "Hold", where a drone is
        await page.goto(f"{address}#/fly")
        await shows(page, "Not with this login")
        await page.screenshot(path=screenshots / "some-lots-fly.png")
        assert await page.evaluate(RUN_AXE) == []
        assert not errors
        drone = re.compile(r"ws|video|stream|snapshot|api/(?!v1/|session)|metrics|recording|settings")
        assert not [url for url in asked if drone.match(url) or "recordings" in url], "nothing of a drone is asked for"
        await page.get_by_role("button", name="Log out").click()
        await expect(page.get_by_role("textbox", name="Token")).to_be_visible()
