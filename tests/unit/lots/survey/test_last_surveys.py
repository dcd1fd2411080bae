"""The newest surveys that the store keeps are those that its rows say, after whatever happens to them."""

from __future__ import annotations

import shutil
import sqlite3
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, suppress
from dataclasses import astuple, replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule, run_state_machine_as_test
from sqlalchemy import Connection, Table, func, select

from hawk.lots import commands
from hawk.lots.documents import parts
from hawk.lots.ingest import save
from hawk.lots.plan.queries import in_plan
from hawk.lots.storage.backup import backup, restore, verify
from hawk.lots.storage.database import Database
from hawk.lots.storage.digests import Part, digest_of
from hawk.lots.storage.erasure import erase_rows, found_lot, found_survey
from hawk.lots.storage.schema import DOCUMENT, LAST_SURVEY, LOT, SECTION, STALL, SURVEY
from hawk.lots.survey import last_surveys
from hawk.lots.survey.counts import counts_of
from hawk.lots.survey.last_surveys import LastSurvey, last_surveys_of
from hawk.lots.survey.order import newest_first, ordered_at
from hawk.lots.survey.source import PictureSource, SourceKind
from hawk.lots.values import FinishedSurvey, LotStoreError, NotFoundError
from tests.examples import examples
from tests.unit.lots.documents.drones import WHO, Drone, collected, photographs
from tests.unit.lots.plan.plans import FAST
from tests.unit.lots.repaints import by_place
from tests.unit.lots.surveys import BEGAN, box, later, survey

HOUR_S = 3600.0
PICTURES = PictureSource(SourceKind.PHOTOGRAPHS, "flight")
HOURS = st.integers(-40, 40)


def photographed(number: int, hours: float, stalls: int = 40) -> FinishedSurvey:
    return replace(later(survey(seed=number, stalls=stalls), number, hours), pictures=PICTURES)


def counted(connection: Connection, lot: str) -> tuple[Any, ...]:
    """Return the newest survey of a lot by the questions that are asked about one survey or one lot, as of `plain`."""
    of_lot = select(SURVEY, ordered_at().label("at"), DOCUMENT.c.writer).outerjoin(DOCUMENT).where(SURVEY.c.lot == lot)
    rows = connection.execute(of_lot.order_by(*newest_first())).mappings().all()
    present = [
        connection.execute(select(func.count()).where(in_plan(each.c, lot))).scalar_one() for each in (STALL, SECTION)
    ]
    last: tuple[Any, ...] = (None,) * 8
    if rows:
        row = rows[0]
        last = tuple(row[name] for name in ("seq", "id", "ended", "at", "writer"))
        last += tuple(counts_of(connection, [row])[0][name] for name in ("free", "taken", "unknown"))
    return (*present, len(rows), *last)


def plain(found: object) -> tuple[Any, ...]:
    """Return all but the ends of pictures, which say how long it holds."""
    return astuple(found)[:-2] if isinstance(found, LastSurvey) else tuple(found)[1:-2]  # type: ignore[arg-type]


def check_kept(store: Database, *, is_whole: bool = False) -> None:
    """Compare what is kept, and what readers get. ``is_whole``: nothing is missing."""
    with store.reading() as connection:
        lots = connection.execute(select(LOT.c.id)).scalars().all()
        wanted = {lot: counted(connection, lot) for lot in lots}
        kept = {row.lot: plain(row) for row in connection.execute(last_surveys._KEPT, among(lots))}
        assert kept == {lot: wanted[lot] for lot in kept}
        assert not is_whole or kept.keys() == wanted.keys()
        assert {lot: plain(each) for lot, each in last_surveys_of(connection, lots).items()} == wanted
        assert store.damage == ""


def among(lots: Sequence[str]) -> dict[str, str]:
    return {"among": "[" + ", ".join(f'"{lot}"' for lot in lots) + "]"}


