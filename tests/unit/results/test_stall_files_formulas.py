"""Cells of tables that no spreadsheet takes for a formula."""

from __future__ import annotations

import unicodedata

import pytest

from hawk.results.stall_files import table_text

SIGNS = "=+-@"


def siblings() -> list[str]:
    """Return every character of Unicode that a compatibility form makes a sign that begins a formula."""
    return [chr(code) for code in range(0x110000) if unicodedata.normalize("NFKC", chr(code)).startswith(tuple(SIGNS))]


@pytest.mark.nightly
def test_every_sign_that_begins_a_formula_and_its_siblings_are_guarded() -> None:
    found = siblings()
    assert {"\N{FULLWIDTH EQUALS SIGN}", "\N{SMALL COMMERCIAL AT}", "\N{SUPERSCRIPT PLUS SIGN}", *SIGNS} <= set(found)
    for sign in (*found, "\N{MINUS SIGN}", "\t", "\r", "\n"):
        assert table_text(f"{sign}1+1") == f"'{sign}1+1", hex(ord(sign))


@pytest.mark.parametrize(
    "before", [" ", "  ", "\u3000", "\ufeff", "\u200b", "\u00a0", "\u202e", " \u2060", "\x00", "\x0b"]
)
def test_what_is_not_seen_before_a_sign_does_not_hide_it(before: str) -> None:
    assert table_text(f"{before}=1") == f"'{before}=1"


@pytest.mark.parametrize("text", ["", "Lot 1", "A=1", "Nord\uff1dS\u00fcd", "(=1)", "\u00bd", "\u2460", " x"])
def test_other_texts_stay(text: str) -> None:
    assert table_text(text) == text
