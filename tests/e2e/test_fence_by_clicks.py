"""The fence by clicks: drawn, put right, saved, taken up by a later start, uploaded, and kept to."""

from __future__ import annotations

import json
import re
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path

import pytest
import pytest_asyncio
from playwright.async_api import Browser, Locator, Page, expect

from hawk.comm.protocol.heartbeat import FenceSetup
from hawk.survey.stack import SimulatedStack
from tests.e2e.hands import button, hover, is_within, new_page, prefer_hand, press, shows, slide, state_is
from tests.e2e.watching import watch
from tests.integration.daemon_support import LOW_HEIGHTS, health, kill_daemon, operator, over_a_picture
from tests.pace import PATIENCE_S

pytestmark = [pytest.mark.e2e, pytest.mark.asyncio(loop_scope="session")]

DESK = {"width": 1440, "height": 900}
ROOMY = {"width": 1440, "height": 980}
"""The whole of `U_SHAPE` is in sight while it is drawn, clear of the tools."""
PHONE = {"width": 390, "height": 844}
SIZES = {
    "desk": DESK,
    "tablet": {"width": 820, "height": 1180},
    "phone": PHONE,
    "small-phone": {"width": 320, "height": 568},
    "phone-on-its-side": {"width": 844, "height": 390},
}
U_SHAPE = ((-20, -45), (40, -45), (40, -15), (10, -15), (10, 15), (40, 15), (40, 45), (-20, 45))
"""North and east of the drone, metres: two arms with a gap between them. Our limit lies 5 m inside."""
IN_THE_ARM, AT_ITS_FOOT = (25.0, -30.0), (0.0, -30.0)
EASE_MS = 500
HALF = 48
"""Of the finger's fence, pixels."""


@dataclass(frozen=True)
class Scene:
    """A drone on the ground and one who flies it."""

    stack: SimulatedStack
    url: str
    page: Page


@pytest_asyncio.fixture(loop_scope="session")
async def scene(browser: Browser, tmp_path: Path) -> AsyncIterator[Scene]:
    stack = over_a_picture(tmp_path, LOW_HEIGHTS)
    try:
        url = (await stack.start()).url
        page = await new_page(browser, viewport=ROOMY, color_scheme="light")
        await page.goto(url)
        yield Scene(stack, url, page)
    finally:
        await stack.stop()


async def test_a_fence_is_drawn_kept_and_kept_to(scene: Scene, screenshots: Path, tmp_path: Path) -> None:
    page = scene.page
    errors = watch(page)
    await press(page, "Take control")
    await page.screenshot(path=screenshots / "fence-1-before.png")
    await press(page, "Edit fence")
    await shows(page, "Draw the fence")
    await drawing_by_clicks(page, screenshots)
    await putting_it_right(page)
    await everything_fits(page, screenshots)
    await a_file_goes_out_and_comes_in(page, tmp_path)
    await press(page, "Save fence")
    await shows(page, "The fence is saved. The next Arm uploads it.")
    await shows(page, "Fence of 8 corners")
    await page.screenshot(path=screenshots / "fence-3-saved.png")
    kept = await fence_of(scene.url)
    assert (kept.source, kept.ceiling, len(kept.corners)) == ("drawn", 60, 8)
    assert [error for error in errors if "422" not in error] == [], "but that of the file that was refused"

    await kill_daemon(scene.stack)
    await scene.stack.start_daemon()
    await press(page, "Take control")
    assert (await fence_of(scene.url)).corners == kept.corners
    await scene.stack.watch_fence([(each.latitude, each.longitude) for each in kept.inner], kept.ceiling)

    await autopilot_is_found(scene.url)
    await hover(page)
    await page.get_by_role("tab", name="Settings").click()
    await expect(button(page, "Edit fence")).to_be_disabled()
    await expect(button(page, "Edit fence")).to_contain_text("Flying: land first")
    await the_path_across_the_gap_is_refused(page, screenshots)
    await move_to(page, AT_ITS_FOOT)
    await slide(page, page.locator("hawk-slide button"))
    await state_is(page, "Moving")
    await state_is(page, "Holding")
    status = await scene.stack.status()
    assert status["excursions"] == 0
    await page.screenshot(path=screenshots / "fence-5-moved.png")
    await move_to(page, IN_THE_ARM, of=AT_ITS_FOOT)
    await expect(page.get_by_label("Anywhere inside the fence")).to_be_enabled()


