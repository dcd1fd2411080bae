from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.comm.message_socket import NoMessagesError, ServerMessageSocket
from hawk.comm.messages import Ack, Arm, Command, Hold, KillRequest, KillToken, Outgoing, Takeoff
from hawk.comm.status import ClientId


class Clients:
    """The transport: what was sent to whom."""

    def __init__(self) -> None:
        self.sent: list[tuple[ClientId | None, str]] = []
        self.is_connected = True

    def open(self, on_message: Callable[[str], None]) -> None:
        pass

    def send(self, text: str) -> None:
        self.sent.append((None, text))

    def post(self, text: str) -> None:
        self.sent.append((None, text))

    def send_to(self, client: ClientId, text: str) -> None:
        self.sent.append((client, text))

    def close(self) -> None:
        self.is_connected = False

    def last(self) -> tuple[ClientId | None, dict[str, Any]]:
        client, text = self.sent[-1]
        return client, json.loads(text)


class Manager:
    def __init__(self) -> None:
        self.acted: list[Command] = []

    def handle_now(self, client: ClientId, command: Command) -> Outgoing:
        self.acted.append(command)
        if isinstance(command, KillRequest):
            return KillToken(id=command.id, token="t" * 16, valid_for=10.0)
        return Ack(id=command.id, accepted=True)


@pytest.fixture
def clients() -> Clients:
    return Clients()


@pytest.fixture
def manager() -> Manager:
    return Manager()


@pytest.fixture
def server(clients: Clients, manager: Manager) -> ServerMessageSocket:
    made = ServerMessageSocket(clients)
    made.init()
    made.attach(manager)
    return made


def test_commands_wait_in_order_with_their_clients(server: ServerMessageSocket) -> None:
    server.feed("a", '{"Type": "Arm", "Id": 1}')
    server.feed("b", '{"Type": "Takeoff"}')
    assert server.receive() == [("a", Arm(id=1)), ("b", Takeoff())]
    assert server.receive() == []


def test_get_message_is_the_specifications_view_of_the_same_queue(server: ServerMessageSocket) -> None:
    server.feed("a", '{"Type": "Arm"}')
    server.feed("a", '{"Type": "Takeoff"}')
    assert json.loads(server.get_message())["Type"] == "Arm"
    assert server.receive() == [("a", Takeoff())]
    with pytest.raises(NoMessagesError):
        server.get_message()


@pytest.mark.parametrize(
    "text", ['{"Type": "Hold"}', '{"Type": "Kill Request"}', f'{{"Type": "Kill", "Token": "{"t" * 16}"}}']
)
def test_hold_and_kill_pass_the_queue(
    server: ServerMessageSocket, manager: Manager, clients: Clients, text: str
) -> None:
    for _ in range(300):
        server.feed("a", '{"Type": "Arm"}')  # full
    server.feed("b", text)
    assert len(manager.acted) == 1
    assert clients.last()[0] == "b"
    assert not any(isinstance(command, type(manager.acted[0])) for _, command in server.receive())


def test_hold_before_anyone_can_act_is_answered(clients: Clients) -> None:
    ServerMessageSocket(clients).feed("a", '{"Type": "Hold", "Id": "h"}')
    client, answer = clients.last()
    assert (client, answer["Id"], answer["Accepted"]) == ("a", "h", False)


def test_overflow_is_answered_and_what_waits_is_kept(clients: Clients) -> None:
    server = ServerMessageSocket(clients, queue_limit=2)
    for number in range(3):
        server.feed("a", f'{{"Type": "Arm", "Id": {number}}}')
    client, answer = clients.last()
    assert (client, answer["Id"], answer["Accepted"]) == ("a", 2, False)
    assert [command.id for _, command in server.receive()] == [0, 1]


def test_the_gate_answers_in_place_of_the_manager(clients: Clients, manager: Manager) -> None:
    server = ServerMessageSocket(clients, lambda _, command: Ack(id=command.id, accepted=False, reason="no"))
    server.attach(manager)
    server.feed("a", '{"Type": "Arm"}')
    server.feed("a", '{"Type": "Hold"}')
    assert manager.acted == []
    assert server.receive() == []
    assert [json.loads(text)["Reason"] for _, text in clients.sent] == ["no", "no"]


def test_the_gate_is_asked_before_hold_too(clients: Clients, manager: Manager) -> None:
    asked: list[Command] = []

    def gate(_: ClientId, command: Command) -> Outgoing | None:
        asked.append(command)
        return None

    server = ServerMessageSocket(clients, gate)
    server.attach(manager)
    server.feed("a", '{"Type": "Hold"}')
    assert asked == manager.acted == [Hold()]


def test_spec_programs_reach_every_client(server: ServerMessageSocket, clients: Clients) -> None:
    server.send_message_sync("x")
    server.send_message_async("y")
    assert clients.sent == [(None, "x"), (None, "y")]
    assert server.is_connected()
    server.close()
    assert not server.is_connected()


@settings(max_examples=40)
@given(
    text=st.text(max_size=200)
    | st.recursive(st.none() | st.booleans() | st.floats() | st.text(), st.lists).map(json.dumps)
)
def test_any_text_is_answered_and_nothing_gets_through(text: str) -> None:
    clients = Clients()
    server = ServerMessageSocket(clients)
    server.feed("a", text)
    client, answer = clients.last()
    assert (client, answer["Type"], answer["Accepted"]) == ("a", "Ack", False)
    assert answer["Reason"]
    assert server.receive() == []
