"""Labels and kinds of stalls from the properties of features: OpenStreetMap's keys, and those that owners use."""

from __future__ import annotations

from typing import Final

from hawk.lots.plan.kinds import KINDS, MEANT
from hawk.lots.plan.operations import LONGEST_LABEL
from hawk.lots.plan_files.values import Facts, Notes

LABEL_KEYS: Final = ("label", "ref", "number", "nummer", "nr", "no", "numero", "name")
"""Names of the property with the label, the first one that a feature has; "ref" is OpenStreetMap's."""
KIND_KEYS: Final = ("parking_space", "kind")
_DISABLED: Final = "capacity:disabled"
_NONE: Final = ("", "0", "no", "none")


def label_of(facts: Facts, asked: str, name: str, notes: Notes) -> str:
    """Return the label of a feature; "" for none, and for one that cannot be shown, which is noted.

    ``asked``: the only property to look at, if any.
    """
    known = {str(key).lower(): value for key, value in facts.items()}
    for key in (asked.lower(),) if asked else LABEL_KEYS:
        if (text := plain_text(known.get(key))) != "":
            return tidy_label(text, name, notes)
    return ""


def tidy_label(text: str, name: str, notes: Notes) -> str:
    """Return a label with single spaces; "" for one that cannot be shown, which is noted. Nothing of it is HTML."""
    found = " ".join(text.split())
    if len(found) > LONGEST_LABEL:
        shown = found[:LONGEST_LABEL]
        notes.add(name, f"label: {shown}… has {len(found)} characters, {LONGEST_LABEL} are the most: shorten it")
        return ""
    if not found.isprintable():
        notes.add(name, "label: holds characters that cannot be shown: write letters and digits")
        return ""
    return found


def kind_of(facts: Facts, name: str, notes: Notes) -> str | None:
    """Return the kind of a feature, of `KINDS`; None where it says none, or one that is not known, which is noted."""
    for key in KIND_KEYS:
        text = plain_text(facts.get(key)).lower()
        if text == "":
            continue
        if text == "normal":
            return ""
        found = MEANT.get(text, text)
        if found in KINDS:
            return found
        notes.add(name, f"{key}: {text[:40]} is no kind: write one of {', '.join(filter(None, KINDS))}")
        return None
    if plain_text(facts.get(_DISABLED)).lower() not in _NONE:
        return "disabled"
    return None


def plain_text(value: object) -> str:
    """Return a property as text: 12.0 is "12", and "" for what is no word or number."""
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        return ""
    if isinstance(value, float):
        return str(int(value)) if value.is_integer() else str(value) if value == value else ""
    return str(value).strip()
