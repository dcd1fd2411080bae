"""Rows: takeoff, landed state, targets, offboard, hold, goto, geofence, disarm, RTL and LAND, arm again after them."""

from __future__ import annotations

import math
import time

import pytest
from mavsdk.plugins.action import ActionError
from mavsdk.plugins.geofence import FenceType, GeofenceData, Point, Polygon
from mavsdk.plugins.offboard import Offboard, PositionNedYaw

from tests.contract.vehicle import (
    BRAKE,
    GUIDED,
    HEIGHT,
    IN_AIR,
    LAND,
    LANDING,
    LOITER,
    METRES_A_DEGREE,
    ON_GROUND,
    RTL,
    STABILIZE,
    TAKING_OFF,
    Vehicle,
)

pytestmark = pytest.mark.contract


def test_takeoff_sets_guided_by_itself_and_climbs_to_the_height_set_in_mavsdk(grounded: Vehicle) -> None:
    pilot = grounded.pilot
    pilot.landed.clear()
    pilot.action.arm()
    assert grounded.mode == STABILIZE
    pilot.action.set_takeoff_altitude(4.0)
    pilot.action.takeoff()
    grounded.wait(lambda: grounded.mode == GUIDED, 3.0)
    grounded.wait(lambda: grounded.place[2] < -3.5, 20.0)
    grounded.wait(lambda: grounded.landed == IN_AIR, 10.0)
    assert grounded.place[2] > -5.0
    assert [state for state in pilot.landed if state != ON_GROUND] == [TAKING_OFF, IN_AIR]


def test_in_the_air_takeoff_and_disarm_fail(flying: Vehicle) -> None:
    for order in (flying.pilot.action.takeoff, flying.pilot.action.disarm):
        with pytest.raises(ActionError, match="FAILED"):
            order()
    assert flying.armed


def test_one_target_is_flown_to_without_the_offboard_plugin(flying: Vehicle) -> None:
    goal = (15.0, -8.0, -12.0)
    farthest = 0.0
    began = flying.seconds
    flying.pilot.target(*goal, yaw=0.5)

    def is_there() -> bool:
        nonlocal farthest
        farthest = max(farthest, flying.place[0])
        return math.dist(flying.place, goal) < 0.5

    flying.wait(is_there, 20.0)
    assert flying.seconds - began < 10.0
    flying.wait(lambda: is_there() and math.hypot(*flying.velocity) < 0.2, 10.0)
    assert farthest < goal[0] + 1.0
    yaw = flying.pilot.messages["ATTITUDE"]["yaw"]
    assert abs(yaw - 0.5) < 0.1


def test_in_guided_a_set_point_of_the_offboard_plugin_moves_before_its_start(flying: Vehicle) -> None:
    offboard = Offboard(flying.pilot.system)
    offboard.set_position_ned(PositionNedYaw(6.0, 0.0, -HEIGHT, 0.0))
    flying.wait(lambda: flying.place[0] > 5.0, 20.0)
    offboard.start()
    assert flying.mode == GUIDED
    offboard.stop()
    flying.wait(lambda: flying.mode == BRAKE, 3.0)


def test_hold_is_brake_and_a_set_point_there_is_taken_and_does_nothing(flying: Vehicle) -> None:
    flying.pilot.action.hold()
    flying.wait(lambda: flying.mode == BRAKE, 3.0)
    flying.let_pass(3.0)
    before = flying.place
    flying.pilot.target(before[0] + 20.0, before[1], before[2])
    flying.let_pass(5.0)
    assert math.dist(flying.place, before) < 0.7
    assert flying.mode == BRAKE


def test_loiter_sinks_with_the_throttle_stick_low(flying: Vehicle) -> None:
    flying.go(0.0, 0.0, -20.0)
    flying.set_mode(LOITER)
    flying.wait(lambda: flying.velocity[2] > 2.0, 10.0)
    height, began = flying.place[2], flying.seconds
    flying.let_pass(2.0)
    assert (flying.place[2] - height) / (flying.seconds - began) == pytest.approx(2.4, abs=0.5)
    flying.set_mode(GUIDED)


