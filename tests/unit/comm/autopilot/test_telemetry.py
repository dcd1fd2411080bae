from __future__ import annotations

import logging
import math

import pytest

from hawk.comm.autopilot.mavlink_link import Message, SensorHealth
from hawk.comm.autopilot.streams import RateKeeper, wanted_streams
from hawk.comm.autopilot.telemetry import LINK_LOST_S
from hawk.model.moment import Moment
from hawk.model.poses import ArmPlace, GlobalPose, VehiclePose
from hawk.model.vehicle import CopterMode, LandedState, StatusText
from tests.unit.comm.autopilot.telemetry_rig import IN_AIR, ON_GROUND, UP, WALL, Rig
from tests.unit.comm.fakes import ALTITUDE, LATITUDE, LONGITUDE, METRE_NORTH


@pytest.fixture
def rig() -> Rig:
    return Rig()


def test_armed_and_mode_come_from_the_heartbeat(rig: Rig) -> None:
    rig.take(rig.said.heartbeat(armed=True, mode=CopterMode.SMART_RTL))
    state = rig.topics.state.value
    assert state is not None
    assert (state.connected, state.armed, state.mode, state.time) == (True, True, "SMART_RTL", 50.0)


def test_a_heartbeat_of_something_else_than_an_autopilot_is_not_heard(rig: Rig) -> None:
    rig.take(rig.said.heartbeat(armed=True, autopilot=8))
    assert rig.topics.state.value is None


def test_landed_states_are_reported_as_they_come(rig: Rig) -> None:
    rig.take(rig.said.heartbeat())
    for number, state in ((1, LandedState.ON_GROUND), (3, LandedState.TAKING_OFF), (99, LandedState.UNDEFINED)):
        rig.take(rig.said.landed(number))
        assert rig.topics.state.value is not None
        assert rig.topics.state.value.landed is state


def test_silence_is_a_lost_link_and_a_heartbeat_finds_it_again(rig: Rig) -> None:
    rig.take(rig.said.heartbeat(armed=True))
    rig.advance(LINK_LOST_S - 0.1)
    assert rig.telemetry.check_link(rig.clock())
    rig.advance(0.2)
    assert not rig.telemetry.check_link(rig.clock())
    lost = rig.topics.state.value
    assert lost is not None
    assert (lost.connected, lost.armed, lost.time) == (False, True, 50.0)
    rig.take(rig.said.heartbeat(armed=True))
    assert rig.telemetry.check_link(rig.clock())
    assert rig.telemetry.state.connected


def test_before_arming_there_is_a_place_on_the_globe_but_no_local_and_no_map(rig: Rig) -> None:
    rig.take(rig.said.heartbeat(), rig.said.landed(ON_GROUND))
    rig.fly(0.2)
    pose = rig.topics.pose.value
    assert pose is not None
    assert (pose.global_.latitude, pose.global_.longitude) == pytest.approx((LATITUDE, LONGITUDE))
    assert (pose.local, pose.map, pose.relative_altitude) == (None, None, None)
    assert rig.telemetry.tie.frames is None


def test_without_any_place_on_the_globe_there_is_no_pose(rig: Rig) -> None:
    rig.take(rig.said.heartbeat(), rig.said.attitude(), rig.said.local())
    name, fields = rig.said.world()
    rig.take((name, fields | {"lat": 0, "lon": 0}), rig.said.local())
    assert rig.topics.pose.value is None


def test_the_arm_place_is_the_first_pose_after_armed_is_seen(rig: Rig) -> None:
    rig.arm_here(ekf=(3.0, -2.0, 0.4))
    assert len(rig.places) == 1
    place = rig.places[0]
    assert (place.latitude, place.longitude, place.altitude) == pytest.approx((LATITUDE, LONGITUDE, ALTITUDE))
    assert (place.ekf_x, place.ekf_y, place.ekf_z) == pytest.approx((3.0, -2.0, 0.4), abs=0.02)
    assert place.boot.seconds == pytest.approx(UP - 100.0, abs=1)
    assert place.boot.utc == pytest.approx(WALL - 100.0, abs=1)
    assert rig.telemetry.tie.datum == GlobalPose(place.latitude, place.longitude, place.altitude)
    rig.fly(0.1, ekf=(3.0, -2.0, -0.2), up=0.6)
    pose = rig.topics.pose.value
    assert pose is not None
    assert pose.local is not None
    assert pose.map is not None
    assert (pose.local.x, pose.local.y, pose.relative_altitude) == pytest.approx((0.0, 0.0, 0.6), abs=0.02)
    assert (pose.map.north, pose.map.east, pose.map.height, pose.map.yaw) == pytest.approx((0, 0, 0.6, 0.5), abs=0.02)


def test_land_and_arm_again_five_metres_away_keeps_the_datum(rig: Rig) -> None:
    rig.arm_here()
    datum = rig.telemetry.tie.datum
    rig.take(rig.said.heartbeat(armed=False))
    rig.fly(0.3, ekf=(5.0, 0.0, 0.0), north=5.0)
    rig.take(rig.said.heartbeat(armed=True))
    rig.fly(0.3, ekf=(5.0, 0.0, 0.0), north=5.0)
    assert len(rig.places) == 2
    assert rig.telemetry.tie.datum == datum
    pose = rig.topics.pose.value
    assert pose is not None
    assert pose.local is not None
    assert pose.map is not None
    assert (pose.local.x, pose.map.north) == pytest.approx((0.0, 5.0), abs=0.03)


