from __future__ import annotations

import http.client
import socket as sockets
import ssl
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from hawk.comm.base_socket import ConnectionTimeout, FailedToSend
from hawk.specification.message_socket import MessageSocket, NoMessagesError
from tests.unit.comm.peer import PATIENCE_S, Peer
from tests.unit.web.access.certificates import make_pair


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
    before = set(threading.enumerate())
    with pytest.raises(ConnectionTimeout, match="cannot be reached"):
        client.init()
    assert not client.is_connected()
    assert set(threading.enumerate()) <= before, "no thread is left behind"


def test_init_raises_when_the_other_side_is_silent() -> None:
    with sockets.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        client = MessageSocket("OPERATOR", "127.0.0.1", silent.getsockname()[1], timeout_s=0.1)
        with pytest.raises(ConnectionTimeout, match="did not answer within"):
            client.init()


def test_after_a_failed_init_send_sync_connects_again(peer: Peer) -> None:
    peer.stop()
    client = MessageSocket("OPERATOR", "127.0.0.1", peer.port, timeout_s=1.0)
    with pytest.raises(ConnectionTimeout):
        client.init()
    with pytest.raises(FailedToSend, match="cannot be reached"):
        client.send_message_sync("nobody is there")
    peer.start()
    client.send_message_sync("hello")
    try:
        assert peer.next() == "hello"
        assert client.is_connected()
        peer.send("answer")
        assert await_message(client) == "answer"
    finally:
        client.close()


@pytest.mark.fault("`send_message_async` after a failed `init`", "connects in the background and sends")
def test_after_a_failed_init_send_async_connects_in_the_background(peer: Peer) -> None:
    peer.stop()
    client = MessageSocket("OPERATOR", "127.0.0.1", peer.port, timeout_s=1.0)
    with pytest.raises(ConnectionTimeout):
        client.init()
    started = time.monotonic()
    client.send_message_async("nobody is there yet")
    assert time.monotonic() - started < 1.0, "it does not wait for the time-out"
    peer.start()
    try:
        assert peer.next() == "nobody is there yet"
        client.send_message_sync("and at once")
        assert peer.next() == "and at once"
        peer.send("answer")
        assert await_message(client) == "answer"
    finally:
        client.close()
    with pytest.raises(FailedToSend, match="init"):
        client.send_message_async("after close")


def test_a_server_whose_port_was_taken_listens_once_it_is_free(server: MessageSocket) -> None:
    second = MessageSocket("SERVER", "", server.port, timeout_s=0.2)
    with pytest.raises(ConnectionTimeout):
        second.init()
    second.send_message_async("nobody is there yet")
    server.close()
    operator = operator_of(second)
    try:
        for _ in range(50):
            try:
                operator.init()
                break
            except ConnectionTimeout:
                time.sleep(0.02)
        await_client(second)
        second.send_message_sync("to the one who came")
        assert await_message(operator) == "to the one who came"
    finally:
        operator.close()
        second.close()


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


@pytest.fixture
def server() -> Iterator[MessageSocket]:
    made = MessageSocket("SERVER", "", free_port(), timeout_s=0.2)
    made.init()
    yield made
    made.close()


def operator_of(server: MessageSocket, token: str | None = None) -> MessageSocket:
    return MessageSocket("OPERATOR", "127.0.0.1", server.port, timeout_s=2.0, token=token)


def await_client(server: MessageSocket) -> None:
    pause = threading.Event()
    for _ in range(500):
        if server.is_connected():
            return
        pause.wait(0.01)
    raise AssertionError("no client came")


def test_the_specifications_server_opens_nothing_before_init() -> None:
    server = MessageSocket("SERVER", "", 3000)  # as 19.4.4 writes it
    assert (server.type, server.host, server.port) == ("SERVER", "", 3000)
    assert not server.is_connected()


def test_server_and_operator_exchange_messages(server: MessageSocket) -> None:
    assert not server.is_connected()
    operator = operator_of(server)
    operator.init()
    try:
        operator.send_message_sync('{"Type": "Arm"}')
        assert await_message(server) == '{"Type": "Arm"}'
        assert server.is_connected()
        server.send_message_sync("one")
        server.send_message_async("two")
        assert [await_message(operator) for _ in range(2)] == ["one", "two"]
        with pytest.raises(NoMessagesError):
            server.get_message()
    finally:
        operator.close()


