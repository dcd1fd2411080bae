"""The gate between real sockets: the autopilot outside, MAVSDK's port inside, strangers beside."""

from __future__ import annotations

import contextlib
import socket
import threading
import time
from collections.abc import Callable, Iterator

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.comm.mavlink.frames import ground_station_heartbeat, is_heartbeat
from hawk.comm.mavlink.peer import Expected, PeerKeeper
from hawk.comm.mavlink.udp_gate import Hearing, UdpGate, serves
from tests.unit.comm.mavlink.test_peer import attitude, beat

OURS = ground_station_heartbeat(245, 190)
GREETING = b"greeting"
WAIT_S = 10.0


class Steps:
    """A clock of the gate that a test moves."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def udp(host: str = "127.0.0.1", port: int = 0) -> socket.socket:
    made = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, socket.SOCK_DGRAM)
    made.bind((host, port))
    made.settimeout(WAIT_S)
    return made


class Rig:
    """A gate, MAVSDK's end of it, and its port."""

    def __init__(self, stack: contextlib.ExitStack, host: str = "127.0.0.1", expected: Expected | None = None) -> None:
        self._stack = stack
        self.clock = Steps()
        with udp(host) as probe:
            self.port = probe.getsockname()[1]
        self.host = host
        url = f"udpin://[{host}]:{self.port}" if ":" in host else f"udpin://{host}:{self.port}"
        self.overheard: list[bytes] = []
        """Datagrams that were passed, with their time noted."""
        self.gate = UdpGate(url, PeerKeeper(expected or Expected()), GREETING, self.clock, self.overheard.append)
        stack.callback(self.gate.close)
        self.inside = self.attach()

    def attach(self) -> socket.socket:
        """Open MAVSDK's end; it is greeted."""

        def add_connection(url: str) -> socket.socket:
            return self._stack.enter_context(udp(port=int(url.rpartition(":")[2])))

        inside = self.gate.attach(add_connection)
        assert inside.recv(999) == GREETING
        return inside

    def sender(self) -> socket.socket:
        made = self._stack.enter_context(udp(self.host))
        made.connect((self.host, self.port))
        return made

    def next(self) -> bytes:
        """Return the next datagram that MAVSDK gets, greetings left out."""
        while True:
            data = self.inside.recv(999)
            if data != GREETING:
                return data

    def keep(self) -> socket.socket:
        """Return the socket of a kept autopilot, with its line made."""
        autopilot = self.sender()
        autopilot.send(beat())
        assert self.next() == beat()
        self.until_passed(beat())
        return autopilot

    def answer(self, data: bytes) -> None:
        """MAVSDK sends."""
        name = self.gate._inside.getsockname()
        self.inside.sendto(data, name)

    def until_passed(self, data: bytes) -> None:
        """Wait until the gate is done with a datagram: it notes the time after it has sent."""
        self.until(lambda: self.overheard[-1:] == [data])

    def until(self, true: Callable[[], bool]) -> None:
        deadline = time.monotonic() + WAIT_S
        while not true():
            assert time.monotonic() < deadline
            time.sleep(0.002)


@pytest.fixture
def stack() -> Iterator[contextlib.ExitStack]:
    with contextlib.ExitStack() as stack:
        yield stack


@pytest.fixture
def rig(stack: contextlib.ExitStack) -> Rig:
    return Rig(stack)


@pytest.mark.parametrize("host", ["127.0.0.1", "0.0.0.0", "::1"])
def test_datagrams_pass_in_both_directions_and_a_stranger_hears_and_says_nothing(
    stack: contextlib.ExitStack, host: str
) -> None:
    rig = Rig(stack, host)
    assert rig.gate.hearing == Hearing()
    autopilot, stranger = rig.keep(), rig.sender()
    for number in range(20):
        stranger.send(beat() + b"forged")
        autopilot.send(b"%d" % number)
        assert rig.next() == b"%d" % number
        rig.answer(b"to the autopilot %d" % number)
        assert autopilot.recv(999) == b"to the autopilot %d" % number
    rig.until(lambda: rig.gate.hearing.refused == 20)
    stranger.setblocking(False)
    with pytest.raises(BlockingIOError):
        stranger.recv(999)
    hearing = rig.gate.hearing
    assert hearing.sender.endswith(f":{autopilot.getsockname()[1]}")
    assert f":{stranger.getsockname()[1]} (system 1) sends to the autopilot's port, too." in hearing.second_sender


