"""A store of several lots: all on one map and in one table, found by their names, opened by a click."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from playwright.async_api import Browser, expect

from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import LOT
from hawk.lots.store import FILE
from hawk.model.poses import GlobalPose
from tests.e2e.desk import desk_of
from tests.e2e.hands import new_page, press, shows
from tests.e2e.test_page_by_keyboard import AXE, RUN_AXE
from tests.e2e.watching import watch
from tests.integration.daemon_support import eventually
from tests.unit.lots.surveys import box, survey

pytestmark = [pytest.mark.e2e, pytest.mark.asyncio(loop_scope="session")]

NAMES = ("Étoile", "North Street", "Ward's Yard")
PIXELS = """() => {
  const { map, layer } = document.querySelector('archive-all-lots').map;
  return Object.fromEntries(layer.marks.map(({ name, place }) => [name, map.getPixelFromCoordinate(place)]));
}"""
"""Place of each lot on its map."""
PINS = """() => {
  const { map, layer, resolution } = document.querySelector('archive-all-lots').map;
  const named = lots => lots.map(({ name }) => name).join(' and ');
  const pins = layer.groups(resolution);
  return Object.fromEntries(pins.map(lots => [named(lots), map.getPixelFromCoordinate(lots[0].place)]));
}"""
"""Place on the map of each pin, by the names of its lots."""


def store_of_lots(path: Path) -> None:
    """Write a store of lots 1 km apart, each with one survey of 40 stalls."""
    store = Database(path)
    for number, name in enumerate(NAMES):
        datum = GlobalPose(52.0 + 0.01 * number, 5.0 + 0.003 * number, 0.0)
        flown = replace(
            survey(f"{number:06d}-20260504T103000Z", seed=number),
            datum=datum, title=name, outline=box(-14, -3, 18, 54, datum), seen_ground=box(-22, -15, 36, 78, datum),
        )  # fmt: skip
        with store.writing() as connection:
            assert save(connection, flown, None).lot
    with store.writing() as connection:
        assert len(connection.execute(LOT.select()).all()) == len(NAMES)
    store.close()


@pytest.mark.parametrize("size", [{"width": 1440, "height": 900}, {"width": 390, "height": 844}], ids=["desk", "phone"])
async def test_a_lot_is_found_among_all_and_opened(
    browser: Browser, tmp_path: Path, screenshots: Path, size: dict[str, int]
) -> None:
    store_of_lots(tmp_path / FILE)
    async with desk_of(tmp_path) as address:
        page = await new_page(browser, locale="en", viewport=size)
        await page.add_init_script(path=AXE)
        errors = watch(page)
        await page.goto(f"{address}#/lots")
        await press(page, "All lots")
        await shows(page, "3 of 3 lots")
        rows = page.locator("archive-all-lots tbody th")
        await expect(rows).to_have_text(list(NAMES))
        scale = page.locator("archive-all-lots .mapfoot span").last
        await expect(scale).to_be_visible()
        await expect(scale).to_contain_text("m")
        await page.screenshot(path=screenshots / f"all-lots-{size['width']}.png")
        assert await page.evaluate(RUN_AXE) == []
        assert await page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        await page.get_by_label("Search").fill("etoile")
        await expect(rows).to_have_text(["Étoile"])
        await page.get_by_label("Search").fill("")
        await page.get_by_label("Order").select_option("free")
        await expect(rows).to_have_count(3)
        box_of_map = await page.locator("archive-all-lots .ol").bounding_box()
        assert box_of_map is not None
        x, y = (await page.evaluate(PIXELS))["North Street"]
        await page.mouse.click(box_of_map["x"] + x, box_of_map["y"] + y)
        await expect(page.locator("hawk-top .lot option:checked")).to_have_text("North Street")
        await expect(page).to_have_url(re.compile("#/lots/[0-9a-f-]{36}"))
        await shows(page, "of 40 stalls")
        assert not errors


async def test_lots_beside_each_other_are_one_pin_that_a_press_opens(browser: Browser, tmp_path: Path) -> None:
    store_of_lots(tmp_path / FILE)
    store = Database(tmp_path / FILE)
    with store.writing() as connection:  # 45 m from the first lot; the third one stays 2 km away
        connection.execute(LOT.update().where(LOT.c.name == NAMES[1]).values(latitude=52.000404, longitude=5.0))
    store.close()
    async with desk_of(tmp_path) as address:
        page = await new_page(browser, locale="en")
        errors = watch(page)
        await page.goto(f"{address}#/lots")
        await press(page, "All lots")
        await shows(page, "3 of 3 lots")
        pins = await eventually(lambda: page.evaluate(PINS), lambda found: len(found) == 2, 10)
        box_of_map = await page.locator("archive-all-lots .ol").bounding_box()
        assert box_of_map is not None
        (x, y) = next(place for lots, place in pins.items() if " and " in lots)
        await page.mouse.click(box_of_map["x"] + x, box_of_map["y"] + y)
        await eventually(lambda: page.evaluate(PINS), lambda found: len(found) == 3, 10)
        assert not errors
