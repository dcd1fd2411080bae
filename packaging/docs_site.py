"""Build the documentation as a site: ``python packaging/docs_site.py``, or ``make docs``.

The pages of ``docs/`` and those at the top of the repository become ``hawk/web/docs_site``, which the daemon serves
under ``/docs/`` and the wheel carries. Nothing is fetched. A warning of Sphinx, a link or an anchor that leads nowhere,
and a page that no menu names are errors. Nothing is done when the sources have not changed since; ``--force`` builds in
any case.
"""

from __future__ import annotations

import argparse
import gzip
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Final

ROOT: Final = Path(__file__).resolve().parent.parent
SITE: Final = Path("hawk/web/docs_site")
STAMP: Final = ".sources"
"""File in the built folder that holds the hash of the sources it was built from."""
TOP_PAGES: Final = ("CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")
"""Pages at the top of the repository that belong to the site."""
INDEX: Final = "index.md"
NOT_SERVED: Final = ("objects.inv", ".buildinfo", "_static/**/*.map")
COMPRESSED: Final = frozenset({".html", ".js", ".css", ".svg", ".txt"})
IMPROVED: Final = {
    'role="heading"': 'role="heading" aria-level="2"',
    '<aside class="sidebar-drawer"': '<aside aria-label="Pages" class="sidebar-drawer"',
    '<aside class="toc-drawer': '<aside aria-label="On this page" class="toc-drawer',
    "<pre>": '<pre tabindex="0">',
    '<div class="table-wrapper': '<div tabindex="0" class="table-wrapper',
}
"""Missing in the theme for screen readers and for the keyboard: names of regions, and focus to scroll by."""
_LINK: Final = re.compile(r"(\]\()([^)\s]+)(\))")
_SHOWN: Final = re.compile(r"^<!-- (\S+\.toml) \[(\w+)\] -->$", re.MULTILINE)
"""A section of a file that a page of the site shows as it is."""
_ENTRY: Final = re.compile(r"^( *)- \[[^\]]*\]\(([^)#\s]+\.md)\)", re.MULTILINE)


class DocsError(RuntimeError):
    """The site could not be built; the text says what to do."""


def build_docs(root: Path = ROOT, *, force: bool = False) -> bool:
    """Build the site of the project in ``root``; return whether there was anything to do. Raises DocsError."""
    site = root / SITE
    wanted = sources_hash(root)
    stamp = site / STAMP
    if not force and stamp.is_file() and stamp.read_text("ascii") == wanted:
        return False
    with tempfile.TemporaryDirectory(prefix="hawk-docs-") as name:
        work = Path(name)
        stage(root, work / "source")
        _sphinx(root, work)
        _prune(work / "site")
        _improve(work / "site")
        _check(root, work / "site")
        _compress(work / "site")
        shutil.rmtree(site, ignore_errors=True)
        shutil.copytree(work / "site", site)
    stamp.write_text(wanted, "ascii")
    return True


def sources_hash(root: Path) -> str:
    """Return the hash of everything that the site depends on."""
    digest = hashlib.sha256()
    for path in sorted(_inputs(root), key=lambda path: path.relative_to(root).as_posix()):
        content = hashlib.sha256(path.read_bytes()).hexdigest()
        digest.update(f"{path.relative_to(root).as_posix()}\0{content}\n".encode())
    return digest.hexdigest()


def stage(root: Path, target: Path) -> None:
    """Copy the pages and pictures to ``target``, with links and menus as the site needs them."""
    places = {path: _place(root, path) for path in _pages(root)}
    repository = _repository(root)
    menus = menu((root / "docs" / INDEX).read_text(encoding="utf-8"))
    for path, place in places.items():
        to = target / place
        to.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix != ".md":
            shutil.copyfile(path, to)
            continue
        text = _with_links(path.read_text(encoding="utf-8"), path, root, places, repository)
        text = _SHOWN.sub(partial(_fenced, path.parent), text)
        to.write_text(text + menus.get(place.as_posix(), ""), encoding="utf-8")


def _fenced(folder: Path, match: re.Match[str]) -> str:
    """Return the section of a file that a page of a folder shows, as a block of code."""
    text = (folder / match[1]).read_text(encoding="utf-8")
    begin, end = rf"^(?:# [^\n]*\n)*(?:# )?\[+{match[2]}\]+$", r"(?=\n\n(?:# [^\n]*\n)*(?:# )?\[|\Z)"
    section = re.search(rf"{begin}.*?{end}", text, re.MULTILINE | re.DOTALL)
    if section is None:
        raise DocsError(f"{match[1]} has no section {match[2]}: correct the page that shows it")
    return f"```toml\n{section[0].rstrip()}\n```"


def menu(index: str) -> dict[str, str]:
    """Return the menus (Sphinx's toctree) to add to each page, by its place in the site.

    The headings of ``docs/index.md`` are the menu's, its list items the entries; an indented item belongs to the page
    of the item above it.
    """
    captions: list[str] = []
    children: dict[str, list[str]] = {}
    for section in re.split(r"^## ", index, flags=re.MULTILINE)[1:]:
        heading, _, body = section.partition("\n")
        entries: list[str] = []
        for indent, page in _ENTRY.findall(body):
            page = _inside(page)
            if indent and entries:
                children.setdefault(entries[-1], []).append(page)
            else:
                entries.append(page)
        if entries:
            captions.append(_toctree(entries, heading.strip()))
    return {INDEX: "".join(captions)} | {page: _toctree(below) for page, below in children.items()}


