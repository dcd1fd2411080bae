"""docs/architecture.md names each folder of the program in one line."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[3]
TEXT = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
NAMED = re.findall(r"^- `([\w/]+)/`", TEXT, re.MULTILINE)
PAGE = "hawk/web/page"


def test_each_folder_has_one_line() -> None:
    folders = {str(found.parent.relative_to(ROOT)) for found in (ROOT / "hawk").rglob("__init__.py")}
    folders = {folder for folder in folders if not folder.startswith(PAGE)} | {PAGE}
    named = [folder for folder in NAMED if folder.startswith("hawk")]
    assert sorted(named) == sorted(folders)
