"""Every access program of DDC Topic Interface: what it gives, and that nothing old or absent is passed off as known."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from hawk.comm.vehicle import VehicleTopics
from hawk.ddc.topic_interface import DdcInputs, DdcTopicInterface
from hawk.model.lot_map import OccupancyMap
from hawk.model.operation import Health, HealthStatus
from hawk.model.plans import DesiredPose, Inbound, Verdict
from hawk.model.poses import GlobalPose, LocalPose, MapPose, VehiclePose
from hawk.model.vehicle import BatteryInfo, Diagnostics, VehicleState
from tests.manual_clock import ManualClock

GOOD = Diagnostics(all_ok=True, global_position_ok=True)


class Rig:
    """A topic interface between topics of its own, at a time that the test moves."""

    def __init__(self) -> None:
        self.clock = ManualClock(100.0)
        self.vehicle = VehicleTopics.create(self.clock)
        self.inputs = DdcInputs.create(self.clock)
        self.topics = DdcTopicInterface(self.vehicle, self.inputs, self.clock)
        self.topics.init()

    def pose(self, local: LocalPose | None = None, relative_altitude: float | None = None) -> VehiclePose:
        place = MapPose(1.0, 2.0, 3.0, 0.0, 0.0, 0.0)
        made = VehiclePose(
            self.clock(),
            GlobalPose(43.0, -79.0, 120.0),
            relative_altitude,
            local,
            place,
            (0.0, 0.0, 0.0),
            0.0,
            0.0,
            0.0,
        )
        self.vehicle.pose.publish(made)
        return made

    def all_well(self) -> None:
        self.vehicle.state.publish(VehicleState(connected=True, time=self.clock()))
        self.vehicle.diagnostics.publish(GOOD)
        self.pose()
        for topic in (
            self.inputs.vision_health,
            self.inputs.mapper_health,
            self.inputs.path_plan_health,
            self.inputs.camera_health,
            self.inputs.recording_health,
        ):
            topic.publish(Health())


@pytest.fixture
def rig() -> Rig:
    return Rig()


def test_before_anything_came_nothing_is_claimed(rig: Rig) -> None:
    topics = rig.topics
    assert topics.get_state() == VehicleState()
    assert topics.get_global_pose() is None
    assert topics.get_local_pose() is None
    assert topics.get_rel_alt() is None
    assert topics.get_battery_info() is None
    assert topics.get_diagnostics() == Diagnostics()
    assert not topics.get_park_lot_detected()
    assert not topics.get_des_loc_inbound()
    assert topics.get_occupancy_map() == OccupancyMap()
    for health in (topics.get_vision_health(), topics.get_mapper_health(), topics.get_path_plan_health()):
        assert health == Health.bad("No result yet.")
    assert not topics.get_health_status().is_healthy
    assert topics.get_link_age() == topics.get_pose_age() == math.inf


def test_the_autopilots_state_and_poses_are_given_as_they_came(rig: Rig) -> None:
    state = VehicleState(connected=True, time=rig.clock())
    rig.vehicle.state.publish(state)
    pose = rig.pose(LocalPose(5.0, 6.0, -7.0, 0.5), 7.0)
    assert rig.topics.get_state() is state
    assert rig.topics.get_global_pose() == pose.global_
    assert rig.topics.get_local_pose() == pose.local
    assert rig.topics.get_rel_alt() == 7.0


def test_the_camera_is_as_well_as_it_says_and_as_its_pictures_show(rig: Rig) -> None:
    assert not rig.topics.get_camera_health().is_healthy
    rig.inputs.camera_health.publish(Health())
    assert rig.topics.get_camera_health() == Health()
    turned = Health.bad("the picture moves as if the camera were turned by about 90°")
    rig.inputs.camera_check.publish(turned)
    assert rig.topics.get_camera_health() == turned
    assert dict(rig.topics.get_part_healths())["camera"] == turned
    dark = Health.bad("Camera: no picture for 2 s")
    rig.inputs.camera_health.publish(dark)
    assert rig.topics.get_camera_health() == dark
    rig.inputs.camera_health.publish(Health())
    rig.inputs.camera_check.publish(Health())
    assert rig.topics.get_camera_health() == Health()
    told = Health(HealthStatus.HEALTHY, "Camera: 1 of the last 20 pictures was damaged")
    rig.inputs.camera_health.publish(told)
    assert rig.topics.get_camera_health() == told
    rig.inputs.camera_check.publish(turned)
    assert rig.topics.get_camera_health() == turned


def test_diagnostics_that_are_old_count_as_bad(rig: Rig) -> None:
    rig.vehicle.diagnostics.publish(GOOD)
    assert rig.topics.get_diagnostics() is GOOD
    rig.clock.advance(5.1)
    assert rig.topics.get_diagnostics() == Diagnostics()


@pytest.mark.parametrize("percentage", [None, math.nan, math.inf])
def test_a_battery_without_a_charge_is_not_known(rig: Rig, percentage: float | None) -> None:
    rig.vehicle.battery.publish(BatteryInfo(percentage=percentage, voltage=16.0))
    assert rig.topics.get_battery_info() is None


def test_a_battery_is_known_for_five_seconds(rig: Rig) -> None:
    battery = BatteryInfo(percentage=80.0, voltage=16.0)
    rig.vehicle.battery.publish(battery)
    assert rig.topics.get_battery_info() is battery
    rig.clock.advance(5.1)
    assert rig.topics.get_battery_info() is None


def test_a_lot_in_sight_is_believed_for_two_seconds(rig: Rig) -> None:
    rig.inputs.park_lot_detected.publish(True)
    assert rig.topics.get_park_lot_detected()
    rig.clock.advance(2.1)
    assert not rig.topics.get_park_lot_detected()


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
    rig: Rig, verdict: Verdict, age: float, inside: bool
) -> None:
    rig.topics.des_pose_pub.publish(DesiredPose(7, 1.0, 2.0))
    rig.inputs.verdict.publish(verdict)
    rig.clock.advance(age)
    assert rig.topics.get_des_loc_inbound() is inside


def test_nothing_is_inbound_when_nothing_is_desired(rig: Rig) -> None:
    rig.inputs.verdict.publish(Verdict(7, Inbound.INSIDE))
    assert not rig.topics.get_des_loc_inbound()


def test_the_map_is_the_very_index_that_was_published(rig: Rig) -> None:
    found = OccupancyMap(version=3)
    rig.inputs.occupancy_map.publish(found)
    assert rig.topics.get_occupancy_map() is found


@pytest.mark.parametrize(
    ("name", "get"),
    [
        ("vision_health", DdcTopicInterface.get_vision_health),
        ("mapper_health", DdcTopicInterface.get_mapper_health),
        ("path_plan_health", DdcTopicInterface.get_path_plan_health),
    ],
)
def test_a_part_that_falls_silent_is_unhealthy(rig: Rig, name: str, get: Callable[[DdcTopicInterface], Health]) -> None:
    topic: Any = getattr(rig.inputs, name)
    topic.publish(Health())
    assert get(rig.topics).is_healthy
    topic.publish(Health.bad("no pose"))
    assert get(rig.topics).reason == "no pose"
    topic.publish(Health())
    rig.clock.advance(2.1)
    assert get(rig.topics) == Health.bad("No result lately.")


def test_the_overall_health_names_the_first_part_that_is_not_well(rig: Rig) -> None:
    rig.all_well()
    assert rig.topics.get_health_status().is_healthy
    rig.inputs.recording_health.publish(Health.bad("disk full"))
    assert rig.topics.get_health_status().reason == "recording: disk full"
    rig.inputs.mapper_health.publish(Health.bad("torn"))
    assert rig.topics.get_health_status().reason == "mapper: torn"
    rig.inputs.loop_lag.publish(0.2)
    rig.clock.advance(3.1)
    assert rig.topics.get_health_status().reason == "link: No word from the autopilot."


def test_a_second_sender_is_a_fault_that_is_shown_and_the_autopilot_is_heard_all_the_same(rig: Rig) -> None:
    rig.all_well()
    rig.inputs.second_sender.publish("10.0.0.6:5 (system 1) sends, too.")
    assert rig.topics.get_health_status().reason == "link: 10.0.0.6:5 (system 1) sends, too."
    assert rig.topics.get_link_health().is_healthy
    rig.clock.advance(3.1)
    assert rig.topics.get_health_status().reason == "link: No word from the autopilot."
    rig.all_well()
    rig.inputs.second_sender.publish("")
    assert rig.topics.get_health_status().is_healthy


def test_nothing_is_desired_and_no_state_is_told_at_first(rig: Rig) -> None:
    assert rig.topics.des_pose_pub.value is None
    assert rig.topics.curr_state_pub.value is None


def test_what_the_states_publish_is_there_for_the_algorithms(rig: Rig) -> None:
    desired = DesiredPose(1, 10.0, 20.0)
    rig.topics.des_pose_pub.publish(desired)
    assert rig.topics.des_pose_pub.value is desired
