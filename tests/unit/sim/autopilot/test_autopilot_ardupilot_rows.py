"""One test for every row of what was observed of MAVSDK and ArduCopter, as far as the autopilot's side makes it so.

The autopilot is reached by MAVLink messages alone. Rows about MAVSDK itself are in tests/integration.
"""

from __future__ import annotations

import math
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

ACCEPTED, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4
GUIDED, LOITER, RTL, LAND, POSHOLD, BRAKE = 4, 5, 6, 9, 16, 17


class TestStreams:
    def test_nothing_but_heartbeat_text_and_home_comes_by_itself(self, station: Any) -> None:
        station.run(10.0)
        assert {message.get_type() for message in station.heard} <= {"HEARTBEAT", "STATUSTEXT", "HOME_POSITION"}

    @pytest.mark.parametrize("message_id", [1, 30, 32, 33, 147, 245])
    def test_what_is_asked_for_comes_at_its_rate(self, station: Any, message_id: int) -> None:
        station.wait_for_position()
        station.stream(message_id, hertz=10.0)
        station.heard.clear()
        station.run(2.0)
        count = sum(message.get_msgId() == message_id for message in station.heard)
        assert 19 <= count <= 21

    def test_altitude_is_denied(self, station: Any) -> None:
        assert station.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 141, 1e5) == DENIED

    def test_a_stream_ends_on_command(self, station: Any) -> None:
        station.stream(30)
        assert station.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 30, -1) == ACCEPTED
        station.heard.clear()
        station.run(1.0)
        assert not station.all("ATTITUDE")


class TestReboot:
    def test_rates_are_lost_and_the_boot_clock_starts_again(self, station: Any) -> None:
        station.stream(30)
        station.run(5.0)
        assert station.command(mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1) == ACCEPTED
        station.heard.clear()
        station.run(2.0)
        assert not station.all("ATTITUDE")
        assert station.all("HEARTBEAT")
        station.command(mavlink.MAV_CMD_REQUEST_MESSAGE, 30)
        assert station.last("ATTITUDE").time_boot_ms == pytest.approx(2000, abs=30)

    def test_refused_while_armed(self, station: Any) -> None:
        station.wait_for_position()
        station.arm()
        assert station.command(mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1) == FAILED
        assert station.autopilot.armed


class TestLatency:
    def test_armed_shows_with_the_next_heartbeat_only(self, station: Any) -> None:
        station.wait_for_position()
        station.heard.clear()
        station.run(1.1, until=lambda: bool(station.all("HEARTBEAT")))
        station.heard.clear()
        station.arm()
        station.run(0.2)
        assert not [m for m in station.all("HEARTBEAT") if m.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED]
        station.run(1.0)
        assert station.last("HEARTBEAT").base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED

    def test_a_mode_change_shows_at_once(self, station: Any) -> None:
        station.run(1.05)
        station.heard.clear()
        station.mode(GUIDED)
        assert station.last("HEARTBEAT").custom_mode == GUIDED


class TestHealth:
    def test_armable_before_the_position_is_good(self, make_station: Any) -> None:
        station = make_station(gnss_wait_s=18.0)
        station.stream(1)
        station.run(2.0)
        health = station.last("SYS_STATUS").onboard_control_sensors_health
        assert health & mavlink.MAV_SYS_STATUS_PREARM_CHECK
        assert not health & mavlink.MAV_SYS_STATUS_SENSOR_GPS
        station.run(17.0)
        assert station.last("SYS_STATUS").onboard_control_sensors_health & mavlink.MAV_SYS_STATUS_SENSOR_GPS

    def test_a_latched_radio_failsafe_leaves_the_position_good_and_the_vehicle_not_armable(self, station: Any) -> None:
        station.wait_for_position()
        station.stream(1)
        station.autopilot.radio_present = False
        station.run(1.5)
        health = station.last("SYS_STATUS").onboard_control_sensors_health
        assert health & mavlink.MAV_SYS_STATUS_SENSOR_GPS
        assert not health & mavlink.MAV_SYS_STATUS_PREARM_CHECK
        assert station.arm() == FAILED
        assert "Arm: Radio failsafe on" in station.texts()


