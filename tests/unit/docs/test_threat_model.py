"""The threat model: each surface has a list, and each line of it names tests that are there."""

from __future__ import annotations

import ast
import re
from functools import cache

from tests.sweep import sweep
from tests.unit.docs.names import ROOT

TEXT = (ROOT / "docs/threat-model.md").read_text(encoding="utf-8")
SURFACES = {
    "API", "Dask", "doctor", "documents of surveys", "erase", "exports", "films", "imports of plans", "inbox", "links",
    "people", "pictures", "recordings", "replay", "restore", "settings", "store of lots", "webhooks",
}  # fmt: skip
"""Parts that others can reach, or files that they bring to a person who opens them."""


def surfaces() -> dict[str, list[str]]:
    """Return the lines of each surface's list, each with what keeps it and its tests."""
    section = TEXT.split("## Lots, pictures, and other programs")[1].split("\n## ")[0]
    _, *parts = re.split(r"^\*\*(.+)\*\*$", section, flags=re.MULTILINE)
    return {name: part.strip().split("\n- ") for name, part in zip(parts[::2], parts[1::2], strict=True)}


@cache
def functions(path: str) -> set[str]:
    tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)}


def test_every_surface_has_its_list() -> None:
    assert surfaces().keys() == SURFACES


@sweep("line", [line for lines in surfaces().values() for line in lines])
def test_each_line_names_tests_of_its_own(line: str) -> None:
    assert re.search(r"`tests/[^`]+`", line), "name a test that fails without what keeps it"


@sweep("name", sorted(set(re.findall(r"`(tests/[^`]+)`", TEXT))))
def test_every_test_that_is_named_is_there(name: str) -> None:
    path, _, function = name.partition("::")
    assert (ROOT / path).is_file()
    assert not function or function in functions(path)
