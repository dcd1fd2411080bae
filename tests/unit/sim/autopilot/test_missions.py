from __future__ import annotations

import math
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

FENCE, MISSION, ALL = 1, 0, 255


def item(sequence: int, latitude: float, longitude: float, count: int = 3, command: int = 5001) -> Any:
    return mavlink.MAVLink_mission_item_int_message(
        1, 1, sequence, 0, command, 0, 1, count, 0, 0, 0, round(latitude * 1e7), round(longitude * 1e7), 0, FENCE
    )


TRIANGLE = [(43.2609, -79.9192), (43.2619, -79.9192), (43.2619, -79.9182)]


def upload(station: Any, corners: list[tuple[float, float]] = TRIANGLE, command: int = 5001) -> int:
    station.send(mavlink.MAVLink_mission_count_message(1, 1, len(corners), FENCE))
    for sequence, corner in enumerate(corners):
        station.send(item(sequence, *corner, count=len(corners), command=command))
    station.listen()
    return int(station.last("MISSION_ACK").type)


def test_what_was_uploaded_is_read_back(station: Any) -> None:
    assert upload(station) == mavlink.MAV_MISSION_ACCEPTED
    station.send(mavlink.MAVLink_mission_request_list_message(1, 1, FENCE))
    station.listen()
    assert station.last("MISSION_COUNT").count == 3
    for sequence, corner in enumerate(TRIANGLE):
        station.send(mavlink.MAVLink_mission_request_int_message(1, 1, sequence, FENCE))
        station.listen()
        answer = station.last("MISSION_ITEM_INT")
        assert (answer.seq, answer.command, answer.param1, answer.mission_type) == (sequence, 5001, 3, FENCE)
        assert (answer.x * 1e-7, answer.y * 1e-7) == pytest.approx(corner, abs=1e-7)


def test_an_item_out_of_turn_is_asked_for_again(station: Any) -> None:
    station.send(mavlink.MAVLink_mission_count_message(1, 1, 3, FENCE))
    station.send(item(2, *TRIANGLE[2]))
    station.listen()
    assert [request.seq for request in station.all("MISSION_REQUEST_INT")] == [0, 0]
    assert not station.all("MISSION_ACK")


def test_a_lost_item_is_asked_for_again_and_given_up_in_the_end(station: Any) -> None:
    station.send(mavlink.MAVLink_mission_count_message(1, 1, 3, FENCE))
    station.run(3.5)
    assert len(station.all("MISSION_REQUEST_INT")) == 4
    station.run(10.0)
    assert station.last("MISSION_ACK").type == mavlink.MAV_MISSION_OPERATION_CANCELLED
    station.heard.clear()
    station.run(5.0)
    assert not station.all("MISSION_REQUEST_INT")


@pytest.mark.parametrize(
    ("corners", "command", "result"),
    [
        (TRIANGLE[:2], 5001, mavlink.MAV_MISSION_INVALID),
        (TRIANGLE, 16, mavlink.MAV_MISSION_INVALID),
        ([(95.0, 0.0), *TRIANGLE[1:]], 5001, mavlink.MAV_MISSION_INVALID_PARAM5_X),
    ],
)
def test_a_wrong_fence_is_refused_and_the_old_one_stays(
    station: Any, corners: list[tuple[float, float]], command: int, result: int
) -> None:
    upload(station)
    station.send(mavlink.MAVLink_mission_count_message(1, 1, len(corners), FENCE))
    for sequence, corner in enumerate(corners):
        station.send(item(sequence, *corner, count=len(corners), command=command))
        station.listen()
        if station.last("MISSION_ACK").type == result:
            break
    assert result in [message.type for message in station.all("MISSION_ACK")]
    assert len(station.autopilot.fence.items) == 3


def test_too_many_items_are_refused(station: Any) -> None:
    station.send(mavlink.MAVLink_mission_count_message(1, 1, 71, FENCE))
    station.listen()
    assert station.last("MISSION_ACK").type == mavlink.MAV_MISSION_NO_SPACE


def upload_rings(station: Any, *counts: int) -> list[int]:
    """Upload an inclusion polygon and exclusion polygons with these numbers of corners; return acknowledgements."""
    station.heard.clear()
    corners = [(5001 if not ring else 5002, count) for ring, count in enumerate(counts) for _ in range(count)]
    station.send(mavlink.MAVLink_mission_count_message(1, 1, len(corners), FENCE))
    for sequence, (command, count) in enumerate(corners):
        turned = math.radians(sequence)
        place = (43.2609 + 1e-3 * math.cos(turned), -79.9192 + 1e-3 * math.sin(turned))
        station.send(item(sequence, *place, count=count, command=command))
    station.listen()
    return [int(message.type) for message in station.all("MISSION_ACK")]


def test_corners_fit_as_far_as_the_memory_of_arducopter_goes(station: Any) -> None:
    assert upload_rings(station, 69) == [mavlink.MAV_MISSION_ACCEPTED]
    assert upload_rings(station, 65, 3) == [mavlink.MAV_MISSION_ACCEPTED]
    for too_many in ((70,), (67, 3), (60, 3, 3, 3)):
        assert upload_rings(station, *too_many) == [mavlink.MAV_MISSION_ERROR]
    assert len(station.autopilot.fence.items) == 68
    assert not station.autopilot.stopped


def test_a_fence_that_fills_the_memory_ends_the_program_as_arducopter_does(station: Any) -> None:
    assert upload_rings(station, 66, 3) == []
    assert "memory" in station.autopilot.stopped


@pytest.mark.parametrize(("kind", "left"), [(FENCE, 0), (ALL, 0), (MISSION, 3)])
def test_clearing(station: Any, kind: int, left: int) -> None:
    upload(station)
    station.send(mavlink.MAVLink_mission_clear_all_message(1, 1, kind))
    station.listen()
    assert station.last("MISSION_ACK").type == mavlink.MAV_MISSION_ACCEPTED
    assert len(station.autopilot.fence.items) == left
    assert station.autopilot.parameters["FENCE_TOTAL"] == left


def test_waypoint_missions_are_not_flown_here(station: Any) -> None:
    station.send(mavlink.MAVLink_mission_count_message(1, 1, 2, MISSION))
    station.listen()
    assert station.last("MISSION_ACK").type == mavlink.MAV_MISSION_UNSUPPORTED
    station.send(mavlink.MAVLink_mission_request_list_message(1, 1, MISSION))
    station.send(mavlink.MAVLink_mission_request_int_message(1, 1, 0, MISSION))
    station.listen()
    assert station.last("MISSION_COUNT").count == 0
    assert station.last("MISSION_ACK").type == mavlink.MAV_MISSION_INVALID_SEQUENCE


def test_an_empty_upload_clears(station: Any) -> None:
    upload(station)
    assert upload(station, []) == mavlink.MAV_MISSION_ACCEPTED
    assert station.autopilot.fence.items == ()


def test_an_item_without_an_upload_is_out_of_turn(station: Any) -> None:
    station.send(item(0, *TRIANGLE[0]))
    station.listen()
    assert station.last("MISSION_ACK").type == mavlink.MAV_MISSION_INVALID_SEQUENCE
