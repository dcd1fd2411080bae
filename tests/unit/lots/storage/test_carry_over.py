"""A restore opens no link again that was taken back, and brings nothing back that was erased."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from sqlalchemy import Connection, select, update

from hawk.cli import main
from hawk.lots import commands, shares
from hawk.lots.documents import arrival_log
from hawk.lots.documents.arrival import Arrival, ArrivalKind, Outcome
from hawk.lots.ingest import save
from hawk.lots.storage.backup import restore
from hawk.lots.storage.damage_search import damaged_parts
from hawk.lots.storage.database import Database
from hawk.lots.storage.erasure import erased_id
from hawk.lots.storage.schema import SHARE, SURVEY
from hawk.model.poses import GlobalPose
from tests.unit.lots import whole
from tests.unit.lots.surveys import BEGAN, box, later, survey

NOW = BEGAN + 60.0
FAR = GlobalPose(52.05, 5.0, 0.0)
FOLDER = "var"


class Kept:
    """A store of two lots, two surveys of the first, with links to it, and a backup of all of it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder / FOLDER
        self.folder.mkdir()
        self.path, self.copy = self.folder / "lots.db", folder / "copy.db"
        far = replace(
            later(survey(stalls=6), 3),
            datum=FAR,
            outline=box(-20, -3, 40, 50, FAR),
            seen_ground=box(-20, -3, 40, 50, FAR),
        )
        store = Database(self.path)
        with store.writing() as connection:
            self.surveys = [
                save(connection, each).survey for each in (survey(stalls=6), later(survey(stalls=6), 2), far)
            ]
            self.lot, self.other = (lot["id"] for lot in whole.lots(connection))
            commands.rename(connection, self.lot, "North", "operator", BEGAN)
            made = [shares.share(connection, self.lot, {"days": days}, BEGAN) for days in (3, 30)]
            self.links = [link.id for link in made]
            self.tokens = [link.token for link in made]
        store.close()
        shutil.copy(self.path, self.copy)

    def change(self, does: Callable[..., object]) -> None:
        store = Database(self.path)
        with store.writing() as connection:
            does(connection)
        store.close()

    def hawk(self, *command: str) -> int:
        return main([command[0], *command[1:], "--store", str(self.folder)])

    def opened_by(self) -> list[bool]:
        """Return which links open the lot."""
        store = Database(self.path)
        with store.reading() as connection:
            found = [shares.lot_of(connection, token, NOW) == self.lot for token in self.tokens]
        store.close()
        return found

    def there(self) -> set[str]:
        """Return the ids of lots and surveys; nothing of the store may be damaged, or lie beside it."""
        with closing(sqlite3.connect(self.path)) as store:
            assert damaged_parts(store) == ()
            assert store.execute("PRAGMA foreign_key_check").fetchall() == []
            return {each for (each,) in store.execute("SELECT id FROM lot UNION SELECT id FROM survey")}


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> Kept:
    return Kept(tmp_path_factory.mktemp("first"))


@pytest.fixture
def kept(first: Kept, tmp_path: Path) -> Kept:
    found = Kept.__new__(Kept)
    found.__dict__ |= first.__dict__
    found.folder, found.copy = tmp_path / FOLDER, tmp_path / "copy.db"
    found.path = found.folder / "lots.db"
    shutil.copytree(first.folder, found.folder)
    shutil.copy(first.copy, found.copy)
    return found


@pytest.mark.slow
@pytest.mark.fault(
    "a backup is restored in which a link is open that was taken back since",
    "the link stays closed, and it is said",
)
def test_a_link_that_was_taken_back_stays_so(kept: Kept, capsys: pytest.CaptureFixture[str]) -> None:
    assert kept.opened_by() == [True, True]
    kept.change(lambda c: shares.take_back(c, kept.links[0], NOW))
    assert kept.hawk("restore", str(kept.copy)) == 0
    assert kept.opened_by() == [False, True]
    said = capsys.readouterr().out
    assert "Links taken back: 0" not in said


def test_what_came_since_the_backup_stays_in_the_log_of_arrivals(kept: Kept) -> None:
    def came(name: str) -> Callable[[Connection], None]:
        arrived = Arrival("Drone 1", ArrivalKind.SURVEY, name, Outcome.REFUSED, reason="no document")
        return lambda connection: arrival_log.note(connection, arrived, NOW)

    kept.change(came("before"))
    shutil.copy(kept.path, kept.copy)
    for name in ("since", "last"):
        kept.change(came(name))
    restore(kept.path, kept.copy, NOW)
    kept.change(came("after"))
    store = Database(kept.path)
    with store.reading() as connection:
        found = [(each.seq, each.name) for each in arrival_log.listed(connection, whole.ALL).items]
    store.close()
    assert found == [(4, "after"), (3, "last"), (2, "since"), (1, "before")]


