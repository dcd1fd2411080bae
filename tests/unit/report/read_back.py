"""A report's files as their readers have them, for the tests."""

from __future__ import annotations

import importlib
import io
import re
import warnings
import zipfile
from dataclasses import dataclass, field
from html.parser import HTMLParser
from typing import Any

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
