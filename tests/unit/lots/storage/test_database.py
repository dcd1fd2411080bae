from __future__ import annotations

import gc
import json
import random
import shutil
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from sqlalchemy import insert, select

from hawk.lots.change_log import undo
from hawk.lots.ingest import save
from hawk.lots.storage import database
from hawk.lots.storage.backup import restore, verify
from hawk.lots.storage.database import Database
from hawk.lots.storage.digests import seal
from hawk.lots.storage.outlines import unpack_outline
from hawk.lots.storage.schema import APPLICATION_ID, LABEL, LOT, METADATA, OBSERVATION, STALL, SURVEY, VERSION
from hawk.lots.storage.tables import unpack_stalls
from hawk.lots.time_zone import zone_of_lot
from hawk.lots.values import LotStoreError
from tests.examples import examples
from tests.unit.lots.surveys import later, survey

REMEDY = "hawk-drone restore FILE"
LOT_ROW = {"id": "a" * 36, "name": "South", "outline": '{"polygons":[],"holes":[]}', "latitude": 52.0}
LOT_ROW |= {"longitude": 5.0, "datum_is_pinned": False, "made": 0.0}


def surveys_in(path: Path) -> int:
    opened = Database(path)
    try:
        with opened.reading() as connection:
            return len(connection.execute(select(SURVEY.c.seq)).all())
    finally:
        opened.close()


def filled(path: Path, surveys: int = 2, stalls: int = 40) -> None:
    opened = Database(path)
    for number in range(1, surveys + 1):
        with opened.writing() as connection:
            save(connection, later(survey(stalls=stalls), number, hours=number))
    opened.close()


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("whole") / "lots.db"
    filled(path)
    assert [each.name for each in path.parent.iterdir()] == ["lots.db"]  # nothing waits in a WAL
    return path


@pytest.mark.slow
def test_a_fresh_store_has_the_tables_that_the_program_reads(tmp_path: Path) -> None:
    opened = Database(tmp_path / "lots.db")
    with opened.reading() as connection:
        assert compare_metadata(MigrationContext.configure(connection), METADATA) == []
        pragmas = ("user_version", "application_id", "foreign_keys", "journal_mode", "synchronous")
        found = [connection.exec_driver_sql(f"PRAGMA {name}").scalar() for name in pragmas]
    assert found == [VERSION, APPLICATION_ID, 1, "wal", 2]
    opened.close()


def test_a_transaction_that_fails_leaves_nothing(tmp_path: Path) -> None:
    opened = Database(tmp_path / "lots.db")
    with pytest.raises(LotStoreError, match="UNIQUE"), opened.writing() as connection:
        connection.execute(insert(LOT), [LOT_ROW, LOT_ROW])
    opened.close()
    opened = Database(tmp_path / "lots.db")
    with opened.reading() as connection:
        assert connection.execute(select(LOT)).all() == []
    opened.close()


