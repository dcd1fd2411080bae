"""A report's files as their readers have them, for the tests."""

from __future__ import annotations

import importlib
import io
import re
import warnings
import zipfile
from collections import Counter
from dataclasses import dataclass, field
from html.parser import HTMLParser
from typing import Any

import pikepdf
import pytest
from defusedxml import ElementTree

_MAIN = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"
Value = str | float | None


def pdf_writer() -> Any:
    """Return WeasyPrint; skip the test where it, or Pango, is not installed."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # a system's library that a later WeasyPrint needs
            return importlib.import_module("weasyprint")
    except (ImportError, OSError) as error:
        pytest.skip(f"no PDF is written here: {error}", allow_module_level=True)


@dataclass
class Page(HTMLParser):
    """A document: its words, its tables (rows of cells) by the heading before each, and its tags with attributes."""

    words: str = ""
    tables: dict[str, list[list[str]]] = field(default_factory=dict)
    tags: list[tuple[str, dict[str, str | None]]] = field(default_factory=list)
    _heading: str = ""
    _open: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()

    @classmethod
    def of(cls, html: str) -> Page:
        page = cls()
        page.feed(html)
        page.words = re.sub(r"[ \n]+", " ", page.words)
        return page

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        self._open.append(tag)
        if tag == "h2":
            self._heading = ""
        elif tag == "tr":
            self.tables.setdefault(self._heading, []).append([])
        elif tag in ("td", "th"):
            self.tables[self._heading][-1].append("")

    def handle_endtag(self, tag: str) -> None:
        while self._open and self._open.pop() != tag:
            pass

    def handle_data(self, data: str) -> None:
        if "style" in self._open:
            return
        self.words += data
        if "h2" in self._open:
            self._heading += data
        if {"td", "th"} & {*self._open}:
            self.tables[self._heading][-1][-1] += data.strip()

    def attributes(self, tag: str) -> list[dict[str, str | None]]:
        return [attrs for each, attrs in self.tags if each == tag]


@dataclass
class Book:
    """A workbook: the rows of each sheet, the parts of the file, and the cells that hold a formula."""

    sheets: dict[str, list[list[Value]]]
    parts: dict[str, str]
    formulas: list[str]

    @classmethod
    def of(cls, data: bytes) -> Book:
        with zipfile.ZipFile(io.BytesIO(data)) as file:
            parts = {name: file.read(name).decode() for name in file.namelist()}
        root = ElementTree.fromstring(parts["xl/workbook.xml"])
        names = [str(each.get("name")) for each in root.iter(f"{_MAIN}sheet")]
        shared = _shared(parts.get("xl/sharedStrings.xml", ""))
        sheets, formulas = {}, []
        for number, name in enumerate(names, 1):
            tree = ElementTree.fromstring(parts[f"xl/worksheets/sheet{number}.xml"])
            formulas += [str(each.text) for each in tree.iter(f"{_MAIN}f")]
            sheets[name] = [_row(row, shared) for row in tree.iter(f"{_MAIN}row")]
        return cls(sheets, parts, formulas)


@dataclass
class Print:
    """A PDF: its pages, its bookmarks and the links of its first page with the pages that they lead to, from 0.

    ``ids`` of heads of tables, ``heads`` that cells refer to, and ``kinds`` of elements, of its structure.
    """

    file: pikepdf.Pdf
    pages: dict[tuple[int, int], int]
    bookmarks: list[tuple[str, int]] = field(default_factory=list)
    links: list[int] = field(default_factory=list)
    ids: list[str] = field(default_factory=list)
    heads: set[str] = field(default_factory=set)
    kinds: Counter[str] = field(default_factory=Counter)

    @classmethod
    def of(cls, data: bytes) -> Print:
        file = pikepdf.open(io.BytesIO(data))
        found = cls(file, {page.obj.objgen: number for number, page in enumerate(file.pages)})
        with file.open_outline() as outline:
            found.bookmarks = [(each.title, found.page(each.destination[0])) for each in outline.root]  # type: ignore[index]
        names = pikepdf.NameTree(file.Root.Names.Dests)
        links: Any = file.pages[0].obj.get("/Annots", [])
        found.links = [found.page(names[str(link.Dest)][0]) for link in links]
        found._walk(file.Root.StructTreeRoot.K[0], file.Root.StructTreeRoot)
        return found

    def page(self, given: Any) -> int:
        return self.pages[given.objgen]

    def check_structure(self) -> None:
        """Each page and each link has a key of its own, under which the structure has what is on it."""
        nums = self.file.Root.StructTreeRoot.ParentTree.Nums
        keys = [int(key) for key in list(nums)[::2]]
        assert keys == list(range(len(keys)))
        used = []
        for number, page in enumerate(self.file.pages):
            used.append(int(page.obj.StructParents))
            marked = nums[2 * used[-1] + 1]
            assert len(marked)
            assert {self.page(each.Pg) for each in marked} == {number}
            for link in page.obj.get("/Annots", []):
                used.append(int(link.StructParent))
                kids: list[Any] = list(nums[2 * used[-1] + 1].K)
                assert link.objgen in [each.Obj.objgen for each in kids if isinstance(each, pikepdf.Dictionary)]
        assert sorted(used) == keys

    def _walk(self, element: Any, parent: Any) -> None:
        assert element.P.objgen == parent.objgen
        self.kinds[str(element.S)] += 1
        self.ids += [str(element.ID)] if "/ID" in element else []
        self.heads.update(str(each) for each in element.get("/A", {}).get("/Headers", []))
        if "/Pg" in element:
            self.page(element.Pg)
        for kid in element.K:
            if isinstance(kid, pikepdf.Dictionary) and kid.Type == "/StructElem":
                self._walk(kid, element)


def _shared(text: str) -> list[str]:
    if not text:
        return []
    root = ElementTree.fromstring(text)
    return ["".join(part.text or "" for part in each.iter(f"{_MAIN}t")) for each in root.iter(f"{_MAIN}si")]


def _row(row: ElementTree.Element, shared: list[str]) -> list[Value]:
    found: list[Value] = []
    for cell in row.iter(f"{_MAIN}c"):
        column = _number(re.sub(r"\d", "", str(cell.get("r"))))
        found += [None] * (column - len(found))
        value, kind = cell.find(f"{_MAIN}v"), cell.get("t")
        if kind == "inlineStr":
            found.append("".join(part.text or "" for part in cell.iter(f"{_MAIN}t")))
        elif value is not None and value.text is not None:
            found.append(shared[int(value.text)] if kind == "s" else float(value.text))
    return found


def _number(letters: str) -> int:
    number = 0
    for letter in letters:
        number = number * 26 + ord(letter) - 64
    return number - 1
