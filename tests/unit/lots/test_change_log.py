"""The log of changes: a change keeps the columns that it set, and its undo brings each back as it was."""

from __future__ import annotations

import json
import sqlite3
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import select

from hawk.lots import commands
from hawk.lots.change_log import Group, net, packed, unpacked
from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import CHANGE, SURVEY
from hawk.lots.values import LotStoreError, Registration
from tests.unit.lots import whole
from tests.unit.lots.surveys import BEGAN, DATUM, box, later, survey

FAST = {"synchronous": 0}
SURVEYS, STALLS = 100, 500
LASTING = ("label", "change", "plan", "digest", "outbox", "looks")
"""Tables that say more after a change that was undone: labels stay given, numbers rise."""


def rows(path: Path) -> dict[str, list[str]]:
    """Return every row of a store with the type of each value."""
    with closing(sqlite3.connect(path)) as opened:
        tables = [name for (name,) in opened.execute("SELECT name FROM sqlite_master WHERE type = 'table'")]
        found = {name: sorted(map(repr, opened.execute(f"SELECT * FROM {name}"))) for name in tables}  # noqa: S608
    return {name: found[name] for name in tables if name not in LASTING and not name.startswith("sqlite_")}


def two_lots(store: Database, stalls: int = 40) -> tuple[str, str]:
    """Return two lots side by side, 700 m apart."""
    east = replace(survey(stalls=stalls), datum=replace(DATUM, longitude=5.01))
    with store.writing() as connection:
        kept = save(connection, survey()).lot
        other = save(connection, replace(later(east, 2), outline=box(0, 0, 20, 54, east.datum))).lot
    return str(kept), str(other)


def repeat(store: Database, times: int) -> None:
    """Add copies of the newest survey."""
    with store.writing() as connection:
        row = dict(connection.execute(select(SURVEY).order_by(SURVEY.c.seq.desc()).limit(1)).mappings().one())
        copies = ({**row, "seq": 100 + k, "id": f"{k:036d}", "origin": f"copy {k}"} for k in range(times))
        connection.execute(SURVEY.insert(), [*copies])


def log_of(store: Database, seq: int) -> str:
    with store.reading() as connection:
        return str(connection.execute(select(CHANGE.c.body).where(CHANGE.c.seq == seq)).scalar_one())


@pytest.mark.nightly
def test_a_merge_of_many_surveys_keeps_what_it_changed_and_is_undone_byte_for_byte(tmp_path: Path) -> None:
    store = Database(tmp_path / "lots.db", FAST)
    kept, other = two_lots(store, STALLS)
    repeat(store, SURVEYS - 1)
    before = rows(store.path)
    with store.writing() as connection:
        done = commands.merge(connection, kept, other, "operator", BEGAN)
    assert rows(store.path) != before
    assert len(log_of(store, done.seq)) < 300_000  # whole rows were 3 MB
    with store.writing() as connection:
        assert commands.undo(connection, done.seq, BEGAN) == "merge"
    assert rows(store.path) == before
    store.close()


def change_name(connection: Any, lots: tuple[str, str]) -> int:
    return commands.rename(connection, lots[0], "North", "operator", BEGAN).seq


def change_lot(connection: Any, lots: tuple[str, str]) -> int:
    first = connection.execute(select(SURVEY.c.id).where(SURVEY.c.lot == lots[0])).scalar_one()
    return commands.move(connection, first, {"lot": lots[1]}, "operator", BEGAN, None).seq


def make_lot(connection: Any, lots: tuple[str, str]) -> int:
    first = connection.execute(select(SURVEY.c.id).where(SURVEY.c.lot == lots[0])).scalar_one()
    return commands.move(connection, first, {"lot": None}, "operator", BEGAN, None).seq


def register(connection: Any, lots: tuple[str, str]) -> int:
    first = connection.execute(select(SURVEY.c.id).where(SURVEY.c.lot == lots[0])).scalar_one()
    found = Registration(1.0, -0.0, 0.1, {})
    return commands.move(connection, first, {"lot": lots[1]}, "operator", BEGAN, lambda known, seen: found).seq


def remove(connection: Any, lots: tuple[str, str]) -> int:
    first = connection.execute(select(SURVEY.c.id).where(SURVEY.c.lot == lots[0])).scalar_one()
    return commands.delete(connection, first, "operator", BEGAN).seq


def part(connection: Any, lots: tuple[str, str]) -> int:
    outline = [list(corner) for corner in box(-30, -5, 22, 70).polygons[0]]
    return commands.split(connection, lots[0], {"name": "Back", "outline": outline}, "operator", BEGAN).seq


def turn(connection: Any, lots: tuple[str, str]) -> int:
    points = [
        {"from": [52.0, 5.0], "to": [52.00002, 5.0]},
        {"from": [52.0, 5.0005], "to": [52.000021, 5.0005]},
    ]
    return commands.pin(connection, lots[0], {"points": points}, "operator", BEGAN).seq


def merge(connection: Any, lots: tuple[str, str]) -> int:
    return commands.merge(connection, *lots, "operator", BEGAN).seq


@pytest.mark.slow
@pytest.mark.parametrize("change", [change_name, change_lot, make_lot, register, remove, part, turn, merge])
def test_every_change_is_undone_byte_for_byte(tmp_path: Path, change: Any) -> None:
    store = Database(tmp_path / "lots.db", FAST)
    lots = two_lots(store)
    before = rows(store.path)
    with store.writing() as connection:
        seq = change(connection, lots)
    assert rows(store.path) != before
    with store.writing() as connection:
        commands.undo(connection, seq, BEGAN)
    assert rows(store.path) == before
    store.close()


@pytest.mark.slow
def test_a_move_is_not_undone_once_the_survey_was_registered_where_it_is(tmp_path: Path) -> None:
    """Its place is of that lot's frame: the former lot has another one."""
    store = Database(tmp_path / "lots.db", FAST)
    lots = two_lots(store)
    with store.writing() as connection:
        seq = change_lot(connection, lots)
        connection.exec_driver_sql(
            "UPDATE survey SET placed = 'registered', north = 1, east = 2, turn = 0 WHERE seq = 1"
        )
    with store.writing() as connection, pytest.raises(LotStoreError, match="undo the later changes first"):
        commands.undo(connection, seq, BEGAN)
    store.close()


@pytest.mark.slow
def test_a_name_is_undone_whatever_else_of_the_lot_was_changed_since(tmp_path: Path) -> None:
    store = Database(tmp_path / "lots.db", FAST)
    lots = two_lots(store)
    with store.writing() as connection:
        seq = change_name(connection, lots)
        merge(connection, lots)
        assert commands.undo(connection, seq, BEGAN) == "name"
        assert {each["name"] for each in whole.lots(connection)} == {"Lot 1"}
    store.close()


def test_groups_are_read_as_they_were_written_and_several_steps_are_one() -> None:
    new = Group("observation", ((3, 1), (3, 2)), None, {"taken_probability": 0.25})
    first = Group("stall", ((1,), (2,)), {"north": 0.0, "kind": ""}, {"north": -0.0, "kind": "bus"})
    assert unpacked(packed([new, first])) == (new, first)
    assert json.loads(packed([first]))[0]["keys"] == [1, 2]
    second = Group("stall", ((1,),), {"kind": "bus"}, {"kind": "taxi"})
    one, other = net([[first], [second]])
    assert (one.keys, one.before, one.after) == (((1,),), {"north": 0.0, "kind": ""}, {"north": -0.0, "kind": "taxi"})
    assert (other.keys, other.after) == (((2,),), {"north": -0.0, "kind": "bus"})
