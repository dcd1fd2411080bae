"""Labels by their parts: the name of a row and a number, and the order in which people count them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, Protocol, TypeVar

SEPARATOR: Final = " "
_NUMBERED: Final = re.compile(r"(.*?)([ .-]*)([0-9]{1,9})")


@dataclass(frozen=True, slots=True)
class LabelParts:
    """A label with a number behind the name of its row, as "B 12", "P2-014" or "7"."""

    row: str
    separator: str
    digits: str

    @property
    def number(self) -> int:
        """The number."""
        return int(self.digits)

    def with_number(self, number: int) -> str:
        """Return the label with another number, of as many digits where it has zeros in front."""
        width = len(self.digits) if self.digits.startswith("0") else 1
        return f"{self.row}{self.separator}{number:0{width}}"

    def in_row(self, row: str) -> str:
        """Return the label of this number in another row."""
        return f"{row}{self.separator if self.row else SEPARATOR}{self.digits}"


def numbered(label: str) -> LabelParts | None:
    """Return a label by its parts; None for one without a number at its end."""
    found = _NUMBERED.fullmatch(label)
    return None if found is None else LabelParts(*found.groups())


def reading_order(label: str) -> tuple[int, str, int, str]:
    """Return by what labels are in order, as people count: row, Z before AA, then number, then text."""
    parts = numbered(label)
    row, number = (label, 0) if parts is None else (parts.row, parts.number)
    return len(row), row, number, label


class HasLabel(Protocol):
    """Something with a label."""

    @property
    def label(self) -> str:
        """As it is painted, or our guess."""


L = TypeVar("L", bound=HasLabel)


def in_order(labelled: Iterable[L]) -> list[L]:
    """Return stalls in the order of their labels."""
    return sorted(labelled, key=lambda each: reading_order(each.label))
