"""States of surveys and lots: with each change one gets the next number of the store, by which the newest state counts.

A state is a row of the outbox whose body is the id, so that its deliveries are noted as those of other messages are.
A survey that came from another store as a document has its state there. By the states of lots a store that
sends its surveys here learns which lots have changed.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Mapping
from typing import Final

SURVEY_STATE: Final = "survey_state"
LOT_STATE: Final = "lot_state"
KINDS: Final = (SURVEY_STATE, LOT_STATE)
"""Kinds of rows of the outbox that are states."""
_OWN: Final[Mapping[str, tuple[str, str]]] = {
    "survey": (
        SURVEY_STATE,
        "SELECT id FROM main.survey WHERE seq = ?1 AND NOT EXISTS (SELECT 1 FROM main.document WHERE survey = ?1)",
    ),
    "lot": (
        LOT_STATE,
        "SELECT id FROM main.lot WHERE id = ?1",
    ),
}
"""Kind of a part of the store -> kind of its state, and the statement that finds its id by its key."""


def renumber(store: sqlite3.Connection, changed: Iterable[tuple[str, str]]) -> None:
    """Give the parts that a transaction has changed, pairs of kind and key, their next states.

    Others than surveys of this store and lots have none, and a file of an earlier version has no states.
    """
    if not store.execute("SELECT 1 FROM main.sqlite_master WHERE name = 'document'").fetchone():
        return
    for part, key in sorted(changed, key=lambda each: (each[0], len(each[1]), each[1])):
        if part not in _OWN:
            continue
        kind, asked = _OWN[part]
        for (named,) in store.execute(asked, (key,)).fetchall():
            store.execute("DELETE FROM outbox WHERE kind = ? AND body = ?", (kind, named))
            store.execute(
                "INSERT INTO outbox (kind, body, made) VALUES (?, ?, CAST(strftime('%s', 'now') AS REAL))",
                (kind, named),
            )


def last(store: sqlite3.Connection) -> int:
    """Return the greatest number that a row of the outbox ever had, 0 without one."""
    found = store.execute("SELECT seq FROM main.sqlite_sequence WHERE name = 'outbox'").fetchone()
    return 0 if found is None else int(found[0])


def renumber_all(store: sqlite3.Connection, beyond: int) -> None:
    """Give every survey and lot of this store a new state, whose number is greater than ``beyond``."""
    if last(store) < beyond:
        store.execute("DELETE FROM sqlite_sequence WHERE name = 'outbox'")
        store.execute("INSERT INTO sqlite_sequence (name, seq) VALUES ('outbox', ?)", (beyond,))
    surveys = [("survey", str(seq)) for (seq,) in store.execute("SELECT seq FROM main.survey").fetchall()]
    lots = [("lot", str(named)) for (named,) in store.execute("SELECT id FROM main.lot").fetchall()]
    renumber(store, [*surveys, *lots])