@pytest.mark.fault(
    "a flood of datagrams on the autopilot's port",
    "the autopilot's datagrams pass by a socket of their own; strangers are read 1280 a second at most",
)
def test_a_flood_takes_neither_room_nor_time_from_the_autopilot(rig: Rig) -> None:
    autopilot, stranger = rig.keep(), rig.sender()
    ending = threading.Event()
    sent = [0]

    def flood() -> None:
        while not ending.is_set():
            stranger.send(beat() * 10)
            sent[0] += 1

    thread = threading.Thread(target=flood, daemon=True)
    thread.start()
    try:
        rig.until(lambda: sent[0] > 5000)  # more than a socket's buffer holds
        for number in range(300):
            autopilot.send(b"%d" % number)
            assert rig.next() == b"%d" % number
    finally:
        ending.set()
        thread.join()
    assert 0 < rig.gate.hearing.refused <= sent[0]


def test_few_strange_datagrams_are_looked_at_in_a_while(rig: Rig) -> None:
    autopilot, stranger = rig.keep(), rig.sender()
    for _ in range(200):
        stranger.send(b"junk")
    autopilot.send(b"after them")
    assert rig.next() == b"after them"
    rig.until(lambda: rig.gate.hearing.refused == 63)  # beside the heartbeat; the clock stands
    rig.clock.now += 0.06
    rig.until(lambda: rig.gate.hearing.refused == 63 + 64)


@pytest.mark.fault(
    "the autopilot's router starts again on another port",
    "it is kept after 3 s of silence, and the change is reported; another host after 30 s; a sender that "
    "spoke beside the autopilot never",
)
def test_a_router_that_starts_again_is_answered_on_its_new_port(rig: Rig) -> None:
    rig.keep().close()
    again = rig.sender()
    again.send(beat())
    rig.until(lambda: rig.gate.hearing.refused == 1)
    rig.clock.now += 4.0
    again.send(beat() + b"again")
    assert rig.next() == beat() + b"again"
    rig.answer(b"welcome")
    assert again.recv(999) == b"welcome"
    again.send(attitude())
    assert rig.next() == attitude()
    assert rig.gate.hearing.sender == f"127.0.0.1:{again.getsockname()[1]}"


@pytest.mark.slow
@pytest.mark.fault(
    "nothing is heard any more, but the uplink is alive: MAVSDK forgets the address after 10 s",
    "MAVSDK keeps it: Kill and RTL go out",
)
def test_mavsdk_is_greeted_while_nothing_is_heard_so_that_it_goes_on_sending(rig: Rig) -> None:
    autopilot = rig.keep()
    rig.clock.now += 1.1
    autopilot.send(b"x")
    assert rig.next() == b"x"
    rig.until_passed(b"x")
    rig.clock.now += 1.1
    assert rig.inside.recv(999) == GREETING
    rig.answer(b"kill")
    assert autopilot.recv(999) == b"kill"


def test_a_connection_that_was_opened_again_gets_the_same_autopilot(rig: Rig) -> None:
    autopilot = rig.keep()
    rig.inside.close()
    rig.clock.now += 0.001
    autopilot.send(b"lost")
    rig.until_passed(b"lost")  # it must not reach the new connection
    rig.inside = rig.attach()
    rig.until(lambda: _passes(rig, autopilot))
    rig.answer(b"still you")
    assert autopilot.recv(999) == b"still you"


