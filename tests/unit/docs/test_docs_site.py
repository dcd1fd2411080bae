"""The site of the documentation: its sources are staged, built strictly, and checked."""

from __future__ import annotations

import gzip
import shutil
from pathlib import Path

import pytest

from tests.unit.docs.scripts import load

ROOT = Path(__file__).parents[3]
docs_site = load("docs_site")
docs_check = load("docs_check")

INDEX = """# hawk

Words.

## Start

- [First](first.md)

## Explanation

- [Deep](deep/page.md)
  - [Security](../SECURITY.md)
- [Changes](../CHANGELOG.md)
- [Contribute](../CONTRIBUTING.md)
"""
FIRST = """# First flight

![A picture](images/page.png)

[settings](../config.toml), [deep](deep/page.md#a-heading), [out](https://example.org), [here](#first-flight)

    make docs

| key | meaning |
|---|---|
| a | b |
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    root = tmp_path / "project"
    for folder in ("docs/deep", "docs/images", "packaging", "hawk/web/page/public"):
        (root / folder).mkdir(parents=True)
    shutil.copytree(ROOT / "packaging" / "docs", root / "packaging" / "docs")
    for name in ("docs_site.py", "docs_check.py"):
        shutil.copy(ROOT / "packaging" / name, root / "packaging")
    shutil.copy(ROOT / "hawk" / "web" / "page" / "public" / "icon.svg", root / "hawk" / "web" / "page" / "public")
    shutil.copy(ROOT / "docs" / "images" / "view-phone.jpg", root / "docs" / "images" / "page.png")
    (root / "pyproject.toml").write_text(
        '[project]\nname = "hawk-drone"\nversion = "1.4.0"\nurls.Homepage = "https://forge.example/hawk"\n'
    )
    (root / "config.toml").write_text("")
    for name in ("CHANGELOG", "CONTRIBUTING", "SECURITY"):
        (root / f"{name}.md").write_text(f"# {name.title()}\n\n[first](docs/first.md), [all](docs/deep/)\n")
    (root / "docs" / "index.md").write_text(INDEX)
    (root / "docs" / "first.md").write_text(FIRST)
    (root / "docs" / "deep" / "page.md").write_text("# Deep\n\n## A heading\n\n[changes](../../CHANGELOG.md)\n")
    return root


def test_links_lead_to_the_same_things_in_the_site(project: Path, tmp_path: Path) -> None:
    docs_site.stage(project, tmp_path / "staged")
    first = (tmp_path / "staged" / "first.md").read_text()
    assert "(https://forge.example/hawk/blob/main/config.toml)" in first
    assert "(deep/page.md#a-heading)" in first
    assert "(https://example.org)" in first
    assert "(#first-flight)" in first
    assert "[first](first.md), [all](index.md)" in (tmp_path / "staged" / "CHANGELOG.md").read_text()
    assert "[changes](../CHANGELOG.md)" in (tmp_path / "staged" / "deep" / "page.md").read_text()


def test_a_page_shows_a_section_of_a_file_as_it_is(project: Path, tmp_path: Path) -> None:
    text = "[a]\nx = 1\n\n[web]\n# TCP port\nport = {port}  # 0 to 65535\n\n[b]\ny = [1]\n"
    (project / "config.toml").write_text(text.format(port=3000))
    (project / "docs" / "first.md").write_text("# First\n\n<!-- ../config.toml [web] -->\n\nmore\n")
    before = docs_site.sources_hash(project)
    docs_site.stage(project, tmp_path / "staged")
    staged = (tmp_path / "staged" / "first.md").read_text()
    assert staged == "# First\n\n```toml\n[web]\n# TCP port\nport = 3000  # 0 to 65535\n```\n\nmore\n"
    (project / "config.toml").write_text(text.format(port=3001))
    assert docs_site.sources_hash(project) != before
    (project / "docs" / "first.md").write_text("# First\n\n<!-- ../config.toml [gone] -->\n")
    with pytest.raises(docs_site.DocsError, match="gone"):
        docs_site.stage(project, tmp_path / "again")


def test_a_link_that_leads_nowhere_is_named(project: Path, tmp_path: Path) -> None:
    (project / "docs" / "first.md").write_text("# First\n\n[gone](gone.md)\n")
    with pytest.raises(docs_site.DocsError, match=r"docs/first\.md: the link gone\.md leads nowhere"):
        docs_site.stage(project, tmp_path / "staged")


def test_the_lists_of_the_index_are_the_menu() -> None:
    menu = docs_site.menu(INDEX)
    assert ":caption: Start\n\n/first\n```" in menu["index.md"]
    assert ":caption: Explanation\n\n/deep/page\n/CHANGELOG\n/CONTRIBUTING\n```" in menu["index.md"]
    assert "/SECURITY\n```" in menu["deep/page.md"]
    assert docs_site.menu("# hawk\n\n## Words\n\nNone.\n") == {"index.md": ""}


def test_every_page_is_in_the_menu_once() -> None:
    menu = docs_site.menu((ROOT / "docs" / "index.md").read_text(encoding="utf-8"))
    entries = [line[1:] for text in menu.values() for line in text.splitlines() if line.startswith("/")]
    pages = {docs_site._place(ROOT, path) for path in docs_site._pages(ROOT) if path.suffix == ".md"}
    assert sorted(entries) == sorted(page.with_suffix("").as_posix() for page in pages if page.name != "index.md")


def test_the_hash_changes_with_a_page_the_theme_and_the_version(project: Path) -> None:
    seen = {docs_site.sources_hash(project)}
    for name in ("docs/first.md", "packaging/docs/static/hawk.css", "pyproject.toml", "docs/images/page.png"):
        with (project / name).open("ab") as file:
            file.write(b"\n")
        seen.add(docs_site.sources_hash(project))
    assert len(seen) == 5


# -- built ------------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_site_is_built_checked_and_not_built_again(project: Path) -> None:
    assert docs_site.build_docs(project)
    site = project / "hawk" / "web" / "docs_site"
    text = (site / "first.html").read_text()
    assert "hawk 1.4.0" in text
    assert 'href="deep/page.html#a-heading"' in text
    assert all(better in text for better in docs_site.IMPROVED.values())
    assert gzip.decompress((site / "first.html.gz").read_bytes()).decode() == text
    assert docs_check.check(site) == []
    assert (site / "searchindex.js").is_file()
    assert not docs_site.build_docs(project)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("page", "text"),
    [
        ("first.md", "# First\n\n[deep](deep/page.md#no-such-heading)\n"),
        ("first.md", "# First\n\n[here](#nowhere)\n"),
        ("alone.md", "# A page that no menu names\n"),
    ],
)
def test_a_fault_of_a_page_ends_the_build(project: Path, page: str, text: str) -> None:
    (project / "docs" / page).write_text(text)
    with pytest.raises(docs_site.DocsError, match="Sphinx found the faults above"):
        docs_site.build_docs(project)
    assert not (project / "hawk" / "web" / "docs_site").exists()


# -- checked ----------------------------------------------------------------------------------------------------------

PAGE = '<!doctype html><link rel="stylesheet" href="a.css"><h1 id="top">hawk</h1>{}'


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        ('<a href="b.html#there">b</a>', None),
        ('<a href="#top">top</a>', None),
        ('<a href="https://example.org/">elsewhere</a>', None),
        ('<a href="c.html">c</a>', "the link c.html leads to no file of the site"),
        ('<a href="b.html#nowhere">b</a>', "the link b.html#nowhere leads to no element of that page"),
        ('<a href="#nowhere">b</a>', "the link #nowhere leads to no element of that page"),
        ('<a href="../out.html">out</a>', "the link ../out.html leads to no file of the site"),
        ('<img src="https://example.org/x.png">', "loads https://example.org/x.png from elsewhere"),
        ('<script src="//cdn.example/x.js"></script>', "loads //cdn.example/x.js from elsewhere"),
        ("<script>act()</script>", "has a script in its text"),
        ("<style>p {}</style>", "has a style sheet in its text"),
        ('<p style="color: red">', "<p> has the attribute style"),
        ('<p onclick="act()">', "<p> has the attribute onclick"),
        ('<a href="javascript:act()">act</a>', "loads javascript:act() from elsewhere"),
    ],
)
def test_what_is_wrong_with_a_page(tmp_path: Path, content: str, fault: str | None) -> None:
    site = tmp_path / "site"
    site.mkdir()
    (tmp_path / "out.html").write_text("")
    (site / "a.css").write_text("a { background: url(data:image/png;base64,AA) }")
    (site / "index.html").write_text(PAGE.format(content))
    (site / "b.html").write_text('<h1 id="there">b</h1>')
    assert docs_check.check(site) == ([] if fault is None else [f"index.html: {fault}"])


def test_a_style_sheet_that_loads_from_elsewhere_is_found(tmp_path: Path) -> None:
    (tmp_path / "index.html").write_text("<h1>hawk</h1>")
    (tmp_path / "a.css").write_text('@import "https://fonts.example/x.css"; a { background: url(missing.png) }')
    assert docs_check.check(tmp_path) == [
        "a.css: loads https://fonts.example/x.css, which is not in the site",
        "a.css: loads missing.png, which is not in the site",
    ]


def test_a_site_without_a_first_page_is_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert docs_check.main([str(tmp_path)]) == 1
    assert "index.html: is missing" in capsys.readouterr().err
