"""Every access program of DDC Topic Interface: what it gives, and that nothing old or absent is passed off as known."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from hawk.comm.autopilot.vehicle import VehicleTopics
from hawk.ddc.readings.topic_interface import DdcInputs, DdcTopicInterface
from hawk.model.lot_map import OccupancyMap
from hawk.model.operation import Health, HealthStatus
from hawk.model.plans import DesiredPose, HeightParameters, Inbound, PathPlan, Verdict
from hawk.model.poses import GlobalPose, LocalPose, MapPoint, MapPose, VehiclePose
from hawk.model.vehicle import BatteryInfo, Diagnostics, VehicleState
from hawk.specification.access_programs import DdcAccess
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
    assert topics.get_battery_info() is None
    assert topics.get_diagnostics() == Diagnostics()
    assert topics.get_occupancy_map() == OccupancyMap()
    for health in (topics.get_vision_health(), topics.get_mapper_health(), topics.get_path_plan_health()):
        assert health == Health.bad("No result yet.")
    assert topics.get_link_age() == topics.get_pose_age() == math.inf


def test_the_autopilots_state_and_poses_are_given_as_they_came(rig: Rig) -> None:
    state = VehicleState(connected=True, time=rig.clock())
    rig.vehicle.state.publish(state)
    pose = rig.pose(LocalPose(5.0, 6.0, -7.0, 0.5), 7.0)
    assert rig.topics.get_state() is state
    assert rig.topics.get_global_pose() == pose.global_


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
    reported = Health(HealthStatus.HEALTHY, "Camera: 1 of the last 20 pictures was damaged")
    rig.inputs.camera_health.publish(reported)
    assert rig.topics.get_camera_health() == reported
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


def test_a_second_sender_is_a_fault_that_is_shown_and_the_autopilot_is_heard_all_the_same(rig: Rig) -> None:
    rig.all_well()
    rig.inputs.second_sender.publish("10.0.0.6:5 (system 1) sends, too.")
    assert DdcAccess(rig.topics).get_health_status().reason == "link: 10.0.0.6:5 (system 1) sends, too."
    assert rig.topics.get_link_health().is_healthy
    rig.clock.advance(3.1)
    assert DdcAccess(rig.topics).get_health_status().reason == "link: No word from the autopilot."
    rig.all_well()
    rig.inputs.second_sender.publish("")
    assert DdcAccess(rig.topics).get_health_status().is_healthy


def test_each_reading_holds_up_to_its_age(rig: Rig) -> None:
    topics = rig.topics
    rig.all_well()
    rig.vehicle.battery.publish(BatteryInfo(percentage=80.0, voltage=16.0))
    rig.inputs.verdict.publish(Verdict(7, Inbound.INSIDE))
    plan = PathPlan(asked=Verdict(3, Inbound.OUTSIDE))
    rig.inputs.path_plan.publish(plan)
    rig.inputs.footprint.publish((MapPoint(1.0, 2.0),))
    rig.inputs.park_lot_detected.publish(True)
    pose = rig.vehicle.pose.value

    def known() -> list[object]:
        return [
            topics.get_fresh_pose() is pose,
            topics.get_position_health().is_healthy,
            topics.get_fresh_verdict() is not None,
            topics.get_asked_verdict() == plan.asked,
            topics.get_path_plan() is plan,
            topics.get_footprint() == (MapPoint(1.0, 2.0),),
            topics.has_lot_word(),
            topics.get_vision_health().is_healthy,
            topics.get_link_health().is_healthy,
            topics.get_battery_info() is not None,
            topics.get_diagnostics() is GOOD,
        ]

    ends = [0.5, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 3.0, 5.0, 5.0]
    for after in (0.5, 1.0, 2.0, 3.0, 5.0):
        rig.clock.advance(100.0 + after - rig.clock())
        assert [bool(each) for each in known()] == [after <= end for end in ends], after
        assert topics.get_pose_age() == topics.get_link_age() == topics.get_battery_age() == after
        rig.clock.advance(0.01)
        assert [bool(each) for each in known()] == [after < end for end in ends], after
    assert topics.get_pose() is pose
    assert topics.get_path_plan_time() == 100.0
    assert topics.get_asked_verdict() is None
    assert topics.has_lot_word() is None


def test_a_pose_that_is_not_whole_takes_no_target(rig: Rig) -> None:
    whole = rig.pose()
    assert rig.topics.get_fresh_pose() is whole
    for place in (None, MapPose(math.nan, 2.0, 3.0, 0.0, 0.0, 0.0)):
        rig.vehicle.pose.publish(replace(whole, map=place))
        assert rig.topics.get_fresh_pose() is None
    rig.vehicle.pose.publish(replace(whole, time=rig.clock() + 1.0))
    assert rig.topics.get_pose_age() == 0.0, "a stamp ahead of us is no age"


def test_a_position_that_the_autopilot_does_not_trust(rig: Rig) -> None:
    rig.all_well()
    rig.vehicle.diagnostics.publish(replace(GOOD, estimator_fault="GPS glitch"))
    assert rig.topics.get_position_health().reason == "The autopilot does not trust its position: GPS glitch."
    rig.vehicle.diagnostics.publish(replace(GOOD, global_position_ok=False))
    assert rig.topics.get_position_health().reason == "The autopilot trusts no position."
    rig.clock.advance(1.1)
    assert rig.topics.get_position_health().reason == "No position from the autopilot."


def test_a_link_that_ended_is_not_heard(rig: Rig) -> None:
    assert rig.topics.get_link_health().reason == "No autopilot found yet."
    rig.vehicle.state.publish(VehicleState(connected=False, time=rig.clock()))
    assert rig.topics.get_link_health().reason == "No word from the autopilot."
    rig.vehicle.state.publish(VehicleState(connected=True, time=rig.clock() + 1.0))
    assert rig.topics.get_link_age() == 0.0


def test_a_loop_that_is_late_is_not_well(rig: Rig) -> None:
    rig.all_well()
    rig.inputs.loop_lag.publish(0.1)
    assert DdcAccess(rig.topics).get_health_status().is_healthy
    rig.inputs.loop_lag.publish(0.101)
    assert DdcAccess(rig.topics).get_health_status().reason == "loop: The program is 101 ms late."
    rig.inputs.loop_lag.publish(2.0)
    assert DdcAccess(rig.topics).get_health_status().reason == "loop: The program is 2000 ms late."


def test_requests_and_tasks_are_well_until_they_say_otherwise(rig: Rig) -> None:
    rig.all_well()
    rig.inputs.tasks_health.publish(Health.bad("vision ended"))
    assert DdcAccess(rig.topics).get_health_status().reason == "tasks: vision ended"
    rig.inputs.requests_health.publish(Health.bad("arm hangs"))
    assert DdcAccess(rig.topics).get_health_status().reason == "requests: arm hangs"
    assert [name for name, _ in rig.topics.get_part_healths()] == [
        "link",
        "position",
        "camera",
        "vision",
        "mapper",
        "planner",
        "recording",
        "requests",
        "tasks",
        "loop",
    ]


def test_what_is_shown_of_pictures_and_heights(rig: Rig) -> None:
    topics = rig.topics
    assert topics.get_camera_age() is None
    assert topics.get_vision_rate() is None
    assert topics.get_footprint() == ()
    assert topics.get_heights() == HeightParameters()
    assert topics.get_path_plan_time() == -math.inf
    rig.inputs.camera_time.publish(98.5)
    rig.inputs.vision_rate.publish(4.5)
    topics.heights_pub.publish(HeightParameters(16.0, 21.0, 41.0))
    assert (topics.get_camera_age(), topics.get_vision_rate()) == (1.5, 4.5)
    assert topics.get_heights() == HeightParameters(16.0, 21.0, 41.0)
    rig.inputs.camera_time.publish(101.0)
    assert topics.get_camera_age() == 0.0


def test_nothing_is_desired_and_no_state_is_reported_at_first(rig: Rig) -> None:
    assert rig.topics.des_pose_pub.value is None
    assert rig.topics.curr_state_pub.value is None


def test_what_the_states_publish_is_there_for_the_algorithms(rig: Rig) -> None:
    desired = DesiredPose(1, 10.0, 20.0)
    rig.topics.des_pose_pub.publish(desired)
    assert rig.topics.des_pose_pub.value is desired