def test_armed_seen_in_the_air_takes_home_for_the_arm_place(rig: Rig) -> None:
    """A daemon that starts in the air without a journal: the drone is 12 m north of home and 30 m above it."""
    rig.take(rig.said.heartbeat(armed=True), rig.said.landed(IN_AIR))
    rig.fly(0.5, ekf=(12.0, 0.0, -30.0), north=12.0, up=30.0)
    assert rig.places == []
    rig.take(rig.said.home())
    rig.fly(0.2, ekf=(12.0, 0.0, -30.0), north=12.0, up=30.0)
    assert len(rig.places) == 1
    pose = rig.topics.pose.value
    assert pose is not None
    assert pose.map is not None
    assert (pose.map.north, pose.map.height) == pytest.approx((12.0, 30.0), abs=0.05)


def test_home_is_published_with_each_message(rig: Rig) -> None:
    found: list[GlobalPose] = []
    rig.topics.home.listen(found.append)
    rig.take(rig.said.home(), rig.said.home(300.0), ("HOME_POSITION", {"latitude": 1}))
    assert [place.latitude for place in found] == pytest.approx([LATITUDE, LATITUDE + 300 * METRE_NORTH], abs=1e-6)
    assert found[-1].altitude == ALTITUDE


def test_an_arm_place_of_the_same_boot_is_taken_up(rig: Rig) -> None:
    kept = ArmPlace(LATITUDE, LONGITUDE, ALTITUDE, 1.0, 2.0, 3.0, Moment("host", UP - 99.0, WALL - 99.0))
    rig.telemetry.tie.set_datum(GlobalPose(LATITUDE - 10 * METRE_NORTH, LONGITUDE, ALTITUDE))
    rig.telemetry.restore_arm_place(kept)
    rig.take(rig.said.heartbeat(armed=True), rig.said.landed(IN_AIR), rig.said.home(99.0))
    rig.fly(0.3, ekf=(5.0, 2.0, -17.0), north=4.0, up=20.0)
    assert rig.places == [kept]
    pose = rig.topics.pose.value
    assert pose is not None
    assert pose.map is not None
    assert (pose.map.north, pose.map.height) == pytest.approx((14.0, 20.0), abs=0.05)


def test_an_arm_place_of_an_earlier_boot_is_void(rig: Rig) -> None:
    kept = ArmPlace(LATITUDE, LONGITUDE, ALTITUDE, 1.0, 2.0, 3.0, Moment("host", UP - 5000.0, WALL - 100.0))
    rig.telemetry.restore_arm_place(kept)
    rig.take(rig.said.heartbeat(armed=True), rig.said.landed(IN_AIR))
    rig.fly(0.3)
    assert rig.places == []
    assert rig.telemetry.tie.frames is None


@pytest.mark.fault("the wall clock steps by 31 minutes or 3 days in the air, forward or back")
@pytest.mark.parametrize(
    ("boot", "is_same"),
    [
        (Moment("host", UP - 100.0, WALL + 31 * 60.0), True),
        (Moment("host", UP - 100.0, WALL - 3 * 86400.0), True),
        (Moment("host", UP - 94.0, WALL - 100.0), False),
        (Moment("earlier", 500.0, WALL - 100.0), False),
        (Moment("", UP - 100.0, WALL - 100.0), False),
    ],
    ids=["wall clock set back", "wall clock set ahead", "booted 6 s later", "this computer booted first", "unknown"],
)
def test_an_arm_place_belongs_to_a_boot_by_the_kernels_clock(rig: Rig, boot: Moment, is_same: bool) -> None:
    rig.telemetry.restore_arm_place(ArmPlace(LATITUDE, LONGITUDE, ALTITUDE, 1.0, 2.0, 3.0, boot))
    rig.take(rig.said.heartbeat(armed=True), rig.said.landed(IN_AIR))
    rig.fly(0.3)
    assert bool(rig.places) is is_same


@pytest.mark.fault("the companion computer boots in the air")
@pytest.mark.parametrize(
    ("up", "off", "is_same"),
    [(15.0, 0.0, True), (79.0, 4.0, True), (15.0, 6.0, False), (15.0, -1860.0, False), (82.0, 0.0, False)],
    ids=["both say so", "to 5 s", "wall 6 s off", "wall 31 min off", "autopilot began 18 s before it"],
)
def test_after_a_boot_of_this_computer_in_the_air_two_clocks_must_say_that_the_autopilot_ran_on(
    rig: Rig, up: float, off: float, is_same: bool
) -> None:
    rig.now = Moment("second", up, WALL)
    kept = Moment("first", 40.0, WALL - 100.0 + off)
    rig.telemetry.restore_arm_place(ArmPlace(LATITUDE, LONGITUDE, ALTITUDE, 1.0, 2.0, 3.0, kept))
    rig.take(rig.said.heartbeat(armed=True), rig.said.landed(IN_AIR))
    rig.fly(0.3)
    assert bool(rig.places) is is_same


def test_an_arm_place_that_is_restored_too_late_does_not_replace_a_newer_one(rig: Rig) -> None:
    rig.arm_here()
    rig.telemetry.restore_arm_place(ArmPlace(0.0, 0.0, 0.0, 9.0, 9.0, 9.0, Moment("host", UP - 100.0, WALL)))
    assert len(rig.places) == 1


