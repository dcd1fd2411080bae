from __future__ import annotations

import socket as sockets
import threading
from collections.abc import Iterator

import pytest

from hawk.comm.message_socket import ConnectionTimeout, FailedToSend, MessageSocket, NoMessagesError
from tests.unit.comm.peer import PATIENCE_S, Peer


@pytest.fixture
def peer() -> Iterator[Peer]:
    made = Peer()
    made.start()
    yield made
    made.close()


@pytest.fixture
def client(peer: Peer) -> Iterator[MessageSocket]:
    made = MessageSocket("OPERATOR", "127.0.0.1", peer.port, timeout_s=2.0)
    made.init()
    peer.connected.get(timeout=PATIENCE_S)
    yield made
    made.close()


def await_message(client: MessageSocket) -> str:
    """Poll as the specification's user interface does."""
    pause = threading.Event()
    for _ in range(500):
        try:
            return client.get_message()
        except NoMessagesError:
            pause.wait(0.01)
    raise AssertionError("no message came")


def send_until_it_fails(client: MessageSocket) -> None:
    """The first may still go into the buffer of a connection that is dead already."""
    for _ in range(50):
        client.send_message_sync("into the void")


def free_port() -> int:
    with sockets.socket() as found:
        found.bind(("127.0.0.1", 0))
        port: int = found.getsockname()[1]
        return port


def test_messages_are_taken_in_order_and_whole(peer: Peer, client: MessageSocket) -> None:
    texts = ["first", "", '{"Type": "Heartbeat"}' * 2000, "ä€𝄞", "last"]
    peer.send(*texts)
    assert [await_message(client) for _ in texts] == texts
    with pytest.raises(NoMessagesError):
        client.get_message()


def test_sync_and_async_messages_arrive(peer: Peer, client: MessageSocket) -> None:
    client.send_message_sync("one")
    assert peer.next() == "one"
    for number in range(20):
        client.send_message_async(str(number))
    assert [peer.next() for _ in range(20)] == [str(number) for number in range(20)]


def test_init_raises_when_nobody_is_there() -> None:
    client = MessageSocket("OPERATOR", "127.0.0.1", free_port(), timeout_s=1.0)
    before = threading.active_count()
    with pytest.raises(ConnectionTimeout, match="cannot be reached"):
        client.init()
    assert not client.is_connected()
    assert threading.active_count() == before, "no thread is left behind"


def test_init_raises_when_the_other_side_is_silent() -> None:
    with sockets.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        client = MessageSocket("OPERATOR", "127.0.0.1", silent.getsockname()[1], timeout_s=0.1)
        with pytest.raises(ConnectionTimeout, match="did not answer within"):
            client.init()


def test_nothing_can_be_sent_before_init_or_after_close(peer: Peer) -> None:
    client = MessageSocket("OPERATOR", "127.0.0.1", peer.port)
    for send in (client.send_message_sync, client.send_message_async):
        with pytest.raises(FailedToSend, match="init"):
            send("x")
    client.init()
    client.close()
    client.close()
    assert not client.is_connected()
    with pytest.raises(FailedToSend):
        client.send_message_sync("x")


def test_init_again_starts_with_an_empty_queue(peer: Peer, client: MessageSocket) -> None:
    peer.send("old")
    assert await_message(client) == "old"
    client.init()
    peer.connected.get(timeout=PATIENCE_S)
    peer.send("new")
    assert await_message(client) == "new"


def test_a_lost_connection_comes_back_with_its_session(peer: Peer, client: MessageSocket) -> None:
    peer.drop()
    assert peer.connected.get(timeout=PATIENCE_S) == "s1", "the cookie of the first connection"
    peer.send("after")
    assert await_message(client) == "after"
    assert client.is_connected()


def test_send_sync_connects_again_or_says_that_it_failed(peer: Peer, client: MessageSocket) -> None:
    peer.stop()
    with pytest.raises(FailedToSend):
        send_until_it_fails(client)
    while not peer.received.empty():
        peer.received.get()
    peer.start()
    client.send_message_sync("back")
    assert peer.next() == "back"


def test_a_full_queue_holds_the_sender_up_and_loses_nothing(peer: Peer) -> None:
    client = MessageSocket("OPERATOR", "127.0.0.1", peer.port, queue_limit=3)
    client.init()
    peer.connected.get(timeout=PATIENCE_S)
    try:
        peer.send(*(str(number) for number in range(50)))
        assert [await_message(client) for _ in range(50)] == [str(number) for number in range(50)]
    finally:
        client.close()


def test_close_does_not_hang_on_a_full_queue(peer: Peer) -> None:
    client = MessageSocket("OPERATOR", "127.0.0.1", peer.port, queue_limit=1)
    client.init()
    peer.connected.get(timeout=PATIENCE_S)
    peer.send(*(str(number) for number in range(20)))
    assert await_message(client) == "0"
    closing = threading.Thread(target=client.close)
    closing.start()
    closing.join(PATIENCE_S)
    assert not closing.is_alive()


def test_another_role_is_refused() -> None:
    with pytest.raises(ValueError, match="SERVER"):
        MessageSocket("PILOT", "", 3000)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="transport"):
        MessageSocket("SERVER", "", 3000)
