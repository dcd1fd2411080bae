"""docs/faults.md names tests that exist."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "faults.md"
NAMED = re.findall(r"`((?:unit|integration|contract|e2e)/[\w/]+\.py)::([\w:]+)", PAGE.read_text())


def test_every_fault_names_its_test() -> None:
    rows = [
        line
        for line in PAGE.read_text().partition("## Shown by tests")[2].partition("\n## ")[0].splitlines()
        if line.startswith("| ")
    ]
    assert len(rows) > 100
    assert all(".py" in row or row.startswith("| fault |") for row in rows)


@pytest.mark.parametrize(("path", "names"), sorted(set(NAMED)))
def test_the_test_exists(path: str, names: str) -> None:
    text = (ROOT / "tests" / path).read_text()
    for name in names.split("::"):
        assert re.search(rf"(def|class) {name}\b", text), f"{path}::{name}"