def test_a_jump_of_ekf_local_is_reported_and_the_map_stays(rig: Rig) -> None:
    rig.arm_here()
    rig.fly(0.5, ekf=(10.0, 0.0, -30.0), north=10.0, up=30.0)  # leaps from the arm place: the watch must settle first
    rig.fly(0.5, ekf=(10.0, 0.0, -30.0), north=10.0, up=30.0)
    assert rig.jumps == []
    before = rig.topics.pose.value
    published: list[VehiclePose] = []
    rig.topics.pose.listen(published.append)
    rig.fly(0.5, ekf=(16.0, -8.0, -30.0), north=10.0, up=30.0)
    assert rig.jumps == [pytest.approx(10.0, abs=0.05)]
    assert len(rig.places) == 2
    assert before is not None
    assert before.map is not None
    assert published
    for pose in published:
        assert pose.map is not None
        assert (pose.map.north, pose.map.east) == pytest.approx((before.map.north, before.map.east), abs=0.05)


def test_the_local_position_is_metres_north_and_east_of_the_arm_place(rig: Rig) -> None:
    rig.arm_here(ekf=(5.0, 6.0, -1.0))
    rig.fly(0.2, ekf=(5.4, 5.1, -1.7), north=0.4, up=0.7)
    pose = rig.topics.pose.value
    assert pose is not None
    assert pose.local is not None
    assert (pose.local.x, pose.local.y, pose.local.z) == pytest.approx((0.4, -0.9, -0.7))
    assert pose.map is not None
    assert (pose.map.north, pose.map.east, pose.map.height) == pytest.approx((0.4, -0.9, 0.7))
    assert pose.relative_altitude == pytest.approx(0.7)


def test_after_a_jump_a_target_on_the_map_goes_to_the_same_ground(rig: Rig) -> None:
    rig.arm_here()
    rig.fly(0.5, ekf=(0.0, 0.0, -30.0), up=30.0)
    assert rig.telemetry.tie.frames is not None
    assert rig.telemetry.tie.frames.ekf(20.0, 5.0, 30.0) == pytest.approx((20.0, 5.0, -30.0), abs=0.05)
    rig.fly(0.5, ekf=(100.0, 50.0, -32.0), up=30.0)
    assert rig.telemetry.tie.frames.ekf(20.0, 5.0, 30.0) == pytest.approx((120.0, 55.0, -32.0), abs=0.05)


def test_a_leap_of_one_sample_gives_no_wrong_pose(rig: Rig) -> None:
    rig.arm_here()
    rig.fly(0.5)
    published: list[VehiclePose] = []
    rig.topics.pose.listen(published.append)
    rig.advance()
    rig.take(rig.said.attitude(), rig.said.local(50.0, 0.0, 0.0))
    assert published == []
    assert rig.telemetry.pose_at(rig.clock()) is None
    rig.fly(1.0)
    assert rig.jumps == []
    assert published
    assert all(abs(pose.map.north) < 0.1 for pose in published if pose.map is not None)


def test_a_boot_makes_everything_void_that_belonged_to_the_old_one(rig: Rig) -> None:
    rig.arm_here()
    datum = rig.telemetry.tie.datum
    rig.rates.due(rig.clock())
    rig.said.boot = 3.0
    rig.clock.advance(5.0)
    rig.pass_host(5.0)
    rig.take(rig.said.heartbeat(armed=False))
    rig.rates.due(rig.clock())
    rig.fly(0.6)
    assert rig.boots == 1
    assert rig.telemetry.tie.frames is None
    assert rig.telemetry.tie.datum == datum  # the survey goes on
    assert {stream.message_id for stream in rig.rates.due(rig.clock())} >= {1, 24, 245, 242}
    rig.arm_here(ekf=(0.5, 0.0, 0.0))
    assert rig.places[-1].boot.seconds == pytest.approx(rig.now.seconds - rig.said.boot, abs=1)


@pytest.mark.fault("The autopilot boots")
def test_a_boot_is_seen_although_the_link_never_fell_silent(rig: Rig) -> None:
    rig.arm_here()
    rig.said.boot = 0.0
    rig.fly(0.7)
    assert rig.boots == 1
    pose, state = rig.topics.pose.value, rig.topics.state.value
    assert pose is not None
    assert state is not None
    assert pose.time == pytest.approx(rig.clock(), abs=0.01)
    assert pose.map is None
    assert state.landed is LandedState.UNDEFINED
    assert state.armed, "only a HEARTBEAT says that it is disarmed"


def test_a_pose_is_put_at_the_time_it_was_measured_not_when_it_came(rig: Rig) -> None:
    rig.arm_here()
    measured = rig.clock()
    late = rig.said.local(0.5, 0.0, 0.0)
    rig.clock.advance(0.2)
    rig.take(rig.said.attitude(), late)
    pose = rig.topics.pose.value
    assert pose is not None
    assert pose.time == pytest.approx(measured, abs=0.01)


def test_a_pose_is_interpolated_to_the_moment_of_a_picture(rig: Rig) -> None:
    rig.arm_here()
    for index in range(20):
        rig.advance()
        north = 0.2 * index
        rig.take(
            rig.said.attitude(yaw=0.01 * index),
            rig.said.local(north, 0.0, 0.0, velocity=(4.0, 0.0, 0.0)),
            rig.said.world(north),
        )
    pose = rig.telemetry.pose_at(rig.clock() - 0.125)
    assert pose is not None
    assert pose.map is not None
    assert (pose.map.north, pose.map.yaw) == pytest.approx((3.8 - 0.5, 0.19 - 0.025), abs=0.03)
    assert rig.telemetry.pose_at(rig.clock() + 0.4) is None