@pytest.mark.slow
@pytest.mark.fault("a server's message has no client", "FailedToSend after its time-out, not after twice that time")
def test_a_server_without_a_client_fails_after_its_time_not_twice_as_late() -> None:
    server = MessageSocket("SERVER", "", free_port(), timeout_s=0.6)
    server.init()
    try:
        for pause in (0.0, 0.2, 0.3):  # an attempt in the background is under way
            time.sleep(pause)
            started = time.monotonic()
            with pytest.raises(FailedToSend, match="no client connected"):
                server.send_message_sync("nobody")
            assert 0.5 < time.monotonic() - started < 1.15
    finally:
        server.close()


@pytest.mark.fault("the daemon serves HTTPS")
def test_server_and_operator_speak_https(tmp_path: Path) -> None:
    pair = make_pair(tmp_path)
    trusted = ssl.create_default_context(cafile=str(pair.certificate))
    certified = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    certified.load_cert_chain(pair.certificate, pair.key)
    server = MessageSocket("SERVER", "", free_port(), timeout_s=2.0, tls=certified)
    server.init()
    operator = MessageSocket("OPERATOR", "127.0.0.1", server.port, timeout_s=2.0, tls=trusted)
    try:
        operator.init()
        operator.send_message_sync("secret")
        assert await_message(server) == "secret"
        opened = operator._base._socket.get_extra_info("socket")  # type: ignore[union-attr]
        operator.close()
        assert opened.fileno() == -1, "TLS ends by a handshake of its own: nothing is left open"
    finally:
        operator.close()
        server.close()


def test_a_server_waits_for_a_client_before_it_says_that_it_failed(server: MessageSocket) -> None:
    with pytest.raises(FailedToSend, match="no client connected"):
        server.send_message_sync("nobody")
    operator = operator_of(server)
    operator.init()
    await_client(server)
    operator.close()
    again = operator_of(server)
    again.init()
    try:
        await_client(server)
        server.send_message_sync("to the one who is there")
        assert await_message(again) == "to the one who is there"
    finally:
        again.close()


def test_a_server_reaches_every_client_and_reads_all_of_them(server: MessageSocket) -> None:
    operators = [operator_of(server) for _ in range(2)]
    for operator in operators:
        operator.init()
    try:
        for number, operator in enumerate(operators):
            operator.send_message_sync(str(number))
        assert sorted(await_message(server) for _ in operators) == ["0", "1"]
        server.send_message_async("all")
        assert [await_message(operator) for operator in operators] == ["all", "all"]
    finally:
        for operator in operators:
            operator.close()


def test_a_server_can_be_initialised_again(server: MessageSocket) -> None:
    operator = operator_of(server)
    operator.init()
    operator.send_message_sync("old")
    assert await_message(server) == "old"
    server.init()
    try:
        await_client(server)
        server.send_message_sync("the operator has connected again")
        assert await_message(operator) == "the operator has connected again"
    finally:
        operator.close()


def test_a_port_that_is_taken_is_a_connection_timeout(server: MessageSocket) -> None:
    with pytest.raises(ConnectionTimeout, match="cannot be listened on"):
        MessageSocket("SERVER", "", server.port).init()


def test_a_server_with_a_token_takes_nobody_without_it() -> None:
    server = MessageSocket("SERVER", "127.0.0.1", free_port(), token="secret")
    server.init()
    try:
        with pytest.raises(ConnectionTimeout, match="token"):
            operator_of(server).init()
        operator = operator_of(server, "secret")
        operator.init()
        operator.close()
    finally:
        server.close()


def test_a_server_for_the_network_needs_a_token() -> None:
    with pytest.raises(ValueError, match="token"):
        MessageSocket("SERVER", "0.0.0.0", 3000)


def test_without_a_token_the_network_does_not_reach_the_server(server: MessageSocket) -> None:
    others = {info[4][0] for info in sockets.getaddrinfo(sockets.gethostname(), None, sockets.AF_INET)}
    for address in others - {"127.0.0.1"}:
        with sockets.socket() as probe:
            probe.settimeout(1.0)
            assert probe.connect_ex((address, server.port)) != 0


def test_a_page_of_another_server_is_refused(server: MessageSocket) -> None:
    upgrade = {"Connection": "Upgrade", "Upgrade": "websocket", "Origin": "http://evil.example"}
    upgrade |= {"Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ=="}
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=PATIENCE_S)
    connection.request("GET", "/ws", headers=upgrade)
    assert connection.getresponse().status == 403
    connection.close()
