"""Values as text: JSON of large ones, made piece by piece (one call for a plan of 20,000 stalls holds the interpreter
50 ms), and cells of a table.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Final
from unicodedata import category, normalize

_FORMULA: Final = ("=", "+", "-", "@", "\t", "\r", "\n")
"""A spreadsheet reads a text that begins so as a formula (OWASP, CSV injection)."""
_UNSEEN: Final = ("Cc", "Cf", "Zs")
"""Categories of characters that are not seen: some spreadsheets leave them out."""


_encoded: Final = json.JSONEncoder(allow_nan=False).encode
"""Made once: `json.dumps` makes another encoder for each item of a list."""


def json_text(value: object) -> str:
    """Return a JSON value as text; each item of a list is a piece. Raises ValueError for what is no number."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{json.dumps(str(name))}: {json_text(each)}" for name, each in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_encoded, value)) + "]"
    return _encoded(value)


def table_text(text: str) -> str:
    """Return a text as the cell of a table that no spreadsheet takes for a formula: names are people's own."""
    first = next((each for each in text if category(each) not in _UNSEEN), "")
    plain = normalize("NFKC", first).replace("\N{MINUS SIGN}", "-")  # a full-width sign is a sign to some
    return f"'{text}" if text.startswith(_FORMULA) or plain.startswith(_FORMULA) else text
