from __future__ import annotations

import math
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.sim.autopilot.autopilot import Autopilot
from hawk.sim.autopilot.telemetry import BUILDERS
from hawk.sim.autopilot.telemetry import build as build_or_none


def build(message_id: int, autopilot: Autopilot) -> Any:
    """Build a message of which the test knows that it can be built, or that it cannot."""
    return build_or_none(message_id, autopilot)


def test_every_message_packs_at_every_moment(station: Any) -> None:
    encoder = mavlink.MAVLink(None, 1, 1)
    for seconds in (0.0, 10.0):
        station.run(seconds)
        for message_id in BUILDERS:
            message = build(message_id, station.autopilot)
            if message is not None:
                assert message.get_msgId() == message_id
                assert message.pack(encoder)


def test_no_position_before_there_is_one(make_station: Any) -> None:
    station = make_station(gnss_wait_s=30.0)
    station.run(1.0)
    for name in ("LOCAL_POSITION_NED", "GLOBAL_POSITION_INT", "HOME_POSITION", "GPS_GLOBAL_ORIGIN"):
        assert build(getattr(mavlink, f"MAVLINK_MSG_ID_{name}"), station.autopilot) is None
    raw = build(mavlink.MAVLINK_MSG_ID_GPS_RAW_INT, station.autopilot)
    assert (raw.fix_type, raw.satellites_visible) == (1, 0)


def test_the_moment_is_that_of_the_world_and_goes_on_through_a_boot(make_station: Any) -> None:
    station = make_station(utc_s=1_777_000_000.0, gnss_wait_s=4.0)
    autopilot = station.autopilot
    station.run(2.0)
    assert build(mavlink.MAVLINK_MSG_ID_SYSTEM_TIME, autopilot).time_unix_usec == 0, "GNSS has no moment yet"
    station.run(8.0)
    assert build(mavlink.MAVLINK_MSG_ID_SYSTEM_TIME, autopilot).time_unix_usec == pytest.approx(
        1_777_000_010e6, abs=1e5
    )
    autopilot.reboot()
    station.run(10.0)
    said = build(mavlink.MAVLINK_MSG_ID_SYSTEM_TIME, autopilot)
    assert said.time_unix_usec == pytest.approx(1_777_000_020e6, abs=1e5)
    assert said.time_boot_ms == pytest.approx(10_000, abs=100)


def test_without_a_moment_of_the_world_there_is_none(station: Any) -> None:
    station.wait_for_position()
    assert build(mavlink.MAVLINK_MSG_ID_SYSTEM_TIME, station.autopilot).time_unix_usec == 0


def test_an_unknown_message_is_none(station: Any) -> None:
    assert build(141, station.autopilot) is None


@pytest.mark.slow
def test_global_and_local_are_the_same_place(flying: Any) -> None:
    flying.local_target(10.0, 5.0, -15.0)
    flying.run(6.0)
    autopilot = flying.autopilot
    world = build(mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT, autopilot)
    local = build(mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED, autopilot)
    place = autopilot.origin.to_world(world.lat * 1e-7, world.lon * 1e-7, world.alt * 1e-3)
    assert place == pytest.approx(
        (local.x + autopilot.ekf_origin[0], local.y + autopilot.ekf_origin[1], local.z), abs=0.02
    )
    assert world.relative_alt == pytest.approx(-local.z * 1000, abs=20)
    assert world.time_boot_ms == local.time_boot_ms == round(autopilot.time_boot * 1000)
    assert world.vx == pytest.approx(local.vx * 100, abs=1)


def test_attitude_and_quaternion_agree(flying: Any) -> None:
    flying.local_target(20.0, 10.0, -12.0, 2.0)
    flying.run(1.0)
    attitude = build(mavlink.MAVLINK_MSG_ID_ATTITUDE, flying.autopilot)
    q = build(mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION, flying.autopilot)
    yaw = math.atan2(2 * (q.q1 * q.q4 + q.q2 * q.q3), 1 - 2 * (q.q3**2 + q.q4**2))
    assert yaw == pytest.approx(attitude.yaw, abs=1e-6)
    assert math.asin(2 * (q.q1 * q.q3 - q.q4 * q.q2)) == pytest.approx(attitude.pitch, abs=1e-6)


def test_both_messages_show_the_same_battery(flying: Any) -> None:
    flying.autopilot.battery.remaining = 0.424
    status = build(mavlink.MAVLINK_MSG_ID_SYS_STATUS, flying.autopilot)
    battery = build(mavlink.MAVLINK_MSG_ID_BATTERY_STATUS, flying.autopilot)
    assert status.battery_remaining == battery.battery_remaining == 43
    assert status.voltage_battery == battery.voltages[0]


@pytest.mark.parametrize("heading", [0.0, 359.999, 180.0])
def test_headings_stay_in_their_field(make_station: Any, heading: float) -> None:
    station = make_station(yaw=math.radians(heading))
    station.run(5.0)
    assert 0 <= build(mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT, station.autopilot).hdg < 36000


def test_home_is_where_it_was_armed(flying: Any) -> None:
    home = build(mavlink.MAVLINK_MSG_ID_HOME_POSITION, flying.autopilot)
    assert (home.x, home.y, home.z) == pytest.approx((0.0, 0.0, 0.0), abs=0.05)
    assert home.altitude == pytest.approx(100_000, abs=50)


def test_a_failsafe_is_critical(flying: Any) -> None:
    flying.autopilot.radio_present = False
    flying.run(2.2)
    assert flying.last("HEARTBEAT").system_status == mavlink.MAV_STATE_CRITICAL


def test_the_fence_breach_is_reported(flying: Any) -> None:
    flying.set_parameter("FENCE_ENABLE", 1)
    flying.set_parameter("FENCE_ALT_MAX", 5)
    flying.run(0.5)
    fence = build(mavlink.MAVLINK_MSG_ID_FENCE_STATUS, flying.autopilot)
    assert fence.breach_status == 1
    status = build(mavlink.MAVLINK_MSG_ID_SYS_STATUS, flying.autopilot)
    assert status.onboard_control_sensors_enabled & mavlink.MAV_SYS_STATUS_GEOFENCE
    assert not status.onboard_control_sensors_health & mavlink.MAV_SYS_STATUS_GEOFENCE