class Lots(RuleBasedStateMachine):
    """A store; every rule is something that may happen to it."""

    @initialize()
    def begin(self) -> None:
        self.folder = Path(tempfile.mkdtemp())
        self.now, self.number = BEGAN + 12 * HOUR_S, 0
        self.store = self.opened()
        self.is_whole = True
        self.other: Drone | None = None
        self.add(survey())

    def opened(self) -> Database:
        return Database(self.folder / "lots.db", FAST, lambda: self.now)

    def teardown(self) -> None:
        self.store.close()
        if self.other is not None:
            self.other.store.close()
        shutil.rmtree(self.folder)

    def do(self, act: Callable[[Connection], object]) -> None:
        """Change the store; what is refused changes nothing."""
        with suppress(LotStoreError), self.store.writing() as connection:
            act(connection)
            self.is_whole = True

    def one(self, data: st.DataObject, asked: Any) -> Any:
        with self.store.reading() as connection:
            found = connection.execute(asked).scalars().all()
        return data.draw(st.sampled_from(found)) if found else "none"

    def add(self, given: FinishedSurvey) -> None:
        self.do(lambda connection: save(connection, given, by_place))

    def a_lot(self, data: st.DataObject) -> str:
        return str(self.one(data, select(LOT.c.id).order_by(LOT.c.made)))

    def a_survey(self, data: st.DataObject) -> str:
        return str(self.one(data, select(SURVEY.c.id).order_by(SURVEY.c.seq)))

    @rule(hours=HOURS, kind=st.sampled_from(["flown", "unsure", "pictures", "photographs"]), again=st.booleans())
    def a_survey_comes(self, hours: int, kind: str, again: bool) -> None:
        self.number += not again
        number = self.number
        flown = later(survey(seed=number, stalls=40 + 20 * again), number, hours)
        made = {
            "flown": flown, "unsure": replace(flown, time_is_sure=False), "pictures": photographed(number, hours),
            "photographs": photographs(number, hours),
        }  # fmt: skip
        self.add(made[kind])

    @rule(data=st.data(), row=st.sampled_from("AB"))
    def a_person_edits_the_plan(self, data: st.DataObject, row: str) -> None:
        drone, lot = Drone(self.store, now=self.now), self.a_lot(data)
        ring = [[-6.0, 52.0], [6.0, 52.0], [6.0, 80.0], [-6.0, 80.0]]
        removes, draws = {"do": "remove", "row": row}, {"do": "draw_section", "name": "Kerb", "outline": ring}
        done: dict[str, Any] = data.draw(st.sampled_from([removes, {**draws, "kind": "parallel"}]))
        with suppress(LotStoreError):
            drone.edit(lot, done)

    @rule(data=st.data(), what=st.sampled_from(["delete", "move", "merge", "split", "rename", "undo"]))
    def a_person_changes_a_lot(self, data: st.DataObject, what: str) -> None:
        lot, named = self.a_lot(data), self.a_survey(data)
        part = [list(corner) for corner in box(-4, -4, 9, 26).polygons[0]]
        seq = data.draw(st.integers(1, 8))
        acts: dict[str, Callable[[Connection], object]] = {
            "delete": lambda c: commands.delete(c, named, WHO, self.now),
            "move": lambda c: commands.move(c, named, {"lot": None, "name": "East"}, WHO, self.now, by_place),
            "merge": lambda c: commands.merge(c, lot, self.a_lot(data), WHO, self.now),
            "split": lambda c: commands.split(c, lot, {"name": "South", "outline": part}, WHO, self.now),
            "rename": lambda c: commands.rename(c, lot, f"Lot {seq}", WHO, self.now),
            "undo": lambda c: commands.undo(c, seq, self.now),
        }
        self.do(acts[what])

    @rule(hours=HOURS)
    def a_drone_sends_its_documents(self, hours: int) -> None:
        self.other = self.other or Drone.at(self.folder / "drone.db")
        self.number += 1
        self.other.add(later(survey(seed=self.number), self.number, hours))
        for document in reversed(self.other.documents()):
            with suppress(LotStoreError):
                collected(self.store, parts.packed(document))

    @rule(data=st.data(), of_lot=st.booleans())
    def something_is_erased(self, data: st.DataObject, of_lot: bool) -> None:
        with closing(sqlite3.connect(self.store.path, isolation_level=None)) as opened:
            opened.execute("PRAGMA foreign_keys = ON")
            opened.execute("BEGIN IMMEDIATE")
            with suppress(NotFoundError, LotStoreError):
                found = found_lot(opened, self.a_lot(data)) if of_lot else found_survey(opened, self.a_survey(data))
                erase_rows(opened, found)
                self.is_whole = False
            opened.execute("COMMIT")

    @rule(hours=st.integers(-20, 30))
    def the_clock_goes_on(self, hours: int) -> None:
        self.now += hours * HOUR_S
        self.is_whole = False

    @rule()
    def a_backup_is_made(self) -> None:
        (self.folder / "backup.db").unlink(missing_ok=True)
        backup(self.store.path, self.folder / "backup.db")

    @rule()
    def the_backup_is_restored(self) -> None:
        if (self.folder / "backup.db").exists():
            self.store.close()
            restore(self.store.path, self.folder / "backup.db", self.now)
            self.store, self.is_whole = self.opened(), False

    @rule()
    def the_program_before_had_the_store(self) -> None:
        self.store.close()
        make_version_8(self.store.path)
        self.store, self.is_whole = self.opened(), True

    @invariant()
    def what_is_kept_is_right(self) -> None:
        if hasattr(self, "store"):
            check_kept(self.store, is_whole=self.is_whole)


