"""A day's plan of a store: lots that are due, their tours, and names of the schedule that no lot has."""

from __future__ import annotations

import shutil
from collections.abc import AsyncIterator, Mapping
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError
from sqlalchemy import update

from hawk.config.sections import Config
from hawk.daemon.lots.day_flights import DayDrone, DayPlanner, drone_of
from hawk.daemon.lots.schedule import Timetable
from hawk.lots import commands, known_lot, names
from hawk.lots.documents.lot_document import LotDue
from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.storage.schema import STALL
from hawk.lots.store import LotStore
from hawk.model.day_plan import DayPlanError, Forecast, WeatherHour
from hawk.model.poses import GlobalPose
from tests.unit.lots.surveys import BEGAN, DATUM, box, later, survey

DUE = datetime.fromtimestamp(BEGAN, UTC).replace(hour=11, minute=0) + timedelta(days=1)
FAR = GlobalPose(DATUM.latitude + 0.002, DATUM.longitude, 0.0)
"""222 m north of the first lot."""


def config(*lots: str, **sections: Mapping[str, Any]) -> Config:
    entries = [{"lot": lot, "at": "11:00", "time_zone": "UTC"} for lot in lots]
    return Config.model_validate({"schedule": entries, **sections})


def forecast(gust: float = 5.0) -> Forecast:
    begin = DUE.timestamp() - 3600.0
    return Forecast(DUE.timestamp() - 7200.0, (WeatherHour(begin, begin + 36_000.0, gust / 2, gust, 0.1, 0.0),))


class Day:
    """A planner over a store with Lot 1 and Lot 2, of 40 and 20 stalls, an hour before their surveys are due."""

    def __init__(self, store: LotStore) -> None:
        self.store = store
        self.drone = drone_of(Config())
        self.timetable: Timetable | None = None

    async def plan(self, of: Config, batteries: int = 3, given: Forecast | None = None) -> Any:
        planner = DayPlanner(
            self.store, of, self.timetable or Timetable(of.schedule), self._drone, lambda: DUE.timestamp() - 3600.0
        )
        try:
            return await planner.plan(given or forecast(), batteries)
        finally:
            planner.close()

    def _drone(self) -> DayDrone:
        return self.drone


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    store = Database(tmp_path_factory.mktemp("day") / "lots.db")
    away = replace(later(survey(stalls=20), 4, hours=0.0), datum=FAR, outline=box(-5, -3, 9, 54, FAR))
    with store.writing() as connection:
        save(connection, survey())
    with store.writing() as connection:
        near = save(connection, replace(away, seen_ground=box(-13, -15, 27, 78, FAR)))
    with store.writing() as connection:
        commands.move(connection, near.survey, {"lot": None, "name": "Lot 2"}, "Ann", BEGAN, None)
    store.close()
    return store.path


@pytest.fixture
async def day(made: Path, tmp_path: Path) -> AsyncIterator[Day]:
    store = LotStore(Path(shutil.copy(made, tmp_path)))
    yield Day(store)
    await store.close()


async def test_lots_that_are_due_together_are_one_round_with_its_tour_and_batteries(day: Day) -> None:
    plan = await day.plan(config("Lot 1", "Lot 2"))
    (one,) = plan.rounds
    assert {name for _, name in one.lots} == {"Lot 1", "Lot 2"}
    assert (one.start, one.due, plan.problems, one.batteries) == (DUE, DUE, (), 1)
    assert 200.0 < one.distance_m < 900.0
    assert one.end == DUE + timedelta(seconds=one.seconds)
    assert one.seconds > one.distance_m / Config().flight.speed_m_s
    (alone,) = (await day.plan(config("Lot 1"))).rounds
    assert alone.distance_m < one.distance_m