async def test_a_fence_is_drawn_with_a_finger(browser: Browser, tmp_path: Path, screenshots: Path) -> None:
    """On a phone: by taps, closed by a tap on the first corner; then a corner is dragged by a finger."""
    stack = over_a_picture(tmp_path, LOW_HEIGHTS)
    try:
        url = (await stack.start()).url
        page = await new_page(browser, viewport=PHONE, has_touch=True, is_mobile=True)
        errors = watch(page)
        await page.goto(url)
        await button(page, "Take control").tap()
        await autopilot_is_found(url)
        await button(page, "Arm").tap()  # its checks fail: it shows them
        await button(page, "Edit fence").tap()
        await shows(page, "Tap its corners on the map")
        await the_map_follows_nothing(page)
        # by pixels from the middle: the map opens at one of several zooms, and its tools lie over its rim
        x, y, per_metre = await scale(page)
        places = [(x - HALF, y + HALF), (x - HALF, y - HALF), (x + HALF, y - HALF), (x + HALF, y + HALF)]
        for count, place in enumerate(places, start=1):
            await page.touchscreen.tap(*place)
            await shows(page, f"{count} corner{'s' if count > 1 else ''} set")
            await page.wait_for_timeout(EASE_MS)
        await page.touchscreen.tap(*places[0])
        await width_is(page, 2 * HALF / per_metre)
        await drag_by_finger(page, places[2], (x + 2 * HALF, y - HALF))
        await width_is(page, 3 * HALF / per_metre)
        await page.screenshot(path=screenshots / "fence-by-finger.png")
        await button(page, "Save fence").tap()
        await shows(page, "The fence is saved. The next Arm uploads it.")
        assert (await fence_of(url)).source == "drawn"
        assert not errors
    finally:
        await stack.stop()


async def width_is(page: Page, metres: float) -> None:
    """Wait until the fence is so wide, within what a finger and rounding may change."""
    await page.wait_for_function(
        """([metres, within]) => {
          const title = document.querySelector("hawk-fence-bar .txt b")?.innerText ?? "";
          const found = /^Fence (\\d+) × \\d+ m, 4 corners/.exec(title);
          return found !== null && Math.abs(Number(found[1]) - metres) <= within;
        }""",
        arg=[metres, 1 + 0.02 * metres],
        timeout=1000 * PATIENCE_S,
    )


async def the_map_follows_nothing(page: Page) -> None:
    """While corners are set, nothing but the operator moves the map under them."""
    for each in ("Follow the drone", "Whole lot"):
        await expect(button(page, each)).to_have_attribute("aria-pressed", "false")


async def drag_by_finger(page: Page, start: tuple[float, float], end: tuple[float, float]) -> None:
    """Put a finger down, move it and lift it (Playwright itself can only tap)."""
    devtools = await page.context.new_cdp_session(page)

    async def touch(kind: str, *places: tuple[float, float]) -> None:
        points = [{"x": x, "y": y} for x, y in places]
        await devtools.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    await touch("touchStart", start)
    for share in (0.1, 0.3, 0.5, 0.7, 0.9, 1.0):
        await touch("touchMove", (start[0] + (end[0] - start[0]) * share, start[1] + (end[1] - start[1]) * share))
        await page.wait_for_timeout(30)
    await touch("touchEnd")


async def drawing_by_clicks(page: Page, screenshots: Path) -> None:
    """Corner by corner, closed by a click on the first one."""
    await press(page, "Follow the drone")
    await page.wait_for_timeout(EASE_MS)
    await expect(button(page, "Save fence")).to_be_disabled()
    places = [await pixel(page, place) for place in U_SHAPE]
    for count, place in enumerate(places, start=1):
        await page.mouse.click(*place)
        await shows(page, f"{count} corner{'s' if count > 1 else ''} set")
        await page.wait_for_timeout(300)  # two clicks within 250 ms at one place are a double click
    await press(page, "Undo")
    await shows(page, "7 corners set")
    await page.mouse.click(*places[-1])
    await shows(page, "8 corners set")
    await page.screenshot(path=screenshots / "fence-2-drawing.png")
    await page.wait_for_timeout(300)
    await page.mouse.click(*places[0])
    await expect(title(page)).to_have_text(re.compile(r"Fence (89|9[01]) × (59|6[01]) m, 8 corners"))
    await shows(page, "From parts of it the straight path home leaves the fence")


async def putting_it_right(page: Page) -> None:
    """A corner dragged across a side and a ceiling that is too low are reported, and mended."""
    first, far = await pixel(page, U_SHAPE[0]), await pixel(page, (30, 0))
    await drag(page, first, far)
    await shows(page, "This fence cannot be saved")
    await shows(page, "cross: move a corner so that no side crosses another")
    await expect(button(page, "Save fence")).to_be_disabled()
    await press(page, "Undo")
    ceiling = page.get_by_label("Ceiling, metres above")
    await ceiling.fill("9")
    await shows(page, "Ceiling: 9 m is too low for flying up to 10 m, which needs 13 m")
    await ceiling.fill("60")
    await expect(title(page)).to_have_text(re.compile("8 corners"))
    await expect(button(page, "Save fence")).to_be_enabled()
    await press(page, "Remove corners")
    await page.mouse.click(*await pixel(page, U_SHAPE[2]))
    await expect(title(page)).to_have_text(re.compile("7 corners"))
    await press(page, "Undo")
    await expect(title(page)).to_have_text(re.compile("8 corners"))