def test_a_link_ends_no_later_than_before(kept: Kept) -> None:
    kept.change(lambda c: c.execute(update(SHARE).where(SHARE.c.id == kept.links[1]).values(ends=NOW - 1)))
    restore(kept.path, kept.copy, NOW)
    assert kept.opened_by() == [True, False]


@pytest.mark.parametrize("before", ["none", "empty", "damaged", "cut"])
def test_where_the_store_before_says_nothing_of_a_link_it_is_taken_back(
    kept: Kept, before: str, capsys: pytest.CaptureFixture[str]
) -> None:
    kept.path.unlink()
    if before == "empty":
        Database(kept.path).close()
    elif before == "damaged":
        kept.path.write_bytes(b"no store" * 100)
    elif before == "cut":
        kept.path.write_bytes(kept.copy.read_bytes()[:9000])
    notes = restore(kept.path, kept.copy, NOW).notes
    assert kept.opened_by() == [False, False]
    (words,) = notes
    with closing(sqlite3.connect(kept.path)) as store:
        assert store.execute("SELECT DISTINCT taken_back FROM share").fetchall() == [(NOW,)]
    assert words.startswith("Links taken back: 2; ")
    assert words.endswith("Make new ones")


@pytest.mark.slow
@pytest.mark.fault(
    "a backup is restored that holds what was erased since",
    "it is erased again, of this backup and of every later one",
)
def test_a_survey_that_was_erased_stays_so(kept: Kept, capsys: pytest.CaptureFixture[str]) -> None:
    assert kept.hawk("erase", "--survey", kept.surveys[1], "--yes") == 0
    left = kept.there()
    for _ in range(2):  # the restored store knows it as well
        assert kept.hawk("restore", str(kept.copy)) == 0
        assert "Erased again, as before this restore: lots 0, surveys 1" in capsys.readouterr().out
        assert kept.there() == left == {kept.lot, kept.other, kept.surveys[0], kept.surveys[2]}
        assert kept.surveys[1].encode() not in kept.path.read_bytes()
    assert kept.opened_by() == [True, True]


@pytest.mark.nightly
def test_a_lot_that_was_erased_stays_so_with_its_links(kept: Kept) -> None:
    assert kept.hawk("erase", "--lot", "North", "--yes") == 0
    assert kept.hawk("restore", str(kept.copy)) == 0
    assert kept.there() == {kept.other, kept.surveys[2]}
    assert kept.opened_by() == [False, False]
    assert kept.lot.encode() not in kept.path.read_bytes()


@pytest.mark.slow
def test_everything_that_was_erased_stays_so(kept: Kept) -> None:
    assert kept.hawk("erase", "--everything", "--yes") == 0
    assert kept.hawk("restore", str(kept.copy)) == 0
    assert kept.there() == set()
    kept.change(lambda c: save(c, later(survey(stalls=6), 9)))
    assert len(kept.there()) == 2


def test_what_was_erased_is_known_over_a_damaged_store(kept: Kept) -> None:
    assert kept.hawk("erase", "--survey", kept.surveys[1], "--yes") == 0
    data = bytearray(kept.path.read_bytes())
    data[data.index(b"CREATE TABLE share")] ^= 1
    kept.path.write_bytes(data)
    assert kept.hawk("restore", str(kept.copy)) == 0
    assert kept.surveys[1] not in kept.there()


@pytest.mark.nightly
def test_a_survey_that_was_moved_before_its_lot_was_erased_is_kept(kept: Kept) -> None:
    kept.change(lambda c: commands.move(c, kept.surveys[1], {"lot": kept.other}, "operator", NOW, None))
    assert kept.hawk("erase", "--lot", "North", "--yes") == 0
    assert kept.hawk("restore", str(kept.copy)) == 0
    assert kept.there() == {kept.other, kept.surveys[1], kept.surveys[2]}
    store = Database(kept.path)
    with store.reading() as connection:
        assert [each["id"] for each in whole.surveys(connection) if each["placed"] == "undecided"] == [kept.surveys[1]]
        assert connection.execute(select(SURVEY.c.lot).where(SURVEY.c.id == kept.surveys[1])).scalar() is None
    store.close()


@pytest.mark.nightly
def test_a_lot_that_was_erased_with_one_that_was_merged_into_it_stays_so(kept: Kept) -> None:
    kept.change(lambda c: commands.merge(c, kept.lot, kept.other, "operator", NOW))
    merged = kept.copy.with_name("merged.db")
    shutil.copy(kept.path, merged)
    assert kept.hawk("erase", "--lot", "North", "--yes") == 0
    for each in (merged, kept.copy):
        assert kept.hawk("restore", str(each)) == 0
        assert kept.there() == set()


def test_of_an_id_that_was_erased_a_hash_is_kept(kept: Kept) -> None:
    assert kept.hawk("erase", "--survey", kept.surveys[1], "--yes") == 0
    with closing(sqlite3.connect(kept.path)) as store:
        assert store.execute("SELECT id FROM erased").fetchall() == [(erased_id(kept.surveys[1]),)]
