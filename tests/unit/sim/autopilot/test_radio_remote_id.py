"""The transmitter behind the simulated ArduCopter: good to arm while operator and place come."""

from __future__ import annotations

from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from tests.unit.sim.test_faults import put

NONE = [0] * 20


def operator() -> Any:
    return mavlink.MAVLink_open_drone_id_operator_id_message(1, 1, NONE, 0, b"FIN87astrdge12k8")


def place(latitude: int = 432_609_000) -> Any:
    return mavlink.MAVLink_open_drone_id_system_message(
        1, 1, NONE, 0, 0, latitude, 0, 1, 0, -1000.0, -1000.0, 0, 0, 100.0, 7
    )


def update() -> Any:
    return mavlink.MAVLink_open_drone_id_system_update_message(1, 1, 432_609_000, 0, 100.0, 8)


def word(station: Any) -> tuple[int, str]:
    station.heard.clear()
    station.run(1.1)
    found = station.last("OPEN_DRONE_ID_ARM_STATUS")
    assert found.get_srcComponent() == 236
    return found.status, found.error


@pytest.mark.slow
def test_a_drone_that_is_sent_nothing_of_it_says_nothing(flying: Any) -> None:
    flying.run(3.0)
    assert not flying.all("OPEN_DRONE_ID_ARM_STATUS")


@pytest.mark.slow
def test_it_says_what_is_missing_and_good_when_nothing_is(flying: Any) -> None:
    flying.send(operator())
    assert word(flying) == (1, "missing SYS")
    flying.send(place())
    assert word(flying) == (0, "")
    flying.run(2.2)
    assert word(flying) == (1, "missing SYS")
    flying.send(update())
    assert word(flying) == (0, "")
    flying.run(20.0)
    flying.send(update())
    assert word(flying) == (1, "missing OP_ID")


@pytest.mark.slow
def test_an_update_without_the_whole_counts_for_nothing(flying: Any) -> None:
    flying.send(operator())
    flying.send(update())
    assert word(flying) == (1, "missing SYS")


@pytest.mark.slow
def test_a_place_that_is_zero_is_none(flying: Any) -> None:
    flying.send(operator())
    flying.send(place(latitude=0))
    assert word(flying) == (1, "missing OP_LOC")


def test_without_a_position_of_the_drone_it_is_not_good(make_station: Any) -> None:
    station = make_station(gnss_wait_s=60.0)
    station.send(operator())
    station.send(place())
    assert word(station) == (1, "missing LOC")


@pytest.mark.slow
def test_a_lost_transmitter_is_silent(flying: Any) -> None:
    flying.send(operator())
    flying.send(place())
    assert word(flying) == (0, "")
    put(flying, remote_id="lost")
    flying.heard.clear()
    flying.run(3.0)
    assert not flying.all("OPEN_DRONE_ID_ARM_STATUS")
