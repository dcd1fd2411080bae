from __future__ import annotations

import socket
from collections.abc import Iterator

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from benchmarks.figures import BenchmarkError
from benchmarks.kill_wire import SilentAutopilot, figures


@pytest.fixture
def ground() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as made:
        made.bind(("127.0.0.1", 0))
        made.settimeout(5.0)
        yield made


@pytest.fixture
def peer(ground: socket.socket) -> Iterator[SilentAutopilot]:
    made = SilentAutopilot(ground.getsockname()[1])
    made.start()
    yield made
    made.close()


def command(number: int) -> bytes:
    coder = mavlink.MAVLink(None, srcSystem=245, srcComponent=190)
    message = mavlink.MAVLink_command_long_message(1, 1, number, 0, 1, 0, 0, 0, 0, 0, 0)
    return bytes(message.pack(coder))


def test_the_peer_is_an_armed_copter_to_who_listens(peer: SilentAutopilot, ground: socket.socket) -> None:
    datagram, _ = ground.recvfrom(1024)
    (beat,) = mavlink.MAVLink(None).parse_buffer(datagram)
    assert beat.get_type() == "HEARTBEAT"
    assert beat.autopilot == mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
    assert beat.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED


def test_only_flight_terminations_are_noted(peer: SilentAutopilot, ground: socket.socket) -> None:
    _, address = ground.recvfrom(1024)
    for number in (mavlink.MAV_CMD_DO_SET_MODE, mavlink.MAV_CMD_DO_FLIGHTTERMINATION):
        ground.sendto(command(number), address)
    assert peer.wait_for(1, 5.0) == peer.arrivals[0]
    assert len(peer.arrivals) == 1


def test_a_kill_that_does_not_come_is_an_error(peer: SilentAutopilot) -> None:
    with pytest.raises(BenchmarkError, match="kill 1 did not arrive"):
        peer.wait_for(1, 0.01)


def test_the_figures_are_percentiles_with_the_limit_on_the_slow_end() -> None:
    found = {figure.key: figure for figure in figures([float(k) for k in range(1, 201)])}
    assert found["kill_to_wire_p50_ms"].value == 100.0
    assert found["kill_to_wire_p99_ms"].value == 198.0
    assert found["kill_to_wire_p99_ms"].passed is False
    assert found["kill_to_wire_max_ms"].value == 200.0
    assert found["kills"].value == 200.0
