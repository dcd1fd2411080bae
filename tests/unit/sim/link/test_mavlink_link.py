from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

VELOCITY_MASK = 0b110111000111


def test_heartbeats_come_once_a_second(station: Any) -> None:
    station.run(10.0)
    assert 10 <= len(station.all("HEARTBEAT")) <= 11


@settings(max_examples=60, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture])
@given(data=st.binary(max_size=300))
def test_any_bytes_are_survived(station: Any, data: bytes) -> None:
    station.link.receive(data)
    station.run(0.02)
    assert not station.autopilot.stopped


def test_a_message_after_garbage_is_still_read(station: Any) -> None:
    station.link.receive(b"\xfd\x09garbage that looks like a start" * 3)
    for _ in range(5):
        station.mode(4)
    assert station.autopilot.mode.number == 4


def test_what_is_for_another_system_is_left_alone(station: Any) -> None:
    station.send(mavlink.MAVLink_command_long_message(2, 1, mavlink.MAV_CMD_DO_SET_MODE, 0, 1, 4, 0, 0, 0, 0, 0))
    station.listen()
    assert not station.all("COMMAND_ACK")
    assert station.autopilot.mode.number == 0


def test_the_acknowledgement_names_who_asked(station: Any) -> None:
    station.mode(4)
    answer = station.last("COMMAND_ACK")
    assert (answer.target_system, answer.target_component) == (245, 190)


def test_no_stream_is_faster_than_two_hundred_hertz(station: Any) -> None:
    station.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 30, 1.0)
    station.command(mavlink.MAV_CMD_GET_MESSAGE_INTERVAL, 30)
    assert station.last("MESSAGE_INTERVAL").interval_us == 5000


def test_intervals_can_be_read_and_switched_off(station: Any) -> None:
    station.stream(30, hertz=20.0)
    station.command(mavlink.MAV_CMD_GET_MESSAGE_INTERVAL, 30)
    assert station.last("MESSAGE_INTERVAL").interval_us == 50_000
    station.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 30, -1)
    station.command(mavlink.MAV_CMD_GET_MESSAGE_INTERVAL, 30)
    assert station.last("MESSAGE_INTERVAL").interval_us == -1
    assert station.command(mavlink.MAV_CMD_GET_MESSAGE_INTERVAL, 141) == mavlink.MAV_RESULT_DENIED


@pytest.mark.parametrize("interval", [math.nan, math.inf])
def test_an_interval_that_is_not_finite_is_denied(station: Any, interval: float) -> None:
    assert station.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 30, interval) == mavlink.MAV_RESULT_DENIED


def test_a_message_is_sent_once_on_request(station: Any) -> None:
    assert station.command(mavlink.MAV_CMD_REQUEST_MESSAGE, 148) == 0
    station.run(2.0)
    assert len(station.all("AUTOPILOT_VERSION")) == 1
    assert station.last("AUTOPILOT_VERSION").capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
    assert station.command(mavlink.MAV_CMD_REQUEST_MESSAGE, 141) == mavlink.MAV_RESULT_FAILED
    assert station.command(mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, 1) == 0
    assert len(station.all("AUTOPILOT_VERSION")) == 2


def test_home_can_be_asked_for(make_station: Any) -> None:
    station = make_station(gnss_wait_s=5.0)
    assert station.command(mavlink.MAV_CMD_GET_HOME_POSITION) == mavlink.MAV_RESULT_FAILED
    station.wait_for_position()
    assert station.command(mavlink.MAV_CMD_GET_HOME_POSITION) == 0


def test_every_parameter_is_listed_once(station: Any) -> None:
    station.send(mavlink.MAVLink_param_request_list_message(1, 1))
    station.run(1.0)
    values = station.all("PARAM_VALUE")
    assert [value.param_index for value in values] == list(range(len(station.autopilot.parameters)))
    assert {value.param_count for value in values} == {len(values)}


def test_a_parameter_is_read_by_name_and_by_place(station: Any) -> None:
    station.send(mavlink.MAVLink_param_request_read_message(1, 1, b"RTL_ALT", -1))
    station.listen()
    by_name = station.last("PARAM_VALUE")
    station.send(mavlink.MAVLink_param_request_read_message(1, 1, b"", by_name.param_index))
    station.send(mavlink.MAVLink_param_request_read_message(1, 1, b"", 9999))
    station.listen()
    assert [value.param_id for value in station.all("PARAM_VALUE")] == ["RTL_ALT", "RTL_ALT"]


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_value_that_is_not_finite_is_not_written(station: Any, value: float) -> None:
    station.set_parameter("WPNAV_SPEED", value)
    assert station.autopilot.parameters["WPNAV_SPEED"] == 500


