"""Drawn lots with a plan, and a person who edits it, for the tests."""

from __future__ import annotations

import uuid
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, insert

from hawk.lots import commands, queries
from hawk.lots.plan import edits
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import LAYOUT, LOT, STALL
from hawk.results.row_labels import letters

A_ROW, APART_M, PITCH_M, DEEP_M = 10, 9.0, 2.5, 5.0
NOW = 1_770_100_000.0
FAST = {"synchronous": 0}
Json = dict[str, Any]


def drawn_lot(connection: Connection, stalls: int, a_row: int = A_ROW) -> str:
    """Store a lot of rows that run from west to east, the first stall at the datum, and return its id."""
    lot, names, rows, letter = str(uuid.uuid4()), letters(), [], ""
    place = {"outline": '{"polygons":[],"holes":[]}', "latitude": 52.0, "longitude": 5.0, "datum_is_pinned": True}
    connection.execute(insert(LOT).values(id=lot, name="Lot 1", **place, made=0.0))
    connection.execute(insert(LAYOUT).values(lot=lot, version=1, valid_from=0.0, why="drawn", who="hawk"))
    for number in range(stalls):
        row, along = divmod(number, a_row)
        letter = letter if along else next(names)
        shape = {"north": -row * APART_M, "east": along * PITCH_M, "angle": 0.0, "width": PITCH_M, "length": DEEP_M}
        ids = {"id": str(uuid.uuid4()), "lot": lot, "label": f"{letter} {along + 1}", "begins": 1, "ends": None}
        rows.append({**ids, **shape, "kind": "", "is_confirmed": False, "first_survey": None, "first_id": None})
    if rows:
        connection.execute(insert(STALL), rows)
    return lot


@dataclass
class Person:
    """A person who edits the plan of a lot, with the requests that the API takes."""

    store: Database
    lot: str
    edit: str = ""
    now: float = NOW

    @classmethod
    def at_work(cls, path: Path, stalls: int = 30) -> Person:
        store = Database(path, FAST)
        with store.writing() as connection:
            person = cls(store, drawn_lot(connection, stalls))
        person.open()
        return person

    def ask(self, act: Any, asked: Mapping[str, Any]) -> Json:
        with self.store.writing() as connection:
            answer: Json = act(connection, self.lot, asked, self.now).model_dump(mode="json")
        return answer

    def open(self, who: str = "Ann", **asked: object) -> Json:
        found = self.ask(edits.open_edit, {"who": who, **asked})
        self.edit = found["edit"]
        return found

    def do(self, do: str, **operation: object) -> Json:
        return self.operate({"do": do, **operation})

    def operate(self, operation: object) -> Json:
        return self.ask(edits.do, {"edit": self.edit, "operation": operation})

    def undo(self) -> Json:
        return self.ask(edits.undo, {"edit": self.edit})

    def redo(self) -> Json:
        return self.ask(edits.redo, {"edit": self.edit})

    def close(self, **asked: object) -> Json:
        return self.ask(edits.close, {"edit": self.edit, **asked})

    def undo_change(self, seq: int) -> str:
        with self.store.writing() as connection:
            return commands.undo(connection, seq, self.now)

    def plan(self, since: int | None = None, layout: int | None = None) -> Json:
        with self.store.reading() as connection:
            found: Json = queries.plan(connection, self.lot, since, layout).model_dump(mode="json")
        return found

    def stalls(self, layout: int | None = None) -> dict[str, Json]:
        """Return the stalls of the plan by label."""
        return {each["label"]: each for each in self.plan(layout=layout)["stalls"]}

    def ids(self, *labels: str) -> list[str]:
        found = self.stalls()
        return [found[label]["id"] for label in labels]

    def shown(self) -> Json:
        """Return the plan without what rises with every change."""
        found = self.plan()
        return {name: found[name] for name in ("stalls", "zones", "sections")}
