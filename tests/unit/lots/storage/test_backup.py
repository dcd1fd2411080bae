from __future__ import annotations

import sqlite3
import subprocess
import sys
from contextlib import closing
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from sqlalchemy import select

from hawk.cli import main
from hawk.lots.ingest import save
from hawk.lots.storage.backup import FlightLock, backup, restore
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import SURVEY, VERSION
from hawk.lots.values import LotStoreError
from tests.unit.lots.surveys import later, survey

WRITER = """
import sys
from pathlib import Path
from hawk.lots.storage.database import Database
from hawk.lots.ingest import save
from tests.unit.lots.surveys import later, survey
store = Database(Path(sys.argv[1]))
for number in range(1, 1000):
    with store.writing() as connection:
        save(connection, later(survey(), number, hours=number))
    print(number, flush=True)
"""
FLIGHT = """
import sys
from pathlib import Path
from hawk.lots.storage.backup import FlightLock
lock = FlightLock(Path(sys.argv[1]))
lock.hold()
print("held", flush=True)
sys.stdin.read()
"""


def add(store: Database, *numbers: int) -> None:
    for number in numbers:
        with store.writing() as connection:
            save(connection, later(survey(), number, hours=number))


def origins(store: Database) -> list[str]:
    with store.reading() as connection:
        return [row[:6] for row in connection.execute(select(SURVEY.c.origin).order_by(SURVEY.c.seq)).scalars()]


def read(path: Path) -> list[str]:
    opened = Database(path)
    try:
        return origins(opened)
    finally:
        opened.close()


@cache
def _bytes_of(*numbers: int) -> bytes:
    """Return the file of a store of these surveys."""
    with TemporaryDirectory() as folder:
        opened = Database(path := Path(folder) / "lots.db")
        add(opened, *numbers)
        opened.close()
        assert [each.name for each in path.parent.iterdir()] == ["lots.db"]  # nothing waits in a WAL
        return path.read_bytes()


def made(path: Path, *numbers: int) -> Path:
    path.write_bytes(_bytes_of(*numbers))
    return path


