"""Words that a reader looks for are in the pages, and no page names a package that no index has."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PAGES = [*sorted((ROOT / "docs").rglob("*.md")), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
WRITTEN = frozenset({"api.md", "protocol.md", "command-line.md", "states.md"})
"""By programs, from other files."""


@pytest.mark.parametrize(("word", "page"), [("wifi", "first-flight-outside.md"), ("uninstall", "install.md")])
def test_a_word_that_is_looked_for_is_there(word: str, page: str) -> None:
    text = (ROOT / "docs" / page).read_text(encoding="utf-8").lower()
    assert re.search(rf"\b{word}\b", text), "Wi-Fi alone is indexed as two words"


def test_no_index_is_asked_for_our_package() -> None:
    code = [*(ROOT / "hawk").rglob("*.py"), ROOT / "config.toml"]
    for path in (*PAGES, *code):
        assert "pip install 'hawk-drone" not in path.read_text(encoding="utf-8"), path


def test_a_link_has_the_title_of_its_page_as_text() -> None:
    for path in PAGES:
        if path.name in WRITTEN or "results" in path.parts:
            continue
        bare = re.findall(r"\[(`?[\w./-]+\.md`?)\]\((?!.*CHANGELOG)[^)]+\)", path.read_text(encoding="utf-8"))
        assert bare == [], path


@pytest.mark.parametrize("page", ["first-flight-outside.md", "architecture.md"])
def test_a_figure_loads_nothing_and_has_words_for_those_who_do_not_see_it(page: str) -> None:
    (name,) = re.findall(r"!\[[^\]]+\]\((images/\w+\.svg)\)", (ROOT / "docs" / page).read_text(encoding="utf-8"))
    figure = (ROOT / "docs" / name).read_text(encoding="utf-8")
    assert "<title" in figure
    assert "<desc" in figure
    assert set(re.findall(r"https?://[^\"]+", figure)) == {"http://www.w3.org/2000/svg"}
    assert not re.search(r"<(script|image|foreignObject)|href=", figure)