def make_version_8(path: Path) -> None:
    """Make a store that of the version before, as a program of that version would have written it."""
    with closing(sqlite3.connect(path)) as opened, opened:
        made = "SELECT name FROM sqlite_master WHERE type = 'trigger' AND (name LIKE '%last_survey_%')"
        for (name,) in opened.execute(made).fetchall():
            opened.execute(f"DROP TRIGGER {name}")
        opened.execute("DROP TABLE last_survey")
        for column in ("began", "ended"):
            opened.execute(f"DROP INDEX ix_survey_{column}")
        opened.execute("ALTER TABLE desk DROP COLUMN due")
        opened.execute("ALTER TABLE share DROP COLUMN who")
        for (lot,) in opened.execute("SELECT DISTINCT lot FROM share").fetchall():
            opened.execute(
                "UPDATE digest SET digest = ? WHERE part = 'lot' AND key = ?",
                (digest_of(opened, Part("lot", lot)), lot),
            )
        opened.execute("DELETE FROM digest WHERE part = 'last'")
        opened.execute("UPDATE alembic_version SET version_num = '0008'")
        opened.execute("PRAGMA user_version = 8")


@pytest.mark.slow
def test_what_is_kept_is_what_the_rows_say_whatever_happens() -> None:
    run_state_machine_as_test(Lots, settings=settings(max_examples=examples(12), stateful_step_count=12))


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Database]:
    opened = Database(tmp_path / "lots.db", FAST)
    yield opened
    opened.close()


def lots_of(store: Database) -> list[str]:
    with store.reading() as connection:
        return [*connection.execute(select(LOT.c.id).order_by(LOT.c.made)).scalars()]


def shown(store: Database, lot: str) -> tuple[Any, ...]:
    with store.reading() as connection:
        (found,) = last_surveys_of(connection, [lot]).values()
        assert plain(found) == counted(connection, lot)
        return found.survey, found.surveys


def columns(table: Table) -> str:
    """Return the columns that rows may share."""
    return ", ".join(each.name for each in table.c if each.name not in ("seq", "id", "origin"))


