"""Sensors that lie, and the estimate that follows them as a real ArduCopter's was seen to (EKF3 of 4.7)."""

from __future__ import annotations

import math
from typing import Any

import pytest

from hawk.sim.autopilot.autopilot import Autopilot
from hawk.sim.autopilot.sensors import RESET_ERROR, Compasses, Heading, Receiver
from tests.unit.sim.test_faults import put

EKF, RAW, LOCAL, GLOBAL, STATUS, ATTITUDE = 193, 24, 32, 33, 1, 30
MAG = 1 << 2
FAILED = 4


def true_place(autopilot: Autopilot) -> tuple[float, float]:
    return autopilot.body.position[0], autopilot.body.position[1]


class TestWalk:
    @pytest.mark.slow
    def test_the_drone_leaves_its_true_place_and_shows_the_old_one(self, flying: Any) -> None:
        """Flown: 20.4 m in 30 s, 0.43 m shown, -0.43 m/s shown and -0.70 m/s true, position variance 0.30."""
        flying.stream(LOCAL, RAW, EKF)
        began = true_place(flying.autopilot)
        put(flying, gps_walk=(0.7, 0.0))
        flying.run(30.0)
        assert true_place(flying.autopilot)[0] - began[0] == pytest.approx(-20.0, abs=1.5)
        assert flying.autopilot.body.velocity[0] == pytest.approx(-0.7, abs=0.06)
        local, report = flying.last("LOCAL_POSITION_NED"), flying.last("EKF_STATUS_REPORT")
        assert local.vx == pytest.approx(-0.43, abs=0.08)
        assert report.flags == 831
        assert report.pos_horiz_variance == pytest.approx(0.30, abs=0.05)

    @pytest.mark.slow
    def test_it_stays_where_it_is_when_the_walk_ends(self, flying: Any) -> None:
        put(flying, gps_walk=(0.0, 1.0))
        flying.run(5.0)
        put(flying, gps_walk=(0.0, 0.0))
        flying.run(5.0)
        assert flying.autopilot.gnss.offset[1] == pytest.approx(5.0, abs=0.02)
        put(flying, gps_bias=(0.0, 0.0, 0.0))
        assert flying.autopilot.gnss.offset == (0.0, 0.0, 0.0)


@pytest.mark.slow
def test_a_bias_is_there_from_the_boot_and_nothing_jumps(station: Any) -> None:
    put(station, gps_bias=(8.0, -6.0, 3.0), autopilot="reboot")
    station.wait_for_position()
    station.stream(EKF, RAW)
    station.fly()
    north, east, down = (
        shown - true
        for shown, true in zip(station.autopilot.estimate.position, station.autopilot.body.position, strict=True)
    )
    assert (north, east) == pytest.approx((8.0, -6.0), abs=0.5)
    assert down == pytest.approx(0.0, abs=0.5)  # the height is the barometer's
    assert station.last("EKF_STATUS_REPORT").flags == 831
    assert "GPS Glitch or Compass error" not in station.texts()


def test_a_glitch_ends_by_itself() -> None:
    receiver = Receiver()
    receiver.set_glitch((25.0, 0.0, 0.0), 4.0)
    receiver.step(3.9)
    assert receiver.offset[0] == 25.0
    receiver.step(0.2)
    assert receiver.offset[0] == 0.0


@pytest.mark.slow
def test_the_receiver_shows_a_glitch_that_the_estimate_refuses(flying: Any) -> None:
    flying.stream(RAW, GLOBAL)
    flying.run(0.3)
    put(flying, gps_glitch=(30.0, 0.0, 0.0))
    flying.run(3.0)
    metres = (flying.last("GPS_RAW_INT").lat - flying.last("GLOBAL_POSITION_INT").lat) * 1e-7 * 111_111
    assert metres == pytest.approx(30.0, abs=1.0)


@pytest.mark.slow
def test_a_barometer_that_drifts_sinks_the_drone_and_gnss_knows(flying: Any) -> None:
    """Flown: 10.3 m lower after 25 s at 0.5 m/s, 0.26 m above shown, 0.26 m/s shown of 0.50; GNSS shows the truth."""
    flying.stream(RAW, GLOBAL, LOCAL)
    flying.local_target(0.0, 0.0, -20.0)
    flying.run(15.0)
    put(flying, baro_drift=0.5)
    flying.run(25.0)
    body, shown = flying.autopilot.body, flying.last("GLOBAL_POSITION_INT")
    assert body.height == pytest.approx(9.8, abs=1.0)
    assert shown.relative_alt / 1000 == pytest.approx(20.3, abs=0.5)
    assert flying.last("LOCAL_POSITION_NED").vz == pytest.approx(0.26, abs=0.08)
    assert flying.last("GPS_RAW_INT").alt / 1000 - 100.0 == pytest.approx(body.height, abs=1.0)
    put(flying, baro_drift=0.0)
    flying.run(20.0)
    assert body.height - flying.autopilot.body.height == pytest.approx(2.7, abs=0.6)
    put(flying, baro_error=0.0)
    flying.run(30.0)
    assert flying.autopilot.body.height == pytest.approx(20.0, abs=0.6)


