"""docs/page.md shows the pictures that a command writes."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import cv2

ROOT = Path(__file__).parents[3]
TEXT = (ROOT / "docs" / "page.md").read_text(encoding="utf-8")
COMMAND = ROOT / "packaging" / "page_pictures.py"


def test_every_view_of_the_command_is_shown_once_and_no_other() -> None:
    command = runpy.run_path(str(COMMAND), run_name="page_pictures")
    shown = re.findall(r"images/view-([\w-]+)\.jpg", TEXT)
    assert sorted(shown) == sorted(view.name for view in (*command["VIEWS"], *command["SHEETS"]))


def test_every_picture_is_there_and_of_its_size() -> None:
    for name in re.findall(r"images/(view-[\w-]+\.jpg)", TEXT):
        picture = cv2.imread(str(ROOT / "docs" / "images" / name))
        assert picture is not None, name
        assert picture.shape[:2] in {(800, 1280), (844, 390), (906, 1250)}, name
