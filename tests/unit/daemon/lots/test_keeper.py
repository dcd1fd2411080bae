from __future__ import annotations

import asyncio
import sqlite3
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, closing
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
from sqlalchemy import Connection, select

from hawk.daemon.lots.keeper import KeeperTimes, LotKeeper, find_stalls
from hawk.lots.storage.backup import restore
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import SURVEY, VERSION
from hawk.lots.store import LotStore
from hawk.lots.survey.landing import LandingFacts
from hawk.lots.values import Doubtful, LotStoreError, Registration
from hawk.model.plans import ExploreStatus, LotLook, Outline, PathPlan
from tests.unit.comm.waiting import until
from tests.unit.lots.survey.test_landing import STALL, landed, lot_map
from tests.unit.lots.survey.test_round_share import NAMES, at, round_of
from tests.unit.lots.surveys import box

ROWS = ((4.0, 7), (9.0, 4), (4.0, 5))
"""East of the first stall of each row, metres, and how many there are."""
TIMES = KeeperTimes(settle_s=0.0, retry_s=0.01)


class Flown:
    """A drone's survey, its store and its messages."""

    def __init__(self, path: Path, *, is_restored: bool = False) -> None:
        self.survey: LandingFacts | None = landed(lot_map({1: STALL}))
        self.messages: list[tuple[str, str, str]] = []
        self.store = LotStore(path)
        self.asked = 0
        self.heard_at_store: list[int] = []
        self.keeper = LotKeeper(
            self.store, self.landed, self.add, TIMES, is_restored=is_restored,
            stored=lambda: self.heard_at_store.append(len(self.messages)),
        )  # fmt: skip

    def landed(self) -> LandingFacts | None:
        self.asked += 1
        return self.survey

    def add(self, level: str, text: str, details: str) -> None:
        self.messages.append((level, text, details))

    def fly(self, name: str, outline: Outline) -> None:
        self.keeper.note(armed=True)
        self.survey = replace(landed(lot_map({1: STALL})), name=name, outline=outline)
        self.keeper.note(armed=False)

    async def stored(self) -> list[str]:
        def names(connection: Connection) -> list[str]:
            return [row.split()[0] for row in connection.execute(select(SURVEY.c.origin)).scalars()]

        return await self.store.read(names)


@asynccontextmanager
async def flown(
    path: Path, change: Callable[[Flown], object] = bool, *, is_restored: bool = False
) -> AsyncIterator[Flown]:
    drone = Flown(path, is_restored=is_restored)
    change(drone)
    task = asyncio.create_task(drone.keeper.run())
    yield drone
    task.cancel()
    await asyncio.gather(task, return_exceptions=True)
    await drone.store.close()


def has_more_than(messages: list[tuple[str, str, str]], count: int) -> bool:
    return len(messages) > count


async def test_each_landing_is_a_save_and_a_message(tmp_path: Path) -> None:
    async with flown(tmp_path / "lots.db") as drone:
        drone.fly("1", box(0, 0, 40, 100))
        await until(lambda: len(drone.messages) == 1)
        drone.fly("2", box(0, 0, 40, 100))
        await until(lambda: len(drone.messages) == 2)
        drone.fly("3", box(0, 120, 40, 100))
        await until(lambda: len(drone.messages) == 3)
        assert await drone.stored() == ["1", "2", "3"]
    assert [text for _, text, _ in drone.messages] == [
        "The survey is stored as the first one of Lot 1.",
        "The survey is stored as one of Lot 1.",
        "Which lot is it? The survey is stored without one.",
    ]
    assert drone.heard_at_store == [0, 1, 2], "the flight knows the lot before the operator hears of it"
    assert drone.messages[2][2] == "1 lots may be meant: choose one under Lots."


