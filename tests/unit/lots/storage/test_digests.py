"""Digests of the store's parts: a bit that the disk changes is stated in words, and never shown as a value."""

from __future__ import annotations

import functools
import json
import random
import sqlite3
import tempfile
from contextlib import closing
from pathlib import Path

import pytest
from sqlalchemy import select

from hawk.cli import main
from hawk.lots import commands, queries, shares
from hawk.lots.ingest import save
from hawk.lots.plan import edits
from hawk.lots.storage import digests
from hawk.lots.storage.backup import backup, damage_in, restore
from hawk.lots.storage.damage_search import damaged_parts
from hawk.lots.storage.database import Database
from hawk.lots.storage.digests import Part
from hawk.lots.storage.schema import CHANGE, METADATA, PARTS, SURVEY
from hawk.lots.values import LotStoreError, Placed
from tests.unit.lots import whole
from tests.unit.lots.surveys import BEGAN, later, survey

NAME = "Behind the cinema"
REMEDY = "Restore a backup that has it whole: hawk-drone restore FILE"
FLIPS = 40


@functools.cache
def _filled() -> tuple[bytes, str]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "lots.db"
        lot = _fill(path)
        return path.read_bytes(), lot


def filled(path: Path) -> str:
    """Return the lot of a store with three surveys, a name, and a link."""
    content, lot = _filled()
    path.write_bytes(content)
    return lot


def _fill(path: Path) -> str:
    store = Database(path)
    for number in (1, 2, 3):
        with store.writing() as connection:
            save(connection, later(survey(stalls=12), number, hours=number))
    with store.writing() as connection:
        lot = str(whole.lots(connection)[0]["id"])
        commands.rename(connection, lot, NAME, "operator", BEGAN)
        shares.share(connection, lot, {"days": 3}, BEGAN)
    store.close()
    return lot


def spoil(path: Path, change: str, part: Part) -> None:
    """Change rows as a disk does: the digest of their part stays."""
    with closing(sqlite3.connect(path)) as opened:
        key = (part.kind, part.key)
        (kept,) = opened.execute("SELECT digest FROM digest WHERE part = ? AND key = ?", key).fetchone()
        opened.execute(change)
        opened.execute("UPDATE digest SET digest = ? WHERE part = ? AND key = ?", (kept, *key))
        opened.commit()


def damaged_in(path: Path) -> tuple[Part, ...]:
    with closing(sqlite3.connect(path)) as opened:
        return damaged_parts(opened)


def shown(path: Path) -> tuple[str, str]:
    """Return all that the lists show of a store, and the words beside it."""
    store = Database(path)
    try:
        with store.reading() as connection:
            lots = whole.lots(connection)
            return json.dumps([lots, [whole.lot(connection, lot["id"]) for lot in lots]]), store.notice
    finally:
        store.close()


def shown_or_refused(path: Path) -> tuple[str | None, str]:
    try:
        return shown(path)
    except LotStoreError as error:
        return None, str(error)


def test_every_table_is_of_a_part() -> None:
    of_parts = {table for tables in PARTS.values() for table in tables}
    assert METADATA.tables.keys() - of_parts == {"digest", "erased", "desk", "arrival"}


