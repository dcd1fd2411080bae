"""The battery that a survey needs: before take-off, in flight, over a restart."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator, Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from hawk.comm.protocol.commands import Arm, AutonomousExplore
from hawk.comm.protocol.heartbeat import VehicleStatus
from hawk.ddc.battery.energy import ASSUMED_DRAIN, SAFETY_FACTOR, seconds_home
from hawk.ddc.battery.survey import (
    Battery,
    SurveyNeed,
    Sweep,
    check_words,
    need_in_flight,
    need_on_ground,
)
from hawk.ddc.rules.notices import SHORT_CONFIRM_S, SurveyNotices
from hawk.ddc.settings import SurveyMemory
from hawk.model.lot_map import OccupancyMap
from hawk.model.operation import FlightDrain, StateName, SurveyLeft
from hawk.model.plans import ExploreStatus, PathPlan
from hawk.model.poses import MapPoint
from tests.unit.ddc.fakes import UTC_START, Rig
from tests.unit.ddc.written_facts import flying as flying_facts
from tests.unit.ddc.written_facts import on_ground

FULL = Battery(96.0, 20.0, 0.1, True)
SWEEP = Sweep.of(4.0, 35.0, 1.4)
MEASURED = ((3_000.0, 72.0, 31.0), (10_000.0, 296.0, 100.0), (30_000.0, 788.0, 257.0))
"""Area, distance and seconds of the planner over the benchmark's lots (means over lots 1-28)."""
MODEL_BEGIN_S = 8.0
"""Seconds beside the distance in those flights."""


@pytest.mark.parametrize(("area", "distance", "seconds"), MEASURED)
def test_distance_and_time_are_those_that_the_planner_was_measured_to_need(
    area: float, distance: float, seconds: float
) -> None:
    assert SWEEP.distance(area) == pytest.approx(distance, rel=0.13)
    assert SWEEP.seconds(distance, begins=False) + MODEL_BEGIN_S == pytest.approx(seconds, rel=0.05)


def test_lower_and_slower_takes_longer() -> None:
    low = Sweep.of(4.0, 25.0, 1.4)
    assert low.distance(5_000.0) == pytest.approx(SWEEP.distance(5_000.0) * 35 / 25)
    assert replace(SWEEP, speed=2.0).seconds(300.0) > 1.5 * SWEEP.seconds(300.0)
    assert SWEEP.seconds(0.0) == 0.0


def test_before_take_off_it_is_climb_survey_and_the_flight_home_with_the_reserve() -> None:
    need = need_on_ground("map", 10_000.0, 300.0, SWEEP, (35.0, 60.0), FULL)
    assert need.percent == pytest.approx(0.1 * (35 / 2 + SWEEP.seconds(300.0)))
    assert need.home == pytest.approx(20.0 + SAFETY_FACTOR * 0.1 * seconds_home(71.0, 35.0, 60.0, 4.0))
    assert need.left == pytest.approx(96.0 - need.home - need.percent)
    assert need.is_enough
    assert need.share == 1.0


def test_what_does_not_suffice_is_reported_as_a_share() -> None:
    need = need_in_flight("planner", 10_000.0, 800.0, SWEEP, 30.0, replace(FULL, charge=43.0))
    assert not need.is_enough
    assert need.percent == pytest.approx(0.1 * SWEEP.seconds(800.0, begins=False))
    assert need.share == pytest.approx(13.0 / need.percent)
    assert replace(need, charge=25.0).share == 0.0
    assert replace(need, charge=25.0, percent=0.0).share == 1.0  # nothing is left of it, though home is dear
    whole = replace(need, flown_s=need.seconds)
    assert whole.whole_share == pytest.approx(0.5 + need.share / 2)


def test_the_check_says_how_far_the_battery_lasts() -> None:
    enough = SurveyNeed("map", 8_000.0, 300.0, 41.0, 22.0, 96.0)
    assert check_words(enough) == "enough for the rest of the survey: survey 41 %, home 22 %, charge 96 %"
    short = replace(enough, percent=100.0, charge=85.0)
    assert check_words(short).startswith(
        "enough for about 60 % of the rest: continue after a battery swap; survey 100 %"
    )
    unknown = replace(enough, basis="fence", area=71_000.0, is_measured=False)
    assert check_words(unknown).startswith("enough, even for a lot as large as the fence (7.1 ha): survey 41 %")
    assert check_words(unknown).endswith("drain assumed, no flight has measured it")
    assert check_words(replace(unknown, charge=40.0)).startswith("enough for about 40 % of a lot as large as the fence")
    assert check_words(replace(enough, seconds=0.0, percent=0.0)).startswith("nothing is left of the survey")


# -- before take-off --------------------------------------------------------------------------------------------------

