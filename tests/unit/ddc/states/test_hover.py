"""Acts and transitions of Hover and Autonomous Explore, unsafe ones refused."""

from __future__ import annotations

import re

import pytest

from hawk.comm.protocol.commands import (
    AutonomousExplore,
    CompulsiveMove,
    Hold,
)
from hawk.model.operation import StateName, UserError
from hawk.model.plans import ExploreStatus, PathPlan
from hawk.model.poses import MapPoint
from hawk.model.vehicle import CopterMode
from tests.unit.ddc.fakes import Rig

S = StateName


# -- Hover ------------------------------------------------------------------------------------------------------------


async def test_hold_aims_at_the_stopping_point(fresh: Rig) -> None:
    await fresh.enter(S.COMPULSIVE_MOVE)
    await fresh.run(4.0)
    north = fresh.autopilot.north
    fresh.order(Hold())
    await fresh.tick()
    target = fresh.autopilot.targets[-1]
    assert north + 3 < target.north < north + 8
    await fresh.run(3)
    assert fresh.autopilot.mode == CopterMode.GUIDED
    assert fresh.autopilot.north == pytest.approx(target.north, abs=0.1)


@pytest.mark.slow
async def test_a_stopping_point_beyond_the_fence_is_brought_inside(flying: Rig) -> None:
    flying.order(CompulsiveMove(x=144.5, y=0))
    while flying.autopilot.north < 140:
        await flying.tick()
    flying.autopilot.targets.clear()
    flying.order(Hold())
    await flying.run(3)
    assert {round(t.north, 1) for t in flying.autopilot.targets} == {144.5}


async def test_without_a_fresh_pose_it_brakes(fresh: Rig) -> None:
    await fresh.enter(S.COMPULSIVE_MOVE)
    fresh.autopilot.pose_flows = False
    await fresh.run(2.0)
    fresh.expect(S.HOVER)
    assert fresh.autopilot.mode == CopterMode.BRAKE
    assert "The position was lost. Holding." in fresh.log


async def test_guided_that_is_refused_again_and_again_ends_in_brake(fresh: Rig) -> None:
    await fresh.enter(S.RETURN_TO_LAUNCH)
    fresh.autopilot.refuse["set_mode"] = "no"
    fresh.order(Hold())
    await fresh.run(7.5)
    del fresh.autopilot.refuse["set_mode"]
    await fresh.run(3.0)
    assert CopterMode.BRAKE in fresh.autopilot.asked("set_mode")
    assert CopterMode.LOITER not in fresh.autopilot.asked("set_mode")
    fresh.expect(S.HOVER)


# -- Explore ----------------------------------------------------------------------------------------------------------


async def test_explore_without_a_lot_stays_in_hover_with_user_error_2(flying: Rig) -> None:
    flying.sight.lot = False
    await flying.tick()
    answer = flying.command(AutonomousExplore())
    assert not answer.accepted
    assert flying.manager.outcomes.user_error is UserError.NO_LOT_DETECTED
    flying.expect(S.HOVER)
    flying.order(Hold())
    assert flying.manager.outcomes.user_error_text == ""


@pytest.mark.slow
async def test_explore_follows_the_plan_with_its_height_and_yaw(flying: Rig) -> None:
    flying.target_plan(25, -10, height=40)
    flying.order(AutonomousExplore())
    await flying.run(12)
    flying.expect(S.AUTONOMOUS_EXPLORE)
    place = flying.autopilot
    assert (place.north, place.east, place.height) == pytest.approx((25, -10, 40), abs=0.2)
    assert flying.autopilot.targets[-1].yaw == 0.5
    assert flying.detail.endswith("% seen of the lot found so far.")


@pytest.mark.slow
@pytest.mark.parametrize(("height", "flown"), [(3, 15), (500, 60), (None, 35)])
async def test_the_plans_height_is_bounded(flying: Rig, height: float | None, flown: float) -> None:
    flying.target_plan(10, 0, height)
    flying.order(AutonomousExplore())
    await flying.run(9)
    flying.target_plan(20, 0, height)
    await flying.run(9)
    assert flying.autopilot.height == pytest.approx(flown, abs=0.2)


