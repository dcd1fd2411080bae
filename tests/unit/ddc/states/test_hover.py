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


@pytest.mark.nightly
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


@pytest.mark.nightly
async def test_explore_follows_the_plan_with_its_height_and_yaw(flying: Rig) -> None:
    flying.target_plan(25, -10, height=40)
    flying.order(AutonomousExplore())
    await flying.run(12)
    flying.expect(S.AUTONOMOUS_EXPLORE)
    place = flying.autopilot
    assert (place.north, place.east, place.height) == pytest.approx((25, -10, 40), abs=0.2)
    assert flying.autopilot.targets[-1].yaw == 0.5
    assert flying.detail.endswith("% seen of the lot found so far.")


@pytest.mark.nightly
async def test_explore_is_no_faster_than_vision_reads_and_says_so_once(flying: Rig) -> None:
    flying.sight.plan = PathPlan(MapPoint(60, 0), 35.0, 0.0, speed=1.0)
    flying.order(AutonomousExplore())
    await flying.run(4)
    begun = flying.autopilot.north
    await flying.run(5)
    assert flying.autopilot.north - begun == pytest.approx(5.0, abs=0.5)
    assert sum("Slower, at 1.0 m/s" in text for text in flying.log) == 1


@pytest.mark.nightly
async def test_a_plan_outside_the_fence_is_not_flown(flying: Rig) -> None:
    flying.order(AutonomousExplore())
    await flying.tick()
    before = len(flying.autopilot.targets)
    flying.target_plan(300.0, 0.0)
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
