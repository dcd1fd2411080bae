"""Real connections at the server's door: who may wait, how long, and who gets in when it is full."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import resource
import socket
from collections.abc import AsyncIterator
from pathlib import Path

import aiohttp
import pytest

from hawk.config.sections import WebSettings
from hawk.web.access.paced_log import LINES
from hawk.web.app import Page, WebServer
from hawk.web.door import FIRST_REQUEST_S, IDLE_S, LEAST_WAITING, MOST_WAITING, RESERVED_DESCRIPTORS, Places
from hawk.web.services import KEPT_PLACES
from tests.unit.comm.waiting import until
from tests.unit.web.rig import PATIENCE_S, Rig, Visitor, browser

HALF = b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX-Slow: "
FEW = Places(waiting=12, waiting_of_one=6, answered=8)


@pytest.fixture
async def server(rig: Rig, tmp_path: Path) -> AsyncIterator[WebServer]:
    """A real server; its clock for waits is ``rig.real``."""
    (tmp_path / "index.html").write_text("<p>page</p>")
    (tmp_path / "large.bin").write_bytes(bytes(32 * 1024 * 1024))
    rig.web = WebSettings(port=0, maximum_clients=3)
    rig.page = Page.load(tmp_path)
    made = WebServer(rig.services(), rig.page)
    await made.start()
    made.door.places = FEW
    yield made
    await made.close()


class Stranger:
    """A connection that does what no browser does."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.reader = reader
        self.writer = writer

    async def is_closed(self) -> bool:
        """Wait for the end of the connection."""
        with contextlib.suppress(ConnectionError):
            async with asyncio.timeout(PATIENCE_S):
                while await self.reader.read(65536):
                    pass
        return True

    async def end(self) -> None:
        self.writer.close()
        with contextlib.suppress(ConnectionError):
            await self.writer.wait_closed()


@pytest.fixture
async def strangers() -> AsyncIterator[list[Stranger]]:
    made: list[Stranger] = []
    yield made
    for each in made:
        await each.end()


async def come(
    server: WebServer, strangers: list[Stranger], text: bytes = HALF, source: str = "127.0.0.1", limit: int = 65536
) -> Stranger:
    """Open a connection that sends this much and then nothing."""
    opened = await asyncio.open_connection("127.0.0.1", server.port, local_addr=(source, 0), limit=limit)
    stranger = Stranger(*opened)
    strangers.append(stranger)
    stranger.writer.write(text)
    await stranger.writer.drain()
    return stranger


async def page_status(server: WebServer, session: aiohttp.ClientSession, path: str = "") -> int:
    async with session.get(f"{server.url}{path}") as response:
        await response.read()
        return response.status


async def join(server: WebServer, session: aiohttp.ClientSession) -> Visitor:
    page = Visitor(await session.ws_connect(f"{server.url}ws"))
    await page.next("Welcome")
    return page


# -- waiting ----------------------------------------------------------------------------------------------------------


@pytest.mark.nightly
async def test_a_crowd_of_half_sent_requests_is_bounded_and_a_page_gets_in(
    server: WebServer, strangers: list[Stranger]
) -> None:
    async with browser() as session:
        operator = await join(server, session)
        for number in range(60):
            await come(server, strangers)
            assert (await operator.ask(Type="Heartbeat", Id=number))["Accepted"]
        await until(lambda: server.door.closed >= 60 - FEW.waiting_of_one)
        assert server.door.waiting <= FEW.waiting_of_one
        async with browser() as other:
            assert await page_status(server, other) == 200
        assert await strangers[0].is_closed(), "the oldest went"


@pytest.mark.slow
async def test_one_address_does_not_take_the_places_of_another(server: WebServer, strangers: list[Stranger]) -> None:
    kept = await come(server, strangers, source="127.0.0.2")
    for _ in range(3 * FEW.waiting):
        await come(server, strangers)
    await until(lambda: server.door.closed >= 3 * FEW.waiting - FEW.waiting_of_one)
    kept.writer.write(b"nothing\r\nConnection: close\r\n\r\n")
    async with asyncio.timeout(PATIENCE_S):
        assert (await kept.reader.read()).startswith(b"HTTP/1.1 200")


