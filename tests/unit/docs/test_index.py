"""The reader's paths of docs/index.md lead to pages that take the minutes that stand beside them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[3] / "docs"
WORDS_A_MINUTE = 200
LONGEST_MIN = 65
READERS = ("fly", "manage a lot", "analyse", "integrate", "change a rule", "change vision")
PATHS: dict[str, list[tuple[str, int]]] = {
    reader: [(page, int(minutes)) for page, minutes in re.findall(r"\]\(([\w./-]+\.md)\) \((\d+)\)", pages)]
    for reader, pages in re.findall(
        rf"^\| ({'|'.join(READERS)}) \| (.*) \|$",
        (DOCS / "index.md").read_text(encoding="utf-8"),
        re.MULTILINE,
    )
}


def test_there_is_a_path_for_each_reader() -> None:
    assert tuple(PATHS) == READERS
    assert all(len(pages) >= 6 for pages in PATHS.values())


@pytest.mark.parametrize(("page", "minutes"), sorted({each for pages in PATHS.values() for each in pages}))
def test_a_page_takes_the_minutes_that_are_said(page: str, minutes: int) -> None:
    words = len((DOCS / page).read_text(encoding="utf-8").split())
    assert abs(minutes - words / WORDS_A_MINUTE) <= 1.5, f"{page}: {words / WORDS_A_MINUTE:.0f} minutes"


@pytest.mark.parametrize("reader", PATHS)
def test_a_path_takes_about_an_hour(reader: str) -> None:
    assert 30 <= sum(minutes for _, minutes in PATHS[reader]) <= LONGEST_MIN
