"""Exclusion zones by clicks: drawn in a fence, changed, saved, uploaded, seen on the map, and kept out of."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from playwright.async_api import Browser, Page, expect

from tests.e2e.hands import button, hover, is_within, new_page, press, shows
from tests.e2e.test_fence_by_clicks import DESK, EASE_MS, SIZES, drag, fence_of, move_to, pixel, title
from tests.e2e.watching import watch
from tests.integration.daemon_support import LOW_HEIGHTS, over_a_picture

pytestmark = [pytest.mark.e2e, pytest.mark.asyncio(loop_scope="session")]

AROUND = ((-40, -45), (36, -45), (36, 45), (-40, 45))
ZONE = ((8, 12), (24, 12), (24, 32), (8, 32))
MAST = ((-20, -30), (-14, -30), (-17, -24))
IN_THE_ZONE, BEHIND_IT, BESIDE_IT = (16.0, 22.0), (24.0, 38.0), (-10.0, 20.0)


@pytest.mark.nightly
async def test_a_zone_is_drawn_kept_and_kept_out_of(browser: Browser, screenshots: Path, tmp_path: Path) -> None:
    stack = over_a_picture(tmp_path, LOW_HEIGHTS)
    try:
        url = (await stack.start()).url
        page = await new_page(browser, viewport=DESK, color_scheme="light")
        errors = watch(page)
        await page.goto(url)
        await press(page, "Take control")
        await press(page, "Edit fence")
        await press(page, "Follow the drone")
        await page.wait_for_timeout(EASE_MS)
        await expect(button(page, "Add zone: an exclusion zone")).to_be_disabled()
        await click_around(page, AROUND)
        await press(page, "Add zone: an exclusion zone")
        await shows(page, "Draw a zone that the drone keeps out of")
        await click_around(page, ZONE)
        await expect(title(page)).to_have_text(re.compile("4 corners, 1 zone$"))
        await press(page, "Add zone: an exclusion zone")
        await click_around(page, MAST)
        await expect(title(page)).to_have_text(re.compile("4 corners, 2 zones$"))
        await shows(page, "From parts of it the straight path home crosses a zone")
        await in_every_size(page, screenshots)
        await putting_it_right(page)
        await press(page, "Save fence")
        await shows(page, "Fence of 4 corners, 1 zone")
        kept = await fence_of(url)
        assert [len(zone) for zone in kept.zones] == [4]
        assert [len(zone) for zone in kept.inner_zones] == [4]
        await page.screenshot(path=screenshots / "zones-2-saved.png")
        await hover(page)
        await move_to(page, IN_THE_ZONE)
        await shows(page, "In a zone or its margin")
        await page.screenshot(path=screenshots / "zones-3-in-the-air.png")
        await press(page, "Cancel")
        await move_to(page, BEHIND_IT)
        await shows(page, "The straight path there crosses a zone")
        await press(page, "Cancel")
        await move_to(page, BESIDE_IT)
        await expect(page.get_by_label("Anywhere inside the fence")).to_be_enabled()
        assert not errors
    finally:
        await stack.stop()


async def click_around(page: Page, ring: tuple[tuple[int, int], ...]) -> None:
    """Click the corners of a ring and the first one again."""
    places = [await pixel(page, place) for place in ring]
    for count, place in enumerate(places, start=1):
        await page.mouse.click(*place)
        await shows(page, f"{count} corner{'s' if count > 1 else ''} set")
        await page.wait_for_timeout(300)  # two clicks within 250 ms at one place are a double click
    await page.mouse.click(*places[0])
    await page.wait_for_timeout(300)


async def in_every_size(page: Page, screenshots: Path) -> None:
    """In every size and both themes the tools are in reach."""
    for name, size in SIZES.items():
        await page.set_viewport_size(size)  # type: ignore[arg-type]
        for theme in ("light", "dark"):
            await page.emulate_media(color_scheme=theme)
            await page.wait_for_timeout(EASE_MS)
            await page.screenshot(path=screenshots / f"zones-1-{name}-{theme}.png")
            for each in ("Save fence", "Cancel", "Undo", "Add zone", "Clear", "Import", "Export", "Hold"):
                assert await is_within(button(page, each), size), (name, each)
    await page.emulate_media(color_scheme="light")
    await page.set_viewport_size(DESK)  # type: ignore[arg-type]
    await page.wait_for_timeout(EASE_MS)


async def putting_it_right(page: Page) -> None:
    """A zone dragged over the fence is reported; a click into a zone removes it, and Undo brings both back."""
    corner, beyond = await pixel(page, ZONE[2]), await pixel(page, (30, 55))
    await drag(page, corner, beyond)
    await shows(page, "Zone 1: crosses the fence's edge: move its corners inside the fence.")
    await expect(button(page, "Save fence")).to_be_disabled()
    await press(page, "Undo")
    await press(page, "Remove corners")
    await shows(page, "or into a zone to remove it")
    await page.mouse.click(*await pixel(page, IN_THE_ZONE))
    await expect(title(page)).to_have_text(re.compile("4 corners, 1 zone$"))
    await press(page, "Undo")
    await expect(title(page)).to_have_text(re.compile("4 corners, 2 zones$"))
    await page.wait_for_timeout(300)
    await page.mouse.click(*await pixel(page, MAST[0]))  # the zone has only three corners: it goes as a whole
    await expect(title(page)).to_have_text(re.compile("4 corners, 1 zone$"))
    await press(page, "Remove corners")
    await expect(button(page, "Save fence")).to_be_enabled()
