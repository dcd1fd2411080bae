"""The page of the API is that of its definition: every address and every value is on it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from hawk.web.v1.table import OPERATIONS
from hawk.web.v1.unknown import ROOT
from tests.unit.docs.scripts import load

api_page = load("api_page")
PAGE = (Path(__file__).parents[3] / "docs" / "api.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_page_is_what_the_command_writes() -> None:
    assert api_page.page() == PAGE, "run: python packaging/api_page.py"


def test_every_address_is_on_the_page_once() -> None:
    named = re.findall(r"^- `([A-Z]+) (/\S+)`: ", PAGE, re.MULTILINE)
    assert sorted(named) == sorted((each.method, f"{ROOT}{each.path}") for each in OPERATIONS)


def test_every_value_that_is_named_has_one_section() -> None:
    sections = [each.lower() for each in re.findall(r"^#+ (.+)$", PAGE, re.MULTILINE)]
    assert len(sections) == len(set(sections))
    assert set(re.findall(r"\]\(#(\w+)\)", PAGE)) <= set(sections)