class TestArm:
    @pytest.mark.parametrize("mode", [0, GUIDED])
    def test_from_stabilize_and_guided(self, station: Any, mode: int) -> None:
        station.wait_for_position()
        assert station.mode(mode) == ACCEPTED
        assert station.arm() == ACCEPTED
        assert station.autopilot.armed

    @pytest.mark.parametrize(
        ("mode", "name"), [(BRAKE, "BRAKE"), (RTL, "RTL"), (LAND, "LAND"), (21, "SMART_RTL")], ids=str
    )
    def test_other_modes_refuse_and_the_reason_comes_before_the_refusal(
        self, station: Any, mode: int, name: str
    ) -> None:
        station.wait_for_position()
        station.mode(mode)
        station.heard.clear()
        assert station.arm() == FAILED
        kinds = [m.get_type() for m in station.heard if m.get_type() in ("STATUSTEXT", "COMMAND_ACK")]
        assert kinds == ["STATUSTEXT", "COMMAND_ACK"]
        assert station.texts() == [f"Arm: {name} mode not armable"]
        assert not station.autopilot.armed

    def test_disarms_by_itself_after_ten_seconds_on_the_ground(self, station: Any) -> None:
        station.wait_for_position()
        station.mode(GUIDED)
        station.arm()
        assert station.run(30.0, until=lambda: not station.autopilot.armed) == pytest.approx(10.0, abs=0.1)

    def test_guided_needs_a_position(self, make_station: Any) -> None:
        station = make_station(gnss_wait_s=20.0)
        station.mode(GUIDED)
        assert station.arm() == FAILED
        assert station.texts()[-1] == "Arm: Need Position Estimate"

    def test_force_is_acknowledged_and_does_nothing(self, station: Any) -> None:
        station.wait_for_position()
        assert station.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1, 21196) == ACCEPTED
        station.run(2.0)
        assert not station.autopilot.armed


class TestTakeoff:
    def test_disarmed_fails(self, station: Any) -> None:
        station.wait_for_position()
        station.mode(GUIDED)
        assert station.command(mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, 12) == FAILED

    @pytest.mark.slow
    def test_in_the_air_fails(self, flying: Any) -> None:
        assert flying.command(mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, 20) == FAILED
        flying.run(3.0)
        assert flying.autopilot.body.height == pytest.approx(12.0, abs=0.3)

    @pytest.mark.parametrize("height", [math.nan, math.inf, 0.0, -5.0])
    def test_without_a_height_it_fails(self, station: Any, height: float) -> None:
        station.wait_for_position()
        station.mode(GUIDED)
        station.arm()
        assert station.command(mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, height) == FAILED


class TestLandedState:
    @pytest.mark.slow
    def test_every_state_is_reported_in_order(self, station: Any) -> None:
        station.wait_for_position()
        station.stream(245, hertz=5.0)
        station.fly(8.0)
        station.mode(LAND)
        station.run(60.0, until=lambda: not station.autopilot.armed)
        station.run(0.5)
        states = [message.landed_state for message in station.all("EXTENDED_SYS_STATE")]
        changes = [state for state, before in zip(states, [None, *states], strict=False) if state != before]
        assert changes == [1, 3, 2, 4, 1]


