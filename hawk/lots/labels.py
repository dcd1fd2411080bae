"""Labels are words on the ground: a stall's id lasts, its label is what is painted, or our guess of it.

A label is one stall's among those of the present layout, and free where none has it. A new stall of a known row gets
the number that its neighbours leave, else the next one of that row; a new row gets the first letter that no row has.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import groupby

from hawk.model.lot_map import Stall
from hawk.results.label_parts import SEPARATOR
from hawk.results.row_labels import letters, row_labels


def lasting_labels(stalls: Mapping[int, Stall], kept: Mapping[int, str], used: Collection[str]) -> dict[int, str]:
    """Return the labels of all stalls by id: those kept, and new ones for the others.

    Args:
        stalls: The stalls of the lot as they are now, by id; suggested ones get none.
        kept: Labels of stalls that have one, by id.
        used: Labels that no stall may get besides these.
    """
    taken = {*used, *kept.values()}
    highest = _highest(taken)
    unused = (letter for letter in letters() if letter not in highest)
    labels = {key: label for key, label in kept.items() if key in stalls}
    for members in _rows(stalls).values():
        if all(key in labels for key in members):
            continue
        parts = [parts_of(labels.get(key, "")) for key in members]
        known = Counter(each[0] for each in parts if each is not None)
        letter = known.most_common(1)[0][0] if known else next(unused)
        numbers = [each[1] if each is not None and each[0] == letter else None for each in parts]
        for key, number in zip(members, _filled(numbers, letter, taken, highest.get(letter, 0)), strict=True):
            labels.setdefault(key, f"{letter}{SEPARATOR}{number}")
        highest |= _highest([*(labels[key] for key in members), f"{letter}{SEPARATOR}{highest.get(letter, 0)}"])
    return labels


def _filled(numbers: Sequence[int | None], letter: str, taken: set[str], highest: int) -> Iterator[int]:
    """Yield the numbers of a row in its order, with those that neighbours leave, else the next ones, for None.

    ``taken`` gets the labels of these.
    """
    place = 0
    for is_missing, run in groupby(numbers, key=lambda number: number is None):
        members = list(run)
        if not is_missing:
            yield from (number or 0 for number in members)
        else:
            left = [number for number in numbers[:place] if number is not None][-2:]
            right = [number for number in numbers[place + len(members) :] if number is not None][:2]
            found = _between(left, right, len(members))
            if any(number < 1 or f"{letter}{SEPARATOR}{number}" in taken for number in found) or not found:
                found = list(range(highest + 1, highest + 1 + len(members)))
            highest = max(highest, *found)
            taken.update(f"{letter}{SEPARATOR}{number}" for number in found)
            yield from found
        place += len(members)


def _between(left: Sequence[int], right: Sequence[int], count: int) -> list[int]:
    """Return the numbers that go on from known neighbours, up to two on each side; none where there is no room."""
    if left and right:
        step = 1 if right[0] > left[-1] else -1
        return [left[-1] + step * n for n in range(1, count + 1)] if abs(right[0] - left[-1]) > count else []
    if left:
        step = -1 if len(left) > 1 and left[0] > left[1] else 1
        return [left[-1] + step * n for n in range(1, count + 1)]
    if right:
        step = -1 if len(right) > 1 and right[0] > right[1] else 1
        return [right[0] - step * n for n in range(count, 0, -1)]
    return []


def _rows(stalls: Mapping[int, Stall]) -> Mapping[str, list[int]]:
    """Return the ids of the stalls of each row in order, by the row's letter in this map alone."""
    rows: dict[str, list[tuple[int, int]]] = defaultdict(list)
    for key, label in row_labels(stalls).items():
        if (parts := parts_of(label)) is not None:
            rows[parts[0]].append((parts[1], key))
    return {letter: [key for _, key in sorted(members)] for letter, members in rows.items()}


def _highest(labels: Collection[str]) -> dict[str, int]:
    """Return the highest number in each row."""
    highest: dict[str, int] = {}
    for label in labels:
        if (parts := parts_of(label)) is not None:
            highest[parts[0]] = max(parts[1], highest.get(parts[0], 0))
    return highest


def parts_of(label: str) -> tuple[str, int] | None:
    """Return the row's name and the number of a label such as "B 12"; None for another form."""
    row, _, number = label.rpartition(SEPARATOR)
    return (row, int(number)) if row and number.isascii() and number.isdecimal() else None