@pytest.mark.slow
async def test_when_all_places_are_taken_the_address_with_most_of_them_gives_one(
    server: WebServer, strangers: list[Stranger]
) -> None:
    for source in ("127.0.0.2", "127.0.0.3"):
        for _ in range(FEW.waiting_of_one):
            await come(server, strangers, source=source)
    await until(lambda: server.door.waiting == FEW.waiting)
    async with browser() as session:
        assert await page_status(server, session) == 200
    assert await strangers[0].is_closed()


@pytest.mark.slow
@pytest.mark.fault("a request that trickles and never ends", "closed after 10 s")
async def test_a_request_that_is_not_whole_in_time_is_closed_however_it_trickles(
    rig: Rig, server: WebServer, strangers: list[Stranger]
) -> None:
    stranger = await come(server, strangers)
    await until(lambda: server.door.waiting == 1)
    for _ in range(3):
        rig.real.advance(FIRST_REQUEST_S / 4)
        stranger.writer.write(b"x")
        server.door.sweep()
    assert server.door.waiting == 1
    rig.real.advance(FIRST_REQUEST_S / 4)
    server.door.sweep()
    assert await stranger.is_closed()
    assert server.door.waiting == 0


@pytest.mark.slow
async def test_between_two_requests_a_connection_may_wait_a_while(
    rig: Rig, server: WebServer, strangers: list[Stranger]
) -> None:
    stranger = await come(server, strangers, b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
    await stranger.reader.readuntil(b"page</p>")
    await until(lambda: server.door.waiting == 1)
    rig.real.advance(IDLE_S - 0.1)
    server.door.sweep()
    assert server.door.waiting == 1
    rig.real.advance(0.1)
    server.door.sweep()
    assert await stranger.is_closed()


@pytest.mark.slow
async def test_an_open_page_waits_for_nothing(rig: Rig, server: WebServer) -> None:
    async with browser() as session:
        page = await join(server, session)
        rig.real.advance(100 * IDLE_S)
        server.door.sweep()
        assert (await page.ask(Type="Heartbeat"))["Accepted"]


@pytest.mark.slow
@pytest.mark.fault("an answer that nobody reads", "closed after 30 s without progress")
async def test_an_answer_that_is_received_slowly_goes_on_and_one_that_is_not_received_ends(
    rig: Rig, server: WebServer, strangers: list[Stranger]
) -> None:
    text = b"GET /large.bin HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
    stranger = await come(server, strangers, text, limit=1024)
    await stranger.reader.readuntil(b"\r\n\r\n")
    (connection,) = server.door.waiting_connections()
    for _ in range(3):
        rig.real.advance(IDLE_S)
        server.door.sweep()
        assert server.door.waiting == 1, "it received some"
        before = connection.unsent
        async with asyncio.timeout(PATIENCE_S):
            while connection.unsent == before:
                await stranger.reader.readexactly(64 * 1024)
    for _ in range(2):
        rig.real.advance(IDLE_S)
        server.door.sweep()
    assert server.door.waiting == 0


async def test_a_connection_that_goes_leaves_its_place(server: WebServer, strangers: list[Stranger]) -> None:
    stranger = await come(server, strangers)
    await until(lambda: server.door.waiting == 1)
    await stranger.end()
    await until(lambda: server.door.waiting == 0)
    assert server.door.closed == 0


# -- being answered ---------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.fault(
    "more requests under way than the server answers",
    "503 for others, the operator in control is answered",
)
async def test_when_too_much_is_asked_only_the_operator_in_control_is_answered(server: WebServer) -> None:
    async with browser() as session, browser() as other:
        operator = await join(server, session)
        await operator.take_control()
        server.door.places = Places(12, 6, answered=1)
        assert await page_status(server, other) == 503
        assert await page_status(server, session) == 200
        await operator.socket.close()
        await until(lambda: server.door.answered == 0)
        assert await page_status(server, other) == 200


