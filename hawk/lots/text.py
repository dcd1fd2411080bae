"""JSON of large values, made piece by piece: one call for a plan of 20,000 stalls holds the interpreter 50 ms."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Final

_encoded: Final = json.JSONEncoder(allow_nan=False).encode
"""Made once: `json.dumps` makes another encoder for each item of a list."""


def json_text(value: object) -> str:
    """Return a JSON value as text; each item of a list is a piece. Raises ValueError for what is no number."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{json.dumps(str(name))}: {json_text(each)}" for name, each in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_encoded, value)) + "]"
    return _encoded(value)
