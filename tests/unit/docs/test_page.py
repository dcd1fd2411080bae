"""docs/page.md shows the pictures that a command writes."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import cv2

ROOT = Path(__file__).parents[3]
TEXT = (ROOT / "docs" / "page.md").read_text(encoding="utf-8")
COMMAND = ROOT / "packaging" / "page_pictures.py"


def test_every_view_of_the_command_is_shown_once_and_no_other() -> None:
    spec = importlib.util.spec_from_file_location("page_pictures", COMMAND)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    shown = re.findall(r"images/view-([\w-]+)\.jpg", TEXT)
    assert sorted(shown) == sorted(view.name for view in module.VIEWS)


def test_every_picture_is_there_and_of_its_size() -> None:
    for name in re.findall(r"images/(view-[\w-]+\.jpg)", TEXT):
        picture = cv2.imread(str(ROOT / "docs" / "images" / name))
        assert picture is not None, name
        assert picture.shape[:2] in {(800, 1280), (844, 390)}