@pytest.mark.parametrize("field", ["x", "vz", "time_boot_ms"])
def test_a_number_that_is_not_finite_is_not_taken(rig: Rig, field: str, caplog: pytest.LogCaptureFixture) -> None:
    rig.arm_here()
    rig.topics.pose.listen(lambda pose: pytest.fail(f"{pose} was published"))
    with caplog.at_level(logging.WARNING):
        for number in (None, math.inf):
            rig.advance()
            name, fields = rig.said.local()
            rig.take((name, fields | {field: number}))
    assert field in caplog.text


def test_a_message_without_its_fields_does_no_harm(rig: Rig) -> None:
    rig.take(("HEARTBEAT", {}), ("ATTITUDE", {"roll": "x"}), ("GLOBAL_POSITION_INT", {}), ("NEWS", {}))
    assert rig.topics.state.value is None


@pytest.mark.parametrize(("enabled", "fence_on"), [(0x100000, True), (0xEFFFFF, False), (0, False), (None, None)])
def test_sys_status_says_whether_a_fence_is_enabled(rig: Rig, enabled: int | None, fence_on: bool | None) -> None:
    name, fields = rig.said.system()
    rig.take((name, fields if enabled is None else {**fields, "onboard_control_sensors_enabled": enabled}))
    assert rig.topics.diagnostics.value is not None
    assert rig.topics.diagnostics.value.fence_on is fence_on


@pytest.mark.parametrize(
    ("remaining", "millivolts", "centiamperes", "expected"),
    [
        (80, 15_800, 1200, (80.0, 15.8, 12.0)),
        (0, 12_000, 0, (0.0, 12.0, 0.0)),
        (-1, 65_535, -1, (None, None, None)),
        (-1, 0, -1, (None, None, None)),
    ],
)
def test_what_the_battery_does_not_know_is_none(
    rig: Rig, remaining: int, millivolts: int, centiamperes: int, expected: tuple[float | None, ...]
) -> None:
    rig.take(rig.said.system(remaining, millivolts, centiamperes))
    battery = rig.topics.battery.value
    assert battery is not None
    assert (battery.percentage, battery.voltage, battery.current) == expected
    assert battery.time == 50.0


def test_diagnostics_say_what_the_gps_says_while_it_is_fresh(rig: Rig) -> None:
    rig.take(rig.said.estimator(), rig.said.gps(), rig.said.system())
    found = rig.topics.diagnostics.value
    assert found is not None
    assert (found.all_ok, found.global_position_ok) == (True, True)
    assert (found.gps_fix, found.satellites, found.horizontal_accuracy) == (3, 12, 0.8)
    rig.take(rig.said.gps(fix=2), rig.said.system())
    flat = rig.topics.diagnostics.fresh(0.0)
    assert flat is not None
    assert (flat.all_ok, flat.global_position_ok, flat.gps_fix) == (False, False, 2)
    rig.advance(5.0)
    rig.take(rig.said.system())
    stale = rig.topics.diagnostics.fresh(0.0)
    assert stale is not None
    assert (stale.global_position_ok, stale.gps_fix, stale.satellites) == (False, None, None)


def test_the_autopilots_words_are_published_and_kept_as_reasons(rig: Rig) -> None:
    rig.take(rig.said.text("Arm: Throttle too high"))
    assert rig.topics.status_text.value == StatusText(50.0, 3, "Arm: Throttle too high")
    assert rig.telemetry.texts.reason_since(49.0) == "Arm: Throttle too high"
    assert rig.telemetry.texts.reason_since(51.0) is None


def test_a_fence_before_the_first_arm_is_about_where_the_drone_stands(rig: Rig) -> None:
    assert rig.origin() is None
    rig.take(rig.said.heartbeat())
    rig.fly(0.2, north=0.0)
    first = rig.origin()
    rig.fly(0.2, north=4.0)
    assert rig.origin() == first  # drift does not move it
    rig.fly(0.2, north=40.0)
    carried = rig.origin()
    assert carried is not None
    assert carried.latitude == pytest.approx(LATITUDE + 40.0 * METRE_NORTH, abs=1e-7)
    rig.arm_here(north=40.0)
    assert rig.origin() == rig.telemetry.tie.datum


def test_the_datum_may_be_set_again_under_a_drone_that_flies(rig: Rig) -> None:
    rig.arm_here()
    rig.telemetry.tie.set_datum(GlobalPose(LATITUDE - 7 * METRE_NORTH, LONGITUDE, ALTITUDE))
    rig.fly(0.1)
    pose = rig.topics.pose.value
    assert pose is not None
    assert pose.map is not None
    assert pose.map.north == pytest.approx(7.0, abs=0.03)


def test_a_time_of_the_boot_clock_can_be_put_on_ours(rig: Rig) -> None:
    assert rig.telemetry.from_boot(100.0) is None
    rig.take(rig.said.attitude(), rig.said.local())
    assert rig.telemetry.from_boot(100.0) is None
    rig.take(rig.said.world())
    assert rig.telemetry.from_boot(101.5) == pytest.approx(51.5)


