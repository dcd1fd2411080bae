from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.model.frames import Attitude, EkfPosition, Frames, OffsetObserver, anchor, offset_ned, place_at
from hawk.model.moment import Moment
from hawk.model.poses import ArmPlace, GlobalPose

DATUM = GlobalPose(43.2609, -79.9192, 100.0)
LEVEL = Attitude(0.0, 0.0, 0.0, 0.5)
metres = st.floats(-500, 500)


def at(x: float, y: float, z: float) -> EkfPosition:
    return EkfPosition(0.0, x, y, z, 0.0, 0.0, 0.0)


def arm_place(north: float = 0.0, east: float = 0.0, ekf: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> ArmPlace:
    place = place_at(north, east, DATUM)
    return ArmPlace(place.latitude, place.longitude, 104.0, *ekf)


@pytest.mark.slow
@given(metres, metres, st.floats(-100, 100))
def test_a_place_and_its_offset_are_each_others_reverse(north: float, east: float, up: float) -> None:
    found = offset_ned(place_at(north, east, DATUM, up), DATUM)
    assert found == pytest.approx((north, east, -up), abs=1e-3)


def test_a_thousandth_of_a_degree_north_is_about_111_metres() -> None:
    north, east, _ = offset_ned(replace(DATUM, latitude=DATUM.latitude + 0.001), DATUM)
    assert north == pytest.approx(111.1, abs=0.1)
    assert east == pytest.approx(0.0, abs=1e-6)


def test_local_is_about_the_arm_place_and_map_about_the_datum() -> None:
    frames = Frames.create(arm_place(30.0, -20.0, ekf=(5.0, 6.0, -1.0)), DATUM)
    position = at(7.0, 9.0, -36.0)
    local = frames.local(position, 0.5)
    assert (local.x, local.y, local.z, local.yaw) == pytest.approx((2.0, 3.0, -35.0, 0.5))
    pose = frames.map(position, LEVEL)
    assert (pose.north, pose.east, pose.height) == pytest.approx((32.0, -17.0, 35.0), abs=1e-3)
    world = frames.world(position)
    assert offset_ned(world, DATUM) == pytest.approx((32.0, -17.0, -39.0), abs=1e-3)


@pytest.mark.slow
@given(metres, metres, st.floats(0, 100), metres, metres)
def test_a_target_on_the_map_is_the_place_that_is_seen_there(
    north: float, east: float, height: float, ekf_x: float, ekf_y: float
) -> None:
    frames = Frames.create(arm_place(12.0, 34.0, ekf=(ekf_x, ekf_y, 2.0)), DATUM)
    x, y, z = frames.ekf(north, east, height)
    pose = frames.map(at(x, y, z), LEVEL)
    assert (pose.north, pose.east, pose.height) == pytest.approx((north, east, height), abs=1e-6)


def test_armed_again_five_metres_away_nothing_on_the_map_moves() -> None:
    """The same spot of ground is at the same place of the map in both flights."""
    spot = place_at(40.0, 25.0, DATUM)
    found = []
    for north, east, ekf in ((0.0, 0.0, (0.0, 0.0, 0.0)), (3.0, 4.0, (100.0, -50.0, 3.0))):
        frames = Frames.create(arm_place(north, east, ekf), DATUM)
        n, e, _ = offset_ned(replace(spot, altitude=104.0), frames.home)
        pose = frames.map(at(ekf[0] + n, ekf[1] + e, ekf[2] - 30.0), LEVEL)
        found.append((pose.north, pose.east, pose.height))
    assert found[0] == pytest.approx(found[1], abs=1e-3)
    assert found[0] == pytest.approx((40.0, 25.0, 30.0), abs=1e-3)


def test_home_ties_the_frames_when_the_drone_is_elsewhere() -> None:
    home = GlobalPose(DATUM.latitude, DATUM.longitude, 104.0)
    here = place_at(20.0, 10.0, home, up=35.0)
    place = anchor(at(120.0, 210.0, -5.0), here, home, boot=Moment("host", 9.0))
    assert (place.ekf_x, place.ekf_y, place.ekf_z) == pytest.approx((100.0, 200.0, 30.0), abs=1e-3)
    assert (place.latitude, place.longitude, place.altitude, place.boot.seconds) == (
        home.latitude,
        home.longitude,
        104.0,
        9.0,
    )


class TestOffsetObserver:
    arm = arm_place(ekf=(1.0, 2.0, -3.0))

    def look(self, watch: OffsetObserver, shift: tuple[float, float, float], north: float = 10.0) -> float | None:
        """One look while the drone is ``north`` of home and EKF-local is shifted; the jump's metres if there is one."""
        here = place_at(north, 0.0, GlobalPose(self.arm.latitude, self.arm.longitude, self.arm.altitude), up=30.0)
        x, y, z = self.arm.ekf_x + north + shift[0], self.arm.ekf_y + shift[1], self.arm.ekf_z - 30.0 + shift[2]
        jump = watch.look(self.arm, at(x, y, z), here)
        if jump is None:
            return None
        ekf = (jump.arm.ekf_x, jump.arm.ekf_y, jump.arm.ekf_z)
        expected = tuple(a + s for a, s in zip((1.0, 2.0, -3.0), shift, strict=True))
        assert ekf == pytest.approx(expected, abs=1e-2)
        assert (jump.arm.latitude, jump.arm.longitude) == (self.arm.latitude, self.arm.longitude)
        return jump.metres

    def test_agreement_is_no_event_wherever_the_drone_is(self) -> None:
        watch = OffsetObserver()
        assert [self.look(watch, (0.3, -0.3, 0.2), north) for north in (0.0, 50.0, 200.0)] == [None] * 3
        assert watch.sure

    @pytest.mark.parametrize("shift", [(5.0, 0.0, 0.0), (0.0, -1.5, 0.0), (0.0, 0.0, 2.0)])
    def test_a_jump_counts_when_three_looks_agree(self, shift: tuple[float, float, float]) -> None:
        watch = OffsetObserver()
        assert self.look(watch, shift) is None
        assert not watch.sure
        assert self.look(watch, shift) is None
        assert self.look(watch, shift) == pytest.approx(math.hypot(*shift), abs=0.02)
        assert watch.sure

    def test_one_wild_look_is_no_jump(self) -> None:
        watch = OffsetObserver()
        assert self.look(watch, (8.0, 0.0, 0.0)) is None
        assert self.look(watch, (0.0, 0.0, 0.0)) is None
        assert self.look(watch, (8.0, 0.0, 0.0)) is None
        assert self.look(watch, (8.0, 0.0, 0.0)) is None
        assert not watch.sure

    def test_looks_that_disagree_start_again(self) -> None:
        watch = OffsetObserver()
        for shift in (3.0, 6.0, 9.0, 12.0):
            assert self.look(watch, (shift, 0.0, 0.0)) is None
        assert self.look(watch, (12.0, 0.0, 0.0)) is None
        assert self.look(watch, (12.0, 0.0, 0.0)) == pytest.approx(12.0, abs=0.02)

    def test_a_doubt_is_settled_by_three_looks(self) -> None:
        watch = OffsetObserver()
        watch.doubt()
        for _ in range(2):
            self.look(watch, (0.0, 0.0, 0.0))
            assert not watch.sure
        self.look(watch, (0.0, 0.0, 0.0))
        assert watch.sure