@pytest.mark.slow
@pytest.mark.fault("all places of pages and viewers are taken", "the operator in control gets in at once")
async def test_a_full_house_has_places_for_the_operator_in_control(server: WebServer) -> None:
    async with browser() as session, browser() as other:
        operator = await join(server, session)
        await operator.take_control()
        pages = [await join(server, other) for _ in range(2)]
        with pytest.raises(aiohttp.WSServerHandshakeError, match="503"):
            await join(server, other)
        for _ in range(KEPT_PLACES):
            pages.append(await join(server, session))
            assert (await pages[-1].take_control())["Accepted"]
        with pytest.raises(aiohttp.WSServerHandshakeError, match="503"):
            await join(server, session)


@pytest.mark.slow
async def test_the_place_is_kept_for_one_whose_lease_ran_out_until_control_is_taken(
    rig: Rig, server: WebServer
) -> None:
    async with browser() as session, browser() as other:
        operator = await join(server, session)
        await operator.take_control()
        await operator.socket.close()
        pages = [await join(server, other) for _ in range(3)]
        rig.clock.advance(100)
        pages.append(await join(server, session))
        await pages[0].take_control()
        with pytest.raises(aiohttp.WSServerHandshakeError, match="503"):
            await join(server, session)


# -- the process ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("descriptors", "clients", "waiting"), [(1024, 20, MOST_WAITING), (512, 20, 152), (300, 20, LEAST_WAITING)]
)
def test_places_leave_descriptors_to_the_flight(descriptors: int, clients: int, waiting: int) -> None:
    places = Places.within(descriptors, clients)
    assert places.waiting == waiting
    assert places.waiting_of_one == waiting // 2
    if waiting > LEAST_WAITING:
        assert places.waiting + places.answered + RESERVED_DESCRIPTORS <= descriptors


async def test_a_process_that_may_open_few_files_is_reported_at_the_start(
    rig: Rig, caplog: pytest.LogCaptureFixture
) -> None:
    rig.web = WebSettings(port=0, maximum_clients=1000)
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(1024, hard), hard))
    try:
        made = WebServer(rig.services(), rig.page)
        await made.start()
        await made.close()
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    assert "web.maximum_clients" in caplog.text
    assert "LimitNOFILE" in caplog.text


@pytest.mark.slow
@pytest.mark.fault(
    "the process has no descriptor left for a connection",
    "one waiting connection goes, accepted again within 0.1 s, no traceback, no spin",
)
async def test_without_descriptors_it_waits_and_accepts_when_there_are_some(
    server: WebServer, strangers: list[Stranger], caplog: pytest.LogCaptureFixture
) -> None:
    waiting = await come(server, strangers)
    await until(lambda: server.door.waiting == 1)
    client = socket.socket()
    client.setblocking(False)
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (client.fileno(), hard))
    try:
        await asyncio.get_running_loop().sock_connect(client, ("127.0.0.1", server.port))
        await until(lambda: "no room for a connection" in caplog.text)
        assert await waiting.is_closed(), "one that only waits makes room"
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    reader, writer = await asyncio.open_connection(sock=client)
    strangers.append(Stranger(reader, writer))
    writer.write(HALF + b"nothing\r\nConnection: close\r\n\r\n")
    async with asyncio.timeout(PATIENCE_S):
        assert (await reader.read()).startswith(b"HTTP/1.1 200")
    assert f"[Errno {errno.EMFILE}]" in caplog.text
    assert "Traceback" not in caplog.text
    assert len(caplog.records) <= LINES


@pytest.mark.slow
@pytest.mark.fault("malformed requests", "ten log lines a minute, without content and traceback")
async def test_malformed_requests_are_logged_a_few_times_without_their_content(
    server: WebServer, strangers: list[Stranger], caplog: pytest.LogCaptureFixture
) -> None:
    for _ in range(10 * LINES):
        stranger = await come(server, strangers, b"GET /?token=secret HTTP/1.1\r\nHo\x00st secret: x\r\n\r\n")
        assert await stranger.is_closed()
    assert 0 < len(caplog.records) <= LINES
    assert "secret" not in caplog.text
    assert "Traceback" not in caplog.text