def test_time_is_synchronised_in_the_boot_clock(station: Any) -> None:
    station.run(3.0)
    station.send(mavlink.MAVLink_timesync_message(0, 1234))
    station.listen()
    answer = station.last("TIMESYNC")
    assert answer.ts1 == 1234
    assert answer.tc1 == pytest.approx(3e9, abs=2e7)
    station.send(mavlink.MAVLink_timesync_message(5, 1234))
    station.listen()
    assert len(station.all("TIMESYNC")) == 1


def test_pings_are_answered(station: Any) -> None:
    station.send(mavlink.MAVLink_ping_message(7, 3, 0, 0))
    station.listen()
    assert (station.last("PING").seq, station.last("PING").target_system) == (3, 245)


def test_the_old_set_mode_message_works(station: Any) -> None:
    station.send(mavlink.MAVLink_set_mode_message(1, 1, 4))
    assert station.autopilot.mode.number == 4


class TestTargets:
    @pytest.mark.slow
    def test_offset_from_where_it_is(self, flying: Any) -> None:
        flying.local_target(5.0, 0.0, 0.0, frame=mavlink.MAV_FRAME_LOCAL_OFFSET_NED)
        flying.run(6.0)
        assert flying.local() == pytest.approx((5.0, 0.0, -12.0), abs=0.4)

    @pytest.mark.slow
    def test_body_frames_turn_with_the_nose(self, flying: Any) -> None:
        flying.command(mavlink.MAV_CMD_CONDITION_YAW, 90)
        flying.run(6.0)
        flying.local_target(4.0, 0.0, 0.0, frame=mavlink.MAV_FRAME_BODY_OFFSET_NED)
        flying.run(6.0)
        assert flying.local() == pytest.approx((0.0, 4.0, -12.0), abs=0.4)

    @pytest.mark.slow
    def test_velocities_in_body_frame(self, flying: Any) -> None:
        flying.command(mavlink.MAV_CMD_CONDITION_YAW, 90)
        flying.run(6.0)
        flying.local_target(mask=VELOCITY_MASK | 1 << 10, velocity=(2.0, 0.0, 0.0), frame=mavlink.MAV_FRAME_BODY_NED)
        flying.run(2.5)
        assert flying.autopilot.body.velocity[1] == pytest.approx(2.0, abs=0.2)

    @pytest.mark.slow
    def test_without_anything_to_fly_it_stays(self, flying: Any) -> None:
        flying.local_target(20.0, mask=0b111111111111)
        flying.run(3.0)
        assert math.hypot(*flying.local()[:2]) < 0.2

    @pytest.mark.slow
    @pytest.mark.parametrize(("frame", "height"), [(6, 15.0), (5, 115.0)])
    def test_global_targets(self, flying: Any, frame: int, height: float) -> None:
        origin = flying.autopilot.origin
        latitude, longitude, _ = origin.to_geodetic((8.0, 0.0, 0.0))
        flying.send(
            mavlink.MAVLink_set_position_target_global_int_message(
                0, 1, 1, frame, 2552, round(latitude * 1e7), round(longitude * 1e7), height, 0, 0, 0, 0, 0, 0, 0.0, 0
            )
        )
        flying.run(10.0)
        assert flying.autopilot.body.position == pytest.approx((8.0, 0.0, -15.0), abs=0.3)

    def test_before_there_is_an_origin_nothing_happens(self, make_station: Any) -> None:
        station = make_station(gnss_wait_s=60.0)
        station.mode(4)
        station.local_target(1.0, math.nan, 1.0, math.nan)
        assert not station.autopilot.stopped


class TestBadLink:
    @pytest.mark.slow
    def test_losses_are_as_frequent_as_asked_for(self, station: Any) -> None:
        station.stream(30, hertz=50.0)
        station.link.loss = 0.3
        station.heard.clear()
        station.run(20.0)
        assert len(station.all("ATTITUDE")) == pytest.approx(700, abs=70)

    def test_after_a_cut_only_what_is_new_comes(self, station: Any) -> None:
        station.stream(30, hertz=10.0)
        station.link.cut = True
        station.run(10.0)
        station.heard.clear()
        station.link.cut = False
        station.run(1.0)
        assert len(station.all("ATTITUDE")) <= 12