@pytest.mark.slow
async def test_a_message_says_how_many_stalls_are_known_ones_or_what_is_in_doubt(tmp_path: Path) -> None:
    places = [(-4.0 - 8.0 * row, begin + 2.5 * k) for row, (begin, count) in enumerate(ROWS) for k in range(count)]
    stalls = {n: replace(STALL, id=n, north=north, east=east) for n, (north, east) in enumerate(places, 1)}
    async with flown(tmp_path / "lots.db") as drone:
        drone.store.register = find_stalls
        for found in (stalls, stalls, {1: STALL}):
            known = len(drone.messages)
            drone.keeper.note(armed=True)
            drone.survey = replace(landed(lot_map(found)), name=str(known))
            drone.keeper.note(armed=False)
            await until(partial(has_more_than, drone.messages, known))
    assert drone.messages[1:] == [
        ("info", "The survey is stored as one of Lot 1.", "16 of 16 stalls are known ones."),
        (
            "warning",
            "The survey is stored as one of Lot 1.",
            "Not certain where it lies on Lot 1: too few stalls are on ground that both saw.",
        ),
    ]


@pytest.mark.timeout(60)
async def test_a_second_landing_before_the_map_is_back_stops_no_other_task(tmp_path: Path) -> None:
    def has_no_map(drone: Flown) -> None:
        drone.survey = None

    async with flown(tmp_path / "lots.db", has_no_map, is_restored=True) as drone:
        drone.keeper.note(armed=False)
        await until(lambda: drone.asked > 0)
        drone.keeper.note(armed=True)
        drone.keeper.note(armed=False)
        seen = drone.asked
        await until(lambda: drone.asked > seen)
        drone.survey = landed(lot_map({1: STALL}))
        await until(lambda: len(drone.messages) == 1)
        assert len(await drone.stored()) == 1