class TestGuided:
    @pytest.mark.slow
    def test_a_target_is_reached_in_about_five_seconds_with_little_overshoot(self, flying: Any) -> None:
        x, y, z = flying.local()
        flying.local_target(x + 15, y - 8, z, 0.5)
        best = 99.0

        def near() -> bool:
            return math.dist(flying.local()[:2], (x + 15, y - 8)) < 0.5

        assert flying.run(12.0, until=near) == pytest.approx(5.4, abs=0.5)
        overshoot = 0.0
        for _ in range(100):
            flying.run(0.05)
            north, east = flying.local()[0] - x, flying.local()[1] - y
            overshoot = max(overshoot, (north * 15 - east * 8) / 17 - 17)
            best = min(best, math.dist((north, east), (15, -8)))
        assert overshoot < 0.8
        assert best < 0.05
        assert flying.autopilot.estimate.yaw == pytest.approx(0.5, abs=0.05)

    @pytest.mark.slow
    @pytest.mark.parametrize("mode", [LOITER, BRAKE, LAND])
    def test_a_target_in_another_mode_does_nothing(self, flying: Any, mode: int) -> None:
        flying.mode(mode)
        before = flying.autopilot.body.position
        flying.local_target(30.0, 0.0, -12.0)
        flying.run(3.0)
        assert math.dist(before[:2], flying.autopilot.body.position[:2]) < 1.0

    def test_a_target_on_the_ground_lifts_nothing(self, station: Any) -> None:
        station.wait_for_position()
        station.mode(GUIDED)
        station.arm()
        station.local_target(5.0, 0.0, -10.0)
        station.run(5.0)
        assert station.autopilot.body.on_ground

    @pytest.mark.parametrize("value", [math.nan, math.inf])
    def test_a_yaw_that_is_not_finite_ends_the_program_while_the_target_moves(self, flying: Any, value: float) -> None:
        flying.local_target(10.0, 0.0, -12.0, yaw=value)
        flying.heard.clear()
        flying.run(3.0)
        assert flying.autopilot.stopped
        assert not flying.heard

    def test_a_yaw_that_is_not_finite_is_survived_while_the_target_stays(self, flying: Any) -> None:
        x, y, z = flying.local()
        flying.local_target(x, y, z, 0.0)
        flying.local_target(x, y, z, math.nan)
        flying.run(1.0)
        assert not flying.autopilot.stopped


class TestHold:
    @pytest.mark.slow
    def test_brake_keeps_the_height_without_a_radio(self, flying: Any) -> None:
        flying.set_parameter("FS_THR_ENABLE", 0)
        flying.autopilot.radio_present = False
        flying.mode(BRAKE)
        flying.run(10.0)
        assert flying.autopilot.body.height == pytest.approx(12.0, abs=0.3)

    @pytest.mark.slow
    @pytest.mark.parametrize("mode", [LOITER, POSHOLD])
    @pytest.mark.parametrize("radio", [True, False])
    def test_loiter_and_poshold_sink_with_the_stick_low_or_no_radio(self, flying: Any, mode: int, radio: bool) -> None:
        flying.set_parameter("FS_THR_ENABLE", 0)
        flying.autopilot.radio_present = radio
        flying.mode(mode)
        flying.run(3.5)
        assert flying.autopilot.body.velocity[2] == pytest.approx(2.4, abs=0.1)
        flying.run(10.0)
        assert flying.autopilot.body.on_ground
        assert not flying.autopilot.body.crashed

    @pytest.mark.slow
    def test_brake_stops_a_moving_drone(self, flying: Any) -> None:
        flying.local_target(60.0, 0.0, -12.0)
        flying.run(4.0)
        flying.mode(BRAKE)
        flying.run(4.0)
        assert math.hypot(*flying.autopilot.body.velocity) < 0.1


