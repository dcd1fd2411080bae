"""The search for damage in a large store goes on beside its use: what it finds is passed over from then on."""

from __future__ import annotations

import itertools
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from hawk.lots import commands
from hawk.lots.storage.damage_search import DamageSearch, damaged_parts, faults_of
from hawk.lots.storage.database import Database
from hawk.lots.storage.digests import Part
from hawk.lots.values import LotStoreError
from tests.pace import PATIENCE_S
from tests.unit.lots import whole
from tests.unit.lots.storage.test_digests import NAME, REMEDY, filled, spoil
from tests.unit.lots.surveys import BEGAN

SECOND = Part("survey", "2")


def spoil_second(path: Path) -> None:
    spoil(path, "UPDATE survey SET free = free + 1 WHERE seq = 2", SECOND)


@pytest.mark.nightly
def test_a_search_in_pieces_finds_what_one_search_finds(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    lot = filled(path)
    spoil_second(path)
    with closing(sqlite3.connect(path)) as opened:
        opened.execute("DELETE FROM digest WHERE part = 'lot'")
        opened.commit()
        whole_search = damaged_parts(opened)
    assert whole_search == (Part("lot", lot), SECOND)
    search = DamageSearch()
    calls = 0
    is_done = False
    while not is_done:
        asked = iter(range(3))
        with closing(sqlite3.connect(path)) as opened:
            is_done = search.go_on(opened, lambda asked=asked: next(asked, None) is None)  # type: ignore[misc]
        calls += 1
    assert calls > 2
    assert (tuple(sorted(search.found)), search.faults) == (whole_search, "")


def test_what_is_written_between_two_pieces_is_not_damaged(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    lot = filled(path)
    search = DamageSearch()
    asked = itertools.count()
    with closing(sqlite3.connect(path)) as opened:
        assert not search.go_on(opened, lambda: next(asked) >= 3)
    with closing(Database(path)) as store, store.writing() as connection:
        commands.rename(connection, lot, "Elsewhere", "operator", BEGAN)
        commands.delete(connection, whole.surveys(connection, lot)[0]["id"], "operator", BEGAN)
    with closing(sqlite3.connect(path)) as opened:
        assert search.go_on(opened, lambda: False)
    assert search.found == set()


def test_a_store_that_is_searched_beside_passes_over_what_is_found_later(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    filled(path)
    spoil_second(path)
    with closing(Database(path, patience_s=0.0)) as store:
        with store.reading() as connection:
            before = whole.lots(connection)
        assert store.is_searched.wait(PATIENCE_S)
        assert store.damaged == (SECOND,)
        assert REMEDY in store.notice
        with store.reading() as connection:
            (lot,) = whole.lots(connection)
        assert (lot["name"], lot["survey_count"]) == (NAME, 2)
        assert before[0]["survey_count"] in (2, 3)  # it may have been found by then
        with store.writing() as connection:
            commands.rename(connection, lot["id"], "Elsewhere", "operator", BEGAN)
    with closing(Database(path)) as store:
        assert store.damaged == (SECOND,)


def test_a_file_whose_pages_are_found_damaged_later_is_written_no_more(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    lot = filled(path)
    with closing(sqlite3.connect(path)) as opened:
        (page,) = opened.execute("SELECT rootpage FROM sqlite_master WHERE name = 'ix_observation_stall'").fetchone()
        (size,) = opened.execute("PRAGMA page_size").fetchone()
    with path.open("r+b") as file:
        file.seek((page - 1) * size + size - 200)
        file.write(b"\xff" * 150)
    with pytest.raises(LotStoreError, match="is damaged"):
        Database(path)
    with closing(Database(path, patience_s=0.0)) as store:
        assert store.is_searched.wait(PATIENCE_S)
        assert "is damaged" in store.notice
        with pytest.raises(LotStoreError, match=r"is damaged.*hawk-drone restore FILE"), store.writing() as connection:
            commands.rename(connection, lot, "Elsewhere", "operator", BEGAN)
        with store.reading() as connection:
            assert whole.lots(connection)[0]["name"] == NAME


class Interrupted(sqlite3.Connection):
    """A connection that counts its interrupts."""

    count = 0

    def interrupt(self) -> None:
        self.count += 1
        super().interrupt()


@pytest.mark.slow
def test_a_look_at_the_pages_of_a_large_table_is_interrupted_since_sqlite_takes_one_step_for_it(tmp_path: Path) -> None:
    rows = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 1000000) SELECT i, i FROM n"
    with closing(sqlite3.connect(tmp_path / "large.db", factory=Interrupted)) as opened:
        opened.execute("CREATE TABLE large (a INTEGER PRIMARY KEY, b INTEGER)")
        opened.execute(f"INSERT INTO large {rows}")
        opened.commit()
        assert faults_of(opened) == ""
        assert opened.count == 0
        assert faults_of(opened, lambda: True) is None
        assert opened.count > 0