def _passes(rig: Rig, autopilot: socket.socket) -> bool:
    autopilot.send(b"found")
    return rig.next() == b"found"


def test_without_a_line_of_its_own_the_autopilot_is_still_the_only_one_heard(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_line(hall: socket.socket) -> socket.socket:
        raise OSError("Operation not supported")

    monkeypatch.setattr(rig.gate, "_line_to_kept", no_line)
    autopilot, stranger = rig.keep(), rig.sender()
    stranger.send(beat())
    autopilot.send(b"x")
    assert rig.next() == b"x"
    rig.answer(b"y")
    assert autopilot.recv(999) == b"y"
    rig.until(lambda: rig.gate.hearing.refused == 1)


def test_no_other_program_opens_the_port_beside_the_gate(rig: Rig) -> None:
    rig.keep()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        with pytest.raises(OSError, match="in use"):
            other.bind(("127.0.0.1", rig.port))
    with pytest.raises(OSError, match="in use"):
        UdpGate(f"udpin://127.0.0.1:{rig.port}", PeerKeeper(Expected()), GREETING)


def test_an_error_in_a_datagram_does_not_end_the_thread(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> bool:
        monkeypatch.undo()
        raise RuntimeError("broken")

    monkeypatch.setattr(rig.gate._keeper, "admit", broken)
    autopilot = rig.sender()
    autopilot.send(beat())
    rig.until(lambda: _passes_heartbeat(rig, autopilot))


def _passes_heartbeat(rig: Rig, autopilot: socket.socket) -> bool:
    autopilot.send(beat())
    return rig.gate.hearing.sender != ""


def test_a_port_that_mavsdk_cannot_open_is_tried_five_times(rig: Rig) -> None:
    urls: list[str] = []

    def refuse(url: str) -> None:
        urls.append(url)
        raise RuntimeError("in use")

    with pytest.raises(RuntimeError, match="in use"):
        rig.gate.attach(refuse)
    assert len(urls) == 5


@pytest.mark.parametrize("url", ["udpin://127.0.0.1", "udpin://:14550", "udpin://127.0.0.1:0", "tcpin://127.0.0.1:5"])
def test_a_url_without_host_and_port_is_refused(url: str) -> None:
    with pytest.raises(ValueError, match=r"must be udpin://HOST:PORT or udpout://HOST:PORT"):
        UdpGate(url, PeerKeeper(Expected()), GREETING)


def test_serial_lines_and_tcp_have_one_sender_and_no_gate() -> None:
    assert serves("udpin://127.0.0.1:1")
    assert serves("udpout://127.0.0.1:1")
    assert not serves("serial:///dev/ttyAMA0:921600")
    assert not serves("tcpout://127.0.0.1:5760")


def test_closed_it_leaves_the_port_and_no_thread(rig: Rig) -> None:
    rig.keep()
    rig.gate.close()
    rig.gate.close()
    assert "autopilot-gate" not in {thread.name for thread in threading.enumerate()}
    udp(port=rig.port).close()


def test_our_heartbeats_can_be_held_back_and_nothing_else(rig: Rig) -> None:
    autopilot = rig.keep()
    rig.gate.speaks = False
    rig.answer(OURS)
    rig.answer(b"a command")
    assert autopilot.recv(999) == b"a command"
    assert rig.gate.held_back == 1
    rig.gate.speaks = True
    rig.answer(OURS)
    assert autopilot.recv(999) == OURS


@pytest.mark.parametrize("older", [False, True])
def test_a_heartbeat_is_known_by_its_id_in_both_versions(older: bool) -> None:
    station = mavlink.MAVLink(None, 245, 190)
    beat, kill = station.heartbeat_encode(6, 8, 0, 0, 4), station.command_long_encode(1, 1, 185, 0, 1, 0, 0, 0, 0, 0, 0)
    assert is_heartbeat(beat.pack(station, force_mavlink1=older))
    assert not is_heartbeat(kill.pack(station, force_mavlink1=older))
    assert not is_heartbeat(b"")
