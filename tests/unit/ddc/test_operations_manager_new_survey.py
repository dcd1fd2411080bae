"""New Survey: on the ground only. Map, datum and what the earlier survey left are forgotten; what is stored stays."""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from hawk.comm.protocol.commands import AutonomousExplore, NewSurvey
from hawk.comm.protocol.heartbeat import VehicleStatus
from hawk.ddc.settings import SurveyMemory
from hawk.model.lot_map import Counts, OccupancyMap
from hawk.model.operation import FlightDrain, StateName, SurveyLeft
from tests.unit.ddc.fakes import UTC_START, Rig

LEFT = SurveyLeft(seen=0.9, lot_area=5_000.0, remaining_m=120.0, flown_s=60.0)
DRAINS = (FlightDrain(drain=0.1, seconds=300.0, at=UTC_START - 600.0),)
AIRBORNE = sorted(set(StateName) - {StateName.IDLE, StateName.CONFIGURE, StateName.ARM})


def show_map(rig: Rig) -> None:
    rig.inputs.occupancy_map.publish(OccupancyMap(counts=Counts(3, 2, 1), lot_area_m2=900.0, map_id="earlier"))


def vehicle(rig: Rig) -> VehicleStatus:
    assert rig.manager.status.value is not None
    return rig.manager.status.value.vehicle


@pytest.fixture
async def earlier(tmp_path: Path) -> AsyncIterator[Rig]:
    """A rig whose program began with the map of an earlier survey."""
    rig = Rig(tmp_path, continues_survey=True, memory=SurveyMemory(left=LEFT, drains=DRAINS))
    show_map(rig)
    await rig.run(2.0)
    yield rig
    await rig.close()


async def test_on_the_ground_another_survey_begins(earlier: Rig) -> None:
    assert vehicle(earlier).survey_basis == "map"
    earlier.order(NewSurvey())
    earlier.inputs.occupancy_map.publish(OccupancyMap(map_id="another"))
    await earlier.run(2.0)
    assert earlier.surveys_begun == 1
    assert earlier.service.datum is None, "the next arm place becomes the datum"
    assert vehicle(earlier).survey_basis == "fence", "nothing is left of the earlier one"
    assert "A new survey begins." in earlier.log
    assert earlier.command(NewSurvey()).reason == "The map is empty: the next flight begins it."


async def test_the_drain_of_the_last_flights_stays(earlier: Rig) -> None:
    earlier.order(NewSurvey())
    await earlier.run(2.0)
    (check,) = [check for check in earlier.manager.situation().checks if check.name == "Survey"]
    assert "assumed" not in check.value


async def test_without_an_earlier_survey_there_is_nothing_to_forget(rig: Rig) -> None:
    assert rig.command(NewSurvey()).reason == "The map is empty: the next flight begins it."
    assert rig.surveys_begun == 0


@pytest.mark.parametrize("state", AIRBORNE)
async def test_in_the_air_the_map_is_not_changed(fresh: Rig, state: StateName) -> None:
    await fresh.enter(state)
    show_map(fresh)
    datum = fresh.service.datum
    answer = fresh.command(NewSurvey())
    assert not answer.accepted
    assert answer.reason in ("Flying: land first.", "Someone else flies: Resume first.")
    await fresh.tick(3)
    assert (fresh.surveys_begun, fresh.service.datum) == (0, datum)


async def test_armed_on_the_ground_it_is_refused(fresh: Rig) -> None:
    await fresh.enter(StateName.ARM)
    show_map(fresh)
    assert fresh.command(NewSurvey()).reason == "Armed: disarm first."
    assert fresh.surveys_begun == 0


async def test_it_needs_control(earlier: Rig) -> None:
    assert earlier.command(NewSurvey(), client="eve").reason == "Someone else has control."
    assert earlier.surveys_begun == 0


async def test_explore_then_flies_the_new_survey(fresh: Rig) -> None:
    show_map(fresh)
    await fresh.run(1.0)
    fresh.order(NewSurvey())
    fresh.inputs.occupancy_map.publish(OccupancyMap(map_id="another"))
    await fresh.enter(StateName.HOVER)
    assert fresh.service.datum is not None
    fresh.order(AutonomousExplore())
    await fresh.run(1.0)
    fresh.expect(StateName.AUTONOMOUS_EXPLORE)
