from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.comm.message_socket import CLIENT_WAITING, TICK_COMMANDS, ServerMessageSocket
from hawk.comm.protocol.commands import Ack, Arm, Command, Hold, KillRequest, KillToken, Outgoing, Takeoff
from hawk.comm.protocol.heartbeat import ClientId
from tests.examples import examples


class Clients:
    """Sent messages with their clients."""

    def __init__(self) -> None:
        self.sent: list[tuple[ClientId, str]] = []

    def send_to(self, client: ClientId, text: str) -> None:
        self.sent.append((client, text))

    def last(self) -> tuple[ClientId, dict[str, Any]]:
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
    made = ServerMessageSocket(clients.send_to)
    made.attach(manager.handle_now)
    return made


def test_commands_wait_in_order_with_their_clients(server: ServerMessageSocket) -> None:
    server.feed("a", '{"Type": "Arm", "Id": 1}')
    server.feed("b", '{"Type": "Takeoff"}')
    assert server.receive() == [("a", Arm(id=1)), ("b", Takeoff())]
    assert server.receive() == []


URGENT = [
    '{"Type": "Hold"}',
    '{"Type": "Kill Request"}',
    f'{{"Type": "Kill", "Token": "{"t" * 16}"}}',
    '{"Type": "Return To Launch"}',
    '{"Type": "Land"}',
]


@pytest.mark.fault(
    "Hold, Return To Launch, Land or Kill behind a full queue",
    "acted on at once; what waits is refused, not done afterwards",
)
@pytest.mark.parametrize("text", URGENT)
def test_what_stops_or_saves_passes_the_queue(
    server: ServerMessageSocket, manager: Manager, clients: Clients, text: str
) -> None:
    for _ in range(300):
        server.feed("a", '{"Type": "Arm"}')  # full
    server.feed("b", text)
    assert len(manager.acted) == 1
    assert clients.last()[0] == "b"
    assert not any(isinstance(command, type(manager.acted[0])) for _, command in server.receive())


def test_hold_before_anyone_can_act_is_answered(clients: Clients) -> None:
    ServerMessageSocket(clients.send_to).feed("a", '{"Type": "Hold", "Id": "h"}')
    client, answer = clients.last()
    assert (client, answer["Id"], answer["Accepted"]) == ("a", "h", False)


def test_overflow_is_answered_and_what_waits_is_kept(clients: Clients) -> None:
    server = ServerMessageSocket(clients.send_to)
    for number in range(CLIENT_WAITING + 1):
        server.feed("a", f'{{"Type": "Arm", "Id": {number}}}')
    client, answer = clients.last()
    assert (client, answer["Id"], answer["Accepted"]) == ("a", CLIENT_WAITING, False)
    assert answer["Reason"] == f"Too many commands: send at most {CLIENT_WAITING} at once."
    assert len(clients.sent) == 1
    assert taken(server) == list(range(CLIENT_WAITING))


def taken(server: ServerMessageSocket) -> list[object]:
    """Take tick after tick until nothing waits; return the ids in their order."""
    found: list[object] = []
    while commands := server.receive():
        found += [command.id for _, command in commands]
    return found


@pytest.mark.fault(
    "a viewer sends valid commands without end",
    "a tick takes 4 commands, one of each client in turn; the 17th that waits is refused; the connection is "
    "ended after 2 s; another client's command is taken in the next tick",
)
def test_a_tick_takes_few_commands_and_of_each_client_the_next(server: ServerMessageSocket) -> None:
    for client in "abcdefghi":
        for number in range(CLIENT_WAITING):
            server.feed(client, f'{{"Type": "Arm", "Id": "{client}{number}"}}')
    server.feed("operator", '{"Type": "Takeoff", "Id": "o"}')
    seen: list[str] = []
    for _ in range(3):
        commands = server.receive()
        assert len(commands) == TICK_COMMANDS
        seen += [str(command.id) for _, command in commands]
    assert {each[0] for each in seen[:10]} == set("abcdefghio"), "each client once before any twice"
    assert len(taken(server)) == 9 * CLIENT_WAITING + 1 - 12, "nothing is lost"


def test_who_sends_seldom_is_taken_in_the_next_tick_whatever_the_others_send(server: ServerMessageSocket) -> None:
    for tick in range(250):
        for client in "abcdefgh":
            server.feed(client, '{"Type": "Arm"}')
        asks = tick % 10 == 9
        if asks:
            server.feed("operator", '{"Type": "Takeoff"}')
        commands = server.receive()
        assert len(commands) == TICK_COMMANDS
        assert ("operator" in {client for client, _ in commands}) == asks
    assert len(server._served) <= 9


def test_one_client_alone_takes_its_share_of_a_tick_only(server: ServerMessageSocket) -> None:
    for number in range(10):
        server.feed("a", f'{{"Type": "Arm", "Id": {number}}}')
    assert [command.id for _, command in server.receive()] == [0]
    assert taken(server) == list(range(1, 10))


@pytest.mark.fault("Hold, Return To Launch, Land or Kill behind a full queue")
@pytest.mark.parametrize("text", [each for each in URGENT if "Request" not in each])
def test_what_stops_or_saves_voids_what_waits_but_questions(
    server: ServerMessageSocket, clients: Clients, text: str
) -> None:
    server.feed("a", '{"Type": "Autonomous Explore", "Id": "late"}')
    server.feed("a", '{"Type": "Route Request", "X": 1, "Y": 1, "Id": "asks"}')
    server.feed("b", '{"Type": "Takeoff", "Id": "also late"}')
    server.feed("c", text)
    refused = {answer["Id"]: answer for answer in (json.loads(sent) for _, sent in clients.sent) if answer["Id"]}
    assert set(refused) == {"late", "also late"}
    assert all(not answer["Accepted"] and "came first" in answer["Reason"] for answer in refused.values())
    assert [command.id for _, command in server.receive()] == ["asks"]


def test_a_stop_that_is_refused_voids_nothing(clients: Clients) -> None:
    server = ServerMessageSocket(clients.send_to)
    server.attach(lambda _, command: Ack(id=command.id, accepted=False, reason="Someone else has control."))
    server.feed("a", '{"Type": "Takeoff", "Id": 1}')
    server.feed("b", '{"Type": "Land"}')
    assert taken(server) == [1]


def test_the_gate_answers_in_place_of_the_manager(clients: Clients, manager: Manager) -> None:
    server = ServerMessageSocket(clients.send_to, lambda _, command: Ack(id=command.id, accepted=False, reason="no"))
    server.attach(manager.handle_now)
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

    server = ServerMessageSocket(clients.send_to, gate)
    server.attach(manager.handle_now)
    server.feed("a", '{"Type": "Hold"}')
    assert asked == manager.acted == [Hold()]


@pytest.mark.slow
@settings(max_examples=examples(40))
@given(
    text=st.text(max_size=200)
    | st.recursive(st.none() | st.booleans() | st.floats() | st.text(), st.lists).map(json.dumps)
)
def test_any_text_is_answered_and_nothing_gets_through(text: str) -> None:
    clients = Clients()
    server = ServerMessageSocket(clients.send_to)
    server.feed("a", text)
    client, answer = clients.last()
    assert (client, answer["Type"], answer["Accepted"]) == ("a", "Ack", False)
    assert answer["Reason"]
    assert server.receive() == []
