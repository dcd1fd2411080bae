"""Labels that last: a stall that has one keeps it; a new stall gets one that its lot never gave.

A new stall in a known row gets the next number of that row, in the order of the row. A new row gets the next letter.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Collection, Mapping
from typing import Final

from hawk.model.lot_map import Stall
from hawk.results.row_labels import letters, row_labels

_SEPARATOR: Final = " "


def lasting_labels(stalls: Mapping[int, Stall], kept: Mapping[int, str], used: Collection[str]) -> dict[int, str]:
    """Return the labels of all stalls by id: those kept, and new ones for the others.

    Args:
        stalls: The stalls of the lot as they are now, by id; suggested ones get none.
        kept: Labels of stalls that have one, by id.
        used: Every label that the lot ever gave.
    """
    taken = {*used, *kept.values()}
    highest = _highest(taken)
    unused = (letter for letter in letters() if letter not in highest)
    labels = {key: label for key, label in kept.items() if key in stalls}
    for members in _rows(stalls).values():
        missing = [key for key in members if key not in labels]
        if not missing:
            continue
        known = Counter(parts[0] for key in members if key in labels and (parts := parts_of(labels[key])) is not None)
        letter = known.most_common(1)[0][0] if known else next(unused)
        for number, key in enumerate(missing, highest.get(letter, 0) + 1):
            labels[key] = f"{letter}{_SEPARATOR}{number}"
        highest[letter] = highest.get(letter, 0) + len(missing)
    return labels


def _rows(stalls: Mapping[int, Stall]) -> Mapping[str, list[int]]:
    """Return the ids of the stalls of each row in order, by the row's letter in this map alone."""
    rows: dict[str, list[tuple[int, int]]] = defaultdict(list)
    for key, label in row_labels(stalls).items():
        if (parts := parts_of(label)) is not None:
            rows[parts[0]].append((parts[1], key))
    return {letter: [key for _, key in sorted(members)] for letter, members in rows.items()}


def _highest(labels: Collection[str]) -> dict[str, int]:
    """Return the highest number that was ever given in each row."""
    highest: dict[str, int] = {}
    for label in labels:
        if (parts := parts_of(label)) is not None:
            highest[parts[0]] = max(parts[1], highest.get(parts[0], 0))
    return highest


def parts_of(label: str) -> tuple[str, int] | None:
    """Return the row's letters and the number of a label of ours; None for an owner's own one."""
    letter, _, number = label.partition(_SEPARATOR)
    if letter.isascii() and letter.isalpha() and letter.isupper() and number.isascii() and number.isdecimal():
        return letter, int(number)
    return None
