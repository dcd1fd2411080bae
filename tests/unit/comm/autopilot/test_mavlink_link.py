"""The real MAVSDK with a peer of one UDP socket that speaks MAVLink."""

from __future__ import annotations

import contextlib
import json
import logging
import math
import os
import socket
import threading
import time
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.comm.autopilot.mavlink_link import FOREIGN_WRITE, Link, Message, command_fields
from hawk.comm.autopilot.remote_id import EPOCH, OperatorPlace, where, who
from hawk.comm.autopilot.vehicle import AutopilotError, FenceRings
from hawk.comm.mavlink.peer import Expected
from hawk.config.sections import RemoteIdSettings
from hawk.runtime.repeated_log import plain

HEARTBEAT_S = 0.2
WAIT_S = 10.0


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class Peer:
    """An autopilot that sends heartbeats, answers commands with ``results`` and notes what it gets."""

    def __init__(self, port: int) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.settimeout(0.02)
        self.address: tuple[str, int] = self._socket.getsockname()
        self.place = ("127.0.0.1", port)
        self.answers_its_caller = False
        self._changed = threading.Condition()
        self._stop = False
        self.results: dict[int, int] = {}
        self.got: list[Any] = []
        self.mav = mavlink.MAVLink(self, 1, 1)
        self._thread = threading.Thread(target=self._run, name="peer", daemon=True)
        self._thread.start()

    def write(self, data: bytes) -> None:
        self._socket.sendto(data, self.place)

    def wait(self, kind: str, true: Callable[[Any], bool] = lambda _: True) -> Any:
        """Wait for a message that fits and return it."""

        def found() -> Any:
            return next((one for one in self.got if one.get_type() == kind and true(one)), None)

        with self._changed:
            message = self._changed.wait_for(found, WAIT_S)
        assert message is not None, f"no {kind}: {[one.get_type() for one in self.got][-10:]}"
        return message

    def close(self) -> None:
        self._stop = True
        self._thread.join()
        self._socket.close()

    def _run(self) -> None:
        last = -math.inf
        while not self._stop:
            if time.monotonic() - last > HEARTBEAT_S:
                last = time.monotonic()
                self.mav.heartbeat_send(2, 3, 81, 4, 4)
            try:
                data, sender = self._socket.recvfrom(2048)
            except TimeoutError:
                continue
            if self.answers_its_caller:
                self.place = sender
            for message in self.mav.parse_buffer(data) or ():
                self._take(message)

    def _take(self, message: Any) -> None:
        if message.get_type() == "COMMAND_LONG":
            self.mav.command_ack_send(message.command, self.results.get(message.command, 0))
        with self._changed:
            self.got.append(message)
            self._changed.notify_all()