class TestDatagramsThatComeLate:
    """The drone is in the air; datagrams from before come late, twice, or out of order."""

    @pytest.fixture
    def high(self, rig: Rig) -> Rig:
        """A drone at 8 m, armed."""
        rig.arm_here()
        rig.take(rig.said.home(), rig.said.landed(IN_AIR))
        for step in range(1, 81):
            rig.advance()
            up = 0.1 * step
            rig.take(
                rig.said.attitude(), rig.said.local(0.0, 0.0, -up, velocity=(0.0, 0.0, -2.0)), rig.said.world(0.0, up)
            )
        rig.take(rig.said.heartbeat(armed=True), rig.said.landed(IN_AIR))
        rig.fly(1.0, ekf=(0.0, 0.0, -8.0), up=8.0)
        return rig

    @pytest.mark.fault(
        "LOCAL_POSITION_NED, ATTITUDE or GLOBAL_POSITION_INT comes 1.2 s late",
        "Dropped: no boot, no pose",
    )
    @pytest.mark.parametrize("kind", ["local", "attitude", "world"])
    def test_one_that_is_late_is_no_boot_and_no_pose(self, high: Rig, kind: str) -> None:
        late = getattr(high.said, kind)()
        high.fly(1.2, ekf=(0.0, 0.0, -8.0), up=8.0)
        before = high.topics.pose.value
        high.take(late)
        assert high.boots == 0
        assert high.topics.pose.value is before
        assert high.telemetry.state.armed
        assert high.telemetry.state.landed is LandedState.IN_AIR
        high.fly(0.1, ekf=(0.0, 0.0, -8.0), up=8.0)
        assert high.topics.pose.value is not before

    @pytest.mark.fault("A datagram comes twice", "Dropped: no second pose")
    def test_one_that_is_repeated_gives_no_second_pose(self, high: Rig) -> None:
        high.advance()
        message = high.said.local(0.0, 0.0, -8.0)
        high.take(high.said.attitude(), message)
        published: list[VehiclePose] = []
        high.topics.pose.listen(published.append)
        high.take(message, message)
        assert published == []

    def test_a_corrupt_stamp_far_ahead_moves_nothing(self, high: Rig) -> None:
        name, fields = high.said.local(0.0, 0.0, -8.0)
        high.take((name, fields | {"time_boot_ms": 4_294_967_295}))
        high.fly(2.0, ekf=(0.0, 0.0, -8.0), up=8.0)
        assert high.boots == 0
        pose = high.topics.pose.value
        assert pose is not None
        assert pose.time == pytest.approx(high.clock())

    @pytest.mark.fault(
        'One HEARTBEAT "disarmed" of before comes late in the air, with or without a late "on the ground"',
    )
    def test_a_late_disarmed_and_a_late_landed_do_not_move_the_arm_place(self, high: Rig) -> None:
        high.take(high.said.heartbeat(armed=False), high.said.landed(ON_GROUND))
        high.fly(0.3, ekf=(0.0, 0.0, -8.0), up=8.0)
        high.take(high.said.heartbeat(armed=True))
        high.fly(0.3, ekf=(0.0, 0.0, -8.0), up=8.0)
        high.take(high.said.landed(IN_AIR))
        high.fly(3.0, ekf=(0.0, 0.0, -8.0), up=8.0)
        assert len(high.places) == 1
        pose = high.topics.pose.value
        assert pose is not None
        assert pose.relative_altitude == pytest.approx(8.0, abs=0.02)


@pytest.mark.fault(
    'EXTENDED_SYS_STATE is old when "armed" is first seen in the air',
    "The arm place is home, never the place in the air",
)
def test_an_old_landed_does_not_make_the_air_the_arm_place(rig: Rig) -> None:
    """EXTENDED_SYS_STATE stopped on the ground; "armed" is first seen at 8 m: home is the arm place."""
    rig.take(rig.said.heartbeat(), rig.said.landed(ON_GROUND), rig.said.home())
    rig.fly(1.0)
    rig.take(rig.said.heartbeat())
    rig.fly(3.0, ekf=(0.0, 0.0, -8.0), up=8.0)
    rig.take(rig.said.heartbeat(armed=True))
    rig.fly(2.0, ekf=(0.0, 0.0, -8.0), up=8.0)
    assert rig.places == []
    rig.fly(1.5, ekf=(0.0, 0.0, -8.0), up=8.0)
    assert len(rig.places) == 1
    pose = rig.topics.pose.value
    assert pose is not None
    assert pose.relative_altitude == pytest.approx(8.0, abs=0.02)


def test_a_drone_that_was_carried_up_a_hill_is_armed_there(rig: Rig) -> None:
    rig.arm_here()
    rig.take(rig.said.heartbeat(armed=False), rig.said.landed(ON_GROUND))
    rig.fly(1.0, ekf=(40.0, 0.0, -10.0), north=40.0, up=10.0)
    rig.take(rig.said.heartbeat(armed=False), rig.said.landed(ON_GROUND))
    rig.fly(0.5, ekf=(40.0, 0.0, -10.0), north=40.0, up=10.0)
    rig.take(rig.said.heartbeat(armed=True))
    rig.fly(0.3, ekf=(40.0, 0.0, -10.0), north=40.0, up=10.0)
    assert len(rig.places) == 2
    assert rig.places[-1].ekf_z == pytest.approx(-10.0)


