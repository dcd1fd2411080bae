"""Links, file names and names of code in the project's documents lead somewhere."""

from __future__ import annotations

import functools
import re
from pathlib import Path

from tests.sweep import sweep
from tests.unit.docs.names import ROOT, anchors, exists, is_known, links, marked

PAGES = sorted(
    [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / ".github").rglob("*.md")],
    key=lambda page: page.relative_to(ROOT).as_posix(),
)
LARGEST_PICTURE = 400_000


@functools.cache
def anchors_of(page: Path) -> set[str]:
    """Return the anchors of a page, to which a hundred links lead."""
    return set(anchors(page.read_text(encoding="utf-8")))


@sweep("page", PAGES)
def test_every_link_leads_to_a_file_and_a_heading(page: Path) -> None:
    for link in links(page.read_text(encoding="utf-8")):
        if re.match(r"https?:", link):
            continue
        name, _, anchor = link.partition("#")
        target = (page.parent / name).resolve() if name else page
        assert target.exists(), link
        assert not anchor or anchor in anchors_of(target), link


@sweep("page", PAGES)
def test_every_name_of_code_and_files_exists(page: Path) -> None:
    unknown = [name for name in marked(page.read_text(encoding="utf-8")) if not is_known(name)]
    assert not unknown


def test_every_page_can_be_reached_from_the_readme() -> None:
    reached = {ROOT / "README.md"}
    waiting = list(reached)
    while waiting:
        for link in links((current := waiting.pop()).read_text(encoding="utf-8")):
            target = (current.parent / link.partition("#")[0]).resolve()
            found = target.glob("*.md") if target.is_dir() else [target] if target.suffix == ".md" else []
            new = [each for each in found if each not in reached]
            reached.update(new)
            waiting += new
    assert {page for page in PAGES if page.is_relative_to(ROOT / "docs")} - reached == set()


def test_pictures_are_small() -> None:
    pictures = list((ROOT / "docs" / "images").iterdir())
    assert pictures
    assert [picture.name for picture in pictures if picture.stat().st_size >= LARGEST_PICTURE] == []


def test_a_decision_is_short() -> None:
    lengths = {page.name: page.read_text().count("\n") for page in (ROOT / "docs" / "decisions").iterdir()}
    assert {name: length for name, length in lengths.items() if length > 40} == {}


def test_every_result_names_its_command() -> None:
    for page in (ROOT / "docs" / "results").glob("*.md"):
        text = page.read_text(encoding="utf-8")
        assert any(
            command in text
            for command in ("python -m benchmarks", "python -m proving", "make mutants", "make bench", "make newcomer")
        ), page.name


def test_a_name_that_is_none_is_noticed() -> None:
    assert exists("hawk.ddc.readings.topic_interface.DdcTopicInterface.des_pose_pub")
    assert not exists("hawk.ddc.readings.topic_interface.DdcTopicInterface.des_pose_publisher")
    assert not exists("hawk.ddc.nothing_of_that_name")
    assert not is_known("hawk/ddc/nothing_of_that_name.py")
    assert is_known("pip install x")


def test_anchors_are_those_of_the_headings() -> None:
    assert anchors("# One frame\n\ntext\n\n## Nearest, by 2 m\n") == {"one-frame", "nearest-by-2-m"}
