"""Acts and transitions of the Moves, unsafe ones refused."""

from __future__ import annotations

import pytest

from hawk.comm.protocol.commands import (
    Ack,
    AutonomousMove,
    CompulsiveMove,
    Hold,
    ReturnToLaunch,
)
from hawk.ddc.fence.geometry import polygon_fence
from hawk.model.operation import StateName, UserError
from hawk.model.plans import Inbound
from tests.unit.ddc.fakes import Rig

S = StateName


@pytest.mark.nightly
async def test_a_relative_move_starts_where_the_drone_is_when_it_is_accepted(flying: Rig) -> None:
    flying.autopilot.north, flying.autopilot.east = 10, 20
    await flying.tick()
    flying.order(CompulsiveMove(x=15, y=-5))
    await flying.until(S.HOVER)
    await flying.run(3)
    assert (flying.autopilot.north, flying.autopilot.east) == pytest.approx((25, 15), abs=0.1)
    assert "There. Holding." in flying.log


@pytest.mark.nightly
async def test_a_map_move_goes_to_coordinates(flying: Rig) -> None:
    flying.autopilot.north, flying.autopilot.east = 10, 20
    await flying.tick()
    flying.order(CompulsiveMove(x=15, y=-5, frame="Map"))
    await flying.until(S.HOVER)
    await flying.run(3)
    assert (flying.autopilot.north, flying.autopilot.east) == pytest.approx((15, -5), abs=0.1)


@pytest.mark.nightly
async def test_a_compulsive_move_may_name_its_height(flying: Rig) -> None:
    flying.order(CompulsiveMove(x=5, y=0, height=50))
    await flying.until(S.HOVER)
    await flying.run(3)
    assert flying.autopilot.height == pytest.approx(50, abs=0.5)


@pytest.mark.parametrize("height", [14.9, 60.1])
async def test_a_height_outside_min_and_max_is_refused(flying: Rig, height: float) -> None:
    answer = flying.command(CompulsiveMove(x=5, y=0, height=height))
    assert not answer.accepted
    assert answer.reason.startswith("Height: must lie between Min 15 m and Max 60 m")
    flying.expect(S.HOVER)


@pytest.mark.parametrize("kind", [CompulsiveMove, AutonomousMove])
async def test_a_place_outside_the_fence_is_refused(
    flying: Rig, kind: type[CompulsiveMove] | type[AutonomousMove]
) -> None:
    answer = flying.command(kind(x=146, y=0))
    assert not answer.accepted
    assert "outside the fence" in answer.reason
    assert flying.manager.outcomes.user_error is UserError.DESIRED_LOCATION_OUT_OF_BOUNDS
    flying.expect(S.HOVER)


async def test_a_path_that_leaves_the_fence_is_refused(fresh: Rig) -> None:
    await fresh.enter(S.HOVER)
    corner = polygon_fence(((-20, -20), (100, -20), (100, 20), (20, 20), (20, 100), (-20, 100)), 5, 100, 3)
    fresh.topics.fence_pub.publish(corner)
    fresh.autopilot.north = 90
    await fresh.tick()
    answer = fresh.command(CompulsiveMove(x=0, y=90, frame="Map"))
    assert "straight path" in answer.reason
    fresh.expect(S.HOVER)


@pytest.mark.nightly
async def test_a_new_target_is_taken_in_flight(fresh: Rig) -> None:
    await fresh.enter(S.COMPULSIVE_MOVE)
    await fresh.run(2)
    former = fresh.manager.state
    fresh.order(CompulsiveMove(x=0, y=30, frame="Map"))
    assert fresh.manager.state is former
    await fresh.until(S.HOVER)
    await fresh.run(2)
    assert (fresh.autopilot.north, fresh.autopilot.east) == pytest.approx((0, 30), abs=0.2)


@pytest.mark.nightly
async def test_a_compulsive_move_needs_no_perception(flying: Rig) -> None:
    flying.sight.healthy = flying.sight.flows = False
    flying.sight.lot = None
    await flying.run(3)
    flying.order(CompulsiveMove(x=20, y=0))
    await flying.until(S.HOVER)
    assert flying.autopilot.north == pytest.approx(20, abs=2)


