from __future__ import annotations

import math
import re
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import pytest_asyncio
from playwright.async_api import Browser, Page, expect

from hawk.comm.protocol.commands import Arm
from hawk.sim.launch import SimulationOptions
from hawk.survey.stack import SimulatedStack
from tests.e2e.hands import (
    button,
    confirm,
    hold_enter,
    is_within,
    keep_pressed,
    new_page,
    press,
    shows,
    slide,
    state_is,
    take_off,
    visible,
)
from tests.e2e.watching import watch
from tests.integration.daemon_support import PatientStack, eventually, kill_daemon, operator, write_settings
from tests.pace import speed_here

pytestmark = [pytest.mark.e2e, pytest.mark.whole, pytest.mark.asyncio(loop_scope="session")]

SETTINGS = """
[heights]
minimum_m = 15.0
desired_m = 25.0
maximum_m = 30.0
"""
SPEED = speed_here(2.0)
"""Two pages beside drone and daemon leave two slow cores no room for more."""
CAMERA_HZ = 5.0
"""Pictures in a simulated second: vision keeps up with them."""
EXPLORE_ATTEMPTS = 5
CUT_ATTEMPTS = 3
DESK = {"width": 1440, "height": 900}
SIZES = {"desk": DESK, "phone": {"width": 390, "height": 844}, "phone-on-its-side": {"width": 844, "height": 390}}
FAR_PX = 80
HALF_THE_LOT_M = 35.0  # it begins at the lot's west end
SOME_STALLS = re.compile(r"\d\d stalls found")
LEAST_MOVE_M = 6.0
STILL_M_S = 0.4
EASE_MS = 500
"""By then the map has come to rest, with the drone in its middle."""


@dataclass(frozen=True)
class Scene:
    """A drone, the one who flies it, and one who watches."""

    stack: SimulatedStack
    url: str
    pilot: Page
    watcher: Page

    async def place_at_rest(self) -> tuple[float, float]:
        """Wait until the drone stands still; return where it really is, metres east and south."""
        return place(await eventually(self.stack.status, lambda s: max(map(abs, s["velocity"])) < STILL_M_S, 20))


def place(status: dict[str, Any]) -> tuple[float, float]:
    return status["position"]["x"], status["position"]["y"]


@pytest_asyncio.fixture(loop_scope="session")
async def scene(browser: Browser, tmp_path: Path) -> AsyncIterator[Scene]:
    config = write_settings(tmp_path, SETTINGS)
    stack = PatientStack(SimulationOptions(seed=1, speed=SPEED, camera_rate=CAMERA_HZ), tmp_path / "run", config, None)
    try:
        url = (await stack.start()).url
        pages = []
        for _ in range(2):
            pages.append(await new_page(browser, viewport=DESK, color_scheme="light"))
            await pages[-1].goto(url)
        yield Scene(stack, url, *pages)
    finally:
        await stack.stop()


async def test_two_people_and_a_drone(scene: Scene, screenshots: Path) -> None:
    """Control, watching, Hold, Move, a daemon that dies, and Cut motors: by clicks on two pages, in one flight."""
    errors, home = watch(scene.pilot), await scene.place_at_rest()
    await press(scene.pilot, "Take control")
    await take_off(scene.pilot)
    await a_viewer_is_shown_as_such_and_commands_nothing(scene)
    await explore(scene.pilot)
    await everything_fits(scene.pilot, screenshots)
    await press(scene.watcher, "Hold")
    await state_is(scene.pilot, "Holding")
    await scene.watcher.context.close()
    # how far it explored depends on the machine: first to where there is lot for sure, then back again
    first = -1 if (await scene.place_at_rest())[0] - home[0] > HALF_THE_LOT_M else 1
    await move(scene, first, by_key=False)
    await press(scene.pilot, "Hold")
    await state_is(scene.pilot, "Holding")
    await move(scene, -first, by_key=True)
    await press(scene.pilot, "Hold")
    await state_is(scene.pilot, "Holding")
    assert not errors
    await a_dead_daemon_is_reported_and_found_again(scene, screenshots)
    await the_motors_are_cut_in_two_steps(scene, screenshots)


async def explore(page: Page) -> None:
    """Explore until a few stalls are known; press again when a machine too busy to see ended it."""
    known = page.locator("hawk-counts").get_by_text(SOME_STALLS)
    for _ in range(EXPLORE_ATTEMPTS):
        await confirm(page, "Explore")
        await state_is(page, "Exploring")
        ended = page.locator("button[data-action=explore][aria-pressed=false]")
        await expect(known.or_(ended).first).to_be_visible()
        if await known.count() and not await ended.count():
            return
    pytest.fail(f"exploring ended {EXPLORE_ATTEMPTS} times")


