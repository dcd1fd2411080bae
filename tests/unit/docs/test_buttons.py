"""Bold names on the start pages, in troubleshooting and safety are those of the page or of a check."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.sweep import sweep

ROOT = Path(__file__).parents[3]
DOCS = ROOT / "docs"
PAGES = [*DOCS.glob("first-flight-*.md"), DOCS / "troubleshooting.md", DOCS / "safety.md", DOCS / "page.md"]
STRESSED = re.compile(r".*[.,].*|not connected")
"""Bold for another reason: a sentence, a figure, a warning."""
NAMES = sorted(
    {
        name
        for page in PAGES
        for name in re.findall(r"\*\*([^*]+)\*\*", page.read_text(encoding="utf-8"))
        if not STRESSED.fullmatch(name)
    }
)


@pytest.fixture(scope="module")
def shown() -> str:
    """Return the sources of what is shown: the page's English messages, and the checks."""
    messages = ROOT / "hawk" / "web" / "page" / "src" / "messages" / "en.ftl"
    files = [messages, *(ROOT / "hawk" / "ddc").glob("*.py")]
    return "\n".join(path.read_text(encoding="utf-8") for path in files)


@sweep("name", NAMES)
def test_the_page_shows_each_name(name: str, shown: str) -> None:
    words = re.escape(name)
    assert re.search(rf"[\"'`]{words}[\"'`]|^[a-z-]+ = {words}$", shown, re.MULTILINE), name


def test_names_of_buttons_are_found() -> None:
    assert {"Set failsafes", "Take control", "GPS"} <= set(NAMES)
