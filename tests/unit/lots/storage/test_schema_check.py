from __future__ import annotations

import sqlite3
import time
from contextlib import closing
from pathlib import Path

import pytest

from hawk.cli import main
from hawk.lots.storage.backup import restore
from hawk.lots.storage.database import Database, check, fresh_schema
from hawk.lots.storage.schema import SCHEMA, VERSION
from hawk.lots.storage.schema_check import difference, digest_of_schema
from hawk.lots.values import LotStoreError
from tests.unit.lots.storage.test_backup import made, read

ENDLESS = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i AS id, i AS lot FROM n"
STRANGE = {
    "a table that is missing": ("DROP TABLE erased", "table erased is missing"),
    "a view in place of a table": (
        f"DROP TABLE share; CREATE VIEW share AS {ENDLESS}",
        "table share is missing; trigger digest_share_delete is missing",
    ),
    "a view": ("CREATE VIEW more AS SELECT * FROM lot", "view more is not one of this program"),
    "a trigger": (
        "CREATE TRIGGER undo AFTER UPDATE ON share BEGIN UPDATE share SET taken_back = NULL; END",
        "trigger undo is not one of this program",
    ),
    "another trigger of a name": (
        "DROP TRIGGER looks_insert; CREATE TRIGGER looks_insert AFTER INSERT ON observation BEGIN SELECT 1; END",
        "trigger looks_insert is another one",
    ),
    "a trigger that is missing": ("DROP TRIGGER digest_lot_update", "trigger digest_lot_update is missing"),
    "an index that is missing": ("DROP INDEX ix_share_lot", "index ix_share_lot is missing"),
    "a further table": ("CREATE TABLE more (id)", "table more is not one of this program"),
    "a virtual table": ("CREATE VIRTUAL TABLE more USING fts5(text)", "table more is not one of this program"),
    "a further column": ("ALTER TABLE lot ADD COLUMN colour TEXT", "table lot is another one (colour TEXT)"),
    "a computed column": (
        "ALTER TABLE lot ADD COLUMN colour TEXT AS (name || name) VIRTUAL",
        "table lot is another one (colour TEXT AS (name || name) VIRTUAL)",
    ),
    "a check of rows": (
        "PRAGMA writable_schema = ON; UPDATE sqlite_master SET "
        "sql = replace(sql, 'PRIMARY KEY (lot)', 'PRIMARY KEY (lot), CHECK (turn < 1)') WHERE name = 'pin'",
        "table pin is another one (CHECK (turn < 1))",
    ),
}


@pytest.mark.slow
@pytest.mark.fault(
    "a backup, or the store of lots, has tables, views or triggers that are not ours",
    "refused in words before a row is read; the store is as before",
)
@pytest.mark.parametrize("name", STRANGE)
def test_a_file_with_another_schema_is_refused_before_a_row_is_read(tmp_path: Path, name: str) -> None:
    change, words = STRANGE[name]
    path, strange = made(tmp_path / "lots.db", 1), made(tmp_path / "strange.db", 1, 2)
    with closing(sqlite3.connect(strange)) as opened:
        opened.executescript(change)
    before, began = strange.read_bytes(), time.monotonic()
    with pytest.raises(LotStoreError) as refused:
        restore(path, strange)
    assert words in str(refused.value)
    assert str(refused.value).startswith(f"{strange} is damaged, or not made by this program: ")
    assert str(refused.value).endswith("Nothing was written. Restore another backup")
    with pytest.raises(LotStoreError, match="hawk-drone restore FILE"):
        Database(strange)
    assert time.monotonic() - began < 10  # no row of a view without end was asked for
    assert strange.read_bytes() == before
    assert read(path) == ["000001"]


def test_the_known_schema_is_that_of_a_fresh_store(tmp_path: Path) -> None:
    assert digest_of_schema(fresh_schema(VERSION)) == SCHEMA
    assert check(made(tmp_path / "lots.db", 1)) == VERSION


def test_a_store_whose_schema_is_written_otherwise_is_ours() -> None:
    """Another version of SQLite or SQLAlchemy may write it with other spaces, or another order of columns."""
    fresh = fresh_schema(VERSION)
    assert difference(fresh, "", lambda: fresh) == ""
    assert difference({"table a": frozenset({"x"})}, "", lambda: {"table a": frozenset({"y"})}) != ""


def test_tables_that_sqlite_keeps_about_its_indices_are_no_strange_ones(tmp_path: Path) -> None:
    path = made(tmp_path / "lots.db", 1)
    with closing(sqlite3.connect(path)) as opened:
        opened.execute("ANALYZE")
        opened.commit()
    assert read(path) == ["000001"]


def test_the_words_about_a_strange_file_show_nothing_that_cannot_be_shown(tmp_path: Path) -> None:
    path = made(tmp_path / "lots.db", 1)
    with closing(sqlite3.connect(path)) as opened:
        opened.execute('CREATE TABLE "\x1b[2Jgone" (id)')
    with pytest.raises(LotStoreError, match=r"table \?\[2Jgone is not one of this program"):
        check(path)


@pytest.mark.slow
def test_the_command_checks_a_store_and_a_backup(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    made(tmp_path / "lots.db", 1, 2)
    assert main(["verify", "--store", str(tmp_path)]) == 0
    assert capsys.readouterr().out == f"{tmp_path / 'lots.db'}: whole, lots 1, surveys 2\n"
    assert main(["backup", str(tmp_path / "copy.db"), "--store", str(tmp_path)]) == 0
    assert main(["verify", str(tmp_path / "copy.db")]) == 0
    with closing(sqlite3.connect(tmp_path / "copy.db")) as opened:
        opened.execute("PRAGMA foreign_keys = OFF")
        opened.execute("UPDATE stall SET lot = 'x' WHERE key = 1")
        opened.commit()
    assert main(["verify", str(tmp_path / "copy.db")]) == 1
    assert "stall names a lot that is not there" in capsys.readouterr().err
    assert main(["verify", "--store", str(tmp_path / "none")]) == 1
    assert "there is no store of lots" in capsys.readouterr().err
