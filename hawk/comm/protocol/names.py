"""Names that people give themselves: shown to the others and written into the log, never proof of who somebody is."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from typing import Annotated, Final

from pydantic import AfterValidator, Field

LONGEST_PERSON: Final = 24
"""Characters of a name: it stands in a line of the log and in a button's row."""
_LONGEST_SENT: Final = 100
_NUMBERED: Final = re.compile(r"(operator|viewer)\d*")
_TAKEN: Final = frozenset(
    {"you", "nobody", "someoneelse", "theoperator", "anoperator", "pilot", "thepilot", "autopilot", "theautopilot"}
    | {"drone", "thedrone", "theprogram", "hawk"}
)
"""Words of the log's own sentences, as `_key` spells them: "Stopped by you." would be said to everybody."""


def cleaned(name: str) -> str:
    """Return a name as it is shown: composed characters, single spaces.

    Raises:
        ValueError: The name cannot be shown, or would be read as something else; the text gives the remedy.
    """
    if not name.isprintable():
        raise ValueError("has characters that cannot be shown: leave out line breaks and control characters")
    name = " ".join(unicodedata.normalize("NFC", name).split())
    if len(name) > LONGEST_PERSON:
        raise ValueError(f"must have at most {LONGEST_PERSON} characters, not {len(name)}")
    marks = sum(unicodedata.category(each).startswith("M") for each in name)
    if not any(each.isalnum() for each in name) or marks > len(name) - marks:
        raise ValueError("must have a letter or a digit, and no more accents than letters")
    if _NUMBERED.fullmatch(_key(name)) or _key(name) in _TAKEN:
        raise ValueError(f"{name} is a word of the log itself: send another name")
    return name


def distinct(name: str, others: Iterable[str]) -> str:
    """Return the name, with a number behind it when one of the others looks the same."""
    taken = {_key(other) for other in others}
    shown, count = name, 1
    while _key(shown) in taken:
        count += 1
        shown = f"{name} {count}"
    return shown


def _key(name: str) -> str:
    """Return what two names have in common that look alike: letters and digits, without case and width."""
    folded = unicodedata.normalize("NFKC", name).casefold()
    return "".join(each for each in folded if each.isalnum())


PersonName = Annotated[str, Field(max_length=_LONGEST_SENT), AfterValidator(cleaned)]