class TestReposition:
    def place(self, station: Any, north: float) -> tuple[float, float, float]:
        home = station.autopilot.home
        return tuple(station.autopilot.origin.to_geodetic((home[0] + north, home[1], home[2] - 20.0)))

    def send(self, station: Any, north: float, yaw: float = 0.0) -> int:
        latitude, longitude, altitude = self.place(station, north)
        station.send(
            mavlink.MAVLink_command_int_message(
                1,
                1,
                0,
                mavlink.MAV_CMD_DO_REPOSITION,
                0,
                0,
                -1,
                0,
                0,
                yaw,
                round(latitude * 1e7),
                round(longitude * 1e7),
                altitude,
            )
        )
        station.listen()
        return int(station.last("COMMAND_ACK").result)

    @pytest.mark.slow
    def test_takes_an_altitude_above_the_sea_and_ignores_the_yaw(self, flying: Any) -> None:
        assert self.send(flying, 10.0, yaw=math.pi) == ACCEPTED
        flying.run(20.0)
        assert flying.autopilot.body.height == pytest.approx(20.0, abs=0.3)
        assert abs(flying.autopilot.body.yaw) < 0.1

    def test_is_accepted_when_disarmed(self, station: Any) -> None:
        station.wait_for_position()
        station.mode(GUIDED)
        assert self.send(station, 10.0) == ACCEPTED

    @pytest.mark.slow
    def test_outside_the_fence_it_fails(self, flying: Any) -> None:
        flying.set_parameter("FENCE_ENABLE", 1)
        flying.set_parameter("FENCE_RADIUS", 50)
        assert self.send(flying, 80.0) == FAILED
        assert self.send(flying, 30.0) == ACCEPTED


class TestDisarmAndKill:
    @pytest.mark.slow
    def test_disarm_in_the_air_fails(self, flying: Any) -> None:
        assert flying.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0) == FAILED
        assert flying.autopilot.armed

    @pytest.mark.slow
    @pytest.mark.parametrize(
        ("command", "parameters"),
        [(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, (0, 21196)), (mavlink.MAV_CMD_DO_FLIGHTTERMINATION, (1,))],
    )
    def test_kill_and_terminate_cut_the_motors_at_once(
        self, flying: Any, command: int, parameters: tuple[float, ...]
    ) -> None:
        assert flying.command(command, *parameters) == ACCEPTED
        assert not flying.autopilot.armed
        flying.run(1.0)
        assert flying.autopilot.body.velocity[2] > 7.0
        flying.run(2.0)
        assert flying.autopilot.body.crashed


class TestReturnAltitude:
    def test_the_parameter_is_in_whole_centimetres_and_its_successor_is_unknown(self, station: Any) -> None:
        station.send(mavlink.MAVLink_param_request_read_message(1, 1, b"RTL_ALT_M", -1))
        station.listen()
        assert not station.all("PARAM_VALUE")
        station.set_parameter("RTL_ALT", 2500, 6)
        value = station.last("PARAM_VALUE")
        assert (value.param_id, value.param_value, value.param_type) == ("RTL_ALT", 2500.0, 6)

    @pytest.mark.slow
    def test_rtl_climbs_to_it_comes_home_and_disarms_by_itself(self, flying: Any) -> None:
        flying.set_parameter("RTL_ALT", 2000, 6)
        x, y, z = flying.local()
        flying.local_target(x + 20, y, z)
        flying.run(8.0)
        flying.mode(RTL)
        highest = 0.0

        def home() -> bool:
            nonlocal highest
            highest = max(highest, flying.autopilot.body.height)
            return not flying.autopilot.armed

        flying.run(90.0, until=home)
        assert highest == pytest.approx(20.0, abs=0.5)
        assert math.hypot(*flying.local()[:2]) < 0.5
        assert flying.autopilot.body.on_ground

    @pytest.mark.slow
    def test_land_disarms_by_itself(self, flying: Any) -> None:
        flying.mode(LAND)
        # 2 m at 1.5 m/s, then 10 m at 0.5 m/s, then the landing is noticed
        assert flying.run(60.0, until=lambda: not flying.autopilot.armed) == pytest.approx(22.8, abs=1.5)


class TestParameters:
    @pytest.mark.parametrize("kind", [2, 4, 6, 9])
    def test_a_wrong_type_is_written_all_the_same_and_answered_in_its_own(self, station: Any, kind: int) -> None:
        station.set_parameter("FENCE_ALT_MAX", 60.0, kind)
        value = station.last("PARAM_VALUE")
        assert (value.param_value, value.param_type) == (60.0, 9)

    def test_an_unknown_name_is_not_answered(self, station: Any) -> None:
        station.set_parameter("NO_SUCH_ONE", 1.0)
        station.send(mavlink.MAVLink_param_request_read_message(1, 1, b"NO_SUCH_ONE", -1))
        station.run(4.0)
        assert not station.all("PARAM_VALUE")


