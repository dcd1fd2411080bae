from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import pytest
import shapely

from hawk.algo.frame import AlgoError, FrameInput
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.topic_interface import AlgorithmTopicInterface
from hawk.model.lot_map import Stall, StallState
from hawk.model.operation import Health, StateName
from hawk.model.plans import AskedGround, DesiredPose, Fence, HeightParameters, Inbound, PathPlan, Route, Verdict
from hawk.model.poses import MapPoint
from tests.unit.algo.path_plan.flight import KnownMap, fence_around
from tests.unit.algo.synthetic import CAMERA, frame_at, pose_at

LOT = shapely.box(-20.0, -20.0, 20.0, 20.0)
FENCE = fence_around(LOT, 15.0)


class FakeMap(KnownMap):
    """All of the lot is known, and what a test says of places and stalls."""

    def __init__(self) -> None:
        super().__init__(LOT, 100.0)
        self.seen[:] = 1
        self.well[:] = 1
        self.verdict = Inbound.UNKNOWN
        self.known: dict[int, Stall] = {}

    def inbound(self, north: float, east: float) -> Inbound:
        return self.verdict

    def unclear_stalls(self) -> Mapping[int, Stall]:
        return {i: stall for i, stall in self.known.items() if stall.state is StallState.UNKNOWN}


class Rig:
    def __init__(self, settings: PathPlanSettings | None = None) -> None:
        self.map = FakeMap()
        self.interface = AlgorithmTopicInterface()
        self.app = PathPlanApp(settings)
        self.app.init(self.map, self.interface)

    def plan(self, frame: FrameInput) -> PathPlan:
        self.interface.begin(frame)
        self.app.process()
        self.app.publish()
        return self.interface.local_pos_pub.value


def stall(stall_id: int, north: float, east: float, state: StallState) -> Stall:
    return Stall(stall_id, north, east, 0.0, 2.6, 5.2, 0.5, state, 0.9, 3, 1.0, 1)


@pytest.mark.parametrize("inbound", list(Inbound))
def test_the_verdict_carries_the_number_of_the_place_it_is_about(inbound: Inbound) -> None:
    rig = Rig()
    rig.map.verdict = inbound
    plan = rig.plan(frame_at(pose_at(0, 0), state=StateName.HOVER, desired=DesiredPose(42, 5.0, 6.0)))
    there = inbound is Inbound.INSIDE
    route = Route((MapPoint(0.0, 0.0), MapPoint(5.0, 6.0)), (0.0, 0.0)) if there else Route()
    assert plan.verdict == Verdict(42, inbound, route)
    assert rig.interface.des_loc_inbound_pub.value == plan.verdict
    assert plan.asked is None


@pytest.mark.parametrize(
    ("inbound", "target"), [(Inbound.INSIDE, MapPoint(5.0, 6.0)), (Inbound.OUTSIDE, None), (Inbound.UNKNOWN, None)]
)
def test_only_a_place_inside_becomes_a_target(inbound: Inbound, target: MapPoint | None) -> None:
    rig = Rig()
    rig.map.verdict = inbound
    frame = frame_at(pose_at(0, 0), state=StateName.AUTONOMOUS_MOVE, desired=DesiredPose(1, 5.0, 6.0))
    assert rig.plan(frame).target == target


def test_a_place_that_is_only_asked_about_gets_its_route_and_no_target() -> None:
    rig = Rig()
    rig.map.verdict = Inbound.INSIDE
    frame = replace(frame_at(pose_at(0, 0), state=StateName.HOVER), asked=DesiredPose(7, 5.0, 6.0))
    plan = rig.plan(frame)
    assert plan.asked == Verdict(7, Inbound.INSIDE, Route((MapPoint(0.0, 0.0), MapPoint(5.0, 6.0)), (0.0, 0.0)))
    assert (plan.target, plan.verdict, plan.route) == (None, None, ())


def test_while_a_move_is_flown_another_place_may_be_asked_about() -> None:
    rig = Rig()
    rig.map.verdict = Inbound.INSIDE
    frame = frame_at(pose_at(0, 0), state=StateName.AUTONOMOUS_MOVE, desired=DesiredPose(1, 5.0, 6.0))
    before = rig.plan(frame).verdict
    plan = rig.plan(replace(frame, asked=DesiredPose(2, -5.0, 6.0)))
    assert plan.asked is not None
    assert plan.asked.route.points[-1] == MapPoint(-5.0, 6.0)
    assert plan.verdict == before


def test_without_a_pose_nothing_is_said_of_a_place_inside() -> None:
    rig = Rig()
    rig.map.verdict = Inbound.INSIDE
    assert rig.plan(frame_at(None, state=StateName.HOVER, desired=DesiredPose(1, 5.0, 6.0))).verdict is None


