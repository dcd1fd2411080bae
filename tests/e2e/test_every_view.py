"""Every view of the page over a made-up drone with surveys and a recording, judged by axe-core, and by Tab."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Any, Final

import pytest
from playwright.async_api import Browser, Page, expect
from playwright.async_api import TimeoutError as NotInTimeError

from tests.e2e.hands import new_page
from tests.e2e.test_page_by_keyboard import AXE, DESK, PHONE, faults, in_words
from tests.e2e.watching import watch
from tests.examples import nightly

pytestmark = [pytest.mark.e2e, pytest.mark.asyncio(loop_scope="session")]

IDLE_MS: Final = 20_000
MAP = "hawk-survey-map[data-drawn]"
VIEWS = {
    "fly": ("#/fly", "hawk-bar .act:visible"),
    "lots": ("#/lots/{lot}/{after}", MAP),
    "stalls": ("#/lots/{lot}?show=stalls", MAP),
    "links": ("#/lots/{lot}?show=links", "archive-links button"),
    "arrivals": ("#/lots/{lot}?show=arrivals", "archive-arrivals select"),
    "compare": ("#/compare/{lot}/{before}/{after}", MAP),
    "report": ("#/report/{lot}?part=row.A&days=mon-fri&hours=8-15", ".ask .answer .large"),
    "document": ("#/report/{lot}?show=document", "archive-document iframe"),
    "recordings": ("#/recordings/{lot}", "archive-recordings table"),
    "film": ("#/recordings/{lot}/{recording}?t=60", MAP),
}
"""Address of each view, and what is seen when it is drawn."""
SHUT = ("localStorage", "script", "Framing")
"""In errors of what this test puts into every frame: the frame of the document runs nothing."""
CONTROLS = """() => {
  const all = document.querySelectorAll("a[href], button, input, select, textarea, summary, iframe, [tabindex]");
  window.controls = [...all].filter((each) =>
    each.tabIndex >= 0 && !each.disabled && !each.closest("[inert]") && each.getClientRects().length > 0
    && each.checkVisibility({ visibilityProperty: true }));
  document.activeElement?.blur();
  return window.controls.map((each) => each.outerHTML.slice(0, 120));
}"""
STEP = """() => {
  const { activeElement: at } = document;
  if (!at || at === document.body) return null;
  const isRinged = (each) => {
    const { outlineStyle, outlineWidth } = getComputedStyle(each);
    return outlineStyle !== "none" && parseFloat(outlineWidth) >= 2;
  };
  const { left, top, right, bottom } = at.getBoundingClientRect();
  const isInWindow = right > 0 && bottom > 0 && left < innerWidth && top < innerHeight;
  const near = [at, at.closest("label"), at.parentElement];
  const isShown = at.tagName === "IFRAME" || near.some((each) => each && isRinged(each));
  const problem = isInWindow ? (isShown ? "" : "nothing shows that it has the focus") : "has the focus out of sight";
  return { index: window.controls.indexOf(at), problem: problem && `${at.outerHTML.slice(0, 120)}: ${problem}` };
}"""


async def ids(page: Page) -> dict[str, str]:
    """Return the ids that addresses have."""

    async def items(path: str, key: str = "items") -> list[Any]:
        found: list[Any] = await page.evaluate(f"async () => (await (await fetch('/api/v1/{path}')).json()).{key}")
        return found

    lot = (await items("lots"))[0]["id"]
    after, before = (each["id"] for each in await items(f"lots/{lot}/statistics/surveys?newest=2", "surveys"))
    return {"lot": lot, "before": before, "after": after, "recording": (await items("recordings"))[0]["name"]}


async def not_by_tab(page: Page) -> list[str]:
    """Return what Tab does not reach, or not in the order of the page, or without showing it."""
    controls: list[str] = await page.evaluate(CONTROLS)
    problems: list[str] = []
    order: list[int] = []
    for _ in range(len(controls) + 20):  # a document has stops of its own
        await page.keyboard.press("Tab")
        step = await page.evaluate(STEP)
        if step is None:
            break
        problems += [step["problem"]] if step["problem"] else []
        if step["index"] >= 0 and step["index"] not in order:  # what scrolls has a stop, too
            order.append(step["index"])
    problems += [] if order == sorted(order) else [f"Tab goes {order}"]
    return problems + [f"{each}: Tab does not reach it" for k, each in enumerate(controls) if k not in order]


async def problems_of(page: Page, address: str, names: list[str], screenshots: Path) -> dict[str, list[str]]:
    """Open views; return what axe finds in each, what Tab does not reach, and what is wider than the window."""
    found: dict[str, list[str]] = {}
    await page.goto(address)
    known = await ids(page)
    for name in names:
        place, sign = VIEWS[name]
        await page.goto("about:blank")
        await page.goto(address + place.format(**known))
        await expect(page.locator(sign).first).to_be_visible()
        with contextlib.suppress(NotInTimeError):  # what comes late is judged, too; a busy computer is never idle
            await page.wait_for_load_state("networkidle", timeout=IDLE_MS)
        problems = [each for all_of_it in (await faults(page, name, screenshots)).values() for each in all_of_it]
        problems += await not_by_tab(page)
        wide = await page.evaluate("document.documentElement.scrollWidth - innerWidth")
        problems += [f"is {wide} pixels wider than the window"] if wide > 0 else []
        if problems:
            found[name] = problems
    return found


@pytest.mark.parametrize(
    ("size", "theme", "language"),
    [
        (PHONE, "dark", "en"),
        *nightly(
            (DESK, "light", "en"),
            (DESK, "dark", "fr"),
            (DESK, "outdoor", "en"),
            (PHONE, "light", "fr"),
            (PHONE, "outdoor", "en"),
        ),
    ],
)
async def test_axe_finds_nothing_and_tab_reaches_everything(
    browser: Browser, fake: Any, tmp_path: Path, screenshots: Path, size: Any, theme: str, language: str
) -> None:
    page = await new_page(browser, viewport=size)
    await page.add_init_script(path=AXE)
    stored = f"JSON.stringify({{theme: '{theme}', language: '{language}', name: 'ana'}})"
    await page.add_init_script(f"localStorage.setItem('hawk-page', {stored})")
    errors = watch(page)
    store = ("--lots", str(tmp_path / "lots.db"), "--surveys", "2")
    drone, address = await fake("ready", *store)
    found = await problems_of(page, address, list(VIEWS), screenshots)
    await page.goto("about:blank")
    drone.kill()
    await drone.wait()
    _, in_flight = await fake("still", *store)
    flying = await problems_of(page, in_flight, ["fly", "lots"], screenshots)
    found |= {f"{name} in flight": problems for name, problems in flying.items()}
    assert not found, in_words(found)
    assert [each for each in errors if not any(word in each for word in SHUT)] == []