def test_goto_returns_before_it_arrives_at_an_altitude_above_the_sea_and_ignores_the_yaw(flying: Vehicle) -> None:
    here = flying.pilot.telemetry.position()
    yaw = flying.pilot.messages["ATTITUDE"]["yaw"]
    north = 20.0 / METRES_A_DEGREE
    began = time.monotonic()
    flying.pilot.action.goto_location(
        here.latitude_deg + north, here.longitude_deg, here.absolute_altitude_m + 2.0, math.degrees(yaw) + 120.0
    )
    assert time.monotonic() - began < 1.5
    assert flying.place[0] < 10.0
    flying.wait(lambda: abs(flying.place[0] - 20.0) < 0.7 and math.hypot(*flying.velocity) < 0.3, 30.0)
    assert flying.place[2] == pytest.approx(-HEIGHT - 2.0, abs=0.7)
    turned = math.remainder(flying.pilot.messages["ATTITUDE"]["yaw"] - yaw, math.tau)
    assert abs(turned) < math.radians(100.0)


def test_a_fence_that_was_uploaded_waits_to_be_enabled_and_then_refuses_targets_beyond(flying: Vehicle) -> None:
    pilot, home = flying.pilot, flying.pilot.telemetry.home()
    degrees = 30.0 / METRES_A_DEGREE
    east = degrees / math.cos(math.radians(home.latitude_deg))
    signs = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    corners = [Point(home.latitude_deg + a * degrees, home.longitude_deg + b * east) for a, b in signs]
    pilot.geofence.upload_geofence(GeofenceData([Polygon(corners, FenceType.INCLUSION)], []))
    assert flying.parameter("FENCE_ENABLE") == 0
    flying.set({"FENCE_TYPE": 5, "FENCE_ENABLE": 1})
    flying.let_pass(3.0)  # ArduCopter takes a new fence up once a second
    altitude = home.absolute_altitude_m + HEIGHT
    with pytest.raises(ActionError, match="FAILED"):
        pilot.action.goto_location(home.latitude_deg + 2 * degrees, home.longitude_deg, altitude, 0.0)
    before = flying.place
    pilot.target(60.0, 0.0, -HEIGHT)
    flying.let_pass(4.0)
    assert math.dist(flying.place, before) < 0.7
    assert flying.mode == GUIDED


def test_rtl_lands_and_disarms_and_arming_again_needs_guided_first(flying: Vehicle) -> None:
    pilot = flying.pilot
    pilot.action.return_to_launch()
    flying.wait(lambda: flying.mode == RTL, 3.0)
    flying.wait(lambda: flying.landed == LANDING, 60.0)
    assert pilot.telemetry.in_air()
    flying.wait(lambda: not flying.armed, 90.0)
    flying.wait(lambda: flying.landed == ON_GROUND, 5.0)
    assert pilot.landed[-2:] == [LANDING, ON_GROUND]
    assert math.hypot(*flying.from_home) < 2.0
    pilot.action.hold()
    flying.wait(lambda: pilot.telemetry.flight_mode().name == "HOLD", 3.0)
    with pytest.raises(ActionError, match="FAILED"):
        pilot.action.arm()
    flying.wait(lambda: flying.said("BRAKE mode not armable"), 2.0)
    flying.set_mode(GUIDED)
    pilot.action.arm()
    flying.wait(lambda: flying.armed, 3.0)
    pilot.action.disarm()


def test_land_descends_and_disarms_by_itself(flying: Vehicle) -> None:
    flying.pilot.action.land()
    flying.wait(lambda: flying.mode == LAND, 3.0)
    flying.wait(lambda: not flying.armed, 60.0)
    flying.wait(lambda: flying.landed == ON_GROUND, 5.0)