def test_every_landed_state_carries_its_moment(rig: Rig) -> None:
    rig.take(rig.said.heartbeat(armed=True), rig.said.landed(ON_GROUND))
    rig.advance(1.5)
    rig.take(rig.said.landed(ON_GROUND))
    rig.advance(1.9)
    state = rig.telemetry.state
    assert (state.time, state.landed_time) == (50.0, 51.5)
    assert state.landed_at(rig.clock()) is LandedState.ON_GROUND
    rig.advance(0.2)
    assert state.landed_at(rig.clock()) is LandedState.UNDEFINED


def test_armed_in_the_air_at_a_boot_is_anchored_again(rig: Rig) -> None:
    """An autopilot whose watchdog booted it in flight stays armed: home becomes the arm place."""
    rig.arm_here()
    rig.said.boot = 0.0
    rig.take(rig.said.heartbeat(armed=True), rig.said.landed(IN_AIR))
    rig.fly(0.7, ekf=(0.0, 0.0, -8.0), up=8.0)
    assert rig.boots == 1
    rig.take(rig.said.heartbeat(armed=True), rig.said.landed(IN_AIR), rig.said.home())
    rig.fly(0.3, ekf=(0.0, 0.0, -8.0), up=8.0)
    assert len(rig.places) == 2
    pose = rig.topics.pose.value
    assert pose is not None
    assert pose.relative_altitude == pytest.approx(8.0, abs=0.02)


class TestRangefinder:
    """DISTANCE_SENSOR turned into the ground below."""

    @staticmethod
    def measure(rig: Rig, centimetres: int, orientation: int = 25, number: int = 0) -> None:
        fields = {"time_boot_ms": rig.said.ms, "min_distance": 20, "max_distance": 5000, "id": number}
        rig.take(("DISTANCE_SENSOR", {**fields, "current_distance": centimetres, "orientation": orientation}))

    def fly(self, rig: Rig, seconds: float, height: float, centimetres: int) -> None:
        for _ in range(round(seconds / 0.1)):
            rig.fly(0.1, (0.0, 0.0, -height), up=height)
            self.measure(rig, centimetres)

    def test_the_ground_is_height_above_the_arm_place_minus_distance(self, rig: Rig) -> None:
        rig.arm_here()
        self.fly(rig, 2.0, 30.0, 2500)
        terrain = rig.topics.terrain.value
        assert terrain is not None
        assert terrain.time == pytest.approx(rig.clock())
        assert terrain.distance == pytest.approx(25.0)
        assert terrain.believed_ground == pytest.approx(5.0, abs=0.05)

    def test_a_lean_is_taken_out(self, rig: Rig) -> None:
        rig.arm_here()
        rig.fly(0.3, (0.0, 0.0, -20.0), up=20.0)
        rig.advance()
        rig.take(rig.said.attitude(roll=0.3), rig.said.local(0.0, 0.0, -20.0))
        self.measure(rig, 2000)
        assert rig.topics.terrain.value is not None
        assert rig.topics.terrain.value.distance is not None
        assert rig.topics.terrain.value.distance == pytest.approx(20.0 * math.cos(0.3), abs=0.01)

    def test_without_a_message_there_is_no_terrain(self, rig: Rig) -> None:
        rig.arm_here()
        rig.fly(2.0)
        assert rig.topics.terrain.value is None

    def test_a_sensor_that_looks_ahead_is_not_heard(self, rig: Rig) -> None:
        rig.arm_here()
        self.measure(rig, 300, orientation=0)
        assert rig.topics.terrain.value is None

    def test_before_arm_there_is_a_distance_and_no_ground(self, rig: Rig) -> None:
        rig.take(rig.said.heartbeat(), rig.said.landed(ON_GROUND))
        self.fly(rig, 2.0, 0.0, 25)
        terrain = rig.topics.terrain.value
        assert terrain is not None
        assert terrain.distance == pytest.approx(0.25)
        assert terrain.ground is None

    @pytest.mark.fault("the rangefinder's messages come late or broken", "dropped")
    def test_one_that_is_late_or_broken_is_dropped(self, rig: Rig) -> None:
        rig.arm_here()
        self.fly(rig, 2.0, 30.0, 2500)
        before = rig.topics.terrain.value
        rig.said.boot -= 1.2
        self.measure(rig, 300)
        rig.said.boot += 1.25
        rig.take(("DISTANCE_SENSOR", {"time_boot_ms": rig.said.ms, "orientation": 25, "current_distance": 300}))
        assert rig.topics.terrain.value is before

    def test_another_arm_place_begins_the_ground_estimate_again(self, rig: Rig) -> None:
        rig.arm_here()
        self.fly(rig, 2.0, 30.0, 2500)
        rig.fly(0.3)
        rig.take(rig.said.heartbeat(), rig.said.landed(ON_GROUND))
        rig.fly(1.0)
        rig.take(rig.said.heartbeat())
        rig.take(rig.said.heartbeat(armed=True))
        rig.fly(0.5)
        self.measure(rig, 2500)
        assert rig.topics.terrain.value is not None
        assert rig.topics.terrain.value.ground is None


def test_a_clock_that_was_mapped_too_late_gives_poses_on_the_right_one_and_is_no_boot(rig: Rig) -> None:
    rig.take(rig.said.heartbeat(), rig.said.landed(ON_GROUND))
    for _ in range(20):  # everything comes three seconds late
        rig.advance()
        for message in (rig.said.attitude(), rig.said.local(), rig.said.world()):
            rig.telemetry.handle(Message(*message, rig.clock() + 3.0))
    late = rig.topics.pose.value
    assert late is not None
    assert late.time == pytest.approx(rig.clock() + 3.0, abs=0.2)
    rig.fly(4.0)
    pose = rig.topics.pose.value
    assert pose is not None
    assert pose.time == pytest.approx(rig.clock(), abs=0.1)
    assert rig.telemetry.from_boot(rig.said.boot) == pytest.approx(rig.clock(), abs=0.01)
    assert rig.boots == 0


