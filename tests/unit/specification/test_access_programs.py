"""The access programs that the product itself does not use: nothing old or absent is passed off as known."""

from __future__ import annotations

import pytest

from hawk.algo.frame import AlgoError
from hawk.algo.topic_interface import AlgorithmTopicInterface
from hawk.model.operation import Health, StateName
from hawk.model.plans import DesiredPose, Inbound, Verdict
from hawk.model.poses import LocalPose
from hawk.specification.access_programs import AlgorithmAccess, DdcAccess, PathPlanAccess
from tests.unit.algo.path_plan.test_app import Rig as PathPlanRig
from tests.unit.algo.synthetic import frame_at, pose_at
from tests.unit.ddc.readings.test_topic_interface import Rig


@pytest.fixture
def rig() -> Rig:
    return Rig()


@pytest.fixture
def access(rig: Rig) -> DdcAccess:
    return DdcAccess(rig.topics)


def test_the_frame_that_was_begun_is_served() -> None:
    interface = AlgorithmTopicInterface()
    access = AlgorithmAccess(interface)
    with pytest.raises(AlgoError, match="no frame"):
        access.get_drone_state()
    interface.begin(frame_at(pose_at(1, 2), desired=DesiredPose(3, 4.0, 5.0), state=StateName.HOVER))
    assert access.get_drone_state() is StateName.HOVER
    assert access.get_desired_pose() == DesiredPose(3, 4.0, 5.0)
    assert access.get_local_pose() == pose_at(1, 2)


@pytest.mark.parametrize("inbound", list(Inbound))
def test_only_a_place_inside_is_inbound(inbound: Inbound) -> None:
    rig = PathPlanRig()
    assert PathPlanAccess(rig.app).get_des_pose_inbound() is False
    rig.map.verdict = inbound
    rig.plan(frame_at(pose_at(0, 0), state=StateName.HOVER, desired=DesiredPose(42, 5.0, 6.0)))
    assert PathPlanAccess(rig.app).get_des_pose_inbound() is (inbound is Inbound.INSIDE)
    rig.plan(frame_at(pose_at(0, 0), state=StateName.HOVER))
    assert PathPlanAccess(rig.app).get_des_pose_inbound() is False


def test_before_anything_came_nothing_is_claimed(access: DdcAccess) -> None:
    assert access.get_local_pose() is None
    assert access.get_rel_alt() is None
    assert not access.get_park_lot_detected()
    assert not access.get_des_loc_inbound()
    assert not access.get_health_status().is_healthy


def test_the_poses_about_the_arm_place_are_given_as_they_came(rig: Rig, access: DdcAccess) -> None:
    pose = rig.pose(LocalPose(5.0, 6.0, -7.0, 0.5), 7.0)
    assert access.get_local_pose() == pose.local
    assert access.get_rel_alt() == 7.0


def test_a_lot_in_sight_is_believed_for_two_seconds(rig: Rig, access: DdcAccess) -> None:
    rig.inputs.park_lot_detected.publish(True)
    assert access.get_park_lot_detected()
    rig.clock.advance(2.1)
    assert not access.get_park_lot_detected()


@pytest.mark.parametrize(
    ("verdict", "age", "inside"),
    [
        (Verdict(7, Inbound.INSIDE), 0.0, True),
        (Verdict(7, Inbound.INSIDE), 1.1, False),  # too old
        (Verdict(6, Inbound.INSIDE), 0.0, False),  # on another place
        (Verdict(7, Inbound.OUTSIDE), 0.0, False),
        (Verdict(7, Inbound.UNKNOWN), 0.0, False),
    ],
)
def test_inbound_only_by_a_fresh_verdict_on_the_same_number(
    rig: Rig, access: DdcAccess, verdict: Verdict, age: float, inside: bool
) -> None:
    rig.topics.des_pose_pub.publish(DesiredPose(7, 1.0, 2.0))
    rig.inputs.verdict.publish(verdict)
    rig.clock.advance(age)
    assert access.get_des_loc_inbound() is inside


def test_nothing_is_inbound_when_nothing_is_desired(rig: Rig, access: DdcAccess) -> None:
    rig.inputs.verdict.publish(Verdict(7, Inbound.INSIDE))
    assert not access.get_des_loc_inbound()


def test_the_overall_health_names_the_first_part_that_is_not_well(rig: Rig, access: DdcAccess) -> None:
    rig.all_well()
    assert access.get_health_status().is_healthy
    rig.inputs.recording_health.publish(Health.bad("disk full"))
    assert access.get_health_status().reason == "recording: disk full"
    rig.inputs.mapper_health.publish(Health.bad("torn"))
    assert access.get_health_status().reason == "mapper: torn"
    rig.inputs.loop_lag.publish(0.2)
    rig.clock.advance(3.1)
    assert access.get_health_status().reason == "link: No word from the autopilot."
