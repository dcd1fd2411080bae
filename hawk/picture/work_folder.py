"""The folder of a survey by pictures: whether what it holds is hawk's, so that a run may go on in it."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Final

WORK: Final = "work"
"""Name of the folder of the results of each step, in the folder of a survey by photographs or a film."""
WINDOWS: Final = "windows"
FAILURES: Final = "failures"
"""Names of the folders of results, and of failures, in the folder of a survey by an orthophoto."""
REPORT: Final = "report.json"
_FOLDERS: Final = {WORK, WINDOWS, FAILURES, "store"}
_KEPT: Final = re.compile(r"\.?[a-z]+-[0-9a-f]{40}(\.part)?")


def is_ours(folder: Path) -> bool:
    """Return whether a run may go on in a folder: it is not there, is empty, or holds work or a report of hawk."""
    if not folder.is_dir():
        return not folder.exists()
    names = {entry.name for entry in folder.iterdir() if not entry.name.startswith(".")}
    if names <= _FOLDERS or {WINDOWS, FAILURES} <= names:
        return True
    return _is_report(folder / REPORT) or _holds_steps(folder / WORK)


def _is_report(path: Path) -> bool:
    try:
        return str(json.loads(path.read_bytes())["program"]).startswith("hawk-drone ")
    except (OSError, ValueError, KeyError, TypeError):
        return False


def _holds_steps(folder: Path) -> bool:
    return folder.is_dir() and any(_KEPT.fullmatch(entry.name) for entry in folder.iterdir())