def test_half_a_text_is_not_published(rig: Rig) -> None:
    heard: list[StatusText] = []
    rig.topics.status_text.listen(heard.append)
    rig.take(("STATUSTEXT", {"text": "a" * 50, "severity": 4, "id": 7, "chunk_seq": 0}))
    assert heard == []
    rig.take(("STATUSTEXT", {"text": "end", "severity": 4, "id": 7, "chunk_seq": 1}))
    assert [text.text for text in heard] == ["a" * 50 + "end"]


def test_the_link_is_lost_after_two_point_six_seconds_and_silence_counts_from_the_heartbeat(rig: Rig) -> None:
    assert rig.telemetry.silence(99.0) == 0.0
    rig.take(rig.said.heartbeat())
    assert rig.telemetry.silence(52.6) == pytest.approx(2.6)
    assert rig.telemetry.check_link(52.6 - 1e-6)
    assert not rig.telemetry.check_link(52.6 + 1e-6)


def test_on_a_faster_clock_the_link_is_lost_after_the_same_real_seconds(rig: Rig) -> None:
    rig.clock.speed = 10.0
    rig.take(rig.said.heartbeat())
    assert rig.telemetry.check_link(50.0 + 26.0 - 1e-6)
    assert not rig.telemetry.check_link(50.0 + 26.0 + 1e-6)


def test_the_autopilots_newest_time_is_in_milliseconds_and_zero_before_it_is_known(rig: Rig) -> None:
    assert rig.telemetry.boot_ms == 0
    rig.fly(0.5)
    assert rig.telemetry.boot_ms == pytest.approx(100_500, abs=1)


@pytest.mark.parametrize(
    ("latitude", "longitude", "known"), [(0, 0, False), (1, 0, True), (0, 1, True), (-1, 0, True), (0, -1, True)]
)
def test_only_zero_and_zero_is_no_position_yet(rig: Rig, latitude: int, longitude: int, known: bool) -> None:
    for _ in range(8):
        rig.advance()
        name, fields = rig.said.world()
        rig.take(rig.said.attitude(), (name, fields | {"lat": latitude, "lon": longitude}), rig.said.local())
    assert (rig.topics.pose.value is not None) is known


@pytest.mark.parametrize(("metres", "maps"), [(1.9, True), (-1.9, True), (2.2, False), (-2.2, False)])
@pytest.mark.parametrize("is_restored", [False, True])
def test_a_position_that_leapt_by_more_than_two_metres_is_not_mapped(
    rig: Rig, metres: float, maps: bool, is_restored: bool
) -> None:
    if is_restored:
        boot = Moment("host", UP - 100.0, WALL - 100.0)
        rig.telemetry.restore_arm_place(ArmPlace(LATITUDE, LONGITUDE, ALTITUDE, 0.0, 0.0, 0.0, boot))
        rig.take(rig.said.heartbeat(armed=True), rig.said.landed(IN_AIR))
        rig.fly(1.0)
    else:
        rig.arm_here()
        rig.take(rig.said.landed(IN_AIR))
        rig.fly(1.0)
    rig.fly(1.0, ekf=(metres, 0.0, 0.0), north=metres)
    rig.take(rig.said.estimator())
    assert (rig.telemetry.map_problem(rig.clock()) == "") is maps


def test_a_stream_is_asked_for_again_once_a_second_while_it_is_silent(rig: Rig) -> None:
    rates = RateKeeper(wanted_streams(20.0))
    names = list(wanted_streams(20.0).values())
    rangefinder = wanted_streams(20.0)["DISTANCE_SENSOR"]
    others = [stream for stream in names if stream != rangefinder]
    assert rates.due(10.0) == names
    assert rates.due(10.99) == []
    assert rates.due(11.0) == others
    assert rangefinder not in rates.due(19.99)
    assert rangefinder in rates.due(20.0)
    rates.forget()
    assert rates.due(11.0) == names
    for name in wanted_streams(20.0):
        rates.seen(name, 12.0)
    rates.seen("SERVO_OUTPUT_RAW", 12.0)
    assert rates.due(13.0) == []
    slow = {stream.message_id for stream in names if stream.hertz <= 8.0} | {rangefinder.message_id}  # asked at 11.0
    assert {stream.message_id for stream in rates.due(13.01)} == {s.message_id for s in names} - slow
    assert rates.age("HOME_POSITION", 13.0) == 1.0
    home = wanted_streams(20.0)["HOME_POSITION"]
    assert home not in rates.due(20.0)
    assert home in rates.due(20.01)
    assert home.interval_us == 1_000_000.0


@pytest.mark.parametrize(
    ("remaining", "millivolts", "centiamperes", "known"),
    [
        (0, 1, 0, (0.0, 0.001, 0.0)),
        (100, 65534, 1, (100.0, 65.534, 0.01)),
        (101, 65535, -1, (None, None, None)),
        (-1, 0, -2, (None, None, None)),
    ],
)
def test_the_battery_at_the_limits_of_its_fields(
    rig: Rig, remaining: int, millivolts: int, centiamperes: int, known: tuple[float | None, ...]
) -> None:
    rig.take(rig.said.system(remaining, millivolts, centiamperes))
    battery = rig.topics.battery.value
    assert battery is not None
    assert (battery.percentage, battery.voltage, battery.current) == known