async def a_viewer_is_shown_as_such_and_commands_nothing(scene: Scene) -> None:
    page = scene.watcher
    await shows(page, "You are watching. Someone else has control.")
    await expect(button(page, "Arm")).to_have_count(0)
    await expect(button(page, "Land")).to_be_disabled()
    await expect(button(page, "Land")).to_contain_text("Someone else has control")
    await expect(button(page, "Cut motors")).to_be_disabled()
    await press(page, "Ask for control")
    await shows(page, "was asked for control.")
    await shows(scene.pilot, "asks for control.")
    await press(scene.pilot, "Keep")
    await shows(page, "keeps control.")
    async with operator(scene.url) as another:
        assert await another.refusal(Arm()) == "Someone else has control."


async def everything_fits(page: Page, screenshots: Path) -> None:
    """In every size and both themes: nothing is cut off at the side, and Hold and Land are in reach."""
    for name, size in SIZES.items():
        await page.set_viewport_size(size)  # type: ignore[arg-type]
        for theme in ("light", "dark"):
            await page.emulate_media(color_scheme=theme)
            await expect(page.locator("html")).to_have_attribute("data-theme", theme)
            await expect(button(page, "Hold")).to_be_enabled()
            await page.screenshot(path=screenshots / f"exploring-{name}-{theme}.png")
            assert await page.evaluate("document.documentElement.scrollWidth <= innerWidth")
            for each in ("Hold", "Land"):
                assert await is_within(button(page, each), size)
    await page.emulate_media(color_scheme="light")
    await page.set_viewport_size(DESK)  # type: ignore[arg-type]


async def move(scene: Scene, side: int, *, by_key: bool) -> None:
    """Point at a place on the map, to the right (1) or left (-1) of the drone, and confirm: it flies there."""
    page, before = scene.pilot, await scene.place_at_rest()
    await press(page, "Follow the drone")
    await page.wait_for_timeout(EASE_MS)
    await press(page, "Move")
    box = await page.locator(".ol").bounding_box()
    assert box is not None
    await page.mouse.click(box["x"] + box["width"] / 2 + side * FAR_PX, box["y"] + box["height"] / 2)
    track = page.locator("hawk-slide button")
    await expect(track).to_be_enabled()
    if by_key:
        await track.focus()
        await hold_enter(page)
        await state_is(page, "Moving")
    else:
        await slide(page, track)
        await state_is(page, "Moving")

    there = await eventually(scene.stack.status, lambda s: math.dist(place(s), before) > LEAST_MOVE_M, 30)
    after = place(there)
    assert side * (after[0] - before[0]) > 2 * abs(after[1] - before[1])  # to the right is east


async def a_dead_daemon_is_reported_and_found_again(scene: Scene, screenshots: Path) -> None:
    page = scene.pilot
    await kill_daemon(scene.stack)
    await shows(page, "No word from the drone for")
    await shows(page, "By its settings")
    await expect(button(page, "Hold")).to_be_disabled()
    await expect(button(page, "Return home")).to_be_disabled()
    await page.screenshot(path=screenshots / "no-link.png")
    await scene.stack.start_daemon()
    await expect(visible(page, "No word from the drone for")).to_have_count(0)
    await press(page, "Take control")
    await state_is(page, "Holding")


async def cut_motors(page: Page) -> None:
    """Keep the button pressed until the motors are cut; press again where the page says that it was busy."""
    await press(page, "Cut motors")
    cut = button(page, "Keep pressed 1 s to cut")
    for _ in range(CUT_ATTEMPTS):
        await expect(cut).to_be_enabled()
        await keep_pressed(page, cut, 3000)  # a page that draws slowly hears of the press late
        if not await cut.count():
            return
        await shows(page, "The page was too busy to follow the press")
    pytest.fail(f"the page could not follow {CUT_ATTEMPTS} presses")


async def the_motors_are_cut_in_two_steps(scene: Scene, screenshots: Path) -> None:
    page = scene.pilot
    await press(page, "Cut motors")
    cut = button(page, "Keep pressed 1 s to cut")
    await expect(cut).to_be_enabled()
    await page.screenshot(path=screenshots / "cut-motors.png")
    await keep_pressed(page, cut, 300)
    status = await scene.stack.status()
    assert not status["disarmed"]
    # the drone allows 10 s: a person who looked around begins again
    await press(page, "Cancel")
    await cut_motors(page)
    fallen = await eventually(scene.stack.status, lambda s: s["disarmed"] and s["landed"], 20)
    assert fallen["crashed"]
    await state_is(page, "Motors cut")
    await expect(button(page, "Arm")).to_contain_text("failed")  # it shows the checks, and arms nothing
    await page.screenshot(path=screenshots / "motors-cut.png")
    await press(page, "Allow arming again")
    await expect(button(page, "Allow arming again")).to_have_count(0)