def _toctree(pages: list[str], caption: str | None = None) -> str:
    lines = ["", "```{toctree}", ":hidden:", *([f":caption: {caption}"] if caption else []), ""]
    return "\n".join([*lines, *(f"/{page.removesuffix('.md')}" for page in pages), "```", ""])


def _inside(link: str) -> str:
    """Return the place in the site of a page that ``docs/index.md`` names."""
    return PurePosixPath(link).name if link.startswith("../") else link


def _with_links(text: str, page: Path, root: Path, places: dict[Path, Path], repository: str) -> str:
    """Return the text with links that lead to the same things in the site; what is not in it is in the repository.

    A diagram stays the text that it is: the program that draws it is larger than the whole site.
    """

    def target(link: str) -> str:
        name, mark, anchor = link.partition("#")
        if not name or re.match(r"[a-z]+:", name):
            return link
        found = (page.parent / name).resolve()
        here = places[page].parent
        if found in places:
            return os.path.relpath(places[found], here).replace(os.sep, "/") + mark + anchor
        if found.is_dir() and found.is_relative_to(root / "docs"):
            return os.path.relpath(INDEX, here).replace(os.sep, "/")
        if not found.is_relative_to(root) or not found.exists():
            raise DocsError(f"{page.relative_to(root)}: the link {link} leads nowhere: correct it")
        return f"{repository}/blob/main/{found.relative_to(root).as_posix()}{mark}{anchor}"

    return _LINK.sub(lambda match: match[1] + target(match[2]) + match[3], text).replace("```mermaid", "```text")


def _repository(root: Path) -> str:
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return str(project["urls"]["Homepage"])


def _pages(root: Path) -> Iterator[Path]:
    yield from (root / name for name in TOP_PAGES)
    yield from sorted(path for path in (root / "docs").rglob("*") if path.suffix in {".md", ".png", ".jpg", ".svg"})


def _place(root: Path, path: Path) -> Path:
    return path.relative_to(root / "docs") if path.is_relative_to(root / "docs") else path.relative_to(root)


def _inputs(root: Path) -> Iterator[Path]:
    yield from _pages(root)
    yield from (path for path in (root / "packaging" / "docs").rglob("*") if path.is_file() and path.suffix != ".pyc")
    yield from (root / "packaging" / name for name in ("docs_site.py", "docs_check.py"))
    yield root / "pyproject.toml"  # the version
    yield from sorted(root.glob("config.toml"))  # the page of settings shows it


def _sphinx(root: Path, work: Path) -> None:
    command = [
        *(sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-E", "-b", "html"),
        *("-c", str(root / "packaging" / "docs"), "-d", str(work / "doctrees")),
        *(str(work / "source"), str(work / "site")),
    ]
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}
    if subprocess.run(command, cwd=root, env=environment, check=False).returncode:
        raise DocsError("Sphinx found the faults above; it and its theme come with: pip install '.[docs]'")


def _check(root: Path, site: Path) -> None:
    command = [sys.executable, str(root / "packaging" / "docs_check.py"), str(site)]
    if subprocess.run(command, cwd=root, check=False).returncode:
        raise DocsError("the site has the faults above")


def _prune(site: Path) -> None:
    """Remove what no reader needs."""
    for pattern in NOT_SERVED:
        for path in site.glob(pattern):
            path.unlink()


def _improve(site: Path) -> None:
    """Add what the theme lacks. Raises DocsError when the theme has changed and nothing is found to add it to."""
    missing = dict(IMPROVED)
    for path in sorted(site.rglob("*.html")):
        text = path.read_text(encoding="utf-8")
        for old, new in IMPROVED.items():
            if old in text:
                missing.pop(old, None)
                text = text.replace(old, new)
        path.write_text(text, encoding="utf-8")
    if missing:
        raise DocsError(f"no page has {', '.join(missing)}: the theme has changed, look at IMPROVED")


def _compress(site: Path) -> None:
    """Write each text beside itself as gzip, so that the daemon need not do it in flight."""
    for path in [path for path in site.rglob("*") if path.suffix in COMPRESSED]:
        path.with_name(f"{path.name}.gz").write_bytes(gzip.compress(path.read_bytes(), 9, mtime=0))


def main(arguments: list[str] | None = None) -> int:
    """Build; return the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--force", action="store_true", help="build even when nothing changed")
    options = parser.parse_args(arguments)
    try:
        if not build_docs(force=options.force):
            print("docs: up to date")
            return 0
    except DocsError as error:
        print(f"docs: {error}", file=sys.stderr)
        return 1
    files = [path for path in (ROOT / SITE).rglob("*") if path.is_file()]
    plain = [path for path in files if path.suffix != ".gz"]
    pages, size = sum(path.suffix == ".html" for path in plain), sum(path.stat().st_size for path in plain)
    print(f"docs: {pages} pages, {size / 1e6:.1f} MB ({sum(p.stat().st_size for p in files) / 1e6:.1f} MB with gzip)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