@pytest.mark.parametrize(("fix", "located"), [(2, False), (3, True), (6, True)])
def test_a_position_needs_a_fix_in_three_dimensions_of_the_last_three_seconds(
    rig: Rig, fix: int, located: bool
) -> None:
    rig.take(rig.said.gps(fix), rig.said.estimator(), rig.said.system())
    shown = rig.topics.diagnostics.value
    assert shown is not None
    assert (shown.all_ok, shown.global_position_ok, shown.gps_fix) == (located, located, fix)
    rig.advance(2.99)
    rig.take(rig.said.estimator(), rig.said.system())
    shown = rig.topics.diagnostics.value
    assert shown is not None
    assert shown.all_ok is located
    rig.advance(0.02)
    rig.take(rig.said.estimator(), rig.said.system())
    shown = rig.topics.diagnostics.value
    assert shown is not None
    assert (shown.all_ok, shown.gps_fix, shown.satellites) == (False, None, None)


@pytest.mark.fault("a link of MAVLink 1, which has no accuracy of the position")
@pytest.mark.parametrize(
    ("frames", "gps", "home", "is_version_1"),
    [
        (None, {}, {}, True),
        (None, {"v_acc": 900}, {}, False),
        (None, {}, {"time_usec": 5}, False),
        (True, {"v_acc": 900}, {"time_usec": 5}, True),
        (False, {}, {}, False),
    ],
    ids=["nothing of version 2", "accuracy of the height", "time of home", "seen in frames", "version 2 in frames"],
)
def test_a_link_of_mavlink_1_is_known_by_its_frames_or_by_all_that_is_missing(
    rig: Rig, frames: bool | None, gps: dict[str, int], home: dict[str, int], is_version_1: bool
) -> None:
    rig.health = SensorHealth(True, True, True, True, frames)
    name, fields = rig.said.gps()
    bare = {key: value for key, value in fields.items() if key not in ("h_acc", "v_acc", "alt_ellipsoid", "vel_acc")}
    place, kept = rig.said.home()
    rig.take((name, bare | gps), (place, kept | {"time_usec": 0} | home), rig.said.system())
    found = rig.topics.diagnostics.value
    assert found is not None
    assert (found.is_mavlink_1, found.horizontal_accuracy) == (is_version_1, None)


def test_before_anything_is_missing_a_link_is_not_called_mavlink_1(rig: Rig) -> None:
    rig.take(rig.said.system())
    found = rig.topics.diagnostics.value
    assert found is not None
    assert not found.is_mavlink_1


def test_an_unknown_number_of_satellites_is_none(rig: Rig) -> None:
    name, fields = rig.said.gps()
    rig.take((name, fields | {"satellites_visible": 255}), rig.said.system())
    found = rig.topics.diagnostics.value
    assert found is not None
    assert found.satellites is None


@pytest.mark.fault("all compasses fail in flight")
@pytest.mark.parametrize(
    ("fields", "works"),
    [
        ({"present": 4, "enabled": 4, "health": 4}, True),
        ({"present": 4, "enabled": 4, "health": 0xFB}, False),
        ({"present": 4, "enabled": 0, "health": 0}, None),
        ({"present": 0, "enabled": 4, "health": 4}, None),
        ({}, None),
    ],
)
def test_sys_status_says_whether_a_compass_works(rig: Rig, fields: dict[str, int], works: bool | None) -> None:
    name, values = rig.said.system()
    rig.take((name, values | {f"onboard_control_sensors_{what}": bits for what, bits in fields.items()}))
    assert rig.topics.diagnostics.value is not None
    assert rig.topics.diagnostics.value.compass_ok is works


def test_the_altitude_by_gnss_comes_with_the_reported_one(rig: Rig) -> None:
    name, values = rig.said.gps()

    def heard(**fields: int) -> tuple[float, float | None, float] | None:
        rig.take((name, values | fields))
        found = rig.topics.gnss_height.value
        return None if found is None else (found.altitude, found.accuracy, found.reported)

    assert heard(alt=104_000) is None, "nothing is reported yet"
    rig.take(rig.said.heartbeat(), rig.said.landed(ON_GROUND))
    rig.fly(0.5)
    assert heard() is None, "no altitude"
    assert heard(alt=104_000, fix_type=2) is None, "no fix"
    assert heard(alt=104_000, v_acc=1500) == (104.0, 1.5, ALTITUDE)
    assert heard(alt=105_000) == (105.0, None, ALTITUDE)
    rig.advance(1.5)
    assert heard(alt=109_000) == (105.0, None, ALTITUDE), "the reported one is old"


@pytest.mark.parametrize(("usec", "utc"), [(1_814_400_000_000_000, 1_814_400_000.0), (0, None), (60_000_000, None)])
def test_the_wall_clock_of_an_autopilot_is_known_once_gnss_has_set_it(rig: Rig, usec: int, utc: float | None) -> None:
    rig.fly(0.5)
    rig.take(("SYSTEM_TIME", {"time_boot_ms": round(rig.said.boot * 1e3), "time_unix_usec": usec}))
    found = rig.telemetry.utc_at(rig.clock() + 5.0)
    assert (None if found is None else found.timestamp()) == (
        None if utc is None else pytest.approx(utc + 5.0, abs=0.1)
    )