async def test_a_drone_that_stands_near_begins_its_round_there(day: Day) -> None:
    (before,) = (await day.plan(config("Lot 1"))).rounds
    day.drone = replace(day.drone, here=replace(DATUM, latitude=DATUM.latitude - 0.001))
    (near,) = (await day.plan(config("Lot 1"))).rounds
    assert near.distance_m > before.distance_m + 80.0
    day.drone = replace(day.drone, here=replace(DATUM, latitude=DATUM.latitude - 1.0))
    assert (await day.plan(config("Lot 1"))).rounds == (before,)


async def test_the_wind_limit_is_that_of_the_settings_and_few_batteries_propose_nothing(day: Day) -> None:
    gusts = forecast(gust=6.5)
    (calm,) = (await day.plan(config("Lot 1"), given=gusts)).rounds
    (strong,) = (await day.plan(config("Lot 1", flight={"maximum_wind_m_s": 6.0}), given=gusts)).rounds
    assert (calm.start, strong.start) == (DUE, None)
    worn = replace(day.drone.battery, drain=2.0)
    day.drone = replace(day.drone, battery=worn)
    (short,) = (await day.plan(config("Lot 1"), batteries=1)).rounds
    assert (short.start, "batteries; left: 1." in short.problem) == (None, True)


async def test_in_flight_nothing_is_planned(day: Day) -> None:
    day.drone = replace(day.drone, is_flying=True)
    with pytest.raises(DayPlanError, match="plan the day after its landing"):
        await day.plan(config("Lot 1"))


async def test_a_name_of_the_schedule_that_no_lot_has_is_said_with_those_that_there_are(day: Day) -> None:
    plan = await day.plan(config("Lot 1", "Nort"))
    assert [each.start for each in plan.rounds] == [DUE]
    assert plan.problems == ("schedule: no lot has the name or id Nort: write one of Lot 1, Lot 2.",)


async def test_a_name_of_the_schedule_that_two_lots_have_is_said_with_their_ids(day: Day) -> None:
    lots = [await day.store.read(partial(names.lot_named, given=f"Lot {number}")) for number in (1, 2)]
    await day.store.write(partial(commands.rename, lot_id=lots[1], name="Lot 1", who="Ada", now=1.8e9))
    plan = await day.plan(config("Lot 1"))
    (said,) = plan.problems
    assert plan.rounds == (), "nobody knows which lot is meant"
    assert said == f"schedule: more than one lot is called Lot 1: write the id of one: {', '.join(sorted(lots))}."
    assert (await day.plan(config(*lots))).problems == ()
    (said,) = (await day.plan(config("Nort"))).problems
    assert said == f"schedule: no lot has the name or id Nort: write one of {', '.join(sorted(lots))}."


async def test_space_around_a_name_of_the_schedule_means_nothing(day: Day) -> None:
    plan = await day.plan(config(" Lot  1 "))
    assert (len(plan.rounds), plan.problems) == (1, ())
    with pytest.raises(ValidationError, match="at least 1 character"):
        config("  ")


async def test_without_a_schedule_the_plan_says_what_to_write(day: Day) -> None:
    plan = await day.plan(Config())
    assert (plan.rounds, plan.problems) == ((), ("The settings have no [[schedule]]: write one for each lot.",))


async def test_a_lot_without_stalls_has_no_flight(day: Day) -> None:
    await day.store.write(lambda connection: connection.execute(update(STALL).values(ends=1)))
    plan = await day.plan(config("Lot 1"))
    assert [(each.start, each.problem) for each in plan.rounds] == [
        (None, "Lot 1 has no stalls: survey it first, or draw them in its plan.")
    ]


async def test_what_is_due_at_the_desk_is_in_the_rounds_of_the_day(day: Day) -> None:
    lot = (await day.store.read(lambda connection: known_lot.newest_survey(connection, "Lot 2")) or ("",))[0]
    day.timetable = Timetable(config("Lot 1").schedule, has_desk=True)
    day.timetable.take([LotDue(lot=lot, last=None, moments=(DUE.timestamp(), DUE.timestamp() + 30 * 86_400.0))])
    (one,) = (await day.plan(config())).rounds
    assert {name for _, name in one.lots} == {"Lot 1", "Lot 2"}
