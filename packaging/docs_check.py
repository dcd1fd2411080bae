"""Check a built site: ``python packaging/docs_check.py FOLDER``.

Every link leads to a file of the site and every anchor to an element of that page. A page loads nothing from elsewhere,
and has no script and no style in its text, so that it works offline and under the daemon's Content-Security-Policy.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from typing import Final
from urllib.parse import unquote, urlsplit

LOADED: Final = {
    *(("script", "src"), ("img", "src"), ("link", "href"), ("iframe", "src"), ("use", "href"), ("form", "action")),
}
"""Elements whose attribute the browser follows by itself."""
_CSS_URL: Final = re.compile(r"url\(\s*['\"]?(?!data:|#)([^'\")]+)|@import\s+['\"]([^'\"]+)")


@dataclass
class Page(HTMLParser):
    """The links, ids and faults of one page; feed it the text."""

    ids: set[str] = field(default_factory=set)
    links: list[tuple[str, bool]] = field(default_factory=list)
    """Target, and whether the page loads it."""
    faults: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note an element."""
        given = dict(attrs)
        if tag == "script" and "src" not in given:
            self.faults.append("has a script in its text")
        if tag == "style":
            self.faults.append("has a style sheet in its text")
        for name, value in attrs:
            if name == "id" and value:
                self.ids.add(value)
            elif name == "style" or name.startswith("on"):
                self.faults.append(f"<{tag}> has the attribute {name}")
            elif (name in ("href", "src", "action")) and value is not None:
                self.links.append((value, (tag, name) in LOADED))


def check(site: Path) -> list[str]:
    """Return the faults of the site, empty for a good one."""
    pages = {path: _read(path) for path in sorted(site.rglob("*.html"))}
    found = [] if site / "index.html" in pages else ["index.html: is missing"]
    for path, page in pages.items():
        name = path.relative_to(site).as_posix()
        found += [f"{name}: {fault}" for fault in (*page.faults, *_bad_links(site, path, pages))]
    for path in sorted(site.rglob("*.css")):
        loaded = [first or second for first, second in _CSS_URL.findall(path.read_text(encoding="utf-8"))]
        found += [
            f"{path.relative_to(site).as_posix()}: loads {target}, which is not in the site"
            for target in loaded
            if urlsplit(target).scheme or not (path.parent / urlsplit(target).path).is_file()
        ]
    return found


def _read(path: Path) -> Page:
    page = Page()
    page.feed(path.read_text(encoding="utf-8"))
    page.close()
    return page


def _bad_links(site: Path, path: Path, pages: dict[Path, Page]) -> Iterator[str]:
    for link, is_loaded in pages[path].links:
        parts = urlsplit(link)
        if parts.scheme or parts.netloc:
            if is_loaded or parts.scheme not in ("http", "https", "mailto"):
                yield f"loads {link} from elsewhere"
            continue
        target = path if not parts.path else (path.parent / unquote(parts.path)).resolve()
        if not target.is_relative_to(site.resolve()) or not target.is_file():
            yield f"the link {link} leads to no file of the site"
        elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].ids:
            yield f"the link {link} leads to no element of that page"


def main(arguments: list[str] | None = None) -> int:
    """Check; return the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("site", type=Path, metavar="FOLDER", help="the built site")
    faults = check(parser.parse_args(arguments).site.resolve())
    for fault in faults:
        print(f"docs: {fault}", file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