class TestSendCommand:
    def test_a_bad_mode_gives_four(self, station: Any) -> None:
        assert station.mode(99) == FAILED
        assert station.autopilot.mode.number == 0


class TestFence:
    def upload(self, station: Any, half: float) -> None:
        home = station.autopilot.home
        corners = [(-half, -half), (half, -half), (half, half), (-half, half)]
        station.send(mavlink.MAVLink_mission_count_message(1, 1, 4, 1))
        for index, (north, east) in enumerate(corners):
            station.listen()
            assert station.last("MISSION_REQUEST_INT").seq == index
            latitude, longitude, _ = station.autopilot.origin.to_geodetic((home[0] + north, home[1] + east, 0.0))
            station.send(
                mavlink.MAVLink_mission_item_int_message(
                    1, 1, index, 0, 5001, 0, 1, 4, 0, 0, 0, round(latitude * 1e7), round(longitude * 1e7), 0, 1
                )
            )
        station.listen()
        assert station.last("MISSION_ACK").type == mavlink.MAV_MISSION_ACCEPTED

    @pytest.mark.slow
    def test_the_upload_does_not_enable_it(self, flying: Any) -> None:
        self.upload(flying, 20.0)
        assert flying.autopilot.parameters["FENCE_ENABLE"] == 0
        flying.local_target(30.0, 0.0, -12.0)
        flying.run(10.0)
        assert flying.local()[0] > 29.0

    @pytest.mark.slow
    def test_a_target_outside_is_ignored_silently_once_it_is_enabled(self, flying: Any) -> None:
        self.upload(flying, 20.0)
        flying.set_parameter("FENCE_ENABLE", 1)
        flying.heard.clear()
        flying.local_target(30.0, 0.0, -12.0)
        flying.run(5.0)
        assert math.hypot(*flying.local()[:2]) < 0.3
        assert not flying.texts()
        flying.local_target(10.0, 0.0, -12.0)
        flying.run(6.0)
        assert flying.local()[0] == pytest.approx(10.0, abs=0.3)

    @pytest.mark.slow
    def test_beyond_it_the_autopilot_acts(self, flying: Any) -> None:
        self.upload(flying, 20.0)
        flying.set_parameter("FENCE_ENABLE", 1)
        flying.local_target(mask=0b110111000111, velocity=(5.0, 0.0, 0.0))
        for _ in range(10):
            flying.run(1.0)
            flying.local_target(mask=0b110111000111, velocity=(5.0, 0.0, 0.0))
        assert "Polygon fence breached" in flying.texts()
        assert flying.autopilot.mode.number == RTL


class TestLinkCut:
    @pytest.mark.slow
    def test_a_velocity_ends_after_three_seconds_and_guided_hovers(self, flying: Any) -> None:
        flying.local_target(mask=0b110111000111, velocity=(3.0, 0.0, 0.0))
        flying.link.cut = True
        flying.run(2.9)
        assert flying.autopilot.body.velocity[0] > 2.5
        flying.run(4.0)
        assert abs(flying.autopilot.body.velocity[0]) < 0.2
        assert flying.autopilot.mode.number == GUIDED

    @pytest.mark.slow
    def test_a_position_is_flown_to_the_end(self, flying: Any) -> None:
        flying.local_target(40.0, 0.0, -12.0)
        flying.link.cut = True
        flying.run(20.0)
        assert flying.local()[0] == pytest.approx(40.0, abs=0.3)

    @pytest.mark.slow
    def test_a_cut_link_passes_nothing_in_either_direction(self, flying: Any) -> None:
        flying.link.cut = True
        flying.heard.clear()
        assert flying.mode(LAND) is None
        flying.run(3.0)
        assert not flying.heard
        assert flying.autopilot.mode.number == GUIDED


