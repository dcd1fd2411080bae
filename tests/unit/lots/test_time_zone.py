from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import update

from hawk.lots import commands, lists, time_zone
from hawk.lots.ingest import make_lot, save
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import LOT
from hawk.lots.time_zone import zone_of_lot
from hawk.lots.values import LotInputError
from hawk.stats.period import period_of_lot
from tests.unit.lots.surveys import survey

PLACES = {
    "America/Toronto": (43.65, -79.38), "Asia/Kolkata": (28.61, 77.21), "Australia/Lord_Howe": (-31.55, 159.08),
    "America/St_Johns": (47.56, -52.71), "Europe/Amsterdam": (52.37, 4.9),
}  # fmt: skip


@pytest.fixture
def store(tmp_path: Path) -> Any:
    opened = Database(tmp_path / "lots.db")
    yield opened
    opened.close()


def lot_of(store: Database) -> str:
    with store.writing() as connection:
        lot = save(connection, survey(stalls=6)).lot
    assert lot is not None
    return lot


@pytest.mark.slow
@pytest.mark.parametrize(("name", "place"), PLACES.items())
def test_a_lot_has_the_time_zone_of_its_place(store: Database, name: str, place: tuple[float, float]) -> None:
    time_zone._learn(PLACES.values())
    assert time_zone._known()[place] == name


def test_the_map_of_time_zones_is_read_once_for_all_lots_and_again_for_new_places_alone(
    store: Database, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[list[list[float]]] = []

    def reader(*_: Any, **given: Any) -> Any:
        asked.append(json.loads(given["input"]))
        return subprocess.CompletedProcess((), 0, json.dumps(["Asia/Kolkata"] * len(asked[-1])))

    monkeypatch.setattr(subprocess, "run", reader)
    time_zone._known.cache_clear()
    made = []
    for number in range(3):
        with store.writing() as connection:
            made.append(make_lot(connection, survey(stalls=6), 1))
            connection.execute(update(LOT).where(LOT.c.id == made[-1]).values(latitude=10.0 + number))
            if number:
                assert {zone_of_lot(connection, each) for each in made} == {"Asia/Kolkata"}
    time_zone._known.cache_clear()
    assert asked == [[[10.0, 5.0], [11.0, 5.0]], [[12.0, 5.0]]]


@pytest.mark.slow
def test_a_person_corrects_it_and_an_undo_brings_that_of_the_place_back(store: Database) -> None:
    lot = lot_of(store)
    with store.writing() as connection:
        assert lists.lot(connection, lot).time_zone == "Europe/Amsterdam"
        done = commands.choose_time_zone(connection, lot, "America/Toronto", "Ann", 1.0)
        assert (done.kind, lists.lot(connection, lot).time_zone) == ("time_zone", "America/Toronto")
        commands.choose_time_zone(connection, lot, None, "Ann", 2.0)
        assert zone_of_lot(connection, lot) == "Europe/Amsterdam"
        again = commands.choose_time_zone(connection, lot, "Etc/UTC", "Ann", 3.0)
        assert zone_of_lot(connection, lot) == "UTC"
        commands.undo(connection, again.seq, 4.0)
        assert zone_of_lot(connection, lot) == "Europe/Amsterdam"


@pytest.mark.slow
def test_a_name_that_this_computer_does_not_know_is_that_of_the_place(store: Database) -> None:
    lot = lot_of(store)
    with store.writing() as connection:
        connection.execute(update(LOT).values(time_zone="Mars/Olympus"))
    with store.reading() as connection:
        assert lists.lot(connection, lot).time_zone == "Europe/Amsterdam"
        assert period_of_lot(connection, lot, "2026-05-04").begin is not None


@pytest.mark.parametrize("name", ["Mars/Olympus", "", "../UTC", "localtime", "Factory", "Europe", "CET+1", 5])
def test_a_name_that_is_none_is_refused_with_field_and_remedy(store: Database, name: object) -> None:
    lot = lot_of(store)
    with store.writing() as connection, pytest.raises(LotInputError) as refused:
        commands.choose_time_zone(connection, lot, name, "Ann", 1.0)
    assert refused.value.field == "time_zone"
    assert "must be a name of the time zone database, as Europe/Amsterdam or UTC" in refused.value.reason
    with store.reading() as connection:
        assert zone_of_lot(connection, lot) == "Europe/Amsterdam"


@pytest.mark.parametrize("damage", [OSError("no room"), subprocess.CalledProcessError(1, "python")])
def test_without_the_map_of_time_zones_times_are_utc_and_a_warning_says_so_once(
    store: Database, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, damage: Exception
) -> None:
    def fails(*_: Any, **__: Any) -> Any:
        raise damage

    lot = lot_of(store)
    with store.writing() as connection:
        connection.execute(update(LOT).values(latitude=52.0 + len(str(damage)) / 1e4))
    monkeypatch.setattr(subprocess, "run", fails)
    with store.reading() as connection:
        assert {zone_of_lot(connection, lot) for _ in range(3)} == {"UTC"}
    assert [each.message.partition(":")[0] for each in caplog.records] == [
        "the time zones of lots are not known by their places, times are UTC"
    ]
