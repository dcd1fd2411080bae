"""What each state does and where it leads, the unsafe ways refused."""

from __future__ import annotations

import pytest

from hawk.comm.messages import (
    Ack,
    Arm,
    AutonomousExplore,
    AutonomousMove,
    CompulsiveMove,
    Disarm,
    Hold,
    Land,
    Resume,
    ReturnToLaunch,
    Takeoff,
)
from hawk.config import FenceSettings
from hawk.ddc.geofence import FenceError, polygon_fence
from hawk.ddc.settings import DdcSettings
from hawk.model import CopterMode, ExploreStatus, Inbound, LandedState, MapPoint, PathPlan, StateName, UserError
from tests.unit.ddc.fakes import Rig

S = StateName

# -- Arm --------------------------------------------------------------------------------------------------------------


async def test_arm_uploads_the_fence_then_guided_then_arms(rig: Rig) -> None:
    rig.autopilot.calls.clear()
    rig.order(Arm())
    await rig.run(0.5)
    asked = [name for name, _ in rig.autopilot.calls if name != "get_parameter"]
    assert asked == ["upload_fence", "set_mode", "arm"]
    assert rig.manager.fence == rig.autopilot.asked("upload_fence")[0]
    assert rig.manager.state.detail == "Armed. Motors stop in 10 s without take-off."
    await rig.run(4.0)
    assert "Motors stop in 6 s" in rig.manager.state.detail


@pytest.mark.parametrize(
    ("request_name", "text"),
    [("upload_fence", "The fence was not taken."), ("arm", "Arm was refused.")],
)
async def test_a_refused_arm_leads_to_idle_with_the_autopilots_words(rig: Rig, request_name: str, text: str) -> None:
    rig.autopilot.refuse[request_name] = "PreArm: GPS 1: Bad fix"
    rig.order(Arm())
    await rig.run(0.5)
    rig.expect(S.IDLE)
    entry = rig.manager.log.entries[-1]
    assert (entry.text, entry.details) == (text, "PreArm: GPS 1: Bad fix")
    assert not rig.autopilot.armed


@pytest.mark.parametrize("silent", ["upload_fence", "set_mode", "arm"])
async def test_arming_times_out(rig: Rig, silent: str) -> None:
    rig.autopilot.silent.add(silent)
    rig.order(Arm())
    await rig.run(21)
    rig.expect(S.IDLE)
    assert rig.manager.log.entries[-1].level == "error"


async def test_armed_that_comes_after_it_gave_up_is_disarmed_at_once(rig: Rig) -> None:
    rig.autopilot.silent.add("arm")
    rig.order(Arm())
    await rig.run(21)
    rig.expect(S.IDLE)
    rig.autopilot.armed = True
    await rig.tick(2)
    assert rig.autopilot.count("disarm") == 1
    await rig.tick(2)
    assert not rig.autopilot.armed
    rig.expect(S.IDLE)


async def test_armed_by_somebody_else_is_not_disarmed(rig: Rig) -> None:
    rig.autopilot.armed = True
    await rig.tick()
    rig.expect(S.MANUAL)
    assert rig.autopilot.count("disarm") == 0


async def test_armed_by_somebody_else_in_guided_is_taken_up_as_arm(rig: Rig) -> None:
    rig.autopilot.armed, rig.autopilot.mode = True, CopterMode.GUIDED
    await rig.tick()
    rig.expect(S.ARM)


async def test_a_lost_operator_ends_arm_and_the_motors_stop(fresh: Rig) -> None:
    await fresh.enter(S.ARM)
    fresh.desk.present = False
    await fresh.run(0.5)
    fresh.expect(S.IDLE)
    assert not fresh.autopilot.armed


async def test_disarm_stops_the_motors(fresh: Rig) -> None:
    await fresh.enter(S.ARM)
    fresh.order(Disarm())
    await fresh.tick(2)
    fresh.expect(S.IDLE)


async def test_disarm_while_arming_stops_it(rig: Rig) -> None:
    rig.autopilot.silent.add("arm")
    rig.order(Arm())
    await rig.run(0.5)
    rig.order(Disarm())
    rig.expect(S.IDLE)
    rig.autopilot.armed = True
    await rig.run(0.2)
    assert not rig.autopilot.armed


async def test_a_refused_disarm_is_told(fresh: Rig) -> None:
    await fresh.enter(S.ARM)
    fresh.autopilot.refuse["disarm"] = "not now"
    fresh.order(Disarm())
    await fresh.tick(3)
    fresh.expect(S.ARM)
    assert fresh.log[-1] == "Disarm was refused."