@pytest.mark.slow
async def test_explore_is_no_faster_than_vision_reads_and_says_so_once(flying: Rig) -> None:
    flying.sight.plan = PathPlan(MapPoint(60, 0), 35.0, 0.0, speed=1.0)
    flying.order(AutonomousExplore())
    await flying.run(4)
    begun = flying.autopilot.north
    await flying.run(5)
    assert flying.autopilot.north - begun == pytest.approx(5.0, abs=0.5)
    assert sum("Slower, at 1.0 m/s" in text for text in flying.log) == 1


@pytest.mark.slow
@pytest.mark.parametrize("speed", [None, 500.0, float("nan"), float("inf"), -3.0, 0.0])
async def test_no_plan_makes_the_drone_faster_than_travel_speed(flying: Rig, speed: float | None) -> None:
    flying.sight.plan = PathPlan(MapPoint(60, 0), 35.0, 0.0, speed=speed)
    flying.order(AutonomousExplore())
    await flying.run(4)
    begun, travel = flying.autopilot.north, flying.settings.flight.speed_m_s
    await flying.run(5)
    assert flying.autopilot.north - begun == pytest.approx(5 * travel, abs=0.5)
    assert not any("Slower" in text for text in flying.log)


@pytest.mark.slow
@pytest.mark.parametrize("place", [(float("nan"), 0.0), (0.0, float("inf")), (300.0, 0.0)])
async def test_a_plan_to_nowhere_or_outside_the_fence_is_not_flown(flying: Rig, place: tuple[float, float]) -> None:
    flying.order(AutonomousExplore())
    await flying.tick()
    before = len(flying.autopilot.targets)
    flying.target_plan(*place)
    await flying.run(9)
    assert len(flying.autopilot.targets) == before
    await flying.run(2)
    flying.expect(S.HOVER)
    assert any("No progress for 10 s" in text for text in flying.log)


async def test_explore_is_done_when_nothing_is_left(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    fresh.finish_plan()
    await fresh.run(1)
    fresh.expect(S.HOVER)
    assert re.fullmatch(
        r"Explored: the lot found is seen whole, 100 % of \d+ m²\. "
        r"Ground outside the fence was not looked at\. Holding\.",
        fresh.log[-1],
    )


async def test_a_done_of_before_the_state_began_does_not_count(flying: Rig) -> None:
    flying.finish_plan()
    await flying.tick()
    flying.order(AutonomousExplore())
    await flying.tick(2)
    flying.expect(S.AUTONOMOUS_EXPLORE)


@pytest.mark.slow
async def test_no_lot_in_sight_for_too_long_is_user_error_2(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    fresh.target_plan(100, 0)
    fresh.sight.lot = False
    await fresh.run(9.8)
    fresh.expect(S.AUTONOMOUS_EXPLORE)
    await fresh.run(0.5)
    fresh.expect(S.HOVER)
    assert fresh.manager.outcomes.user_error is UserError.NO_LOT_DETECTED


async def test_explored_without_a_lot_is_user_error_2(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    fresh.sight.plan = PathPlan(MapPoint(10, 0), 35.0, 0.0, explore=ExploreStatus(lot_known=False))
    await fresh.run(1)
    assert fresh.detail == "Looking for the lot."
    fresh.sight.plan = PathPlan(explore=ExploreStatus(done=True, lot_known=False))
    await fresh.run(1)
    fresh.expect(S.HOVER)
    assert fresh.manager.outcomes.user_error is UserError.NO_LOT_DETECTED
    assert fresh.manager.outcomes.user_error_text == "No lot was found here."


@pytest.mark.slow
async def test_explore_says_where_it_goes_next(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    fresh.target_plan(0, -40)
    await fresh.run(10)
    assert "Next: to the north, 40 m away." in fresh.log
    assert any(text.startswith("Next: to the west") or "south-west" in text for text in fresh.log)


async def test_a_plan_without_target_waits(fresh: Rig) -> None:
    await fresh.enter(S.HOVER)
    fresh.sight.plan = PathPlan(route=(MapPoint(1, 1),), explore=ExploreStatus(seen=0.1))
    fresh.order(AutonomousExplore())
    before = len(fresh.autopilot.targets)
    await fresh.run(5)
    fresh.expect(S.AUTONOMOUS_EXPLORE)
    assert len(fresh.autopilot.targets) == before
    await fresh.run(6)
    assert "No progress for 10 s. The planner gives no further path. Holding." in fresh.log