async def test_nothing_is_saved_in_flight_and_no_backup_is_restored_then(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    async with flown(path) as drone:
        drone.keeper.note(armed=True)
        await asyncio.sleep(0)
        assert await drone.keeper.keep()
        assert await drone.stored() == []
        with pytest.raises(LotStoreError, match="a survey is flown"):
            restore(path, path)
        drone.keeper.note(armed=False)
        await until(lambda: len(drone.messages) == 1)


async def test_a_survey_that_was_saved_is_not_saved_again_until_its_map_changes(tmp_path: Path) -> None:
    async with flown(tmp_path / "lots.db") as drone:
        assert await drone.keeper.keep()
        assert await drone.keeper.keep()
        assert len(drone.messages) == 1
        assert drone.survey is not None
        drone.survey = replace(drone.survey, current=replace(drone.survey.current, version=6))
        assert await drone.keeper.keep()
        assert len(drone.messages) == 2
        assert await drone.stored() == ["000001-x"]


@pytest.mark.slow
@pytest.mark.fault(
    "a survey cannot be stored after its landing",
    "one message with the remedy; tried again until it is stored",
)
async def test_a_save_that_fails_is_one_message_with_its_remedy_and_is_tried_again(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    path.write_bytes(b"no store" * 100)
    async with flown(path) as drone:
        drone.keeper.note(armed=True)
        drone.keeper.note(armed=False)
        await until(lambda: len(drone.messages) == 1)
        await asyncio.sleep(0.1)  # some tries
        ((level, text, details),) = drone.messages
        assert (level, text) == ("error", "The survey is not in the store of lots; its map and files are whole.")
        assert str(path) in details
        assert "hawk-drone restore FILE" in details
        path.unlink()
        await until(lambda: len(drone.messages) == 2)
        assert await drone.stored() == ["000001-x"]


async def test_the_map_of_a_run_that_ended_in_the_air_is_saved_once_it_is_there(tmp_path: Path) -> None:
    def without_map(drone: Flown) -> None:
        drone.survey = None

    async with flown(tmp_path / "lots.db", without_map, is_restored=True) as drone:
        drone.keeper.note(armed=False)
        await asyncio.sleep(0.05)
        drone.survey = landed(lot_map({1: STALL}))
        await until(lambda: len(drone.messages) == 1)
        assert await drone.stored() == ["000001-x"]


async def test_a_start_in_the_air_opens_the_store_after_the_landing(tmp_path: Path) -> None:
    path = tmp_path / "lots.db"
    async with flown(path, lambda drone: drone.keeper.note(armed=True)) as drone:
        await asyncio.sleep(0.1)
        assert drone.messages == []
        assert "lots.db" not in {each.name for each in tmp_path.iterdir()}  # noqa: ASYNC240
        drone.keeper.note(armed=False)
        await until(lambda: len(drone.messages) == 1)
        assert await drone.stored() == ["000001-x"]


async def test_a_store_of_a_newer_version_is_said_at_the_start(tmp_path: Path) -> None:
    Database(tmp_path / "lots.db").close()
    with closing(sqlite3.connect(tmp_path / "lots.db")) as newer:
        newer.execute(f"PRAGMA user_version = {VERSION + 1}")
    async with flown(tmp_path / "lots.db") as drone:
        await until(lambda: len(drone.messages) == 1)
    assert drone.messages[0][:2] == ("warning", "The store of lots.")
    assert f"is of version {VERSION + 1}, of a newer hawk-drone" in drone.messages[0][2]


def over(*lots: str) -> PathPlan:
    return PathPlan(explore=ExploreStatus(lots=tuple(LotLook(lot, 1.0, lot in lots) for lot in NAMES)))


def ended(flown: LandingFacts, *lots: str) -> LandingFacts:
    assert flown.outline is not None
    marked = tuple(replace(lot, is_over=lot.id in lots) for lot in flown.outline.lots)
    return replace(flown, outline=replace(flown.outline, lots=marked))


async def test_a_lot_of_a_round_is_stored_in_flight_once_it_is_over_and_the_others_at_the_landing(
    tmp_path: Path,
) -> None:
    async with flown(tmp_path / "lots.db") as drone:
        await until(lambda: drone.store.is_open)
        drone.keeper.note(armed=True)
        drone.survey = round_of(at(1, 10.0), at(2, 40.0))
        drone.keeper.note_plan(over())
        assert await drone.keeper.keep()
        assert await drone.stored() == []
        drone.survey = ended(drone.survey, "west")
        drone.keeper.note_plan(over("west"))
        await until(lambda: len(drone.messages) == 1)
        assert await drone.stored() == ["000001-x@west"]
        drone.survey = replace(drone.survey, current=replace(drone.survey.current, version=6))
        drone.keeper.note(armed=False)
        await until(lambda: len(drone.messages) == 3)
        assert sorted(await drone.stored()) == ["000001-x@east", "000001-x@west"]
    assert drone.messages[1:] == [
        ("info", "The survey is stored as the first one of Lot 2.", ""),
        (
            "warning",
            "Not finished: East.",
            "Fly on, or survey them again: they are first then.",
        ),
    ]


async def test_a_lot_that_the_round_has_not_begun_gets_no_survey_of_the_stalls_beyond_another_one(
    tmp_path: Path,
) -> None:
    async with flown(tmp_path / "lots.db") as drone:
        await until(lambda: drone.store.is_open)
        drone.keeper.note(armed=True)
        drone.survey = round_of(at(1, 10.0), at(2, 40.0))
        drone.keeper.note_plan(looks(0.4, 0.0))
        drone.keeper.note_plan(PathPlan())  # the path home explores nothing
        drone.keeper.note(armed=False)
        await until(lambda: len(drone.messages) == 2)
        assert await drone.stored() == ["000001-x@west"]
    assert drone.messages[1][1] == "Not finished: West, East."


def looks(west: float, east: float) -> PathPlan:
    return PathPlan(explore=ExploreStatus(lots=(LotLook("west", west), LotLook("east", east))))


async def test_a_lot_that_an_earlier_flight_has_begun_is_stored_though_this_one_has_not(tmp_path: Path) -> None:
    async with flown(tmp_path / "lots.db") as drone:
        await until(lambda: drone.store.is_open)
        drone.keeper.note(armed=True)
        drone.keeper.note_plan(looks(0.6, 0.5))
        drone.survey = None  # its save failed
        drone.keeper.note(armed=False)
        drone.keeper.note(armed=True)
        drone.keeper.note_plan(looks(0.7, 0.0))
        drone.survey = round_of(at(1, 10.0), at(2, 40.0))
        drone.keeper.note(armed=False)
        await until(lambda: len(drone.messages) == 3)
        assert sorted(await drone.stored()) == ["000001-x@east", "000001-x@west"]


async def test_a_lot_that_a_flight_without_a_round_has_seen_is_stored(tmp_path: Path) -> None:
    async with flown(tmp_path / "lots.db") as drone:
        await until(lambda: drone.store.is_open)
        drone.keeper.note(armed=True)
        drone.keeper.note_plan(looks(0.6, 0.0))
        drone.keeper.note(armed=False)
        drone.keeper.note(armed=True)  # by hand over the other lot
        drone.survey = round_of(at(1, 10.0), at(2, 40.0))
        drone.keeper.note(armed=False)
        await until(lambda: len(drone.messages) == 3)
        assert sorted(await drone.stored()) == ["000001-x@east", "000001-x@west"]


async def test_after_a_start_in_the_air_each_lot_of_a_round_is_stored(tmp_path: Path) -> None:
    async with flown(tmp_path / "lots.db", is_restored=True) as drone:
        drone.keeper.note(armed=True)
        drone.survey = round_of(at(1, 10.0), at(2, 40.0))
        drone.keeper.note_plan(looks(0.6, 0.0))
        drone.keeper.note(armed=False)
        await until(lambda: len(drone.messages) == 3)
        assert sorted(await drone.stored()) == ["000001-x@east", "000001-x@west"]


async def test_after_a_battery_swap_the_rest_of_a_round_replaces_what_was_stored_of_it(tmp_path: Path) -> None:
    async with flown(tmp_path / "lots.db") as drone:
        for version, lots in ((5, ("west",)), (6, ("west", "east"))):
            drone.keeper.note(armed=True)
            whole = ended(round_of(at(1, 10.0), at(2, 40.0)), *lots)
            drone.survey = replace(whole, current=replace(whole.current, version=version))
            drone.keeper.note(armed=False)
            await until(lambda: not drone.keeper.is_armed and drone.heard_at_store != [])
            assert await drone.keeper.keep()
        assert sorted(await drone.stored()) == ["000001-x@east", "000001-x@west"]
    assert [text for _, text, _ in drone.messages].count("Not finished: East.") == 1


async def test_a_lot_of_a_round_whose_place_was_in_doubt_is_stored_again_at_the_landing(tmp_path: Path) -> None:
    outcomes: list[Registration | Doubtful] = [Doubtful("two places fit alike"), Registration(0.0, 0.0, 0.0, {})]
    both = ended(round_of(at(1, 10.0), at(2, 40.0)), "west")
    async with flown(tmp_path / "lots.db") as drone:
        drone.survey = both
        drone.keeper.note(armed=False)
        await until(lambda: len(drone.messages) == 2)
        drone.store.register = lambda *_: outcomes.pop(0) if outcomes else Registration(0.0, 0.0, 0.0, {})
        drone.keeper.note(armed=True)
        drone.survey = replace(both, name="000002-x")
        drone.keeper.note_plan(over("west"))
        await until(lambda: len(drone.messages) == 3)
        assert "two places fit alike" in drone.messages[2][2]
        drone.survey = replace(drone.survey, current=replace(both.current, version=6))
        drone.keeper.note(armed=False)
        await until(lambda: drone.messages[-1][1] == "Not finished: East.")
    west, east = drone.messages[3:5]
    assert west == ("info", "The survey is stored as one of Lot 1.", "0 of 1 stalls are known ones.")
    assert east[1] == "The survey is stored as one of Lot 2."


async def test_no_lot_is_stored_in_flight_where_the_store_is_not_open(tmp_path: Path) -> None:
    drone = Flown(tmp_path / "lots.db")
    drone.keeper.note(armed=True)
    drone.survey = ended(round_of(at(1, 10.0), at(2, 40.0)), "west")
    assert await drone.keeper.keep()
    assert not drone.store.is_open
    await drone.store.close()