@pytest.mark.slow
@pytest.mark.fault(
    "the store of lots is cut at any byte",
    "refused with the file's name and the restore as remedy; nothing is written",
)
@settings(
    max_examples=examples(200),
    deadline=None,
    derandomize=True,
    phases=[Phase.generate],
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(share=st.floats(0, 1, exclude_max=True))
def test_a_store_that_was_cut_anywhere_is_refused_with_its_remedy_and_left_as_it_is(
    whole: Path, tmp_path_factory: pytest.TempPathFactory, share: float
) -> None:
    path = tmp_path_factory.mktemp("cut") / "lots.db"
    data = whole.read_bytes()
    cut = data[: int(share * len(data))]
    path.write_bytes(cut)
    with pytest.raises(LotStoreError) as refused:
        Database(path)
    assert str(path) in str(refused.value)
    assert REMEDY in str(refused.value)
    assert "Traceback" not in str(refused.value)
    assert path.read_bytes() == cut
    shutil.rmtree(path.parent)


def refusal(path: Path) -> str:
    try:
        database.check(path)
    except LotStoreError as error:
        return str(error)
    return ""


@pytest.mark.slow
@pytest.mark.fault(
    "bytes of the store of lots are wrong",
    "read or refused; nothing is written",
)
def test_a_store_with_wrong_bytes_is_read_or_refused_and_never_written(whole: Path, tmp_path: Path) -> None:
    drawn, data = random.Random(5), whole.read_bytes()
    path, refused = tmp_path / "lots.db", 0
    for _ in range(100):
        begin = drawn.randrange(len(data) - 600)
        wrong = data[:begin] + drawn.randbytes(600) + data[begin + 600 :]
        path.write_bytes(wrong)
        words = refusal(path)
        refused += bool(words)
        assert not words or str(path) in words
        assert path.read_bytes() == wrong
    assert refused > 10


@pytest.mark.fault(
    "the store of lots is of another program",
    "refused; nothing is written",
)
def test_a_file_of_another_program_is_refused_and_left_as_it_is(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    with closing(sqlite3.connect(path)) as other:
        other.execute("CREATE TABLE lot (id)")
    before = path.read_bytes()
    with pytest.raises(LotStoreError, match=r"is no store of lots. Name another file: store\.lots"):
        Database(path)
    path.with_name("text.db").write_text("Dear reader, this is a letter.")
    with pytest.raises(LotStoreError, match=r"text\.db is damaged or no store of lots"):
        Database(path.with_name("text.db"))
    assert path.read_bytes() == before


@pytest.mark.fault(
    "the store of lots is missing beside its WAL",
    "refused; no store is made over it",
)
def test_a_store_is_not_made_beside_the_wal_of_one_that_is_missing(tmp_path: Path) -> None:
    (tmp_path / "lots.db-wal").write_bytes(b"committed surveys")
    with pytest.raises(LotStoreError, match="is missing beside its -wal"):
        Database(tmp_path / "lots.db")
    assert [each.name for each in tmp_path.iterdir()] == ["lots.db-wal"]


@pytest.mark.slow
@pytest.mark.fault(
    "the store of lots is of a newer version",
    "only read; a message names both versions",
)
def test_a_store_of_a_newer_version_is_read_and_never_written(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    filled(path)
    with closing(sqlite3.connect(path)) as newer:
        newer.execute("ALTER TABLE lot ADD COLUMN colour TEXT")
        newer.execute(f"PRAGMA user_version = {VERSION + 1}")
        newer.execute("PRAGMA journal_mode = DELETE")
    before = path.read_bytes()
    opened = Database(path)
    assert (
        f"{path} is of version {VERSION + 1}, of a newer hawk-drone; this one knows version {VERSION}" in opened.notice
    )
    with opened.reading() as connection:
        assert connection.execute(select(LOT.c.name)).scalars().all() == ["Lot 1"]
        with pytest.raises(LotStoreError, match="cannot be written"), database.explained(path):
            connection.execute(insert(LOT).values(**LOT_ROW))
    with pytest.raises(LotStoreError, match=f"is of version {VERSION + 1}"), opened.writing():
        pytest.fail("a newer store was opened for writing")
    opened.close()
    assert path.read_bytes() == before


LATER = f"""
import sqlalchemy as sa
from alembic import op

revision, down_revision = "{VERSION + 1:04d}", "{VERSION:04d}"


def upgrade():
    op.create_table("note", sa.Column("lot", sa.String(36), primary_key=True), sa.Column("text", sa.Text))
    op.execute("PRAGMA user_version = {VERSION + 1}")
"""
"""A step to a version that a later program has."""


@pytest.fixture
def earlier(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a store of the version before that of the program."""
    path = tmp_path / "lots.db"
    filled(path)
    shutil.copytree(database._REVISIONS, tmp_path / "revisions")
    (tmp_path / "revisions" / f"v{VERSION + 1:04d}_note.py").write_text(LATER)
    monkeypatch.setattr(database, "_REVISIONS", tmp_path / "revisions")
    monkeypatch.setattr(database, "VERSION", VERSION + 1)
    return path


@pytest.mark.slow
@pytest.mark.fault(
    "the store of lots is of an earlier version",
    "migrated in one step; a copy is kept",
)
def test_a_store_of_an_earlier_version_is_migrated_and_a_copy_is_kept(earlier: Path) -> None:
    before = earlier.read_bytes()
    opened = Database(earlier)
    kept = earlier.with_name(f"lots.db.version-{VERSION}")
    assert (
        opened.notice
        == f"{earlier} was of version {VERSION} and is of version {VERSION + 1} now; {kept} is a copy of it"
    )
    with opened.reading() as connection:
        assert connection.exec_driver_sql("SELECT count(*) FROM note").scalar() == 0
        assert connection.execute(select(LOT.c.name)).scalars().all() == ["Lot 1"]
    opened.close()
    opened = Database(earlier)
    assert opened.notice == ""
    opened.close()
    with closing(sqlite3.connect(kept)) as copy:
        assert copy.execute("PRAGMA user_version").fetchone() == (VERSION,)
        assert copy.execute("SELECT name FROM lot").fetchall() == [("Lot 1",)]
    assert len(kept.read_bytes()) == len(before)


def schema_of(path: Path) -> list[tuple[str, str]]:
    with closing(sqlite3.connect(path)) as opened:
        return opened.execute("SELECT name, sql FROM sqlite_master ORDER BY name").fetchall()


def pages(path: Path) -> int:
    with closing(sqlite3.connect(path)) as opened:
        return int(opened.execute("PRAGMA page_count").fetchone()[0])


@pytest.mark.slow
@pytest.mark.fault(
    "the disk is full while a survey is stored",
    "nothing of it is written; the error names file and remedy",
)
def test_a_full_disk_during_a_commit_names_file_and_remedy_and_leaves_the_store_whole(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    filled(path)
    opened = Database(path, {"max_page_count": pages(path) + 1})
    with pytest.raises(LotStoreError) as full, opened.writing() as connection:
        save(connection, later(survey(stalls=2000, seed=3), 3, hours=72))
    assert str(full.value) == f"{path} cannot grow: the disk is full, nothing of this was written. Make room"
    opened.close()
    assert surveys_in(path) == 2


@pytest.mark.slow
@pytest.mark.fault(
    "the disk is full while the store of lots is migrated",
    "the earlier version stays whole",
)
def test_a_full_disk_during_a_migration_leaves_the_earlier_version(earlier: Path) -> None:
    before, schema = pages(earlier), schema_of(earlier)
    with pytest.raises(LotStoreError, match="cannot grow: the disk is full"):
        Database(earlier, {"max_page_count": before})
    assert schema_of(earlier) == schema
    with closing(sqlite3.connect(earlier)) as old:
        assert old.execute("PRAGMA user_version").fetchone() == (VERSION,)
        assert old.execute("PRAGMA quick_check").fetchall() == [("ok",)]
    Database(earlier).close()
    assert surveys_in(earlier) == 2


def of_version_1(path: Path, spoil: str = "SELECT 1") -> None:
    """Make a store of one lot as release 0.4.0 made it."""
    database.migrate_file(path, "0001")
    with closing(sqlite3.connect(path)) as opened:
        opened.execute(
            "INSERT INTO lot (id, name, outline, latitude, longitude, datum_is_pinned, made) "
            "VALUES (:id, :name, :outline, :latitude, :longitude, :datum_is_pinned, :made)",
            LOT_ROW,
        )
        seal(opened)
        opened.execute(spoil)
        opened.commit()


@pytest.mark.nightly
def test_a_store_of_version_1_is_migrated_and_its_lots_have_the_time_zone_of_their_place(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    of_version_1(path)
    assert verify(path) == f"{path}: whole, lots 1, surveys 0"
    opened = Database(path)
    with opened.reading() as connection:
        assert connection.execute(select(LOT.c.name, LOT.c.time_zone)).all() == [("South", None)]
        assert zone_of_lot(connection, "a" * 36) == "Europe/Amsterdam"
    opened.close()
    assert database.check(path) == VERSION
    assert path.with_name("lots.db.version-1").exists()


DRAWN = (("found", 0), ("confirmed", 1), ("drawn", 1), ("drawn, numbered", 1), ("numbered", 0), ("numbered, undone", 0))
"""Stalls of a store of version 1: what a person did with each, and whether it was confirmed."""


@pytest.mark.slow
def test_a_store_of_version_1_knows_after_its_migration_which_labels_persons_gave(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    of_version_1(path)
    steps = [
        ("add_row", [3, 4], {"ends": 2}, {"ends": None}, "done"),
        ("renumber", [4], {"label": "E 4"}, {"label": "A 4"}, "done"),
        ("renumber", [5], {"label": "E 5"}, {"label": "A 5"}, "done"),
        ("renumber", [6], {"label": "A 6"}, {"label": "P 6"}, "undone"),
    ]
    with closing(sqlite3.connect(path)) as opened, opened:
        stall = "INSERT INTO stall VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"
        for key, (_, confirmed) in enumerate(DRAWN, 1):
            shape = (0.0, 0.0, 0.0, 2.5, 5.0, "")
            opened.execute(stall, (key, f"stall {key}", "a" * 36, f"A {key}", *shape, confirmed, 1, None, None, None))
            opened.execute("INSERT INTO label VALUES (?, ?, ?)", ("a" * 36, f"A {key}", f"stall {key}"))
        for kind, keys, before, after, state in steps:
            body = json.dumps([{"table": "stall", "keys": keys, "before": before, "after": after}])
            opened.execute(
                "INSERT INTO change (kind, lot, who, made, body, state) VALUES (?, ?, 'Ann', 0.0, ?, ?)",
                (kind, "a" * 36, body, state),
            )
        seal(opened)
    migrated = Database(path)
    with migrated.reading() as connection:
        named = connection.execute(select(STALL.c.is_named).order_by(STALL.c.key)).scalars().all()
        assert connection.execute(select(LABEL)).all() == []
    assert (migrated.damage, named) == ("", [False, True, False, True, True, False])
    migrated.close()
    assert verify(path) == f"{path}: whole, lots 1, surveys 0"


@pytest.mark.fault(
    "a lot in a store of an earlier version is damaged",
    "the migration keeps it damaged: it is named, and passed over",
)
def test_what_is_damaged_in_an_earlier_version_stays_so(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    of_version_1(path, "UPDATE digest SET digest = x'00'")
    with pytest.raises(LotStoreError, match="Damaged on the disk, and passed over: lot 'South'"):
        verify(path)
    for _ in range(2):
        opened = Database(path)
        assert "Damaged on the disk, and passed over: lot 'South'" in opened.damage
        opened.close()


VERSION_3 = Path(__file__).with_name("version_3.sql").read_text("utf-8")
"""Rows of a store that the program of version 3 made: a lot, two surveys, and one that a person deleted."""
BEFORE = "Damaged on the disk, and passed over: change 1. Restore a backup that has it whole: hawk-drone restore FILE"


def of_version_3(path: Path, spoil: str = "SELECT 1") -> None:
    """Make the store of `VERSION_3`. ``spoil``: changes it as a disk does, which knows no trigger."""
    database.migrate_file(path, "0003")
    with closing(sqlite3.connect(path)) as opened, opened:
        triggers = opened.execute("SELECT name, sql FROM sqlite_master WHERE type = 'trigger'").fetchall()
        made = [f"DROP TRIGGER {name}" for name, _ in triggers], [sql for _, sql in triggers]
        opened.executescript(f"{';'.join(made[0])}; {VERSION_3} {spoil}")
        for statement in made[1]:
            opened.execute(statement)


def looks_in(opened: Database) -> list[tuple[object, ...]]:
    with opened.reading() as connection:
        return [tuple(row) for row in connection.execute(select(OBSERVATION))]


@pytest.mark.slow
def test_a_store_of_version_3_keeps_its_looks_and_stalls_and_its_changes_can_be_undone(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    of_version_3(path)
    assert verify(path) == f"{path}: whole, lots 1, surveys 3"
    opened = Database(path)
    assert opened.damage == ""
    assert looks_in(opened)[3] == (2, 1, 1770000152.1826484, 0.0848236843374619, "taken", 284)
    with opened.writing() as connection:
        first, _, deleted = connection.execute(select(SURVEY).order_by(SURVEY.c.seq)).mappings().all()
        assert {len(unpack_outline(each["seen_ground"]).polygons) for each in (first, deleted)} == {1}
        assert [stall.picture_count for stall in unpack_stalls(first["stalls"])] == [165, 112, 126]
        (found, *_) = unpack_stalls(first["stalls"])
        assert (found.looked_at, found.taken_probability, found.known, found.is_blurred) == (
            1770000155.6,
            0.869,
            "",
            None,
        )
        undo(connection, 1, 1.8e9)
    assert looks_in(opened)[6:] == [
        (3, 1, 1770000371.446154, 0.45029298594608724, "taken", 185),
        (3, 2, 1770000222.4248488, 0.23444711625754389, "free", 80),
        (3, 3, 1770000127.0457284, 0.18161204179308932, "free", 125),
    ]
    opened.close()
    assert verify(path) == f"{path}: whole, lots 1, surveys 3"


@pytest.mark.slow
def test_a_backup_of_version_3_is_restored(tmp_path: Path) -> None:
    path, source = tmp_path / "lots.db", tmp_path / "backup.lots"
    filled(path, surveys=1)
    of_version_3(source)
    backup_of_it = source.read_bytes()
    restore(path, source)
    assert source.read_bytes() == backup_of_it
    opened = Database(path)
    assert (opened.damage, len(looks_in(opened)), surveys_in(path)) == ("", 6, 3)
    opened.close()


@pytest.mark.slow
@pytest.mark.parametrize("body", ["[{", "7", '[{"table": "survey"}]', '[{"table": "survey", "before": 1, "after": 2}]'])
def test_a_change_that_is_damaged_in_version_3_stays_so_and_stops_no_migration(tmp_path: Path, body: str) -> None:
    path = tmp_path / "lots.db"
    of_version_3(path, f"UPDATE change SET body = '{body}'")  # noqa: S608 - our own words
    opened = Database(path)
    assert (opened.damage, len(looks_in(opened))) == (BEFORE, 6)
    with pytest.raises(LotStoreError, match="change: it is damaged on the disk"), opened.writing() as connection:
        undo(connection, 1, 1.8e9)
    opened.close()


@pytest.mark.fault(
    "the folder of the store of lots cannot be written",
    "the error names the file and the remedy",
)
@pytest.mark.parametrize("spoil", [lambda folder: folder.write_text("a file"), lambda folder: folder.symlink_to("no")])
def test_a_folder_that_cannot_be_used_is_named(tmp_path: Path, spoil: Callable[[Path], object]) -> None:
    folder = tmp_path / "store"
    spoil(folder)
    with pytest.raises(LotStoreError, match=f"{folder / 'lots.db'}: .*Look at disk and rights of the folder"):
        Database(folder / "lots.db")


@pytest.mark.slow
@pytest.mark.fault(
    "two daemons use one store of lots",
    "every survey is stored",
)
def test_two_programs_store_surveys_in_one_file_and_neither_loses_one(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    first, second = Database(path), Database(path)
    for number in range(1, 7):
        with (first if number % 2 else second).writing() as connection:
            save(connection, later(survey(), number, hours=number))
    first.close()
    second.close()
    assert surveys_in(path) == 6


def test_a_file_that_was_replaced_is_noticed(tmp_path: Path) -> None:
    opened = Database(tmp_path / "lots.db")
    found = [opened.is_replaced]
    (tmp_path / "other").write_bytes(b"")
    (tmp_path / "other").replace(tmp_path / "lots.db")
    assert [*found, opened.is_replaced] == [False, True]
    opened.close()


def test_a_long_list_is_read_without_a_collection_of_garbage(tmp_path: Path) -> None:
    opened = Database(tmp_path / "lots.db")
    with opened.reading():
        collected = gc.get_stats()
        kept = [[number] for number in range(10_000)]
        assert gc.get_stats() == collected
    assert gc.isenabled()
    assert len(kept) == 10_000
    opened.close()


@pytest.mark.slow
def test_a_new_store_is_no_news_in_the_log(tmp_path: Path) -> None:
    program = "import logging, pathlib, sys; logging.basicConfig(level=logging.INFO); "
    program += "from hawk.lots.storage.database import Database; Database(pathlib.Path(sys.argv[1])).close()"
    ended = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path / "lots.db")], capture_output=True, text=True, check=True
    )
    assert ended.stderr == ""