@pytest.fixture(scope="module")
def three(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of a store with three surveys of a lot, and another lot."""
    with closing(Database(tmp_path_factory.mktemp("three") / "lots.db", FAST)) as store:
        with store.writing() as connection:
            for number in (1, 2):
                save(connection, later(survey(seed=number), number, 24.0 * number), by_place)
            save(connection, photographed(3, 2.0, stalls=0), by_place)
            connection.exec_driver_sql("UPDATE survey SET lot = (SELECT lot FROM survey WHERE seq = 2) WHERE seq = 3")
            connection.exec_driver_sql(f"INSERT INTO lot SELECT 'other', {columns(LOT)} FROM lot")  # noqa: S608
        check_kept(store, is_whole=True)
    return store.path


@pytest.mark.parametrize(
    "change",
    [
        "UPDATE survey SET lot = 'other' WHERE seq = 2",
        "DELETE FROM survey WHERE seq = 3",
        "INSERT INTO survey SELECT 9, '9', '9', {columns} FROM survey WHERE seq = 3",
        "UPDATE survey SET ended = 1 WHERE seq = 2",
        "DELETE FROM observation WHERE survey = 2 AND stall < 9",
        "UPDATE observation SET state = 'unknown' WHERE survey = 2",
        "UPDATE stall SET ends = 1 WHERE key < 5",
        "UPDATE stall SET lot = 'other' WHERE key < 5",
        "INSERT INTO document VALUES (2, 'Drone 2', 1, '', '', '[]', 0)",
    ],
)
def test_each_statement_that_changes_what_it_follows_from_makes_a_row_again(
    three: Path, tmp_path: Path, change: str
) -> None:
    """Alone in its transaction: no other change of an operation can stand in for it."""
    with closing(Database(Path(shutil.copy(three, tmp_path)), FAST)) as store:
        with store.reading() as connection:
            before = connection.execute(select(LAST_SURVEY).order_by(LAST_SURVEY.c.lot)).all()
        with store.writing() as connection:
            connection.exec_driver_sql(change.format(columns=columns(SURVEY)))
            assert connection.execute(select(LAST_SURVEY.c.stalls)).scalars().all().count(None) in (1, 2)
        check_kept(store, is_whole=True)
        with store.reading() as connection:
            assert connection.execute(select(LAST_SURVEY).order_by(LAST_SURVEY.c.lot)).all() != before


def test_a_picture_that_is_to_come_is_the_newest_once_its_time_has_been(tmp_path: Path) -> None:
    now = BEGAN + 24 * HOUR_S
    with closing(Database(tmp_path / "lots.db", FAST, lambda: now)) as store:
        with store.writing() as connection:
            for given in (survey(), photographed(2, 12.0), photographed(3, 36.0)):
                save(connection, given, by_place)
            connection.exec_driver_sql("UPDATE survey SET time_is_sure = 1")  # as that of a drone whose clock is ahead
        (lot,) = lots_of(store)
        at = [(24.0, 2), (36.09, 3), (11.0, 1), (24.0, 2), (36.2, 3)]
        for hours, newest_one in at:
            now = BEGAN + hours * HOUR_S
            assert shown(store, lot) == (newest_one, 3)
            check_kept(store)
        with store.writing():
            pass
        check_kept(store, is_whole=True)


def digests_and_states(path: Path) -> list[tuple[object, ...]]:
    """Return the digests of what was there before an upgrade, and all messages."""
    with closing(sqlite3.connect(path)) as opened:
        digests = opened.execute("SELECT * FROM digest WHERE part != 'last' ORDER BY part, key").fetchall()
        return [*digests, *opened.execute("SELECT * FROM outbox ORDER BY seq")]


def test_the_rows_of_an_upgrade_are_made_some_at_a_time_and_the_next_program_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "lots.db"
    with closing(Database(path, FAST)) as store, store.writing() as connection:
        save(connection, survey(), by_place)
        for number in range(6):
            connection.exec_driver_sql(f"INSERT INTO lot SELECT 'lot {number}', {columns(LOT)} FROM lot LIMIT 1")  # noqa: S608
    make_version_8(path)
    states = digests_and_states(path)
    monkeypatch.setattr(last_surveys, "_CHANGED", last_surveys._CHANGED.limit(3))
    monkeypatch.setattr(last_surveys, "_AT_ONCE", 2)
    kept = []
    for _ in range(4):
        with closing(Database(path, FAST)) as store:
            check_kept(store)
            with store.reading() as connection:
                kept.append(connection.execute(select(func.count(LAST_SURVEY.c.stalls))).scalar_one())
            with store.writing():
                pass
            assert store.has_more_newest == (kept[-1] < 6)
    assert kept == [2, 4, 6, 7]
    assert digests_and_states(path) == states  # no drone sends its surveys again
    with closing(Database(path, FAST)) as store:
        check_kept(store, is_whole=True)


def closed(store: Database) -> Path:
    store.close()
    return store.path


def spoiled(path: Path, change: str) -> Database:
    """Change a store as a disk does, which knows no trigger, and open it."""
    with closing(sqlite3.connect(path)) as opened, opened:
        triggers = opened.execute("SELECT name, sql FROM sqlite_master WHERE type = 'trigger'").fetchall()
        for name, _ in triggers:
            opened.execute(f"DROP TRIGGER {name}")
        opened.execute(change)
        for _, sql in triggers:
            opened.execute(sql)
    return Database(path, FAST)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    with closing(Database(tmp_path_factory.mktemp("two") / "lots.db", FAST)) as store, store.writing() as connection:
        for number in (1, 2):
            save(connection, later(survey(seed=number), number, 24.0 * number), by_place)
        away = save(connection, later(survey(seed=3), 3, 72.0), by_place).survey
        commands.move(connection, away, {"lot": None, "name": "East"}, WHO, BEGAN, by_place)
    return store.path


@pytest.fixture
def two(made: Path, tmp_path: Path) -> Iterator[Database]:
    """A store with two surveys of its first lot, and one survey of another lot."""
    opened = Database(Path(shutil.copy(made, tmp_path)), FAST)
    yield opened
    opened.close()


def by_name(store: Database) -> dict[str, str]:
    """Return the ids of the lots of `two` by their names."""
    with store.reading() as connection:
        found = {str(row.name): str(row.id) for row in connection.execute(select(LOT.c.name, LOT.c.id))}
    return {name: found[name] for name in ("Lot 1", "East")}


def kept_in(store: Database) -> set[str]:
    with store.reading() as connection:
        return {str(row.lot) for row in connection.execute(last_surveys._KEPT, among(lots_of(store)))}


@pytest.mark.parametrize(
    "change",
    [
        "UPDATE last_survey SET free = free + 1",
        "UPDATE last_survey SET taken_at = 'abc'",
        "DELETE FROM last_survey",
        "UPDATE last_survey SET lot = substr(lot, 2)",
        "DELETE FROM digest WHERE part = 'last'",
        "UPDATE digest SET digest = X'' WHERE part = 'last'",
    ],
)
def test_a_damaged_newest_survey_is_made_again_without_a_word(two: Database, change: str, tmp_path: Path) -> None:
    first, east = by_name(two).values()
    with closing(spoiled(closed(two), change)) as opened:
        assert (opened.damage, opened.notice, opened.damaged) == ("", "", ())
        assert kept_in(opened) == set()  # passed over
        assert [shown(opened, lot) for lot in (first, east)] == [(2, 2), (3, 1)]
        assert backup(opened.path, tmp_path / "copy.db") == ""
        assert verify(tmp_path / "copy.db").endswith("whole, lots 2, surveys 3")
        with opened.writing():
            pass
        check_kept(opened, is_whole=True)
        restore(opened.path, tmp_path / "copy.db")  # into the file that is open
        with opened.writing():
            pass
        check_kept(opened, is_whole=True)
    with closing(Database(two.path, FAST)) as again:
        assert again.stale == frozenset()
        check_kept(again, is_whole=True)


def test_a_row_that_a_search_beside_finds_is_made_again_by_the_next_transaction(two: Database) -> None:
    spoiled(closed(two), "UPDATE last_survey SET free = free + 1").close()
    with closing(Database(two.path, FAST, patience_s=0.0)) as opened:
        assert opened.is_searched.wait(30)
        assert (len(opened.stale), opened.has_more_newest, opened.notice) == (2, True, "")
        check_kept(opened)
        with opened.writing():
            pass
        check_kept(opened, is_whole=True)


@pytest.mark.parametrize(
    ("change", "damage", "newest_one", "kept"),
    [
        ("UPDATE survey SET ended = ended + 1 WHERE seq = 2", "survey", (1, 1), {"East"}),
        ("DELETE FROM survey WHERE seq = 2", "survey", (1, 1), {"East"}),
        ("UPDATE survey SET lot = {east} WHERE seq = 2", "survey", (1, 1), set()),
        ("UPDATE survey SET lot = CAST(X'FFFE' AS TEXT) WHERE seq = 2", "survey", (1, 1), {"East"}),
        ("UPDATE outbox SET body = 'x' WHERE seq = 1", "message", (2, 2), {"East", "Lot 1"}),
        ("UPDATE stall SET label = 'Z' WHERE lot = {east}", "lot", (2, 2), {"Lot 1"}),
    ],
)
def test_what_is_damaged_stops_the_newest_surveys_of_its_lot_alone(
    two: Database, change: str, damage: str, newest_one: tuple[int, int], kept: set[str]
) -> None:
    lot, east = by_name(two).values()
    names = {lot: "Lot 1", east: "East"}
    with closing(spoiled(closed(two), change.format(east=f"'{east}'"))) as opened:
        assert f"passed over: {damage}" in opened.damage
        assert {names[each] for each in kept_in(opened)} == kept
        assert shown(opened, lot) == newest_one
        with opened.writing() as connection:
            commands.rename(connection, lot, "Yard", WHO, BEGAN)
        assert shown(opened, lot) == newest_one
        with opened.writing() as connection:
            connection.exec_driver_sql("UPDATE survey SET free = free WHERE lot IN (SELECT id FROM lot)")
        names_kept = {names[each] for each in kept_in(opened)}
        assert names_kept >= kept
        assert shown(opened, lot) == newest_one
        with opened.reading() as connection:
            assert not last_surveys.has_more(connection)