@pytest.mark.slow
def test_a_backup_while_another_program_writes_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    writer = subprocess.Popen([sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE, text=True)
    try:
        assert writer.stdout is not None
        for _ in range(3):
            writer.stdout.readline()
        backup(path, tmp_path / "copy.db")
    finally:
        writer.kill()
        writer.communicate()
    found = read(tmp_path / "copy.db")
    assert len(found) >= 3
    assert found == [f"{number:06d}" for number in range(1, len(found) + 1)]
    assert read(path)[: len(found)] == found  # what a killed writer leaves opens as well


@pytest.mark.slow
def test_a_restore_replaces_the_content_under_a_program_that_has_it_open_and_keeps_the_former(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    running = Database(path)
    add(running, 1)
    backup(path, tmp_path / "copy.db")
    add(running, 2, 3)
    kept = restore(path, tmp_path / "copy.db").kept
    assert origins(running) == ["000001"]
    add(running, 4)
    assert origins(running) == ["000001", "000004"]
    running.close()
    assert kept == tmp_path / "lots.db.before-restore"
    assert read(kept) == ["000001", "000002", "000003"]
    assert restore(path, tmp_path / "copy.db").kept == tmp_path / "lots.db.before-restore-2"


@pytest.mark.slow
@pytest.mark.fault(
    "a backup is restored over a store of lots that is damaged",
    "restored; the damaged file is kept",
)
@pytest.mark.parametrize("left", [0, 20, 5000])
def test_a_restore_replaces_a_damaged_store_and_keeps_it_with_its_wal(tmp_path: Path, left: int) -> None:
    path = made(tmp_path / "lots.db", 1)
    backup(path, tmp_path / "copy.db")
    damaged = path.read_bytes()[:left]
    path.write_bytes(damaged)
    path.with_name("lots.db-wal").write_bytes(b"the rest")
    kept = restore(path, tmp_path / "copy.db").kept
    assert kept is not None
    assert kept.read_bytes() == damaged
    assert kept.with_name(f"{kept.name}-wal").read_bytes() == b"the rest"
    assert read(path) == ["000001"]


@pytest.mark.slow
def test_a_restore_where_there_is_no_store_makes_it(tmp_path: Path) -> None:
    copy = made(tmp_path / "copy.db", 1)
    assert restore(tmp_path / "new" / "lots.db", copy).kept is None
    assert read(tmp_path / "new" / "lots.db") == ["000001"]


@pytest.mark.slow
@pytest.mark.fault(
    "a backup is restored while a survey is flown",
    "refused until the motors are off",
)
def test_a_restore_is_refused_while_a_survey_is_flown_and_allowed_when_its_program_was_killed(tmp_path: Path) -> None:
    path = made(tmp_path / "lots.db", 1, 2)
    copy = made(tmp_path / "copy.db", 1)
    flight = subprocess.Popen(
        [sys.executable, "-c", FLIGHT, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    try:
        assert flight.stdout is not None
        assert flight.stdout.readline() == "held\n"
        second = FlightLock(path)
        second.hold()  # another drone's daemon on the same store
        second.release()
        with pytest.raises(LotStoreError, match=r"a survey is flown.*Restore once the motors are off"):
            restore(path, copy)
        assert read(path) == ["000001", "000002"]
    finally:
        flight.kill()
        flight.communicate()
    restore(path, copy)
    assert read(path) == ["000001"]


@pytest.mark.slow
def test_a_flight_s_lock_is_held_once_and_released(tmp_path: Path) -> None:
    path = made(tmp_path / "lots.db", 1)
    copy = made(tmp_path / "copy.db", 1)
    lock = FlightLock(path)
    lock.hold()
    lock.hold()
    with pytest.raises(LotStoreError, match="a survey is flown"):
        restore(path, copy)
    lock.release()
    lock.release()
    restore(path, copy)


@pytest.mark.slow
@pytest.mark.fault(
    "a backup is damaged, or of a newer version",
    "refused; the store is as before",
)
def test_a_backup_that_cannot_be_used_changes_nothing(tmp_path: Path) -> None:
    path = made(tmp_path / "lots.db", 1)
    copy = made(tmp_path / "copy.db", 2)
    (tmp_path / "cut.db").write_bytes(copy.read_bytes()[:9000])
    with closing(sqlite3.connect(copy)) as newer:
        newer.execute(f"PRAGMA user_version = {VERSION + 1}")
    before = path.read_bytes()
    with pytest.raises(LotStoreError, match=r"cut\.db is damaged"):
        restore(path, tmp_path / "cut.db")
    with pytest.raises(
        LotStoreError, match=f"is of version {VERSION + 1}, .* knows version {VERSION}. Install that hawk-drone"
    ):
        restore(path, copy)
    assert path.read_bytes() == before


def test_a_backup_writes_over_nothing_and_needs_a_store(tmp_path: Path) -> None:
    path = made(tmp_path / "lots.db", 1)
    with pytest.raises(LotStoreError, match=r"lots\.db is there already. Name a new file"):
        backup(path, path)
    with pytest.raises(LotStoreError, match="no survey was stored yet"):
        backup(tmp_path / "none.db", tmp_path / "copy.db")


@pytest.mark.slow
def test_the_commands_back_up_and_restore_the_store_of_a_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    store, copy = tmp_path / "var", tmp_path / "copy.db"
    store.mkdir()
    made(store / "lots.db", 1, 2)
    assert main(["backup", str(copy), "--store", str(store)]) == 0
    assert str(store / "lots.db") in capsys.readouterr().out
    made(store / "lots.db", 3)
    assert main(["restore", str(copy), "--store", str(store)]) == 0
    assert "lots.db.before-restore keeps the former content" in capsys.readouterr().out
    assert read(store / "lots.db") == ["000001", "000002"]
    assert main(["backup", str(copy), "--store", str(store)]) == 1
    assert "is there already" in capsys.readouterr().err
    assert main(["restore", str(tmp_path / "none.db"), "--store", str(store)]) == 2


@pytest.mark.slow
def test_the_commands_use_the_file_that_the_settings_name(tmp_path: Path) -> None:
    made(tmp_path / "other.db", 1)
    settings = tmp_path / "config.toml"
    settings.write_text(f'[store]\nlots = "{tmp_path / "other.db"}"\n')
    assert main(["backup", str(tmp_path / "copy.db"), "--config", str(settings)]) == 0
    assert read(tmp_path / "copy.db") == ["000001"]
