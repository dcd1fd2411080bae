"""Rally points: as AP_Rally and AP_Rally_Copter of ArduPilot decide."""

from __future__ import annotations

import math
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from tests.unit.sim.test_faults import put

RALLY, ALL, RTL = 2, 255, 6


def upload(station: Any, *places: tuple[float, float, float], command: int = 5100) -> int:
    station.send(mavlink.MAVLink_mission_count_message(1, 1, len(places), RALLY))
    for number, (latitude, longitude, up) in enumerate(places):
        at = round(latitude * 1e7), round(longitude * 1e7), up
        station.send(mavlink.MAVLink_mission_item_int_message(1, 1, number, 3, command, 0, 1, 0, 0, 0, 0, *at, RALLY))
    station.listen()
    return int(station.last("MISSION_ACK").type)


def landed_at(station: Any) -> tuple[float, float]:
    """Send it home and return where it lands, metres from home."""
    autopilot = station.autopilot
    home = autopilot.home
    station.mode(RTL)
    station.run(200.0, until=lambda: autopilot.body.on_ground)
    return autopilot.body.position[0] - home[0], autopilot.body.position[1] - home[1]


def test_an_upload_is_read_back_counted_and_cleared(station: Any) -> None:
    assert upload(station, (43.2612, -79.9190, 25.0), (43.2613, -79.9191, 30.0)) == mavlink.MAV_MISSION_ACCEPTED
    assert station.autopilot.parameters["RALLY_TOTAL"] == 2
    station.send(mavlink.MAVLink_mission_request_list_message(1, 1, RALLY))
    station.listen()
    assert station.last("MISSION_COUNT").count == 2
    station.send(mavlink.MAVLink_mission_request_int_message(1, 1, 1, RALLY))
    station.listen()
    item = station.last("MISSION_ITEM_INT")
    assert (item.command, item.frame, item.x, item.y, item.z, item.mission_type) == (
        5100,
        3,
        432613000,
        -799191000,
        30.0,
        RALLY,
    )
    station.send(mavlink.MAVLink_mission_clear_all_message(1, 1, RALLY))
    station.listen()
    assert station.autopilot.rally.points == ()
    assert station.autopilot.parameters["RALLY_TOTAL"] == 0


def test_what_is_no_rally_point_is_refused(station: Any) -> None:
    assert upload(station, (43.26, -79.91, 25.0), command=16) == mavlink.MAV_MISSION_UNSUPPORTED
    assert station.autopilot.rally.points == ()


def test_more_than_there_is_room_for_is_refused(station: Any) -> None:
    station.send(mavlink.MAVLink_mission_count_message(1, 1, 21, RALLY))
    station.listen()
    assert station.last("MISSION_ACK").type == mavlink.MAV_MISSION_NO_SPACE


def test_a_fence_stays_when_rally_points_are_cleared(station: Any) -> None:
    station.wait_for_position()
    put(station, fence=[(50.0, 50.0), (50.0, -50.0), (-50.0, 0.0)], rally=[(10.0, 10.0, 20.0)])
    station.send(mavlink.MAVLink_mission_clear_all_message(1, 1, RALLY))
    station.listen()
    assert len(station.autopilot.fence.items) == 3
    station.send(mavlink.MAVLink_mission_clear_all_message(1, 1, ALL))
    station.listen()
    assert station.autopilot.fence.items == ()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rally", "parameters", "goal"),
    [
        ([(20.0, 30.0, 15.0)], {}, (20.0, 30.0)),
        ([(20.0, 30.0, 15.0), (60.0, 0.0, 15.0)], {}, (20.0, 30.0)),
        ([(-60.0, -60.0, 15.0)], {}, (0.0, 0.0)),
        ([(-60.0, -60.0, 15.0)], {"RALLY_INCL_HOME": 0.0}, (-60.0, -60.0)),
        ([(20.0, 30.0, 15.0)], {"RALLY_LIMIT_KM": 0.005}, (0.0, 0.0)),
        ([], {}, (0.0, 0.0)),
    ],
    ids=["near", "nearest", "home is nearer", "home does not count", "out of reach", "none"],
)
def test_rtl_goes_to_the_nearest(
    flying: Any, rally: list[tuple[float, float, float]], parameters: dict[str, float], goal: tuple[float, float]
) -> None:
    flying.local_target(15.0, 15.0, -12.0)
    flying.run(12.0)
    put(flying, rally=rally, parameters=parameters)
    assert landed_at(flying) == pytest.approx(goal, abs=1.5)


@pytest.mark.slow
def test_a_point_outside_the_fence_does_not_count(flying: Any) -> None:
    flying.local_target(15.0, 15.0, -12.0)
    flying.run(12.0)
    put(
        flying,
        rally=[(20.0, 30.0, 15.0)],
        fence=[(25.0, 25.0), (25.0, -25.0), (-25.0, -25.0), (-25.0, 25.0)],
        parameters={"FENCE_ENABLE": 1.0, "FENCE_TYPE": 4.0},
    )
    assert math.hypot(*landed_at(flying)) < 1.5


@pytest.mark.nightly
def test_it_returns_at_the_point_s_height_where_that_is_higher(flying: Any) -> None:
    flying.local_target(0.0, 0.0, -12.0)
    flying.run(3.0)
    put(flying, rally=[(40.0, 0.0, 24.0)], parameters={"RALLY_INCL_HOME": 0.0})
    flying.mode(RTL)
    highest = 0.0
    while not flying.autopilot.landed:
        flying.run(1.0)
        highest = max(highest, flying.autopilot.body.height)
    assert highest == pytest.approx(24.0, abs=0.7)
