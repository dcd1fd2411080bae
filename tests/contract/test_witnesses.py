"""Rows: where RTL goes with rally points, and sensors that disagree while the autopilot reports health."""

from __future__ import annotations

import json
import math

import pytest
from mavsdk.plugins.mavlink_direct import MavlinkMessage
from mavsdk.plugins.mission_raw import MissionItem

from tests.contract.vehicle import HEIGHT, METRES_A_DEGREE, RTL, Vehicle

pytestmark = pytest.mark.contract
RALLY_POINT, RALLY, RELATIVE = 5100, 2, 3
GPS_RAW_INT, SYS_STATUS = 24, 1
COMPASS = 1 << 2
DRIFT_M_S = 0.5


def rally_point(vehicle: Vehicle, north: float, east: float, up: float) -> MissionItem:
    """Return a rally point, metres from home."""
    home = vehicle.pilot.telemetry.home()
    x = home.latitude_deg + north / METRES_A_DEGREE
    y = home.longitude_deg + east / (METRES_A_DEGREE * math.cos(math.radians(home.latitude_deg)))
    return MissionItem(0, RELATIVE, RALLY_POINT, 0, 1, 0.0, 0.0, 0.0, 0.0, round(x * 1e7), round(y * 1e7), up, RALLY)


def go_from_home(vehicle: Vehicle, north: float) -> None:
    """Fly to a place north of home, metres."""
    at, place = vehicle.from_home, vehicle.place
    vehicle.go(place[0] - at[0] + north, place[1] - at[1], -HEIGHT)


def clear_rally_points(vehicle: Vehicle) -> None:
    """Clear them; MAVSDK uploads no empty list."""
    fields = json.dumps({"target_system": 1, "target_component": 1, "mission_type": RALLY})
    vehicle.pilot.direct.send_message(MavlinkMessage("MISSION_CLEAR_ALL", 245, 190, 1, 1, fields))
    vehicle.let_pass(2.0)
    assert vehicle.parameter("RALLY_TOTAL") == 0


def test_rtl_lands_at_a_rally_point_that_is_nearer_than_home(flying: Vehicle) -> None:
    flying.pilot.missions.upload_rally_points([rally_point(flying, 18.0, 6.0, HEIGHT)])
    try:
        assert flying.parameter("RALLY_TOTAL") == 1
        go_from_home(flying, 14.0)
        flying.set_mode(RTL)
        flying.wait(lambda: not flying.armed, 120.0)
        assert math.dist(flying.from_home, (18.0, 6.0)) < 2.5
    finally:
        clear_rally_points(flying)
        flying.fly()  # home is where it is armed: bring it back
        flying.land()


def test_a_rally_point_that_is_farther_than_home_is_passed_over(flying: Vehicle) -> None:
    flying.pilot.missions.upload_rally_points([rally_point(flying, 30.0, 0.0, HEIGHT)])
    try:
        go_from_home(flying, 5.0)
        flying.set_mode(RTL)
        flying.wait(lambda: not flying.armed, 120.0)
        assert math.dist(flying.from_home, (0.0, 0.0)) < 2.5
    finally:
        clear_rally_points(flying)


def test_a_drifting_barometer_shows_in_gnss_alone(flying: Vehicle) -> None:
    flying.stream(GPS_RAW_INT, 5.0)
    flying.wait(lambda: "GPS_RAW_INT" in flying.pilot.messages)
    apart = altitude_apart(flying)
    flying.faults.barometer_rises(DRIFT_M_S)
    try:
        flying.let_pass(10.0)
        assert flying.pilot.telemetry.health_all_ok()
        assert -flying.place[2] == pytest.approx(HEIGHT, abs=1.0)
        assert altitude_apart(flying) - apart == pytest.approx(-3.0, abs=1.2)
    finally:
        flying.faults.barometer_rises(-DRIFT_M_S)
        flying.let_pass(10.0)
        flying.faults.barometer_rises(0.0)
        flying.let_pass(10.0)


def altitude_apart(vehicle: Vehicle) -> float:
    """Return how much higher GNSS is than the estimate, metres."""
    messages = vehicle.pilot.messages
    return float(messages["GPS_RAW_INT"]["alt"] - messages["GLOBAL_POSITION_INT"]["alt"]) / 1000.0


def test_failed_compasses_show_in_sys_status_alone(flying: Vehicle) -> None:
    flying.stream(SYS_STATUS, 5.0)
    before = flying.place
    flying.faults.compasses(work=False)
    try:
        flying.wait(lambda: not flying.pilot.messages["SYS_STATUS"]["onboard_control_sensors_health"] & COMPASS, 10.0)
        flying.let_pass(10.0)
        assert math.dist(flying.place, before) < 1.0
        assert flying.pilot.telemetry.health().is_global_position_ok
    finally:
        flying.faults.compasses(work=True)
    flying.wait(lambda: bool(flying.pilot.messages["SYS_STATUS"]["onboard_control_sensors_health"] & COMPASS), 10.0)