async def everything_fits(page: Page, screenshots: Path) -> None:
    """In every size, theme and hand: nothing is cut off at the side, and all that edits is in reach."""
    for name, size in SIZES.items():
        await page.set_viewport_size(size)  # type: ignore[arg-type]
        for theme in ("light", "dark"):
            await page.emulate_media(color_scheme=theme)
            await expect(page.locator("html")).to_have_attribute("data-theme", theme)
            await page.wait_for_timeout(EASE_MS)
            await page.screenshot(path=screenshots / f"fence-editor-{name}-{theme}.png")
            assert await page.evaluate("document.documentElement.scrollWidth <= innerWidth")
            await prefer_hand(page, is_left=theme == "dark")
            for each in ("Save fence", "Cancel", "Undo", "Clear", "Import", "Export", "Layers", "Hold", "Land"):
                assert await is_within(button(page, each), size), (name, each)
    await prefer_hand(page, is_left=False)
    await page.emulate_media(color_scheme="light")
    await page.set_viewport_size(ROOMY)  # type: ignore[arg-type]


async def a_file_goes_out_and_comes_in(page: Page, folder: Path) -> None:
    """The exported fence is the drawn one and is imported after a clear; a wrong file changes nothing."""
    async with page.expect_download() as waiting:
        await press(page, "Export")
    path = folder / "exported.geojson"
    await (await waiting.value).save_as(path)
    (ring,) = json.loads(path.read_text())["geometry"]["coordinates"]
    assert len(ring) == 9
    await press(page, "Clear")
    await shows(page, "Draw the fence")
    wrong = folder / "wrong.geojson"
    wrong.write_text('{"type": "Point", "coordinates": [0, 0]}')
    await page.locator("hawk-fence-tools input").set_input_files(wrong)
    await shows(page, "exactly one polygon")
    await page.locator("hawk-fence-tools input").set_input_files(path)
    await expect(title(page)).to_have_text(re.compile("8 corners"))


async def the_path_across_the_gap_is_refused(page: Page, screenshots: Path) -> None:
    """The arm is inside, the straight path to it is not, and no lot to fly over is known: the bar says why."""
    await move_to(page, IN_THE_ARM)
    await shows(page, "The straight path there leaves the fence")
    await expect(page.get_by_label("Anywhere inside the fence")).to_be_disabled()
    await expect(page.locator("hawk-slide button")).to_be_disabled()
    await page.screenshot(path=screenshots / "fence-4-refused.png")
    await press(page, "Cancel")


async def move_to(page: Page, place: tuple[float, float], of: tuple[float, float] = (0.0, 0.0)) -> None:
    """Point at a place (metres north and east of where the drone was armed) while the drone is at another."""
    await press(page, "Follow the drone")
    await page.wait_for_timeout(EASE_MS)
    await press(page, "Move")
    await page.mouse.click(*await pixel(page, (place[0] - of[0], place[1] - of[1])))


def title(page: Page) -> Locator:
    return page.locator("hawk-fence-bar .txt b")


async def drag(page: Page, start: tuple[float, float], end: tuple[float, float]) -> None:
    await page.mouse.move(*start)
    await page.mouse.down()
    await page.mouse.move((start[0] + end[0]) / 2, (start[1] + end[1]) / 2, steps=5)
    await page.mouse.move(*end, steps=5)
    await page.mouse.up()


SETTLED_SCALE = """async () => {
  const read = () => {
    const one = (selector) => document.querySelector(selector);
    const [map, bar] = [one(".ol"), one(".mapfoot .scale")].map((each) => each.getBoundingClientRect());
    return [map.x + map.width / 2, map.y + map.height / 2, bar.width, one(".mapfoot .metres").innerText];
  };
  let [before, same] = [null, 0];
  while (same < 5) {
    await new Promise(requestAnimationFrame);
    const now = JSON.stringify(read());
    same = now === before ? same + 1 : 0;
    before = now;
  }
  return read();
}"""
"""The middle of the map, the length of the scale bar and what it says, once five drawn frames agree on it."""


async def scale(page: Page) -> tuple[float, float, float]:
    """Return the middle of the map on the screen, and its pixels a metre by the scale bar."""
    x, y, bar, words = await page.evaluate(SETTLED_SCALE)
    metres, unit = words.split()
    return x, y, bar / (float(metres) / (100 if unit == "cm" else 1))


async def pixel(page: Page, place: tuple[float, float]) -> tuple[float, float]:
    """Return where a place (metres north and east of the middle of the map) is on the screen."""
    x, y, per_metre = await scale(page)
    north, east = place
    return x + east * per_metre, y - north * per_metre


async def autopilot_is_found(url: str) -> None:
    """Wait until the daemon hears the autopilot: before, it takes no command for it."""
    async with operator(url) as anyone:
        await anyone.until(lambda beat: health(beat, "link").healthy)


async def fence_of(url: str) -> FenceSetup:
    """Return which fence the drone says that it would arm with."""
    async with operator(url) as anyone:
        await anyone.until(lambda _: anyone.drone.fence_setup is not None)
        assert anyone.drone.fence_setup is not None
        return anyone.drone.fence_setup
