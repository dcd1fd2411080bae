from __future__ import annotations

import asyncio
from collections.abc import Iterator

import pytest

from hawk.comm.base_socket import BaseSocket, ConnectionTimeout, FailedToSend, SocketClosedError
from hawk.comm.message_socket import STALE_S, AsyncMessageSocket
from tests.manual_clock import ManualClock
from tests.unit.comm.peer import Peer


@pytest.fixture
def peer() -> Iterator[Peer]:
    made = Peer()
    made.start()
    yield made
    made.close()


class ScriptedSocket(BaseSocket):
    """A connection in the hands of the test."""

    def __init__(self) -> None:
        super().__init__("drone", 1)
        self.up = True
        self.there = True
        self.sent: list[str] = []
        self.gone = asyncio.Event()
        self.connects = 0
        self.sending = asyncio.Event()
        self.incoming: asyncio.Queue[str] = asyncio.Queue()

    @property
    def is_connected(self) -> bool:
        return self.up

    async def connect(self, timeout_s: float) -> None:
        if not self.there:
            raise ConnectionTimeout("nobody there")
        self.up = True
        self.gone.clear()
        self.connects += 1

    async def send(self, text: str) -> None:
        if not self.up:
            raise FailedToSend("down")
        self.sent.append(text)
        self.sending.set()

    async def receive(self) -> str:
        if not self.incoming.empty():
            return self.incoming.get_nowait()
        await self.gone.wait()
        raise SocketClosedError("gone")

    async def close(self) -> None:
        self.up = False

    def lose(self) -> None:
        self.up = self.there = False
        self.gone.set()


async def test_a_command_that_waited_too_long_is_dropped_and_logged(caplog: pytest.LogCaptureFixture) -> None:
    clock, base = ManualClock(), ScriptedSocket()
    socket = AsyncMessageSocket(base, monotonic=clock)
    await socket.init()
    base.lose()
    await asyncio.sleep(0)
    socket.post_message("Takeoff")
    await asyncio.sleep(0)
    clock.advance(STALE_S + 0.1)
    socket.post_message("Hold")
    base.there = True
    async with asyncio.timeout(5):
        await base.sending.wait()
    assert base.sent == ["Hold"]
    assert [record.message for record in caplog.records] == [
        "A message that waited longer than 2 s for the link was dropped"
    ]
    await socket.close()


async def test_too_many_waiting_messages_are_refused_aloud() -> None:
    base = ScriptedSocket()
    socket = AsyncMessageSocket(base, queue_limit=2)
    await socket.init()
    base.lose()
    await asyncio.sleep(0)
    socket.post_message("taken by the writer, which waits for a connection")
    await asyncio.sleep(0)
    socket.post_message("1")
    socket.post_message("2")
    with pytest.raises(FailedToSend, match="2 messages wait"):
        socket.post_message("3")
    await socket.close()


async def test_send_says_why_when_the_drone_is_away() -> None:
    base = ScriptedSocket()
    socket = AsyncMessageSocket(base)
    await socket.init()
    base.lose()
    with pytest.raises(FailedToSend, match="nobody there"):
        await socket.send_message("x")
    base.there = True
    await socket.send_message("y")
    assert base.sent == ["y"]
    await socket.close()


async def test_after_a_failed_init_a_send_connects_and_answers_are_read() -> None:
    base = ScriptedSocket()
    base.lose()
    socket = AsyncMessageSocket(base)
    with pytest.raises(ConnectionTimeout):
        await socket.init()
    base.there = True
    await socket.send_message("x")
    assert base.sent == ["x"]
    base.incoming.put_nowait("answer")
    async with asyncio.timeout(5):
        assert await socket.get_message() == "answer"
    await socket.close()


async def test_close_leaves_no_task_behind() -> None:
    socket = AsyncMessageSocket(ScriptedSocket())
    await socket.init()
    await socket.close()
    assert [task for task in asyncio.all_tasks() if "message-socket" in task.get_name()] == []


async def test_a_refused_handshake_names_the_reason(peer: Peer) -> None:
    base = BaseSocket("127.0.0.1", peer.port, path="/refuse")
    try:
        with pytest.raises(ConnectionTimeout, match="not allowed"):
            await base.connect(2.0)
    finally:
        await base.close()


async def test_an_ipv6_address_is_written_as_the_field_does() -> None:
    assert BaseSocket("::1", 3000).url == "http://[::1]:3000"


async def test_receive_without_a_connection_is_an_error() -> None:
    base = BaseSocket("127.0.0.1", 1)
    with pytest.raises(SocketClosedError):
        await base.receive()
    with pytest.raises(FailedToSend):
        await base.send("x")
