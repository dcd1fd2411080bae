from __future__ import annotations

import pytest

from hawk.comm.mavlink.frames import Heartbeat
from hawk.comm.mavlink.peer import SHOWN_S, Roster

TRACKER = Heartbeat(2, 1, 5, 3, 0)
QUADROTOR = Heartbeat(1, 1, 2, 3, 0)
GIMBAL = Heartbeat(1, 154, 26, 8, 0)
HEXAROTOR = Heartbeat(3, 1, 13, 3, 0)
STATION = Heartbeat(255, 190, 6, 8, 0)
TWIN = Heartbeat(245, 190, 6, 8, 0)


def heard(*beats: Heartbeat) -> Roster:
    roster = Roster(own_id=245)
    for beat in beats:
        roster.take(beat, 0.0)
    return roster


def test_the_vehicle_is_the_first_copter_or_the_named_one() -> None:
    assert heard().vehicle(None, 0.0) is None
    assert heard(TRACKER, GIMBAL, STATION).vehicle(None, 0.0) is None
    both = heard(TRACKER, HEXAROTOR, QUADROTOR)
    both.take(HEXAROTOR, 1.0)
    assert both.vehicle(None, 1.0) == 3
    assert both.vehicle(1, 1.0) == 1
    assert both.vehicle(2, 1.0) is None, "named, but no copter"


def test_everybody_is_named_while_heard() -> None:
    roster = heard(TRACKER, GIMBAL, STATION)
    words = "antenna tracker (ArduPilot), system 2; gimbal, system 1.154; ground station, system 255"
    assert roster.names(SHOWN_S) == words
    assert roster.names(SHOWN_S + 0.1) == ""


def test_other_copters_are_named_and_the_vehicle_is_not() -> None:
    roster = heard(QUADROTOR, TRACKER, HEXAROTOR)
    assert roster.other_vehicles(1, 0.0) == "hexarotor (ArduPilot), system 3"
    assert roster.other_vehicles(3, 0.0) == "quadrotor (ArduPilot), system 1"
    assert heard(QUADROTOR, GIMBAL).other_vehicles(1, 0.0) == ""


@pytest.mark.fault(
    "a daemon of another computer on the same autopilot",
    "a ground station with our own MAVLink id is a second sender: named, Arm is refused",
)
def test_a_ground_station_with_our_own_id_is_a_twin() -> None:
    assert heard(QUADROTOR, STATION).twin(0.0) == ""
    assert heard(TWIN).twin(0.0) == "ground station, system 245, component 190"
    assert heard(Heartbeat(245, 1, 2, 3, 0)).twin(0.0) == "", "a vehicle of that id is another matter"


def test_one_that_nobody_named_is_alone_for_the_time_to_wait() -> None:
    roster = heard(QUADROTOR, TRACKER)
    assert (roster.vehicle(None, 1.4, 1.5), roster.vehicle(None, 1.5, 1.5)) == (None, 1)
    roster.take(HEXAROTOR, 2.0)
    assert roster.vehicle(None, 5.0, 1.5) is None
    assert roster.vehicle(3, 5.0, 1.5) == 3
    assert roster.several(5.0) == "quadrotor (ArduPilot), system 1; hexarotor (ArduPilot), system 3"
    assert heard(QUADROTOR, TRACKER).several(0.0) == ""
