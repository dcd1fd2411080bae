"""The threat model: each surface has a row, and each row names tests that are there."""

from __future__ import annotations

import ast
import re
from functools import cache

from tests.sweep import sweep
from tests.unit.docs.names import ROOT

TEXT = (ROOT / "docs/threat-model.md").read_text(encoding="utf-8")
SURFACES = {
    "API", "Dask", "doctor", "erase", "exports", "films", "imports of plans", "links", "pictures", "recordings",
    "replay", "restore", "settings", "store of lots", "webhooks",
}  # fmt: skip
"""Parts that others can reach, or files that they bring to a person who opens them."""


def rows() -> list[list[str]]:
    """Return the cells of the table of surfaces."""
    section = TEXT.split("## Lots, pictures, and other programs")[1].split("\n## ")[0]
    lines = [line for line in section.splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines[1:]]


@cache
def functions(path: str) -> set[str]:
    tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)}


def test_every_surface_has_a_row_of_four_cells() -> None:
    assert {row[0] for row in rows()} == SURFACES
    assert {len(row) for row in rows()} == {4}


@sweep("row", rows())
def test_each_row_names_tests_of_its_own(row: list[str]) -> None:
    named = re.findall(r"`(tests/[^`]+)`", row[3])
    assert named, "name a test that fails without what keeps it"


@sweep("name", sorted(set(re.findall(r"`(tests/[^`]+)`", TEXT))))
def test_every_test_that_is_named_is_there(name: str) -> None:
    path, _, function = name.partition("::")
    assert (ROOT / path).is_file()
    assert not function or function in functions(path)
