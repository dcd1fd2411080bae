from __future__ import annotations

import asyncio
import threading

import pytest

from hawk.comm.protocol.heartbeat import DroneStatus
from hawk.config.sections import WebSettings
from hawk.web.app import WebServer
from tests.unit.web.rig import Rig, browser


async def test_a_free_port_is_taken_and_shown(rig: Rig) -> None:
    rig.web = WebSettings(port=0)
    server = WebServer(rig.services(), rig.page)
    await server.start()
    try:
        assert server.port > 0
        assert server.url == server.page_url == f"http://127.0.0.1:{server.port}/"
        async with browser() as session, session.get(server.url) as response:
            assert response.status == 200
    finally:
        await server.close()


async def test_a_taken_port_is_an_error_and_leaves_nothing_behind(rig: Rig) -> None:
    rig.web = WebSettings(port=0)
    first = WebServer(rig.services(), rig.page)
    await first.start()
    rig.web = WebSettings(port=first.port)
    second = WebServer(rig.services(), rig.page)
    try:
        with pytest.raises(OSError, match=r"(?i)address already in use"):
            await second.start()
    finally:
        await first.close()
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("web-")]


async def test_close_ends_clients_tasks_and_listeners(rig: Rig) -> None:
    rig.web = WebSettings(port=0)
    server = WebServer(rig.services(), rig.page)
    await server.start()
    async with (
        browser() as session,
        session.ws_connect(f"{server.url}ws") as socket,
        session.ws_connect(f"{server.url}video"),
        asyncio.timeout(5),
    ):
        await socket.receive()
        await server.close()
    assert len(rig.side.hub) == 0
    assert not [task for task in asyncio.all_tasks() if task.get_name().startswith("web-")]
    rig.status.publish(DroneStatus())


@pytest.mark.parametrize(
    ("host", "shown"),
    [
        ("127.0.0.1", "127.0.0.1"),
        ("0.0.0.0", "127.0.0.1"),
        ("::", "[::1]"),
        ("::1", "[::1]"),
        ("drone.local", "drone.local"),
    ],
)
def test_the_address_to_open_has_the_token(rig: Rig, host: str, shown: str) -> None:
    rig.web = WebSettings(host=host, port=3000, token="a/b+c&d correct-horse")
    server = WebServer(rig.services(), rig.page)
    assert server.url == f"http://{shown}:3000/"
    assert server.page_url == f"http://{shown}:3000/?token=a%2Fb%2Bc%26d%20correct-horse"
