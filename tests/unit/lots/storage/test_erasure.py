"""The file of the store after its rows are removed: no byte of them is left, or an error says so."""

from __future__ import annotations

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from hawk.lots.storage import erasure
from hawk.lots.storage.erasure import counted, emptied
from hawk.lots.values import LotStoreError, NotFoundError

SECRET = "behind the cinema"


@pytest.fixture
def store(tmp_path: Path) -> Path:
    path = tmp_path / "lots.db"
    with closing(sqlite3.connect(path, isolation_level=None)) as opened:
        opened.execute("PRAGMA journal_mode = WAL")
        opened.execute("CREATE TABLE survey (id TEXT)")
        opened.executemany("INSERT INTO survey VALUES (?)", [(f"{SECRET} {number}",) for number in range(500)])
    return path


def holds(store: Path) -> bool:
    return any(SECRET.encode() in path.read_bytes() for path in store.parent.iterdir() if path.is_file())


def _refused(store: Path, error: Exception) -> None:
    with emptied(store) as opened:
        opened.execute("DELETE FROM survey")
        raise error


def test_an_error_leaves_every_row(store: Path) -> None:
    with pytest.raises(ZeroDivisionError):
        _refused(store, ZeroDivisionError())
    assert counted(store) == 500


def test_a_try_that_ended_before_the_file_was_written_is_finished_by_the_next(
    store: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The files are brought back as they were between the rows and the file, as after a loss of power."""
    lost = store.parent / "lost"
    lost.mkdir()

    def power_goes(_: sqlite3.Connection, path: Path) -> None:
        for each in path.parent.glob("lots.db*"):
            shutil.copy(each, lost)

    with monkeypatch.context() as patched:
        patched.setattr(erasure, "_write_again", power_goes)
        with emptied(store) as opened:
            opened.execute("DELETE FROM survey")
    for each in store.parent.glob("lots.db*"):
        each.unlink()
    for each in lost.iterdir():
        each.rename(store.parent / each.name)
    assert holds(store)
    with pytest.raises(NotFoundError):
        _refused(store, NotFoundError("there is none"))
    assert not holds(store)


def test_a_reader_that_keeps_bytes_in_the_file_is_an_error(store: Path) -> None:
    with (
        closing(sqlite3.connect(store, isolation_level=None, timeout=0)) as opened,
        closing(sqlite3.connect(store, isolation_level=None)) as reader,
    ):
        reader.execute("BEGIN")
        reader.execute("SELECT count(*) FROM survey").fetchone()
        opened.execute("DELETE FROM survey")
        with pytest.raises(LotStoreError, match=r"is used by another program: end it, and erase again\. The file"):
            erasure._write_again(opened, store)
        assert holds(store)
        reader.execute("ROLLBACK")
        erasure._write_again(opened, store)
    assert not holds(store)


def test_a_file_that_cannot_be_written_again_is_an_error(store: Path) -> None:
    with closing(sqlite3.connect(store, isolation_level=None)) as opened:
        opened.execute("BEGIN")
        with pytest.raises(LotStoreError, match=r"cannot VACUUM from within a transaction .* The file may still hold"):
            erasure._write_again(opened, store)


def test_surveys_of_a_file_that_is_no_store_are_none(tmp_path: Path) -> None:
    (tmp_path / "lots.db").write_bytes(b"no store" * 100)
    assert counted(tmp_path / "lots.db") == 0