class Heard:
    """Messages that came over the link."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self.messages: list[Message] = []

    def take(self, message: Message) -> None:
        with self._changed:
            self.messages.append(message)
            self._changed.notify_all()

    def wait(self, name: str, count: int = 1) -> Message:
        def found() -> list[Message]:
            return [one for one in self.messages if one.name == name]

        with self._changed:
            assert self._changed.wait_for(lambda: len(found()) >= count, WAIT_S), f"no {name}"
            return found()[-1]


@pytest.fixture(scope="module")
def port() -> int:
    return free_port()


@pytest.fixture(scope="module")
def heard() -> Heard:
    return Heard()


@pytest.fixture(scope="module")
def peer(port: int) -> Iterator[Peer]:
    peer = Peer(port)
    yield peer
    peer.close()


@pytest.fixture(scope="module")
def link(port: int, heard: Heard, peer: Peer) -> Iterator[Link]:
    """A link on which the peer was found; shared, because MAVSDK needs half a second to find it."""
    link = Link(f"udpin://127.0.0.1:{port}", 245, lambda: 12.5, heard.take)
    link.open()
    deadline = time.monotonic() + WAIT_S
    while not link.find(0.5):
        assert time.monotonic() < deadline
    yield link
    link.close()


@pytest.mark.slow
def test_our_heartbeats_are_those_of_ground_station_245(link: Link, peer: Peer) -> None:
    message = peer.wait("HEARTBEAT")
    assert (message.get_srcSystem(), message.get_srcComponent()) == (245, 190)
    assert link.found


def test_the_greeting_of_our_own_gate_is_no_other_station(link: Link) -> None:
    beat = json.dumps({"type": 6, "autopilot": 8, "base_mode": 0})
    greeting: Any = SimpleNamespace(system_id=245, component_id=190, fields_json=beat)
    link._note(greeting, None)
    assert link.hearing().second_sender == ""


@pytest.mark.slow
@pytest.mark.fault(
    "downlink dead, and RTL messages are lost too",
    "our heartbeats end after 3 s; the ground-station failsafe brings the drone home 7 to 8 s after the cut "
    "(real ArduCopter: 7.05 s)",
)
def test_silent_it_sends_commands_and_no_heartbeat(link: Link, peer: Peer) -> None:
    peer.wait("HEARTBEAT")
    link.set_voice(False)
    peer.got.clear()
    gate = link._gate
    assert gate is not None
    deadline = time.monotonic() + WAIT_S
    while not gate.held_back:
        assert time.monotonic() < deadline
        time.sleep(0.02)
    link.send("COMMAND_LONG", command_fields(177, [1, 6]))
    peer.wait("COMMAND_LONG", lambda one: one.command == 177)
    assert not [one for one in peer.got if one.get_type() == "HEARTBEAT"]
    link.set_voice(True)
    peer.wait("HEARTBEAT")


def test_messages_come_with_their_fields_and_arrival(link: Link, peer: Peer, heard: Heard) -> None:
    peer.mav.local_position_ned_send(7000, 1.5, -2.0, -3.0, math.nan, 0.0, 0.0)
    message = heard.wait("LOCAL_POSITION_NED")
    assert message.arrival == 12.5
    fields = message.fields
    assert (fields["time_boot_ms"], fields["x"], fields["y"], fields["z"]) == (7000, 1.5, -2.0, -3.0)
    assert fields["vx"] is None  # NaN
    assert heard.wait("HEARTBEAT").fields["custom_mode"] == 4


def test_other_components_of_the_vehicle_are_not_the_autopilot(link: Link, peer: Peer, heard: Heard) -> None:
    gimbal = mavlink.MAVLink(peer, 1, 154)
    gimbal.attitude_send(1, 9.0, 9.0, 9.0, 0, 0, 0)
    peer.mav.attitude_send(2, 0.1, 0.2, 0.3, 0, 0, 0)
    assert heard.wait("ATTITUDE").fields["time_boot_ms"] == 2
    assert len([one for one in heard.messages if one.name == "ATTITUDE"]) == 1


def test_a_command_returns_the_autopilots_own_result(link: Link, peer: Peer) -> None:
    peer.results[176] = 4
    assert link.command(176, [1.0, 4.0]) == 4
    assert link.command(400, [1.0]) == 0
    sent = peer.wait("COMMAND_LONG", lambda one: one.command == 176)
    assert (sent.param1, sent.param2, sent.param7) == (1.0, 4.0, 0.0)
    assert (sent.target_system, sent.target_component) == (1, 1)


def test_a_target_is_on_the_wire_as_it_was_given(link: Link, peer: Peer) -> None:
    fields = {"time_boot_ms": 5, "coordinate_frame": 1, "type_mask": 2552, "x": 1.0, "y": 2.0, "z": -3.0, "yaw": 0.5}
    link.send("SET_POSITION_TARGET_LOCAL_NED", fields)
    sent = peer.wait("SET_POSITION_TARGET_LOCAL_NED")
    assert (sent.x, sent.y, sent.z, sent.yaw, sent.type_mask) == (1.0, 2.0, -3.0, 0.5, 2552)
    assert (sent.vx, sent.afx, sent.yaw_rate) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_what_is_not_finite_never_reaches_mavsdk(link: Link, peer: Peer, value: float) -> None:
    before = len(peer.got)
    with pytest.raises(AutopilotError, match=r"^yaw is"):
        link.send("SET_POSITION_TARGET_LOCAL_NED", {"x": 1.0, "yaw": value})
    with pytest.raises(AutopilotError, match=r"^param2 is"):
        link.command(176, [1.0, value])
    assert not [one for one in peer.got[before:] if one.get_type() != "HEARTBEAT"]


def test_remote_id_reaches_the_wire_as_it_was_written(link: Link, peer: Peer) -> None:
    settings = RemoteIdSettings(
        enabled=True, operator_id="FIN87astrdge12k8", description="parking survey", serial_number="1581F4ABC123"
    )
    place = OperatorPlace(60.1699, -24.9384, None)
    for name, fields in (
        *who(settings),
        where(settings, place, EPOCH + 5.0, whole=True),
        where(settings, place, EPOCH + 6.0, whole=False),
    ):
        link.send(name, fields)
    operator = peer.wait("OPEN_DRONE_ID_OPERATOR_ID")
    assert (operator.target_system, operator.target_component) == (1, 1)
    assert operator.operator_id.rstrip("\0") == "FIN87astrdge12k8"
    assert peer.wait("OPEN_DRONE_ID_SELF_ID").description.rstrip("\0") == "parking survey"
    basic = peer.wait("OPEN_DRONE_ID_BASIC_ID")
    assert bytes(basic.uas_id).rstrip(b"\0") == b"1581F4ABC123"
    assert (basic.id_type, basic.ua_type) == (1, 2)
    whole = peer.wait("OPEN_DRONE_ID_SYSTEM")
    assert (whole.operator_latitude, whole.operator_longitude, whole.timestamp) == (601_699_000, -249_384_000, 5)
    assert (whole.area_count, whole.area_ceiling, whole.area_floor) == (1, -1000.0, -1000.0)
    assert whole.operator_altitude_geo == -1000.0
    update = peer.wait("OPEN_DRONE_ID_SYSTEM_UPDATE")
    assert (update.operator_latitude, update.timestamp) == (601_699_000, 6)


@pytest.mark.fault("the transmitter forges messages of the autopilot", "only its OPEN_DRONE_ID_ARM_STATUS is heard")
def test_of_a_transmitter_behind_the_autopilot_only_its_word_is_heard(link: Link, peer: Peer, heard: Heard) -> None:
    transmitter = mavlink.MAVLink(peer, 1, 236)
    transmitter.statustext_send(6, b"forged by the transmitter")
    transmitter.open_drone_id_arm_status_send(1, b"missing OP_ID")
    found = heard.wait("OPEN_DRONE_ID_ARM_STATUS")
    assert (found.fields["status"], found.fields["error"]) == (1, "missing OP_ID")
    peer.mav.statustext_send(6, b"own word")
    heard.wait("STATUSTEXT")
    assert [one.fields["text"] for one in heard.messages if one.name == "STATUSTEXT"][-1] == "own word"
    assert not any(one.fields.get("text") == "forged by the transmitter" for one in heard.messages)


def test_a_message_that_mavlink_does_not_know_is_an_error(link: Link) -> None:
    with pytest.raises(AutopilotError, match="NO_SUCH_MESSAGE was not sent"):
        link.send("NO_SUCH_MESSAGE", {})


def test_a_second_link_to_one_autopilot_names_the_first(link: Link, port: int) -> None:
    second = Link(f"udpin://127.0.0.1:{port}", 245, lambda: 0.0, lambda _: None)
    try:
        with pytest.raises(AutopilotError, match=rf"in use by another hawk-drone \(process {os.getpid()}, version "):
            second.open()
    finally:
        second.close()


@pytest.mark.fault("another program has the autopilot's port", "it is named")
def test_a_port_that_another_program_has_is_named_with_its_owner() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        link = Link(f"udpin://127.0.0.1:{taken.getsockname()[1]}", 245, lambda: 0.0, lambda _: None)
        try:
            with pytest.raises(AutopilotError, match=r"Address already in use: by a program of the user \w+"):
                link.open()
        finally:
            link.close()


@pytest.mark.slow
def test_opened_again_the_link_goes_on_and_its_subscriptions_too(link: Link, peer: Peer, heard: Heard) -> None:
    link.reopen()
    before = len([one for one in heard.messages if one.name == "HEARTBEAT"])
    heard.wait("HEARTBEAT", before + 2)
    assert link.command(400, [0.0]) == 0


def test_before_an_autopilot_is_found_nothing_can_be_sent() -> None:
    link = Link(f"udpin://127.0.0.1:{free_port()}", 245, lambda: 0.0, lambda _: None)
    calls: list[Callable[[], Any]] = [
        lambda: link.send("HEARTBEAT", {}),
        lambda: link.command(400),
        lambda: link.upload_fence(FenceRings(((1.0, 2.0),))),
        link.download_fence,
    ]
    for call in calls:
        with pytest.raises(AutopilotError, match="No autopilot found yet"):
            call()
    assert not link.find(0.1)
    assert not link.sensor_health().all_ok
    link.close()


@pytest.mark.parametrize("url", ["nonsense", "serial:///dev/null:57600"])
def test_an_address_that_cannot_be_opened_is_named_with_its_setting(url: str) -> None:
    link = Link(url, 245, lambda: 0.0, lambda _: None)
    for _ in range(2):
        with pytest.raises(AutopilotError, match=rf"autopilot.url '{url}' cannot be opened"):
            link.open()
    link.close()


def test_closed_twice_it_stays_closed(port: int) -> None:
    link = Link(f"udpin://127.0.0.1:{free_port()}", 245, lambda: 0.0, lambda _: None)
    link.open()
    link.close()
    link.close()
    link.open()
    assert not link.find(0.1)


@pytest.mark.slow
def test_a_second_sender_is_neither_heard_nor_spoken_to(link: Link, peer: Peer, heard: Heard) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as forger:
        forger.bind(("127.0.0.1", 0))
        forger.setblocking(False)
        for system in (1, 9):  # the autopilot's own id, and another one
            mav = mavlink.MAVLink(None, system, 1)
            landed = mavlink.MAVLink_extended_sys_state_message(0, 1).pack(mav)
            forged = bytes(mavlink.MAVLink_heartbeat_message(2, 3, 0, 777, 4, 3).pack(mav)) + bytes(landed)
            for _ in range(10):
                forger.sendto(forged, peer.place)
        before = len([one for one in heard.messages if one.name == "HEARTBEAT"])
        heard.wait("HEARTBEAT", before + 2)  # MAVSDK had time for the forged ones
        with pytest.raises(BlockingIOError):
            forger.recv(2048)
        assert "EXTENDED_SYS_STATE" not in {one.name for one in heard.messages}
        assert 777 not in {one.fields["custom_mode"] for one in heard.messages if one.name == "HEARTBEAT"}
        address = f"127.0.0.1:{forger.getsockname()[1]}"
        assert (
            link.hearing().second_sender == f"{address} (system 1) sends to the autopilot's port, too. It is not heard."
        )
    assert link.hearing().refused >= 2


@pytest.mark.fault(
    "another vehicle, gimbal or camera behind the autopilot's own router",
    "its messages are dropped; no fault",
)
def test_another_vehicle_behind_the_same_router_is_not_heard_and_no_fault(peer: Peer, heard: Heard, link: Link) -> None:
    before = len([one for one in heard.messages if one.name == "ATTITUDE"])
    other = mavlink.MAVLink(peer, 7, 1)
    other.heartbeat_send(2, 3, 0, 999, 4, 3)
    other.attitude_send(70, 9.0, 9.0, 9.0, 0, 0, 0)
    peer.mav.attitude_send(71, 0.1, 0.2, 0.3, 0, 0, 0)
    heard.wait("ATTITUDE", 1 + before)
    assert not [one for one in heard.messages if one.fields.get("time_boot_ms") == 70]
    assert 999 not in {one.fields.get("custom_mode") for one in heard.messages}


def test_another_station_that_writes_to_the_autopilot_on_our_link_is_heard_by_its_name(
    peer: Peer, heard: Heard, link: Link
) -> None:
    station = mavlink.MAVLink(peer, 254, 190)
    station.statustext_send(6, b"not of the vehicle")
    station.param_set_send(7, 1, b"FENCE_ENABLE", 0.0, 9)  # to another vehicle
    station.param_set_send(1, 1, b"BATT_FS_LOW_ACT", 5.0, 9)
    found = heard.wait(FOREIGN_WRITE)
    assert (found.fields["subjects"], found.sender) == (("BATT_FS_LOW_ACT",), (254, 190))
    peer.mav.statustext_send(6, b"own word")
    assert heard.wait("STATUSTEXT").sender is None
    assert [one.name for one in heard.messages if one.sender] == [FOREIGN_WRITE]


@pytest.fixture
def made() -> Iterator[list[Any]]:
    """Links and peers that the test made; closed after it."""
    made: list[Any] = []
    yield made
    for one in reversed(made):
        one.close()


@pytest.mark.slow
def test_the_expected_system_id_is_found_though_another_vehicle_speaks_first(made: list[Any]) -> None:
    port, heard = free_port(), Heard()
    link = Link(f"udpin://127.0.0.1:{port}", 245, lambda: 1.0, heard.take, Expected(system_id=7))
    link.open()
    peer = Peer(port)
    made += [link, peer]
    other = mavlink.MAVLink(peer, 7, 1)
    assert not link.find(0.5)
    assert not link.find(0.1)
    assert "(system 1) sends to the autopilot's port, but is not the expected autopilot" in link.hearing().second_sender
    deadline = time.monotonic() + WAIT_S
    while not link.find(0.1):
        other.heartbeat_send(2, 3, 0, 3, 4, 3)
        assert time.monotonic() < deadline
    other.heartbeat_send(2, 3, 0, 3, 4, 3)
    heard.wait("HEARTBEAT")
    assert {one.fields["custom_mode"] for one in heard.messages if one.name == "HEARTBEAT"} == {3}
    link.send("COMMAND_LONG", {"command": 400, "confirmation": 0})
    assert peer.wait("COMMAND_LONG").target_system == 7


@pytest.mark.slow
def test_a_link_that_calls_out_hears_only_whom_it_called(made: list[Any]) -> None:
    called = Peer(free_port())
    heard = Heard()
    link = Link(f"udpout://127.0.0.1:{called.address[1]}", 245, lambda: 1.0, heard.take)
    link.open()
    made += [link, called]
    called.answers_its_caller = True
    deadline = time.monotonic() + WAIT_S
    while not link.find(0.5):
        assert time.monotonic() < deadline
    assert called.wait("HEARTBEAT").get_srcSystem() == 245
    assert link.hearing().sender == f"127.0.0.1:{called.address[1]}"


class Line:
    """A serial line or router: a TCP server to which MAVSDK connects. ``present`` give signs of life."""

    def __init__(self) -> None:
        self._server = socket.create_server(("127.0.0.1", 0))
        self._server.settimeout(WAIT_S)
        self.url = f"tcpout://127.0.0.1:{self._server.getsockname()[1]}"
        self.present: list[tuple[int, int, int, int]] = []  # system, component, MAV_TYPE, MAV_AUTOPILOT
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="line", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        with contextlib.suppress(OSError):
            served, _ = self._server.accept()
            with served:
                while not self._stop.wait(HEARTBEAT_S):
                    for system, component, kind, autopilot in self.present:
                        message = mavlink.MAVLink_heartbeat_message(kind, autopilot, 0, 4, 4, 3)
                        served.sendall(message.pack(mavlink.MAVLink(None, system, component)))

    def close(self) -> None:
        self._stop.set()
        self._server.close()
        self._thread.join()


TRACKER, QUADROTOR, GIMBAL, HEXAROTOR, TWIN = (
    (2, 1, 5, 3),
    (1, 1, 2, 3),
    (1, 154, 26, 8),
    (3, 1, 13, 3),
    (245, 190, 6, 8),
)


def wait_for(true: Callable[[], object]) -> None:
    deadline = time.monotonic() + WAIT_S
    while not true():
        assert time.monotonic() < deadline
        time.sleep(0.05)


@pytest.mark.slow
@pytest.mark.fault(
    "an antenna tracker, rover, plane or another autopilot is heard first, on a UDP port or on one line with the copter"
)
def test_on_a_line_with_a_tracker_the_copter_is_waited_for_and_everybody_named(made: list[Any]) -> None:
    line, heard = Line(), Heard()
    link = Link(line.url, 245, lambda: 1.0, heard.take)
    made += [line, link]
    line.present = [TRACKER, TWIN]
    link.open()
    wait_for(lambda: link.find(0.2) or "system 2" in link.hearing().heard)
    for _ in range(3):
        assert not link.find(0.1), "a tracker is not flown"
    assert "antenna tracker (ArduPilot), system 2" in link.hearing().heard
    wait_for(lambda: [link.find(0.1), link.hearing().second_sender][1])
    assert link.hearing().second_sender == (
        "ground station, system 245, component 190, has our own MAVLink id: is it another hawk-drone on this autopilot?"
    )
    line.present = [TRACKER, GIMBAL, QUADROTOR]
    wait_for(lambda: link.find(0.2))
    heard.wait("HEARTBEAT")
    line.present.append(HEXAROTOR)
    deadline = time.monotonic() + WAIT_S
    while not link.hearing().other_vehicles:
        link.look_around()
        assert time.monotonic() < deadline
        time.sleep(0.05)
    assert link.hearing().other_vehicles == "hexarotor (ArduPilot), system 3"
    assert link.hearing().is_mavlink_1 is None, "a line shows no frames"
    link.look_around()
    assert {one.fields["type"] for one in heard.messages if one.name == "HEARTBEAT"} == {2}


@pytest.mark.slow
@pytest.mark.fault("a second copter on the link")
def test_of_two_copters_on_a_line_none_is_taken_before_one_is_named(made: list[Any]) -> None:
    line, heard = Line(), Heard()
    link = Link(line.url, 245, lambda: 1.0, heard.take, Expected(wait_s=1.5))
    made += [line, link]
    line.present = [HEXAROTOR, QUADROTOR]
    link.open()
    end = time.monotonic() + 3.0
    while time.monotonic() < end:
        assert not link.find(0.2)
        time.sleep(0.05)
    assert link.hearing().second_sender == (
        "Several copters are heard: hexarotor (ArduPilot), system 3; quadrotor (ArduPilot), system 1. "
        "Name yours in autopilot.vehicle_system_id, autopilot.vehicle_address."
    )


@pytest.mark.slow
@pytest.mark.fault("a second copter on the link")
def test_on_a_line_the_named_vehicle_is_found_among_others(made: list[Any]) -> None:
    line, heard = Line(), Heard()
    link = Link(line.url, 245, lambda: 1.0, heard.take, Expected(system_id=3))
    made += [line, link]
    line.present = [QUADROTOR, TRACKER]
    link.open()
    for _ in range(8):
        assert not link.find(0.2)
    line.present.append(HEXAROTOR)
    wait_for(lambda: link.find(0.2))
    heard.wait("HEARTBEAT")
    assert {one.fields["type"] for one in heard.messages if one.name == "HEARTBEAT"} == {13}


def test_a_link_of_mavlink_1_is_known_by_its_frames(peer: Peer, link: Link) -> None:
    wait_for(lambda: link.hearing().is_mavlink_1 is False)
    assert link.sensor_health().is_mavlink_1 is False
    frame = mavlink.MAVLink_attitude_message(72, 0, 0, 0, 0, 0, 0).pack(
        mavlink.MAVLink(None, 1, 1), force_mavlink1=True
    )
    for _ in range(50):
        peer.write(frame)
        if link.hearing().is_mavlink_1:
            break
        time.sleep(0.01)
    else:
        pytest.fail("not noticed")


TEXTS = (
    b"h\xff\xfe\xc3\x1b[31mello",
    b"\x1b]0;title\x07",
    "\u202eturned\u2028".encode(),
    b"\xed\xa0\xbd",
    bytes(range(1, 50)),
)


@pytest.mark.fault(
    "a STATUSTEXT that is no UTF-8, with escape sequences or a turned writing direction",
    "shown with visible escapes, in page, log and check; MAVSDK prints nothing itself; a chunk is counted in bytes",
)
def test_texts_of_the_autopilot_print_nothing_raw(
    made: list[Any], capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.DEBUG, "hawk.comm.mavsdk")
    port, heard = free_port(), Heard()
    link = Link(f"udpin://127.0.0.1:{port}", 245, lambda: 1.0, heard.take)
    link.open()
    peer = Peer(port)
    made += [link, peer]
    wait_for(lambda: link.find(0.2))
    for text in TEXTS:
        peer.mav.statustext_send(4, text)
    heard.wait("STATUSTEXT", len(TEXTS))
    printed = "".join(capfd.readouterr())
    assert printed == "", "MAVSDK itself prints nothing"
    wait_for(lambda: r"\xff" in caplog.text)
    lines = [record.getMessage() for record in caplog.records]
    assert all(plain(line) == line for line in lines)
    json.dumps([dict(one.fields) for one in heard.messages])