Make = Callable[..., Rig]


@pytest.fixture
async def make(tmp_path: Path) -> AsyncIterator[Make]:
    made: list[Rig] = []

    def make_it(**options: Any) -> Rig:
        made.append(Rig(tmp_path, **options))
        return made[-1]

    yield make_it
    for rig in made:
        await rig.close()


def vehicle(rig: Rig) -> VehicleStatus:
    """Return the drone's last word on its battery."""
    status = rig.manager.status.value
    assert status is not None
    return status.vehicle


def charge(rig: Rig, percent: float) -> None:
    """Take some percent out of the battery."""
    assert rig.autopilot.battery is not None
    rig.autopilot.battery -= percent


async def looked(rig: Rig, lot_area: float = 0.0) -> Rig:
    await rig.run(2.0)
    rig.inputs.occupancy_map.publish(OccupancyMap(lot_area_m2=lot_area))
    await rig.run(1.5)
    return rig


async def checked(rig: Rig) -> str:
    found = [item for item in rig.manager.situation().checks if item.name == "Survey"]
    assert [item.passed for item in found] == [True]
    return found[0].value


async def test_an_unknown_lot_is_at_most_as_large_as_the_fence(make: Make) -> None:
    rig = await looked(make())
    assert "of a lot as large as the fence (6.6 ha)" in await checked(rig)
    reported = vehicle(rig)
    assert reported.survey_basis == "fence"
    assert reported.battery_needed_survey is not None
    assert reported.battery_needed_home is not None
    assert reported.battery_left == pytest.approx(95.0 - reported.battery_needed_home - reported.battery_needed_survey)


async def test_a_battery_that_is_too_low_for_the_survey_refuses_nothing(make: Make) -> None:
    rig = make()
    rig.autopilot.battery = 40.0
    await looked(rig)
    assert "battery swap" in await checked(rig) or "of a lot as large" in await checked(rig)
    assert rig.command(Arm()).accepted


async def test_what_is_not_known_is_not_reported(make: Make) -> None:
    rig = make()
    rig.autopilot.battery = None
    await looked(rig)
    assert all(item.name != "Survey" for item in rig.manager.situation().checks)
    assert vehicle(rig).battery_needed_survey is None
    assert not rig.command(Arm()).accepted


LEFT = SurveyLeft(seen=0.9, lot_area=5_000.0, remaining_m=120.0, flown_s=60.0)


async def test_the_rest_of_an_earlier_survey_counts(make: Make) -> None:
    rig = await looked(make(continues_survey=True, memory=SurveyMemory(left=LEFT)), 5_000.0)
    assert (await checked(rig)).startswith("enough for the rest of the survey")
    assert vehicle(rig).survey_basis == "map"


async def test_an_earlier_map_without_a_word_on_the_rest_is_flown_again_at_most(make: Make) -> None:
    rig = await looked(make(continues_survey=True), 5_000.0)
    whole = vehicle(rig).battery_needed_survey
    seconds = SWEEP.seconds(SWEEP.distance(5_000.0)) + 35 / 2
    assert whole == pytest.approx(seconds * ASSUMED_DRAIN, rel=0.02)


@pytest.mark.nightly
async def test_the_worst_drain_of_the_last_flights_is_used(make: Make) -> None:
    drains = tuple(FlightDrain(drain, 300.0, UTC_START - 600) for drain in (0.06, 0.09))
    first = await looked(make(continues_survey=True, memory=SurveyMemory(left=LEFT)), 5_000.0)
    second = await looked(make(continues_survey=True, memory=SurveyMemory(left=LEFT, drains=drains)), 5_000.0)
    assumed, measured = (vehicle(rig).battery_needed_survey for rig in (first, second))
    assert assumed is not None
    assert measured == pytest.approx(assumed * 0.09 / ASSUMED_DRAIN)
    assert "drain assumed" in await checked(first)
    assert "drain assumed" not in await checked(second)


@pytest.mark.nightly
async def test_it_is_reported_once_that_an_earlier_survey_goes_on(make: Make) -> None:
    rig = await looked(make(continues_survey=True, memory=SurveyMemory(left=LEFT)), 5_000.0)
    await rig.run(5)
    assert sum(text.startswith("An earlier survey goes on") for text in rig.log) == 1
    assert not any(text.startswith("An earlier survey") for text in (await looked(make(), 5_000.0)).log)


# -- in flight --------------------------------------------------------------------------------------------------------


def exploring(remaining: float, north: float = 60.0) -> PathPlan:
    return PathPlan(MapPoint(north, 0.0), 35.0, 0.0, explore=ExploreStatus(seen=0.8, remaining_m=remaining))


