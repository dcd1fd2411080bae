"""A round through the whole state machine: lots are asked for and ended, and a low battery brings the drone home."""

from __future__ import annotations

import pytest

from hawk.comm.protocol.commands import AutonomousExplore, SurveyAgain
from hawk.ddc.fence.geometry import ring_from_map
from hawk.model.known_lot import LotAhead, LotsAhead
from hawk.model.operation import StateName
from hawk.model.plans import ExploreStatus, LotLook, Outline, PathPlan
from hawk.model.poses import MapPoint
from tests.unit.ddc.fakes import Rig

BOTH = SurveyAgain(lots=["n", "s"])


def lots_at(rig: Rig, *norths: float) -> LotsAhead:
    datum = rig.service.datum
    assert datum is not None
    found = []
    for (name, title), north in zip((("n", "North"), ("s", "South")), norths, strict=True):
        ring = ring_from_map(datum, ((north, 0.0), (north + 15.0, 0.0), (north + 15.0, 15.0), (north, 15.0)))
        found.append(LotAhead(name, title, 20, 10.0, Outline((ring,))))
    return LotsAhead(tuple(found), tour_m=120.0)


def plan(rig: Rig, *looks: LotLook, path_m: float = 0.0, done: bool = False) -> None:
    target = None if done else MapPoint(10.0, 5.0)
    explore = ExploreStatus(done, 1.0 if done else 0.5, lots=looks, path_m=path_m)
    rig.sight.plan = PathPlan(target, 35.0, 0.0, explore=explore)


@pytest.fixture
async def exploring(rig: Rig) -> Rig:
    await rig.enter(StateName.HOVER)
    rig.inputs.lots.publish(lots_at(rig, -20.0, 20.0))
    await rig.tick()
    rig.order(BOTH)
    await rig.tick()
    plan(rig, LotLook("n", 0.2), LotLook("s", 0.0))
    rig.order(AutonomousExplore())
    await rig.run(1.0)
    rig.expect(StateName.AUTONOMOUS_EXPLORE)
    return rig


async def test_each_lot_of_a_round_is_ended_and_shown_and_explore_ends_with_the_last(exploring: Rig) -> None:
    rig = exploring
    assert [lot.name for lot in rig.shown.site.again_lots] == ["North", "South"]
    assert "2 lots are surveyed again in one flight: 40 stalls. North, South" in rig.log
    plan(rig, LotLook("n", 1.0, is_over=True), LotLook("s", 0.0))
    await rig.run(1.0)
    assert [lot.is_over for lot in rig.shown.site.again_lots] == [True, False]
    assert rig.log.count("North: every stall of the plan was looked at.") == 1
    plan(rig, LotLook("n", 1.0, is_over=True), LotLook("s", 1.0, is_over=True), done=True)
    await rig.until(StateName.HOVER)
    assert any("every stall in the plans of 2 lots was looked at" in text for text in rig.log)
    await rig.run(0.5)
    assert [lot.is_over for lot in rig.shown.site.again_lots] == [True, True]


async def test_with_too_little_battery_for_the_path_to_the_next_lot_it_returns_home(exploring: Rig) -> None:
    rig = exploring
    plan(rig, LotLook("n", 1.0, is_over=True), LotLook("s", 0.0), path_m=5_000.0)
    await rig.tick(2)
    assert rig.state is StateName.RETURN_TO_LAUNCH
    assert any("The battery does not last for the 5000 m to the next lot and back." in text for text in rig.log)
    await rig.run(0.5)
    assert [lot.is_over for lot in rig.shown.site.again_lots] == [True, False]
    outline = rig.manager.outlines.outline
    assert outline is not None
    rig.manager.outlines.begin_survey()
    assert [lot.is_first for lot in (rig.manager.outlines.outline or Outline()).lots] == [False, True]


@pytest.mark.parametrize(
    ("norths", "words"),
    [
        ((-20.0, 9_000.0), "nothing of South lies inside the fence"),
        ((-20.0, -12.0), "North and South overlap by 105 m²"),
    ],
)
async def test_a_round_that_is_not_safe_is_refused_and_the_outline_stays(
    rig: Rig, norths: tuple[float, float], words: str
) -> None:
    await rig.enter(StateName.HOVER)
    rig.inputs.lots.publish(lots_at(rig, *norths))
    await rig.tick()
    answer = rig.command(BOTH)
    assert not answer.accepted
    assert words in answer.reason
    assert rig.manager.outlines.outline is None


async def test_a_round_is_not_changed_while_it_is_flown(exploring: Rig) -> None:
    rig = exploring
    before = rig.manager.outlines.outline
    answer = rig.command(SurveyAgain(lots=["s"]))
    assert not answer.accepted
    assert rig.manager.outlines.outline == before