class TestGroundStationFailsafe:
    @pytest.mark.slow
    @pytest.mark.parametrize(("naming", "name"), [("old", "SYSID_MYGCS"), ("new", "MAV_GCS_SYSID")])
    def test_it_watches_one_id_only(self, make_station: Any, naming: str, name: str) -> None:
        station = make_station(gcs_parameter=naming)
        station.set_parameter("FS_GCS_ENABLE", 1)
        assert station.autopilot.parameters[name] == 255
        station.run(2.0, heartbeat=True)
        station.fly()
        station.run(15.0)
        assert station.autopilot.mode.number == GUIDED

    @pytest.mark.slow
    def test_off_by_default(self, make_station: Any) -> None:
        station = make_station(system=255)
        station.run(2.0, heartbeat=True)
        station.fly()
        station.run(15.0)
        assert station.autopilot.mode.number == GUIDED

    @pytest.mark.slow
    def test_with_both_ids_equal_it_returns(self, make_station: Any) -> None:
        station = make_station()
        station.set_parameter("FS_GCS_ENABLE", 1)
        station.set_parameter("SYSID_MYGCS", 245)
        station.wait_for_position()
        station.mode(GUIDED)
        station.arm()
        station.command(mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, 12)
        station.run(12.5, heartbeat=True)
        assert station.autopilot.mode.number == GUIDED
        # the last heartbeat was half a second ago: 4.5 s after the cut
        assert station.run(10.0, until=lambda: station.autopilot.mode.number == RTL) == pytest.approx(4.5, abs=0.3)
        assert "GCS Failsafe" in station.texts()

    @pytest.mark.slow
    def test_real_heartbeats_are_counted_in_real_seconds(self, make_station: Any) -> None:
        station = make_station(real_time_factor=4.0)
        station.set_parameter("FS_GCS_ENABLE", 1)
        station.set_parameter("SYSID_MYGCS", 245)
        station.fly()
        station.heartbeat()
        station.run(18.0)
        assert station.autopilot.mode.number == GUIDED
        station.run(4.0)
        assert station.autopilot.mode.number == RTL


class TestOtherFailsafes:
    @pytest.mark.slow
    def test_radio_loss_in_guided_returns(self, flying: Any) -> None:
        assert flying.autopilot.parameters["FS_THR_ENABLE"] == 1
        flying.autopilot.radio_present = False
        flying.run(1.5)
        assert flying.autopilot.mode.number == RTL
        assert "Radio Failsafe" in flying.texts()

    @pytest.mark.slow
    def test_gnss_loss_turns_health_false_and_lands(self, flying: Any) -> None:
        flying.stream(1)
        flying.autopilot.estimator.receiving = False

        def unhealthy() -> bool:
            status = flying.all("SYS_STATUS")
            gps = mavlink.MAV_SYS_STATUS_SENSOR_GPS
            return bool(status) and not status[-1].onboard_control_sensors_health & gps

        assert flying.run(20.0, until=unhealthy) == pytest.approx(7.5, abs=0.5)
        flying.run(2.0)
        assert flying.autopilot.mode.number == LAND
        assert "EKF Failsafe: changed to LAND Mode" in flying.texts()
        flying.run(60.0, until=lambda: not flying.autopilot.armed)
        assert flying.autopilot.body.on_ground

    @pytest.mark.slow
    def test_battery_low_for_ten_seconds_returns(self, flying: Any) -> None:
        flying.set_parameter("BATT_FS_LOW_ACT", 2)
        flying.autopilot.battery.remaining = 0.2
        waited = flying.run(20.0, until=lambda: flying.autopilot.mode.number == RTL)
        assert waited == pytest.approx(10.0, abs=0.3)
        assert any(text.startswith("Battery 1 is low") for text in flying.texts())

    @pytest.mark.slow
    def test_battery_low_does_nothing_by_default(self, flying: Any) -> None:
        flying.autopilot.battery.remaining = 0.2
        flying.run(15.0)
        assert flying.autopilot.mode.number == GUIDED
