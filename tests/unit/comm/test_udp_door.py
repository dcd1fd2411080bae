"""The door between MAVSDK and the autopilot's UDP address, with real sockets of the loopback."""

from __future__ import annotations

import queue
import socket
from collections.abc import Iterator

import pytest
from pymavlink.dialects.v10 import ardupilotmega as mavlink1
from pymavlink.dialects.v20 import ardupilotmega as mavlink2

from hawk.comm.udp_door import PEERS, UdpDoor, is_heartbeat, is_udp

PATIENCE_S = 5.0
VEHICLE = mavlink2.MAVLink(None, 1, 1)
AUTOPILOT = VEHICLE.heartbeat_encode(2, 3, 81, 4, 4, 3).pack(VEHICLE)
STATION = VEHICLE.heartbeat_encode(6, 8, 0, 0, 4, 3).pack(VEHICLE)
KILL = VEHICLE.command_long_encode(1, 1, 185, 0, 1, 0, 0, 0, 0, 0, 0).pack(VEHICLE)


class Peer:
    """A socket on the autopilot's side."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(PATIENCE_S)
        self.port = int(self.socket.getsockname()[1])

    def got(self) -> bytes:
        return self.socket.recv(2048)


class Rig:
    """A door that listens, and what came through it."""

    def __init__(self) -> None:
        self.came: queue.Queue[bytes] = queue.Queue()
        self.peer = Peer()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            self.place = ("127.0.0.1", int(probe.getsockname()[1]))
        self.door = UdpDoor(f"udpin://127.0.0.1:{self.place[1]}", self.came.put)

    def hear(self, data: bytes, peer: Peer | None = None) -> None:
        (peer or self.peer).socket.sendto(data, self.place)
        assert self.came.get(timeout=PATIENCE_S) == data

    def close(self) -> None:
        assert self.door.close()
        self.peer.socket.close()


@pytest.fixture
def rig() -> Iterator[Rig]:
    made = Rig()
    yield made
    made.close()


def test_an_autopilot_that_was_heard_is_answered(rig: Rig) -> None:
    rig.hear(AUTOPILOT)
    rig.door.send(KILL)
    assert rig.peer.got() == KILL


def test_a_sender_that_is_no_autopilot_is_heard_and_not_answered(rig: Rig) -> None:
    station = Peer()
    rig.hear(STATION, station)
    rig.hear(AUTOPILOT)
    rig.door.send(KILL)
    assert rig.peer.got() == KILL
    station.socket.setblocking(False)
    with pytest.raises(BlockingIOError):
        station.socket.recv(2048)
    station.socket.close()


def test_silent_it_holds_heartbeats_back_and_nothing_else(rig: Rig) -> None:
    rig.hear(AUTOPILOT)
    rig.door.speaks = False
    rig.door.send(STATION)
    rig.door.send(KILL)
    assert rig.peer.got() == KILL
    rig.door.speaks = True
    rig.door.send(STATION)
    assert rig.peer.got() == STATION


def test_the_newest_autopilots_are_answered_and_older_addresses_forgotten(rig: Rig) -> None:
    peers = [Peer() for _ in range(PEERS + 1)]
    for peer in peers:
        rig.hear(AUTOPILOT, peer)
    rig.door.send(KILL)
    assert [peer.got() for peer in peers[1:]] == [KILL] * PEERS
    peers[0].socket.setblocking(False)
    with pytest.raises(BlockingIOError):
        peers[0].socket.recv(2048)
    for peer in peers:
        peer.socket.close()


def test_out_it_talks_first_and_to_one_address() -> None:
    peer, came = Peer(), queue.Queue[bytes]()
    door = UdpDoor(f"udpout://127.0.0.1:{peer.port}", came.put)
    door.send(STATION)
    data, sender = peer.socket.recvfrom(2048)
    assert data == STATION
    peer.socket.sendto(AUTOPILOT, sender)
    assert came.get(timeout=PATIENCE_S) == AUTOPILOT
    assert door.close()
    door.send(KILL)  # closed: dropped
    peer.socket.close()


def test_a_closed_port_behind_it_does_not_end_it() -> None:
    gone, came = Peer(), queue.Queue[bytes]()
    door = UdpDoor(f"udpout://127.0.0.1:{gone.port}", came.put)
    gone.socket.close()
    for _ in range(3):
        door.send(STATION)
    again = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    again.bind(("127.0.0.1", gone.port))
    again.settimeout(PATIENCE_S)
    door.send(KILL)
    data, sender = again.recvfrom(2048)
    assert data == KILL
    again.sendto(AUTOPILOT, sender)
    assert came.get(timeout=PATIENCE_S) == AUTOPILOT
    assert door.close()
    again.close()


def test_an_address_in_use_is_told(rig: Rig) -> None:
    with pytest.raises(OSError, match="in use"):
        UdpDoor(f"udpin://127.0.0.1:{rig.place[1]}", print)


def test_a_datagram_that_cannot_be_handled_does_not_end_it() -> None:
    came: queue.Queue[bytes] = queue.Queue()

    def take(data: bytes) -> None:
        came.put(data)
        if data == STATION:
            raise ValueError("broken")

    peer = Peer()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        place = probe.getsockname()
    door = UdpDoor(f"udpin://127.0.0.1:{place[1]}", take)
    for data in (STATION, AUTOPILOT):
        peer.socket.sendto(data, place)
        assert came.get(timeout=PATIENCE_S) == data
    assert door.close()
    peer.socket.close()


def test_heartbeats_are_told_from_everything_else() -> None:
    old = mavlink1.MAVLink(None, 1, 1)
    assert is_heartbeat(AUTOPILOT)
    assert is_heartbeat(old.heartbeat_encode(2, 3, 81, 4, 4, 3).pack(old, force_mavlink1=True))
    assert not is_heartbeat(KILL)
    assert not is_heartbeat(old.command_long_encode(1, 1, 185, 0, 1, 0, 0, 0, 0, 0, 0).pack(old, force_mavlink1=True))
    assert not is_heartbeat(b"")
    assert not is_heartbeat(b"\0\0\0")


@pytest.mark.parametrize(
    ("url", "expected"),
    [("udpin://0.0.0.0:14550", True), ("udpout://[::1]:1", True), ("serial:///dev/ttyAMA0:57600", False)],
)
def test_only_udp_goes_through_it(url: str, expected: bool) -> None:
    assert is_udp(url) is expected