async def test_the_autopilots_own_disarm_leads_to_idle(fresh: Rig) -> None:
    await fresh.enter(S.ARM)
    fresh.autopilot.armed = False
    await fresh.tick()
    fresh.expect(S.IDLE)


async def test_armed_in_another_mode_is_someone_elses(fresh: Rig) -> None:
    await fresh.enter(S.ARM)
    fresh.autopilot.mode = CopterMode.STABILIZE
    await fresh.tick()
    fresh.expect(S.MANUAL)


async def test_a_mode_that_changed_while_arming_is_someone_elses(rig: Rig) -> None:
    rig.autopilot.silent.add("arm")
    rig.order(Arm())
    await rig.run(0.5)
    rig.autopilot.mode = CopterMode.STABILIZE
    await rig.tick()
    rig.expect(S.ARM)
    rig.autopilot.armed = True
    await rig.tick(2)
    rig.expect(S.MANUAL)


async def test_an_arm_that_is_acknowledged_and_does_not_show(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    async def acknowledge() -> None:
        """Say yes and stay disarmed."""

    monkeypatch.setattr(rig.autopilot, "arm", acknowledge)
    rig.order(Arm())
    await rig.run(3.0)
    rig.expect(S.ARM)
    await rig.run(0.5)
    rig.expect(S.IDLE)
    assert rig.log[-1] == "Arm was taken, but the drone does not arm."


async def test_without_a_fence_it_does_not_arm(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail() -> None:
        raise FenceError("fence: too narrow")

    monkeypatch.setattr(rig.manager, "prepare_fence", fail)
    rig.order(Arm())
    await rig.tick()
    rig.expect(S.IDLE)
    assert rig.manager.log.entries[-1].details == "fence: too narrow"
    assert rig.autopilot.count("arm") == 0


async def test_takeoff_waits_for_armed(rig: Rig) -> None:
    rig.autopilot.silent.add("arm")
    rig.order(Arm())
    await rig.run(0.5)
    assert rig.command(Takeoff()).reason == "Arming: wait until it is armed."


# -- Takeoff ----------------------------------------------------------------------------------------------------------


async def test_takeoff_ends_in_hover_at_95_percent(fresh: Rig) -> None:
    await fresh.enter(S.TAKEOFF)
    await fresh.until(S.HOVER)
    assert fresh.autopilot.height == pytest.approx(0.95 * 35, abs=0.3)
    await fresh.run(3)
    assert fresh.autopilot.height == pytest.approx(35, abs=0.1)


@pytest.mark.parametrize(("armed", "state"), [(True, S.ARM), (False, S.IDLE)])
async def test_a_refused_takeoff_leads_back_to_the_ground(fresh: Rig, armed: bool, state: StateName) -> None:
    await fresh.enter(S.ARM)
    fresh.autopilot.refuse["takeoff"] = "Mode change failed"
    fresh.order(Takeoff())
    fresh.autopilot.armed = armed
    await fresh.tick(2)
    fresh.expect(state)
    if armed:
        assert fresh.manager.log.entries[-1].details == "Mode change failed"


async def test_still_on_the_ground_after_eight_seconds(fresh: Rig) -> None:
    await fresh.enter(S.ARM)
    fresh.autopilot.stuck = True
    fresh.order(Takeoff())
    await fresh.run(7.9)
    fresh.expect(S.TAKEOFF)
    await fresh.run(0.3)
    fresh.expect(S.ARM)


async def test_a_climb_that_stops_for_five_seconds_leads_to_hover(fresh: Rig) -> None:
    await fresh.enter(S.TAKEOFF)
    await fresh.run(8.0)
    fresh.autopilot.stuck = True
    await fresh.run(4.8)
    fresh.expect(S.TAKEOFF)
    await fresh.run(0.5)
    fresh.expect(S.HOVER)
    assert fresh.log[-1] == "The climb stopped. Holding."


async def test_hold_below_min_brakes_at_the_present_height(fresh: Rig) -> None:
    await fresh.enter(S.TAKEOFF)
    await fresh.run(2.0)
    height = fresh.autopilot.height
    assert 2 < height < 13
    fresh.order(Hold())
    await fresh.run(1.0)
    assert fresh.autopilot.mode == CopterMode.BRAKE
    assert fresh.autopilot.targets == []
    assert fresh.autopilot.height == pytest.approx(height, abs=0.5)
    fresh.expect(S.HOVER)


async def test_the_move_after_a_low_hold_climbs_to_min_first(fresh: Rig) -> None:
    await fresh.enter(S.TAKEOFF)
    await fresh.run(2.0)
    fresh.order(Hold())
    await fresh.run(1.0)
    fresh.order(CompulsiveMove(x=20, y=0))
    await fresh.until(S.HOVER)
    assert fresh.autopilot.north == pytest.approx(20, abs=2)
    sent = fresh.autopilot.targets
    assert all(abs(t.north) < 0.1 for t in sent if t.height < 14.4)
    assert sent[-1].height == pytest.approx(15)


async def test_an_operator_lost_while_it_climbs_lets_the_climb_end(fresh: Rig) -> None:
    await fresh.enter(S.TAKEOFF)
    fresh.desk.present = False
    await fresh.run(5.0)
    fresh.expect(S.TAKEOFF)
    await fresh.until(S.COMMUNICATION_LOST)
    assert fresh.autopilot.height > 33


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
    assert flying.manager.user_error is UserError.NO_LOT_DETECTED
    flying.expect(S.HOVER)
    flying.order(Hold())
    assert flying.manager.user_error_text == ""


async def test_explore_follows_the_plan_with_its_height_and_yaw(flying: Rig) -> None:
    flying.target_plan(25, -10, height=40)
    flying.order(AutonomousExplore())
    await flying.run(12)
    flying.expect(S.AUTONOMOUS_EXPLORE)
    place = flying.autopilot
    assert (place.north, place.east, place.height) == pytest.approx((25, -10, 40), abs=0.2)
    assert flying.autopilot.targets[-1].yaw == 0.5


@pytest.mark.parametrize(("height", "flown"), [(3, 15), (500, 60), (None, 35)])
async def test_the_plans_height_is_bounded(flying: Rig, height: float | None, flown: float) -> None:
    flying.target_plan(10, 0, height)
    flying.order(AutonomousExplore())
    await flying.run(9)
    flying.target_plan(20, 0, height)
    await flying.run(9)
    assert flying.autopilot.height == pytest.approx(flown, abs=0.2)


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
    assert fresh.log[-1] == "Explored. Nothing left to see. Holding."


async def test_a_done_of_before_the_state_began_does_not_count(flying: Rig) -> None:
    flying.finish_plan()
    await flying.tick()
    flying.order(AutonomousExplore())
    await flying.tick(2)
    flying.expect(S.AUTONOMOUS_EXPLORE)


async def test_no_lot_in_sight_for_too_long_is_user_error_2(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    fresh.target_plan(100, 0)
    fresh.sight.lot = False
    await fresh.run(9.8)
    fresh.expect(S.AUTONOMOUS_EXPLORE)
    await fresh.run(0.5)
    fresh.expect(S.HOVER)
    assert fresh.manager.user_error is UserError.NO_LOT_DETECTED


async def test_explore_says_where_it_goes_next(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    fresh.target_plan(0, -40)
    await fresh.run(10)
    assert "Next: to the north, 40 m away." in fresh.log
    assert any(text.startswith("Next: to the west") or "south-west" in text for text in fresh.log)


# -- Moves ------------------------------------------------------------------------------------------------------------


async def test_a_relative_move_starts_where_the_drone_is_when_it_is_accepted(flying: Rig) -> None:
    flying.autopilot.north, flying.autopilot.east = 10, 20
    await flying.tick()
    flying.order(CompulsiveMove(x=15, y=-5))
    await flying.until(S.HOVER)
    await flying.run(3)
    assert (flying.autopilot.north, flying.autopilot.east) == pytest.approx((25, 15), abs=0.1)
    assert "There. Holding." in flying.log


async def test_a_map_move_goes_to_coordinates(flying: Rig) -> None:
    flying.autopilot.north, flying.autopilot.east = 10, 20
    await flying.tick()
    flying.order(CompulsiveMove(x=15, y=-5, frame="Map"))
    await flying.until(S.HOVER)
    await flying.run(3)
    assert (flying.autopilot.north, flying.autopilot.east) == pytest.approx((15, -5), abs=0.1)


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
    assert flying.manager.user_error is UserError.DESIRED_LOCATION_OUT_OF_BOUNDS
    flying.expect(S.HOVER)


async def test_a_way_that_leaves_the_fence_is_refused(fresh: Rig) -> None:
    await fresh.enter(S.HOVER)
    corner = polygon_fence(((-20, -20), (100, -20), (100, 20), (20, 20), (20, 100), (-20, 100)), 5, 100, 3)
    fresh.manager.fences.put_in_force(corner)
    fresh.autopilot.north = 90
    await fresh.tick()
    answer = fresh.command(CompulsiveMove(x=0, y=90, frame="Map"))
    assert "straight way" in answer.reason
    fresh.expect(S.HOVER)


async def test_a_new_target_is_taken_on_the_way(fresh: Rig) -> None:
    await fresh.enter(S.COMPULSIVE_MOVE)
    await fresh.run(2)
    former = fresh.manager.state
    fresh.order(CompulsiveMove(x=0, y=30, frame="Map"))
    assert fresh.manager.state is former
    await fresh.until(S.HOVER)
    await fresh.run(2)
    assert (fresh.autopilot.north, fresh.autopilot.east) == pytest.approx((0, 30), abs=0.2)


async def test_no_progress_for_ten_seconds_holds_with_the_reason(fresh: Rig) -> None:
    await fresh.enter(S.COMPULSIVE_MOVE)
    fresh.autopilot.stuck = True
    await fresh.run(9.5)
    fresh.expect(S.COMPULSIVE_MOVE)
    await fresh.run(1.0)
    fresh.expect(S.HOVER)
    assert fresh.log[-1] == "No progress for 10 s. Holding."


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


async def test_an_autonomous_move_inside_the_lot_is_flown(flying: Rig) -> None:
    assert (await autonomous(flying, x=20, y=5)).accepted
    flying.expect(S.AUTONOMOUS_MOVE)
    await flying.until(S.HOVER)
    assert "There. Holding." in flying.log
    assert flying.topics.des_pose_pub.value is None


@pytest.mark.parametrize(
    ("verdict", "words"),
    [(Inbound.OUTSIDE, "outside the lot"), (Inbound.UNKNOWN, "nobody has seen"), (None, "could not be told")],
)
async def test_an_autonomous_move_elsewhere_stays_with_user_error_1(
    flying: Rig, verdict: Inbound | None, words: str
) -> None:
    flying.sight.inbound = verdict
    answer = await autonomous(flying, x=20, y=5)
    assert not answer.accepted
    assert words in answer.reason
    assert flying.manager.user_error is UserError.DESIRED_LOCATION_OUT_OF_BOUNDS
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
    assert fresh.manager.user_error is UserError.DESIRED_LOCATION_OUT_OF_BOUNDS


@pytest.mark.parametrize("verdict", [None, Inbound.UNKNOWN])
async def test_a_verdict_older_than_a_second_is_not_inbound(fresh: Rig, verdict: Inbound | None) -> None:
    await fresh.enter(S.AUTONOMOUS_MOVE)
    fresh.sight.inbound = verdict
    await fresh.run(0.9)
    fresh.expect(S.AUTONOMOUS_MOVE)
    await fresh.run(1.2)
    fresh.expect(S.HOVER)
    assert fresh.manager.user_error is UserError.DESIRED_LOCATION_OUT_OF_BOUNDS


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
    assert fresh.manager.target_place is not None
    assert fresh.manager.target_place.north < 0


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


# -- Return To Launch and Land ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("command", "mode"), [(ReturnToLaunch(), CopterMode.RTL), (Land(), CopterMode.LAND)])
async def test_coming_down_is_the_autopilots_work(flying: Rig, command: ReturnToLaunch | Land, mode: int) -> None:
    flying.autopilot.north = 40
    flying.order(command)
    await flying.tick(2)
    assert flying.autopilot.mode == mode
    sent = len(flying.autopilot.targets)
    await flying.until(S.IDLE, 90)
    assert len(flying.autopilot.targets) == sent
    assert flying.log[-1] == "Landed. Motors off."
    assert flying.autopilot.count("set_mode") == 1


async def test_a_refused_return_is_asked_for_again_and_told(flying: Rig) -> None:
    flying.autopilot.refuse["set_mode"] = "EKF variance"
    flying.order(ReturnToLaunch())
    await flying.run(5)
    flying.expect(S.RETURN_TO_LAUNCH)
    assert flying.autopilot.count("set_mode") == 3
    assert "EKF variance" in flying.manager.state.detail
    assert flying.manager.log.entries[-1].details == "EKF variance"
    flying.autopilot.refuse.clear()
    await flying.run(2.5)
    assert flying.autopilot.mode == CopterMode.RTL


async def test_the_operator_holds_a_return(fresh: Rig) -> None:
    await fresh.enter(S.RETURN_TO_LAUNCH)
    fresh.order(Hold())
    await fresh.run(1)
    fresh.expect(S.HOVER)
    assert fresh.autopilot.mode == CopterMode.GUIDED


# -- CommunicationLost ------------------------------------------------------------------------------------------------


async def test_it_holds_for_thirty_seconds_then_returns(fresh: Rig) -> None:
    await fresh.enter(S.COMMUNICATION_LOST)
    await fresh.run(1.0)
    assert fresh.manager.status.value is not None
    assert fresh.manager.status.value.return_in == pytest.approx(28.9, abs=0.3)
    await fresh.run(28.5)
    fresh.expect(S.COMMUNICATION_LOST)
    assert fresh.autopilot.mode == CopterMode.GUIDED
    await fresh.run(0.8)
    fresh.expect(S.RETURN_TO_LAUNCH)
    await fresh.tick(2)
    assert fresh.autopilot.mode == CopterMode.RTL


async def test_nothing_resumes_by_itself_when_the_operator_is_back(fresh: Rig) -> None:
    await fresh.enter(S.AUTONOMOUS_EXPLORE)
    fresh.desk.present = False
    await fresh.tick()
    fresh.expect(S.COMMUNICATION_LOST)
    fresh.desk.present = True
    await fresh.tick()
    fresh.expect(S.HOVER)
    await fresh.run(5)
    fresh.expect(S.HOVER)


async def test_hold_is_refused_while_the_operator_is_lost_and_taken_when_back(fresh: Rig) -> None:
    await fresh.enter(S.COMMUNICATION_LOST)
    await fresh.run(30.5)
    fresh.expect(S.RETURN_TO_LAUNCH)
    assert fresh.command(Hold()).reason == "Not while this lasts: The operator is lost."
    fresh.desk.present = True
    fresh.order(Hold())
    fresh.expect(S.HOVER)


# -- Manual -----------------------------------------------------------------------------------------------------------


async def test_a_pilot_takes_over_from_every_state_in_the_air(fresh: Rig) -> None:
    for state in (S.AUTONOMOUS_EXPLORE, S.COMPULSIVE_MOVE, S.RETURN_TO_LAUNCH, S.LAND):
        fresh.autopilot.put_in_air()
        fresh.autopilot.change_mode(CopterMode.GUIDED)
        await fresh.run(3.5)
        await fresh._order_from_hover(state)
        fresh.expect(state)
        sent, asked = len(fresh.autopilot.targets), len(fresh.autopilot.asked("set_mode"))
        fresh.autopilot.change_mode(CopterMode.LOITER)
        await fresh.run(3.5)
        fresh.expect(S.MANUAL)
        assert len(fresh.autopilot.targets) == sent
        assert len(fresh.autopilot.asked("set_mode")) == asked


async def test_manual_commands_nothing_by_itself(fresh: Rig) -> None:
    await fresh.enter(S.MANUAL)
    calls, sent = len(fresh.autopilot.calls), len(fresh.autopilot.targets)
    fresh.desk.present = False
    fresh.autopilot.battery = 3.0
    fresh.autopilot.north = 400.0
    fresh.sight.healthy = False
    await fresh.run(20)
    fresh.expect(S.MANUAL)
    assert len(fresh.autopilot.calls) == calls
    assert len(fresh.autopilot.targets) == sent


async def test_the_pilot_lands_and_disarms(fresh: Rig) -> None:
    await fresh.enter(S.MANUAL)
    fresh.autopilot.landed, fresh.autopilot.height = LandedState.ON_GROUND, 0.0
    await fresh.tick()
    assert fresh.command(Resume(confirmed=True)).reason == "On the ground."
    fresh.autopilot.armed = False
    await fresh.tick()
    fresh.expect(S.IDLE)


async def test_a_plan_without_target_waits(fresh: Rig) -> None:
    await fresh.enter(S.HOVER)
    fresh.sight.plan = PathPlan(route=(MapPoint(1, 1),), explore=ExploreStatus(seen=0.1))
    fresh.order(AutonomousExplore())
    before = len(fresh.autopilot.targets)
    await fresh.run(5)
    fresh.expect(S.AUTONOMOUS_EXPLORE)
    assert len(fresh.autopilot.targets) == before
    await fresh.run(6)
    assert "No progress for 10 s. The planner gives no way on. Holding." in fresh.log


async def test_the_ceiling_of_a_configured_fence_bounds_what_can_be_configured() -> None:
    assert DdcSettings(fence=FenceSettings(ceiling_margin_m=3)).ceiling == 97