async def autonomous(rig: Rig, x: float, y: float) -> Ack:
    """Give an Autonomous Move and wait for the planner's word."""
    answer = rig.manager.handle("ana", AutonomousMove(x=x, y=y))
    for _ in range(25):
        if answer is None:
            await rig.tick()
            answer = rig.socket.replies.pop()[1] if rig.socket.replies else None
    assert isinstance(answer, Ack)
    return answer


@pytest.mark.slow
async def test_an_autonomous_move_inside_the_lot_is_flown(flying: Rig) -> None:
    assert (await autonomous(flying, x=20, y=5)).accepted
    flying.expect(S.AUTONOMOUS_MOVE)
    await flying.until(S.HOVER)
    assert "There. Holding." in flying.log
    assert flying.topics.des_pose_pub.value is None


@pytest.mark.parametrize(
    ("verdict", "words"),
    [(Inbound.OUTSIDE, "outside the lot"), (Inbound.UNKNOWN, "nobody has seen"), (None, "could not be found")],
)
async def test_an_autonomous_move_elsewhere_stays_with_user_error_1(
    flying: Rig, verdict: Inbound | None, words: str
) -> None:
    flying.sight.inbound = verdict
    answer = await autonomous(flying, x=20, y=5)
    assert not answer.accepted
    assert words in answer.reason
    assert flying.manager.outcomes.user_error is UserError.DESIRED_LOCATION_OUT_OF_BOUNDS
    flying.expect(S.HOVER)
    assert flying.topics.des_pose_pub.value is None


async def test_the_verdict_on_another_number_does_not_count(flying: Rig) -> None:
    assert (await autonomous(flying, x=5, y=5)).accepted
    flying.order(Hold())
    flying.sight.inbound = None  # the old verdict stays published
    answer = await autonomous(flying, x=20, y=5)
    assert not answer.accepted
    flying.expect(S.HOVER)


async def test_a_place_that_turns_out_outside_ends_the_move_with_user_error_1(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_MOVE)
    fresh.sight.inbound = Inbound.OUTSIDE
    await fresh.tick(2)
    fresh.expect(S.HOVER)
    assert fresh.manager.outcomes.user_error is UserError.DESIRED_LOCATION_OUT_OF_BOUNDS


@pytest.mark.slow
async def test_a_refused_new_target_lets_the_move_go_on(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_MOVE)
    fresh.sight.inbound = Inbound.OUTSIDE
    fresh.manager.handle("ana", AutonomousMove(x=-30, y=0))
    await fresh.tick()
    assert not getattr(fresh.socket.replies.pop()[1], "accepted")  # noqa: B009
    fresh.sight.inbound = Inbound.INSIDE
    await fresh.run(1.5)
    fresh.expect(S.AUTONOMOUS_MOVE)


async def test_a_planner_that_thinks_about_a_new_target_does_not_end_the_move(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_MOVE)
    fresh.sight.inbound = None
    fresh.manager.handle("ana", AutonomousMove(x=-30, y=0))
    await fresh.run(0.95)
    fresh.expect(S.AUTONOMOUS_MOVE)
    fresh.sight.inbound = Inbound.INSIDE
    await fresh.run(0.5)
    fresh.expect(S.AUTONOMOUS_MOVE)
    assert fresh.manager.state.goal is not None
    assert fresh.manager.state.goal.north < 0


async def test_a_newer_command_ends_an_open_question(flying: Rig) -> None:
    flying.sight.inbound = None
    assert flying.manager.handle("ana", AutonomousMove(x=20, y=5)) is None
    flying.order(ReturnToLaunch())
    client, answer = flying.socket.replies.pop()
    assert client == "ana"
    assert isinstance(answer, Ack)
    assert answer.reason == "Something else came first."
    flying.sight.inbound = Inbound.INSIDE
    await flying.run(1)
    flying.expect(S.RETURN_TO_LAUNCH)


async def test_control_lost_while_the_planner_thinks_refuses_the_move(flying: Rig) -> None:
    flying.sight.inbound = None
    flying.manager.handle("ana", AutonomousMove(x=20, y=5))
    flying.desk.client = "eve"
    flying.sight.inbound = Inbound.INSIDE
    await flying.tick()
    flying.expect(S.HOVER)