@pytest.mark.nightly
def test_whatever_the_program_writes_has_its_digests(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    lot = filled(path)
    store = Database(path)
    with store.writing() as connection:
        edit = edits.open_edit(connection, lot, {"who": "Ada"}, BEGAN).edit
        stall = whole.stalls(connection, lot)[0]["id"]
        move = {"do": "confirm", "stalls": [stall]}
        edits.do(connection, lot, {"edit": edit, "operation": move}, BEGAN)
        edits.close(connection, lot, {"edit": edit}, BEGAN)
    with store.writing() as connection:
        first = whole.surveys(connection, lot)[0]["id"]
        done = commands.move(connection, first, {"lot": None}, "operator", BEGAN, None)
    with store.writing() as connection:
        commands.undo(connection, done.seq, BEGAN)
        commands.delete(connection, first, "operator", BEGAN)
    store.close()
    assert damaged_in(path) == ()
    with closing(sqlite3.connect(path)) as opened:
        assert opened.execute("SELECT count(*) FROM digest WHERE digest IS NULL").fetchone() == (0,)
        kinds = {kind for (kind,) in opened.execute("SELECT part FROM digest")}
        assert kinds == PARTS.keys()


@pytest.mark.slow
@pytest.mark.fault(
    "the disk changes a bit of the store of lots",
    "refused, or the damaged part is passed over and named; no changed value is shown without a word",
)
@pytest.mark.parametrize("flips", [FLIPS, pytest.param(10 * FLIPS, marks=pytest.mark.nightly)])
def test_no_bit_that_the_disk_changes_is_shown_as_a_value(tmp_path: Path, flips: int) -> None:
    path, drawn = tmp_path / "lots.db", random.Random(49)
    filled(path)
    whole, (before, _) = path.read_bytes(), shown(path)
    used = [n for n, byte in enumerate(whole) if byte]  # zeros are mostly room that nothing uses
    found = {"refused": 0, "stated": 0}
    for _ in range(flips):
        flipped, at = bytearray(whole), drawn.choice(used)
        flipped[at] ^= 1 << drawn.randrange(8)
        path.write_bytes(flipped)
        after, words = shown_or_refused(path)
        assert "hawk-drone restore FILE" in words or "Name another file" in words or not words, words
        if after is None:
            found["refused"] += 1
            continue
        assert after == before or words, f"byte {at} was shown without a word"
        found["stated"] += bool(words)
    assert min(found.values()) > flips / 24, found


@pytest.mark.slow
@pytest.mark.fault(
    "the disk changes a bit of the store of lots, and a command reads it",
    "every command says it in words; a backup is restored over it",
)
def test_no_command_ends_in_a_traceback_and_a_backup_is_restored_over_any_damage(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, drawn, copy = tmp_path / "var" / "lots.db", random.Random(50), tmp_path / "copy.db"
    path.parent.mkdir()
    filled(path)
    backup(path, copy)
    whole, folder = path.read_bytes(), str(path.parent)
    names = [
        n for n in range(len(whole)) if whole[n : n + 6] in (b"CREATE", b"survey", b"observ", b"digest", b"taken_")
    ]
    for _ in range(8):
        flipped, at = bytearray(whole), drawn.choice(names) + drawn.randrange(6)
        flipped[at] ^= 1 << drawn.randrange(8)
        path.write_bytes(flipped)
        for command in (
            ["stats", NAME],
            ["verify"],
            ["backup", str(tmp_path / "x.db")],
            ["erase", "--survey", "x", "--yes"],
        ):
            (tmp_path / "x.db").unlink(missing_ok=True)
            assert main([*command, "--store", folder]) in (0, 1)
        assert main(["restore", str(copy), "--store", folder]) == 0
        assert main(["verify", "--store", folder]) == 0
        for each in path.parent.iterdir():
            each.unlink()
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.fault(
    "a survey in the store of lots is damaged",
    "passed over and named; the others are shown, a backup says it, a restore mends it",
)
def test_a_damaged_survey_is_passed_over_and_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, copy, later_copy = tmp_path / "lots.db", tmp_path / "copy.db", tmp_path / "later.db"
    lot = filled(path)
    backup(path, copy)
    spoil(
        path,
        "UPDATE observation SET taken_probability = 1 - taken_probability WHERE survey = 1 AND stall = 3",
        Part("survey", "1"),
    )
    store = Database(path)
    with store.reading() as connection:
        shown = whole.surveys(connection, lot)
        assert len(shown) == 2
        assert connection.execute(select(SURVEY.c.seq)).scalars().all() == [2, 3]
    with store.writing() as connection:
        gone = connection.execute(select(SURVEY.c.id).where(SURVEY.c.seq == 1)).scalar_one()
        with pytest.raises(LotStoreError, match="survey: it is damaged on the disk"):
            commands.delete(connection, gone, "operator", BEGAN)
    assert f"{path}: Damaged on the disk, and passed over: survey {gone[:8]} of 20" in store.notice
    assert store.notice.endswith(REMEDY)
    store.close()
    assert main(["stats", NAME, "--store", str(tmp_path)]) == 0
    assert f"passed over: survey {gone[:8]}" in capsys.readouterr().err
    assert main(["verify", "--store", str(tmp_path)]) == 1
    assert f"passed over: survey {gone[:8]}" in capsys.readouterr().err
    assert main(["backup", str(later_copy), "--store", str(tmp_path)]) == 1
    words = capsys.readouterr().err
    assert "with its damage. Keep the backups before it." in words
    assert f"survey {gone[:8]}" in words
    assert damage_in(later_copy) != ""
    assert any(gone[:8] in note for note in restore(path, later_copy).notes)
    restore(path, copy)
    assert damaged_in(path) == ()


def test_what_is_damaged_while_the_store_is_open_is_refused_where_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    lot = filled(path)
    store = Database(path)
    with store.reading() as connection:
        first = whole.surveys(connection, lot)[0]["id"]
        whole.lot(connection, lot)
    spoil(path, "UPDATE stall SET label = 'B9' WHERE key = 1", Part("lot", lot))
    spoil(path, "UPDATE observation SET taken_probability = 1 - taken_probability WHERE stall = 1", Part("survey", "1"))
    for access in (store.reading, store.writing):
        with access() as connection:
            with pytest.raises(LotStoreError, match="lot: it is damaged on the disk"):
                whole.lot(connection, lot)
            with pytest.raises(LotStoreError, match="survey: it is damaged on the disk"):
                queries.survey_row(connection, first)
    store.close()


def test_no_damaged_step_of_an_edit_is_undone(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    lot = filled(path)
    store = Database(path)
    with store.writing() as connection:
        edit = edits.open_edit(connection, lot, {"who": "Ada"}, BEGAN).edit
        move = {"do": "move", "all": True, "north": 1.0, "east": 0.0}
        edits.do(connection, lot, {"edit": edit, "operation": move}, BEGAN)
        step = connection.execute(select(CHANGE.c.seq).where(CHANGE.c.edit == edit)).scalar_one()
    spoil(path, "UPDATE change SET body = replace(body, ':1', ':2') WHERE edit NOTNULL", Part("change", str(step)))
    with store.writing() as connection:
        with pytest.raises(LotStoreError, match="change: it is damaged on the disk"):
            edits.undo(connection, lot, {"edit": edit}, BEGAN)
        closed = edits.close(connection, lot, {"edit": edit}, BEGAN)
    with store.writing() as connection, pytest.raises(LotStoreError, match="change: it is damaged on the disk"):
        commands.undo(connection, closed.seq or 0, BEGAN)
    store.close()


def test_what_is_written_into_a_damaged_part_heals_nothing(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    lot = filled(path)
    spoil(path, "UPDATE stall SET label = 'B9' WHERE key = 1", Part("lot", lot))
    for _ in range(2):
        store = Database(path)
        assert store.damaged == (Part("lot", lot),)
        with store.reading() as connection:
            assert whole.lots(connection) == []
            with pytest.raises(LotStoreError, match="lot: it is damaged on the disk"):
                whole.lot(connection, lot)
        with store.writing() as connection:
            connection.exec_driver_sql("UPDATE stall SET kind = 'wide' WHERE key = 2")
        store.close()


def test_a_survey_of_a_lot_with_a_damaged_plan_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    lot = filled(path)
    spoil(path, "UPDATE stall SET north = 'x' WHERE key = 1", Part("lot", lot))
    store = Database(path)
    with store.writing() as connection:
        saved = save(connection, later(survey(stalls=12), 9, hours=9))
    store.close()
    assert (saved.lot, saved.placed, saved.doubt) == (lot, Placed.UNREGISTERED, "the lot's plan is damaged on the disk")
    assert damaged_in(path) == (Part("lot", lot),)


@pytest.mark.parametrize(
    ("change", "part"),
    [
        ("UPDATE survey SET free = 99 WHERE seq = 2", Part("survey", "2")),
        ("UPDATE survey SET began = 5 WHERE seq = 2", Part("survey", "2")),
        ("DELETE FROM observation WHERE survey = 1 AND stall = 1", Part("survey", "1")),
        ("UPDATE share SET taken_back = NULL, ends = 9e9", Part("lot", "")),
        ("UPDATE layout SET why = X'FF'", Part("lot", "")),
        ("UPDATE lot SET name = CAST(X'FFFE' AS TEXT)", Part("lot", "")),
        ("UPDATE change SET body = 'x' WHERE seq = 1", Part("change", "1")),
        ("UPDATE outbox SET body = 'x' WHERE seq = 1", Part("outbox", "1")),
    ],
)
def test_a_change_of_any_column_is_found(tmp_path: Path, change: str, part: Part) -> None:
    path = tmp_path / "lots.db"
    lot = filled(path)
    meant = Part(part.kind, part.key or lot)
    spoil(path, change, meant)
    assert damaged_in(path) == (meant,)
    with closing(sqlite3.connect(path)) as opened:
        assert digests.words_of(opened, (meant,)).endswith(REMEDY)
