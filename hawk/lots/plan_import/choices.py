"""The choices of a person about an import, from the text of a query or a command line."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from hawk.lots.plan_files.values import Asked
from hawk.lots.plan_import.match import Choices
from hawk.lots.plan_import.placement import Pin
from hawk.lots.values import LotInputError, check_fields

LONGEST: Final = 200
"""Characters of a choice."""
_TEXTS: Final = ("layer", "units", "label", "crs")
_SWITCHES: Final = ("replace", "rename")
_UNNAMED: Final = "a file"


@dataclass(frozen=True, slots=True)
class ImportAsked:
    """All choices about an import. ``name``: of the file, as it is shown."""

    name: str
    file: Asked
    choices: Choices
    pins: tuple[Pin, ...]


def asked_of(given: Mapping[str, str], pins: Sequence[str]) -> ImportAsked:
    """Return the choices. ``pins``: "x,y,latitude,longitude" each. Raises LotInputError."""
    check_fields(given, ("name", *_TEXTS, "pin", *_SWITCHES))
    for key, value in given.items():
        if len(value) > LONGEST or not value.isprintable():
            raise LotInputError(key, f"is longer than {LONGEST} characters, or holds some that cannot be shown")
    file = Asked(**{name: given.get(name, "") for name in _TEXTS})
    switches = {name: _is_on(name, given.get(name, "")) for name in _SWITCHES}
    name = " ".join(given.get("name", "").replace("\\", "/").rpartition("/")[2].split()) or _UNNAMED
    return ImportAsked(name[:LONGEST], file, Choices(**switches), tuple(_pin(text) for text in pins))


def _is_on(name: str, text: str) -> bool:
    if text not in ("", "0", "1", "true", "false"):
        raise LotInputError(name, "must be 1 or 0")
    return text in ("1", "true")


def _pin(text: str) -> Pin:
    try:
        x, y, latitude, longitude = map(float, text.split(","))
    except ValueError:
        words = "must be x,y,latitude,longitude: a point of the drawing, and its place on Earth"
        raise LotInputError("pin", words) from None
    if not all(map(math.isfinite, (x, y, latitude, longitude))) or abs(latitude) > 90 or abs(longitude) > 180:
        raise LotInputError("pin", "must be finite numbers: latitude -90 to 90, longitude -180 to 180 degrees")
    return Pin(x, y, latitude, longitude)