def test_a_boot_takes_the_pressure_at_hand_as_that_of_the_ground(station: Any) -> None:
    put(station, baro_error=7.0, autopilot="reboot")
    station.wait_for_position()
    assert station.autopilot.estimate.position[2] == pytest.approx(0.0, abs=0.5)


class TestHeading:
    @pytest.mark.slow
    def test_all_compasses_fail_and_it_flies_on(self, flying: Any) -> None:
        """Flown: SYS_STATUS alone shows it; the heading drifts by 0.03 degrees a second."""
        flying.stream(STATUS, EKF)
        put(flying, compass="lost")
        began = true_place(flying.autopilot)
        flying.run(20.0)
        assert not flying.last("SYS_STATUS").onboard_control_sensors_health & MAG
        assert flying.last("EKF_STATUS_REPORT").flags == 831
        assert math.degrees(flying.autopilot.estimator.heading.error) == pytest.approx(0.6, abs=0.05)
        assert math.dist(began, true_place(flying.autopilot)) < 1.0
        put(flying, compass="ok")
        flying.run(0.3)
        assert flying.last("SYS_STATUS").onboard_control_sensors_health & MAG

    def test_without_a_compass_it_does_not_arm(self, station: Any) -> None:
        station.wait_for_position()
        put(station, compass="lost")
        assert station.arm() == FAILED
        assert "Arm: Compass not healthy" in station.texts()
        put(station, compass="ok")
        assert station.arm() == 0

    @pytest.mark.slow
    def test_compasses_that_turn_make_it_circle_until_the_filter_takes_its_heading_from_the_motion(
        self, flying: Any
    ) -> None:
        flying.stream(EKF)
        before = flying.autopilot.body.yaw
        put(flying, compass_error_deg=45.0)
        flying.run(6.0)
        assert flying.last("EKF_STATUS_REPORT").compass_variance > 0.8
        assert abs(math.degrees(flying.autopilot.body.yaw - before)) > 30.0
        flying.run(6.0)
        assert "EKF3 IMU0 emergency yaw reset" in flying.texts()
        assert "GPS Glitch or Compass error" in flying.texts()
        flying.run(12.0)
        assert flying.texts()[-1] == "Glitch cleared"
        assert math.hypot(*flying.autopilot.body.velocity[:2]) < 0.5
        assert flying.last("EKF_STATUS_REPORT").flags == 831

    def test_a_heading_by_motion_follows_no_compass(self) -> None:
        heading, compasses = Heading(), Compasses()
        compasses.error = math.radians(-90.0)
        assert any(heading.step(compasses, 0.1) for _ in range(200))
        assert heading.error == pytest.approx(-RESET_ERROR)
        assert not any(heading.step(compasses, 0.1) for _ in range(200))
        assert heading.error == pytest.approx(-RESET_ERROR)

    @pytest.mark.slow
    def test_a_constant_error_is_reported_and_flown_by(self, make_station: Any) -> None:
        """A drone that flies and looks north, as it believes."""
        station = make_station(compass_error=math.radians(8.0))
        station.run(15.0)
        station.fly()
        station.stream(ATTITUDE)
        station.local_target(30.0, 0.0, -12.0, 0.0)
        station.run(15.0)
        assert math.degrees(station.last("ATTITUDE").yaw) == pytest.approx(0.0, abs=1.5)
        assert math.degrees(station.autopilot.body.yaw) == pytest.approx(-8.0, abs=1.5)
        assert true_place(station.autopilot)[:2] == pytest.approx((30.0, 0.0), abs=1.0), "GNSS gives the place"

    def test_a_constant_error_outlives_a_boot(self, make_station: Any) -> None:
        station = make_station(compass_error=math.radians(-8.0))
        put(station, autopilot="reboot")
        station.run(15.0)
        assert math.degrees(station.autopilot.estimator.heading.error) == pytest.approx(-8.0, abs=0.1)

    @pytest.mark.slow
    def test_a_small_error_stays(self, flying: Any) -> None:
        put(flying, compass_error_deg=15.0)
        flying.run(30.0)
        assert math.degrees(flying.autopilot.estimator.heading.error) == pytest.approx(15.0, abs=0.1)
        assert math.hypot(*flying.autopilot.body.velocity[:2]) < 0.3
