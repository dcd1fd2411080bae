from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sqlalchemy import Connection, func, select, text

from hawk.lots.storage.backup import restore
from hawk.lots.storage.schema import LAST_SURVEY, LOT, OUTBOX, SURVEY
from hawk.lots.storage.states import KINDS
from hawk.lots.store import MOST_READS, READS, LotStore, lots_file
from hawk.lots.survey import last_surveys
from hawk.lots.survey.landing import LandingFacts
from hawk.lots.survey.pictures import pictures_of
from hawk.lots.values import LotStoreError, Placed, StoreBusyError
from hawk.model.lot_map import TILE_CELLS, EncodedTile, OccupancyMap
from hawk.model.tile_picture import encode_picture
from tests.unit.comm.waiting import until
from tests.unit.lots.survey.test_landing import STALL, landed, lot_map
from tests.unit.lots.survey.test_last_surveys import columns, make_version_8, spoiled


def a_survey() -> LandingFacts:
    return landed(lot_map({1: STALL}))


def names(connection: Connection) -> list[str]:
    return [row.split()[0] for row in connection.execute(select(SURVEY.c.origin)).scalars()]


async def test_a_survey_is_saved_on_a_thread_of_the_store_and_read_on_others(tmp_path: Path) -> None:
    store = LotStore(tmp_path / "lots.db")
    assert await store.open() == ""
    saved = await store.save(a_survey())
    assert (saved.placed, saved.lot_name) == (Placed.FIRST, "Lot 1")
    assert await store.read(names) == ["000001-x"]
    threads = {await store.read(lambda _: threading.current_thread().name) for _ in range(3)}
    threads |= {await store.write(lambda _: threading.current_thread().name) for _ in range(3)}
    assert threads - {"lots-read_0", "lots-read_1"} == {"lots_0"}
    await store.close()


async def test_a_store_that_was_opened_keeps_the_newest_surveys_that_an_upgrade_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = LotStore(tmp_path / "lots.db")
    await first.save(a_survey())
    for number in range(5):
        copied = f"INSERT INTO lot SELECT 'lot {number}', {columns(LOT)} FROM lot LIMIT 1"  # noqa: S608
        await first.write(lambda connection, copied=copied: connection.execute(text(copied)))  # type: ignore[misc]
    await first.close()
    make_version_8(first.path)
    monkeypatch.setattr(last_surveys, "_CHANGED", last_surveys._CHANGED.limit(2))
    monkeypatch.setattr(last_surveys, "_AT_ONCE", 1)
    store = LotStore(first.path)
    assert "was of version 8" in await store.open()
    missing, left = select(func.count() - func.count(LAST_SURVEY.c.stalls)), 6
    while left:  # the store itself goes on: nothing is written beside
        was, left = left, int(await store.read(lambda c: c.execute(missing).scalar_one()))
        assert left <= was
    await store.close()


async def test_a_store_that_was_opened_makes_a_damaged_newest_survey_again(tmp_path: Path) -> None:
    first = LotStore(tmp_path / "lots.db")
    await first.save(a_survey())
    kept = select(LAST_SURVEY.c.free)
    free = await first.read(lambda c: c.execute(kept).scalar_one())
    await first.close()
    spoiled(first.path, "UPDATE last_survey SET free = free + 1").close()
    store = LotStore(first.path)
    assert await store.open() == ""
    found = None
    while found is None:  # passed over until then
        found = await store.read(lambda c: c.execute(kept).scalar())
    assert found == free
    await store.close()


async def test_reports_of_an_old_survey_are_dated_when_it_is_stored(tmp_path: Path) -> None:
    store = LotStore(tmp_path / "lots.db", wall=lambda: 5e9)
    await store.save(a_survey())
    assert set(
        await store.read(lambda c: c.execute(select(OUTBOX.c.made).where(OUTBOX.c.kind.not_in(KINDS))).scalars().all())
    ) == {5e9}
    await store.close()


async def test_the_loop_goes_on_while_the_store_works(tmp_path: Path) -> None:
    store = LotStore(tmp_path / "lots.db")
    await store.open()
    begun = threading.Event()
    held = threading.Event()

    def slow(connection: Connection) -> list[str]:
        begun.set()
        held.wait(10)
        return names(connection)

    reading = asyncio.create_task(store.read(slow))
    await until(begun.is_set)
    assert not reading.done()
    held.set()
    assert await reading == []
    await store.close()


ENDLESS = text("WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT count(*) FROM n")
READING_S = 3.0
"""Longer than all that is done meanwhile, on a computer with other work."""


def endless(begun: threading.Event) -> Callable[[Connection], object]:
    def read(connection: Connection) -> object:
        names(connection)  # from here on it has a view of its own, which saves may not change
        begun.set()
        return connection.execute(ENDLESS).scalar()

    return read


@pytest.mark.slow
@pytest.mark.fault(
    "a read of the lots would take minutes",
    "it is ended at its deadline, in words; a save meanwhile waits for nothing",
)
async def test_a_read_without_end_is_ended_and_a_save_meanwhile_waits_for_nothing(tmp_path: Path) -> None:
    store = LotStore(tmp_path / "lots.db")
    await store.save(a_survey())
    begun, began = threading.Event(), time.monotonic()
    reading = asyncio.create_task(store.read(endless(begun), READING_S))
    await until(begun.is_set)
    await store.save(replace(a_survey(), name="000002-x", utc=1.9e9))
    assert await store.read(names) == ["000001-x", "000002-x"]
    assert not reading.done()
    assert store.path.with_name("lots.db-wal").stat().st_size > 0  # the reader still needs its view
    with pytest.raises(StoreBusyError, match="needs too long for this: ask for a shorter period"):
        await reading
    assert time.monotonic() - began < 2 * READING_S
    await until(lambda: store.path.with_name("lots.db-wal").stat().st_size == 0)
    await store.close()
    assert not store.path.with_name("lots.db-wal").exists()