@pytest.mark.nightly
async def test_in_flight_the_planners_distance_counts_and_what_is_left_is_journalled(make: Make) -> None:
    kept: list[SurveyLeft] = []
    rig = make(memory=SurveyMemory(keep_left=kept.append))
    await rig.enter(StateName.HOVER)
    rig.sight.plan = exploring(200.0)
    rig.order(AutonomousExplore())
    await rig.run(6)
    reported = vehicle(rig)
    assert reported.survey_basis == "planner"
    reserve = rig.manager.situation().facts.battery.reserve
    assert reserve is not None
    assert reported.battery_needed_home == pytest.approx(reserve.needed, abs=0.5)
    assert reported.battery_needed_survey == pytest.approx(SWEEP.seconds(200.0, begins=False) * ASSUMED_DRAIN, rel=0.05)
    assert kept[-1].remaining_m == 200.0
    assert kept[-1].seen == 0.8
    assert 2.0 < kept[-1].flown_s < 7.0


async def short(rig: Rig, seconds: float) -> int:
    """Explore with a battery that empties while the planner has far to go; return the number of warnings."""
    rig.autopilot.battery = 60.0
    await rig.enter(StateName.HOVER)
    rig.sight.plan = exploring(1_500.0)
    rig.order(AutonomousExplore())
    for second in range(round(seconds)):
        rig.sight.plan = exploring(1_500.0, 60.0 if second % 20 < 10 else -60.0)
        charge(rig, 0.1)
        await rig.run(1)
    return sum("The battery will not last for the whole survey: about" in text for text in rig.log)


@pytest.mark.nightly
async def test_a_battery_that_will_not_last_is_reported_once_and_it_explores_on(make: Make) -> None:
    rig = make()
    assert await short(rig, 60) == 1
    rig.expect(StateName.AUTONOMOUS_EXPLORE)


@pytest.mark.nightly
async def test_it_is_not_reported_before_it_is_certain(make: Make) -> None:
    assert await short(make(), 20) == 0  # the drain of this flight is not measured yet


def test_it_must_last_for_ten_seconds() -> None:
    need = SurveyNeed("planner", 5_000.0, 400.0, 60.0, 30.0, 60.0)
    facts = flying_facts(0.0)
    notice = SurveyNotices(continues_survey=False)

    class Exploring:
        identity = StateName.AUTONOMOUS_EXPLORE

    def reported(short_s: float | None) -> int:
        battery = replace(facts.battery, survey=need, short_s=short_s)
        return len(notice.tick(replace(facts, battery=battery), Exploring()))  # type: ignore[arg-type]

    assert [
        reported(None),
        reported(SHORT_CONFIRM_S - 0.1),
        reported(SHORT_CONFIRM_S),
        reported(SHORT_CONFIRM_S + 1),
    ] == [0, 0, 1, 0]
    notice.tick(on_ground(facts), Exploring())  # type: ignore[arg-type]
    assert reported(SHORT_CONFIRM_S) == 1


async def test_a_fault_in_the_estimate_keeps_no_fact_from_being_gathered(make: Make) -> None:
    raised: list[SurveyLeft] = []

    def full(left: SurveyLeft) -> None:
        raised.append(left)
        raise OSError("no room")

    rig = make(memory=SurveyMemory(keep_left=full))
    await rig.enter(StateName.HOVER)
    rig.sight.plan = exploring(200.0)
    rig.order(AutonomousExplore())
    await rig.run(5)
    rig.expect(StateName.AUTONOMOUS_EXPLORE)
    assert raised
    assert rig.manager.own_health.is_healthy
    assert vehicle(rig).battery_percentage is not None


@pytest.mark.parametrize("remaining", [math.nan, math.inf])
async def test_a_plan_without_a_finite_distance_says_nothing(make: Make, remaining: float) -> None:
    kept: list[SurveyLeft] = []
    rig = make(memory=SurveyMemory(keep_left=kept.append))
    await rig.enter(StateName.HOVER)
    rig.sight.plan = exploring(remaining)
    rig.order(AutonomousExplore())
    await rig.run(3)
    assert kept == []
    assert vehicle(rig).survey_basis == "fence"


@pytest.mark.slow
async def test_a_flight_journals_its_drain(make: Make) -> None:
    kept: list[tuple[FlightDrain, ...]] = []
    rig = make(memory=SurveyMemory(keep_drains=kept.append))
    await rig.enter(StateName.HOVER)
    for _ in range(120):
        charge(rig, 0.1)
        await rig.run(1)
    rig.autopilot.landed, rig.autopilot.armed = rig.autopilot.landed.ON_GROUND, False
    rig.autopilot.height = 0.0
    await rig.run(2)
    assert len(kept) == 1
    assert kept[0][-1].drain == pytest.approx(0.1, rel=0.1)
