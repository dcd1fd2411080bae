"""Results that a test compares with the ones that are checked in.

``HAWK_GOLDEN=write`` writes them again: read the difference before it is committed.
"""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any

import pytest

_ID = re.compile(r"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}")


class NamedIds:
    """Names for ids, by the order in which they are shown."""

    def __init__(self) -> None:
        self._named: dict[str, str] = {}

    def plain(self, value: Any) -> Any:
        """Return a value of JSON with names in place of ids, and 8 decimals."""
        if hasattr(value, "model_dump"):
            return self.plain(value.model_dump(mode="json"))
        if isinstance(value, dict):
            return {self.plain(key): self.plain(each) for key, each in value.items()}
        if isinstance(value, list | tuple):
            if all(isinstance(each, dict) and {"outline", "name"} <= each.keys() for each in value):
                value = sorted(value, key=lambda each: str(each["name"]))  # zones are listed by their ids
            return [self.plain(each) for each in value]
        if isinstance(value, str):
            return _ID.sub(lambda found: self._named.setdefault(found[0], f"#{len(self._named) + 1}"), value)
        return round(value, 8) if isinstance(value, float) else value


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