@pytest.mark.parametrize("end", ["the store is closed", "nobody waits for it"])
async def test_a_long_read_ends_with_those_who_wait_for_it(tmp_path: Path, end: str) -> None:
    store = LotStore(tmp_path / "lots.db")
    await store.open()
    begun, began = threading.Event(), time.monotonic()
    reading = asyncio.create_task(store.read(endless(begun), 60.0))
    await until(begun.is_set)
    if end == "nobody waits for it":
        reading.cancel()
        await asyncio.wait([reading])
    await store.close()
    await asyncio.wait([reading])
    assert reading.cancelled() or isinstance(reading.exception(), StoreBusyError)
    assert time.monotonic() - began < 10
    with pytest.raises(LotStoreError, match="the store is closed"):
        await store.read(names)


@pytest.mark.slow
async def test_too_many_reads_are_refused_and_a_save_is_not(tmp_path: Path) -> None:
    store = LotStore(tmp_path / "lots.db")
    await store.open()
    held = threading.Event()
    many = [asyncio.create_task(store.read(lambda _: held.wait(30))) for _ in range(MOST_READS)]
    await asyncio.sleep(0)
    with pytest.raises(StoreBusyError, match="is busy: ask again in some seconds"):
        await store.read(names)
    await store.save(a_survey())
    held.set()
    assert await asyncio.gather(*many) == [True] * MOST_READS
    assert await store.read(names) == ["000001-x"]
    await store.close()


@pytest.mark.slow
async def test_a_read_that_waited_too_long_for_others_is_refused(tmp_path: Path) -> None:
    store = LotStore(tmp_path / "lots.db")
    await store.open()
    held = threading.Event()
    many = [asyncio.create_task(store.read(lambda _: held.wait(30))) for _ in range(READS)]
    late = asyncio.create_task(store.read(names, 0.0))
    await asyncio.sleep(0)
    held.set()
    with pytest.raises(StoreBusyError, match="is busy"):
        await late
    await asyncio.gather(*many)
    await store.close()


@pytest.mark.slow
@pytest.mark.fault(
    "the store of lots is damaged while a daemon runs",
    "a message with the remedy; the restored store is used without a new start",
)
async def test_a_store_that_could_not_be_opened_is_opened_once_it_was_restored(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    other = LotStore(tmp_path / "copy.db")
    await other.save(a_survey())
    await other.close()
    path.write_bytes(b"x" * 200)
    store = LotStore(path)
    for call in (store.open(), store.save(a_survey()), store.read(names)):
        with pytest.raises(LotStoreError, match="hawk-drone restore FILE"):
            await call
    restore(path, tmp_path / "copy.db")
    assert await store.read(names) == ["000001-x"]
    await store.close()


@pytest.mark.slow
async def test_a_store_whose_file_was_replaced_is_opened_again(tmp_path: Path) -> None:
    store, other = LotStore(tmp_path / "lots.db"), LotStore(tmp_path / "copy.db")
    await store.open()
    await other.save(a_survey())
    await other.close()
    (tmp_path / "copy.db").replace(tmp_path / "lots.db")
    assert await store.read(names) == ["000001-x"]
    await store.close()


@pytest.mark.slow
async def test_no_backup_is_restored_while_a_survey_is_flown(tmp_path: Path) -> None:
    store = LotStore(tmp_path / "lots.db")
    await store.save(a_survey())
    (tmp_path / "copy.db").write_bytes((tmp_path / "lots.db").read_bytes())
    await store.fly(is_flown=True)
    with pytest.raises(LotStoreError, match="a survey is flown"):
        restore(tmp_path / "lots.db", tmp_path / "copy.db")
    await store.fly(is_flown=False)
    restore(tmp_path / "lots.db", tmp_path / "copy.db")
    await store.close()


async def test_a_lock_that_cannot_be_taken_stops_no_flight(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    store = LotStore(tmp_path / "none" / "lots.db")
    await store.fly(is_flown=True)
    assert "Restore no backup while a survey is flown" in caplog.text
    await store.close()


def test_the_end_of_a_store_that_was_never_opened_opens_nothing(tmp_path: Path) -> None:
    asyncio.run(LotStore(tmp_path / "lots.db").close())
    assert list(tmp_path.iterdir()) == []


def test_the_settings_name_another_file(tmp_path: Path) -> None:
    assert lots_file(tmp_path) == tmp_path / "lots.db"
    assert lots_file(tmp_path, tmp_path / "all.db") == tmp_path / "all.db"


@pytest.mark.slow
async def test_the_picture_of_a_survey_is_kept_beside_the_store(tmp_path: Path) -> None:
    store = LotStore(tmp_path / "lots.db")
    saved = await store.save(replace(a_survey(), current=with_picture()))
    assert pictures_of(store.path).surveys() == {saved.survey}
    await store.close()


async def test_a_picture_that_cannot_be_kept_loses_no_survey(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "lots-pictures").write_text("a file in the place of the folder")
    store = LotStore(tmp_path / "lots.db")
    await store.save(replace(a_survey(), current=with_picture()))
    assert await store.read(names) == ["000001-x"]
    assert "the picture of the survey is not kept" in caplog.text
    await store.close()


def with_picture() -> OccupancyMap:
    seen = np.full((TILE_CELLS, TILE_CELLS), 255, np.uint8)
    tile = EncodedTile(1, encode_picture(np.zeros((TILE_CELLS, TILE_CELLS, 3), np.uint8), seen))
    return replace(lot_map({1: STALL}), mosaic={(0, 0): tile})
