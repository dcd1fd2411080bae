"""Results that a test compares with the ones that are checked in.

``HAWK_GOLDEN=write`` writes them again: read the difference before it is committed.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest


def check_text(path: Path, found: str) -> None:
    """Compare a text with that of a file."""
    if os.environ.get("HAWK_GOLDEN") == "write":
        path.write_bytes(found.encode())
    assert found == path.read_bytes().decode()


def check_values(path: Path, found: Any, digits: int | None = 4) -> None:
    """Compare a JSON value with that of a file: another computer may round a number up that this one rounds down.

    ``digits``: decimals that its numbers have at most; None: all.
    """
    if os.environ.get("HAWK_GOLDEN") == "write":
        path.write_text(_lines(found) + "\n", "utf-8")
    assert _near(found, digits) == json.loads(path.read_text("utf-8"))


def _lines(value: Any, indent: int = 0) -> str:
    """Return a value as JSON that breaks only lines that are too long."""
    line = json.dumps(value)
    if len(line) + indent <= 400 or not isinstance(value, dict | list):
        return line
    pad = " " * (indent + 1)
    if isinstance(value, dict):
        parts = [f"{json.dumps(key)}: {_lines(each, indent + 1)}" for key, each in value.items()]
    else:
        parts = [_lines(each, indent + 1) for each in value]
    begin, end = "{}" if isinstance(value, dict) else "[]"
    return f"{begin}\n{pad}" + f",\n{pad}".join(parts) + f"\n{' ' * indent}{end}"


def _near(value: Any, digits: int | None) -> Any:
    if isinstance(value, dict):
        return {key: _near(each, digits) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_near(each, digits) for each in value]
    if isinstance(value, float):
        assert digits is None or value == round(value, digits)
        return pytest.approx(value, abs=1e-9 if digits is None else 1.1 * 10**-digits, rel=0)
    return value
