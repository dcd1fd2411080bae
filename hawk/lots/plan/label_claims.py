"""Labels of a draft: a person's own ones, those of ours that yield to them, and those that new stalls get.

A label that a person gave or confirmed yields to none: it is refused, with the remedy. One of ours yields alone,
and gets the next number of its row; where its row is taken as a whole, the whole row gets another letter.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import replace

from sqlalchemy import Connection

from hawk.lots.labels import lasting_labels, parts_of
from hawk.lots.plan import queries
from hawk.lots.plan.values import Draft, LayoutStall
from hawk.lots.values import LotInputError
from hawk.model.lot_map import Stall, StallState
from hawk.model.sentences import say


def with_labels_free(connection: Connection, lot: str, draft: Draft) -> Draft:
    """Return a draft in which no other stall has a label that a person gives: ours are taken away, and given again.

    Raises LotInputError for a label that a person gave to another stall, or gives to two.
    """
    given = {stall.label: former for former, stall in draft.given}
    if not given:
        return draft
    if len(given) < len(draft.given):
        twice, _ = Counter(stall.label for _, stall in draft.given).most_common(1)[0]
        raise LotInputError(
            draft.field, say("would give {label} to two stalls: name other stalls, or give one of them", label=twice)
        )
    holding = _keeping(draft, queries.labelled(connection, lot, [*given]))
    if not holding:
        return draft
    _check_ours(draft, holding)
    rows = _rows_taken(connection, lot, draft, holding)
    yielding = {stall.key: stall for stall in (*holding, *(stall for row in rows.values() for stall in row))}
    changed = {old.key: (old, new) for old, new in draft.changed}
    for key, stall in yielding.items():
        old, new = changed.get(key, (stall, stall))
        changed[key] = old, replace(new, label="", is_named=False)
    return replace(draft, changed=tuple(changed.values()))


def _keeping(draft: Draft, stalls: Sequence[LayoutStall]) -> list[LayoutStall]:
    """Return those of some stalls that keep their labels in a draft."""
    leaving = {stall.key for stall in draft.ended} | {old.key for old, new in draft.changed if old.label != new.label}
    return [stall for stall in stalls if stall.key not in leaving]


def _check_ours(draft: Draft, holding: Sequence[LayoutStall]) -> None:
    """Refuse a draft that needs the label of a stall which a person named. Raises LotInputError."""
    named = [stall.label for stall in holding if stall.is_named]
    if named:
        labels = named[0]
        if len(named) > 1:
            labels = say("{label} and {count} more", label=labels, count=len(named) - 1)
        words = say(
            "{labels}: a person confirmed the label of another stall: swap the rows, or rename that one first",
            labels=labels,
        )
        raise LotInputError(draft.field, words)


def _rows_taken(
    connection: Connection, lot: str, draft: Draft, holding: Sequence[LayoutStall]
) -> dict[str, list[LayoutStall]]:
    """Return the rows of ours that give up their name, with all stalls that leave them.

    A row does where it is named, or where others take half of its labels.
    """
    growing = {parts[0] for former, _ in draft.given if (parts := parts_of(former)) is not None}
    wanted = Counter(parts[0] for stall in holding if (parts := parts_of(stall.label)) is not None)
    found: dict[str, list[LayoutStall]] = {}
    for row, count in wanted.items():
        ours = [stall for stall in _keeping(draft, queries.of_row(connection, lot, row)) if not stall.is_named]
        if row in draft.rows or (row not in growing and 2 * count >= len(ours)):
            found[row] = ours
    return found


def labelled(draft: Draft, around: Sequence[LayoutStall], used: Collection[str]) -> Draft:
    """Return a draft whose stalls have labels: the next ones of the rows that they join, else those of new rows.

    Args:
        draft: The draft.
        around: The stalls near its own, with their labels; a row that has none there is not joined.
        used: All labels that the other stalls of the lot have.
    """
    missing = draft.nameless
    every = (*missing, *(new for _, new in draft.changed if new.label), *around)
    every = (*every, *(stall for stall in draft.added if stall.label))
    kept = {number: stall.label for number, stall in enumerate(every) if stall.label}
    labels = lasting_labels({number: _on_map(number, stall) for number, stall in enumerate(every)}, kept, used)
    return draft.naming({stall.id: labels[number] for number, stall in enumerate(missing)})


def _on_map(number: int, stall: LayoutStall) -> Stall:
    seen = {"taken": 0.0, "state": StallState.UNKNOWN, "score": 1.0, "seen": 1, "last_seen": 0.0, "version": 0}
    return Stall(number, *stall.shape, **seen)  # type: ignore[arg-type]