def test_without_a_place_there_is_no_verdict() -> None:
    rig = Rig()
    assert rig.plan(frame_at(pose_at(0, 0), state=StateName.HOVER)).verdict is None


def test_nothing_is_explored_in_other_states() -> None:
    rig = Rig()
    for state in set(StateName) - {StateName.AUTONOMOUS_EXPLORE}:
        plan = rig.plan(frame_at(pose_at(0, 0), state=state, fence=FENCE))
        assert plan.target is None
        assert not plan.explore.done


@pytest.mark.parametrize(
    ("heights", "expected"),
    [(HeightParameters(15, 35, 60), 35.0), (HeightParameters(40, 35, 60), 40.0), (HeightParameters(15, 35, 30), 30.0)],
)
def test_the_height_is_the_desired_one_within_its_bounds(heights: HeightParameters, expected: float) -> None:
    rig = Rig()
    rig.map.verdict = Inbound.INSIDE
    frame = frame_at(pose_at(0, 0), state=StateName.AUTONOMOUS_MOVE, desired=DesiredPose(1, 5.0, 6.0))
    assert rig.plan(replace(frame, heights=heights)).height == expected


@pytest.mark.slow
def test_explore_has_the_height_for_the_wanted_pixels_and_a_speed_that_can_be_read() -> None:
    rig = Rig(PathPlanSettings(cm_per_pixel=100 * 28.0 / CAMERA.fx, exposure_s=0.02))
    rig.map.seen[:, : rig.map.window.columns // 2] = 0
    rig.map.well[:] = rig.map.seen
    plans = [
        rig.plan(frame_at(pose_at(0, 0), n, state=StateName.AUTONOMOUS_EXPLORE, fence=FENCE, interval=0.25))
        for n in range(12)
    ]
    targeted = [plan for plan in plans if plan.target is not None]
    assert targeted
    assert all(plan.height == pytest.approx(28.0) for plan in targeted)
    assert all(plan.speed == pytest.approx(5.0) for plan in targeted)


def first_target(rig: Rig, frame: FrameInput) -> PathPlan:
    """Return the first plan with a target: what lies beyond the border is looked for before, a part a frame."""
    plans = (rig.plan(frame) for _ in range(10))
    return next((plan for plan in plans if plan.target is not None), PathPlan())


@pytest.mark.nightly
def test_an_unclear_stall_is_flown_to_once_before_it_is_done() -> None:
    rig = Rig()
    rig.map.known = {7: stall(7, 12.0, 8.0, StallState.UNKNOWN), 8: stall(8, -5.0, 0.0, StallState.FREE)}
    frame = frame_at(pose_at(0, 0), fence=FENCE)
    plan = first_target(rig, frame)
    assert plan.target == MapPoint(12.0, 8.0)
    assert plan.yaw == pytest.approx(math.atan2(8, 12))
    assert rig.plan(replace(frame, pose=pose_at(12.0, 8.0))).target is None
    done = [rig.plan(replace(frame, pose=pose_at(12.0, 8.0))).explore.done for _ in range(20)]
    assert done[-1]
    assert not done[0]


@pytest.mark.slow
def test_an_unclear_stall_that_becomes_clear_in_flight_is_left() -> None:
    rig = Rig()
    rig.map.known = {7: stall(7, 12.0, 8.0, StallState.UNKNOWN)}
    assert first_target(rig, frame_at(pose_at(0, 0), fence=FENCE)).target is not None
    rig.map.known = {7: stall(7, 12.0, 8.0, StallState.TAKEN)}
    assert rig.plan(frame_at(pose_at(1, 1), fence=FENCE)).target is None


@pytest.mark.slow
def test_an_unclear_stall_beyond_the_fence_is_not_flown_to() -> None:
    rig = Rig()
    rig.map.known = {7: stall(7, 12.0, 8.0, StallState.UNKNOWN)}
    polygon = ((-20.0, -20.0), (5.0, -20.0), (5.0, 20.0), (-20.0, 20.0))
    frame = frame_at(pose_at(0, 0), fence=Fence(polygon, polygon, 60.0, 63.0))
    for _ in range(20):
        plan = rig.plan(frame)
        assert plan.target is None
    assert plan.explore.done


@pytest.mark.slow
def test_progress_is_reported_until_an_exploration_begins_again() -> None:
    rig = Rig()
    frame = frame_at(pose_at(0, 0), fence=FENCE)
    while not rig.plan(frame).explore.done:
        pass
    after = rig.plan(replace(frame, state=StateName.HOVER)).explore
    assert after.done
    assert after.seen == 1.0
    assert not rig.plan(frame).explore.done


@pytest.mark.slow
def test_an_exploration_is_spent_until_lot_is_found_or_the_drone_has_landed() -> None:
    rig = Rig()
    frame = frame_at(pose_at(0, 0), fence=FENCE)
    while not (plan := rig.plan(frame)).explore.done:
        assert not plan.explore.is_spent
    assert plan.explore.is_spent
    hover = replace(frame, state=StateName.HOVER)
    assert rig.plan(hover).explore.is_spent
    rig.map.lot = rig.map._drawn(shapely.box(-20.0, -20.0, 20.0, 21.0))  # the border moves a little: 40 m²
    assert rig.plan(hover).explore.is_spent
    landed = rig.plan(replace(frame, state=StateName.TAKEOFF)).explore
    assert (landed.done, landed.is_spent) == (True, False), (
        "what was seen stays seen, and another flight may look again"
    )


@pytest.mark.slow
def test_lot_that_is_found_after_an_exploration_is_not_explored() -> None:
    rig = Rig()
    frame = frame_at(pose_at(0, 0), fence=FENCE)
    while not rig.plan(frame).explore.done:
        pass
    rig.map.lot = rig.map._drawn(shapely.union(LOT, shapely.box(-20.0, 40.0, 20.0, 60.0)))
    after = rig.plan(replace(frame, state=StateName.HOVER)).explore
    assert (after.done, after.is_whole, after.is_spent) == (False, False, False)


@pytest.mark.slow
def test_another_outline_is_not_explored() -> None:
    rig = Rig()
    frame = frame_at(pose_at(0, 0), fence=FENCE)
    while not rig.plan(frame).explore.done:
        pass
    ring = ((-10.0, -10.0), (-10.0, 10.0), (10.0, 10.0), (10.0, -10.0))
    after = rig.plan(replace(frame, state=StateName.HOVER, asked_ground=AskedGround(((ring,),), 400.0))).explore
    assert (after.done, after.is_spent) == (False, False)


@pytest.mark.slow
def test_a_place_that_was_given_up_leaves_the_exploration_open() -> None:
    rig = Rig(PathPlanSettings(idle_plans=8))
    rig.map.seen[100:130, 110:150] = rig.map.well[100:130, 110:150] = 0  # no picture of this test shows it
    frame = frame_at(pose_at(0, 0), fence=FENCE)
    for _ in range(200):
        plan = rig.plan(frame)
        if plan.explore.done:
            break
    assert (plan.explore.done, plan.explore.unreached, plan.explore.is_spent) == (True, True, False)


def test_before_anything_is_seen_it_waits_and_says_why() -> None:
    rig = Rig()
    rig.map.lot[:] = 0
    plan = rig.plan(frame_at(pose_at(0, 0), fence=FENCE))
    assert plan.target is None
    assert not plan.explore.done
    assert plan.explore.reason == "no lot is known yet"


def test_without_a_pose_there_is_no_target() -> None:
    assert Rig().plan(frame_at(None, fence=FENCE)).target is None


@pytest.mark.slow
def test_a_pose_that_is_not_finite_is_an_error_and_leaves_no_target() -> None:
    rig = Rig()
    rig.map.known = {7: stall(7, 12.0, 8.0, StallState.UNKNOWN)}
    assert first_target(rig, frame_at(pose_at(0, 0), fence=FENCE)).target is not None
    rig.interface.begin(frame_at(pose_at(math.nan, 0), fence=FENCE))
    with pytest.raises(AlgoError, match="not finite"):
        rig.app.process()
    assert rig.app.get_local_pose().target is None
    assert not rig.app.get_health().is_healthy


def test_a_plan_is_the_answer_to_a_frame_and_a_map_and_the_getters_repeat_it() -> None:
    app, known = PathPlanApp(), FakeMap()
    known.verdict = Inbound.INSIDE
    plan = app.plan(frame_at(pose_at(0, 0), state=StateName.HOVER, desired=DesiredPose(1, 5.0, 6.0)), known)
    assert plan.path.target == MapPoint(5.0, 6.0)
    assert plan.health == Health()
    assert app.get_local_pose() is plan.path
    without = app.plan(frame_at(pose_at(math.nan, 0)), known)
    assert (without.path, without.health.is_healthy) == (PathPlan(), False)
    assert app.get_health() is without.health


def test_a_map_that_fails_leaves_no_target_and_a_planner_that_is_not_healthy(monkeypatch: pytest.MonkeyPatch) -> None:
    app, known = PathPlanApp(), FakeMap()
    known.verdict = Inbound.INSIDE
    frame = frame_at(pose_at(0, 0), state=StateName.HOVER, desired=DesiredPose(1, 5.0, 6.0))
    app.plan(frame, known)
    monkeypatch.setattr(known, "coarse", None)
    with pytest.raises(TypeError):
        app.plan(replace(frame, desired=DesiredPose(2, 5.0, 6.0)), known)
    assert app.get_local_pose().target is None
    assert not app.get_health().is_healthy


def test_not_initialised_is_said() -> None:
    with pytest.raises(AlgoError, match="not initialised"):
        PathPlanApp().process()
