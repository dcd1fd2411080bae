from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import aiohttp
import pytest
from aiohttp import web

from hawk.config.sections import WebSettings
from hawk.web.access.guesses import (
    ADDRESS_LIMIT,
    FIRST_WAIT_S,
    FORGOTTEN_S,
    FREE_GUESSES,
    LONGEST_WAIT_S,
    TokenGuesses,
    network_of,
)
from hawk.web.access.paced_log import LINES
from hawk.web.access.tokens import Tokens
from hawk.web.app import create_app
from hawk.web.security import InsecureBindingError, check_binding, is_loopback
from tests.manual_clock import ManualClock
from tests.unit.web.rig import Rig, browser

TOKEN = "correct-horse-battery"


async def status_of(rig: Rig, path: str = "/api/schema.json", method: str = "GET", **options: Any) -> int:
    if rig.server is None:
        await rig.start()
    assert rig.server is not None
    url = rig.server.make_url(path)
    async with browser() as session, session.request(method, url, allow_redirects=False, **options) as response:
        return response.status


async def socket_status(rig: Rig, path: str = "/ws", **options: Any) -> int:
    """Return 101 when the WebSocket opens, else the status of the refusal."""
    if rig.server is None:
        await rig.start()
    assert rig.server is not None
    async with browser() as session:
        try:
            async with session.ws_connect(rig.server.make_url(path), **options):
                return 101
        except aiohttp.WSServerHandshakeError as error:
            return error.status


# -- where it may listen ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("host", ["127.0.0.1", "127.8.8.8", "::1", "localhost", "LOCALHOST"])
def test_loopback_needs_no_token(host: str) -> None:
    check_binding(WebSettings(host=host), Tokens(), Path("var"))


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.1.100", "drone.local", "localhost.example.org"])
def test_beyond_loopback_there_is_no_start_without_a_token(rig: Rig, host: str) -> None:
    rig.web = WebSettings(host=host)
    with pytest.raises(InsecureBindingError, match=r"web\.token"):
        create_app(rig.services(), rig.page)
    rig.web = WebSettings(host=host, token=TOKEN)
    assert isinstance(create_app(rig.services(), rig.page), web.Application)


def test_names_other_than_localhost_are_not_loopback() -> None:
    assert not is_loopback("127.0.0.1.example.org")


# -- Host -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "host",
    [
        "localhost",
        "localhost:3000",
        "127.0.0.1:3000",
        "192.168.1.100:3000",
        "[::1]:3000",
        "[fe80::1]",
        "drone.local",
        "DRONE.local:80",
    ],
)
async def test_our_own_names_and_bare_addresses_are_served(rig: Rig, host: str) -> None:
    rig.web = WebSettings(allowed_hosts=("drone.local",), token=TOKEN)
    assert await status_of(rig, headers={"Host": host, "Authorization": f"Bearer {TOKEN}"}) == 200


@pytest.mark.slow
@pytest.mark.parametrize(
    "host",
    [
        "evil.example",
        "evil.example:3000",
        "localhost.evil.example",
        "127.0.0.1.evil.example",
        "drone.local.evil",
        "user@localhost",
        "localhost/x",
        "localhost:x",
        "",
        "[::1",
    ],
)
async def test_a_foreign_name_is_refused(rig: Rig, host: str) -> None:
    rig.web = WebSettings(allowed_hosts=("drone.local",), token=TOKEN)
    assert await status_of(rig, headers={"Host": host}) in (400, 403)
    assert await socket_status(rig, headers={"Host": host}) in (400, 403)
    assert await status_of(rig, method="POST", headers={"Host": host}) in (400, 403)


# -- Origin -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", ["/ws", "/video"])
async def test_a_websocket_is_for_the_servers_own_page_or_a_tool(rig: Rig, path: str) -> None:
    server = await rig.start()
    assert server.port is not None
    own = f"http://127.0.0.1:{server.port}"
    assert await socket_status(rig, path) == 101, "a tool sends no Origin"
    assert await socket_status(rig, path, headers={"Origin": own}) == 101
    for foreign in (
        "http://evil.example",
        "null",
        f"http://127.0.0.1:{server.port + 1}",
        "file://",
        f"ftp{own[4:]}",
        f"{own}.evil.example",
        "http://localhost",
    ):
        assert await socket_status(rig, path, headers={"Origin": foreign}) == 403, foreign
    assert len(rig.side.hub) == 0


async def test_a_post_from_another_page_is_refused_before_anything_else(rig: Rig) -> None:
    server = await rig.start()
    assert await status_of(rig, method="POST", headers={"Origin": "http://evil.example"}) == 403
    assert await status_of(rig, method="POST", headers={"Origin": f"http://127.0.0.1:{server.port}"}) == 405


# -- token ------------------------------------------------------------------------------------------------------------


@pytest.fixture
def guarded(rig: Rig) -> Rig:
    rig.web = WebSettings(token=TOKEN)
    return rig


@pytest.mark.parametrize("path", ["/", "/api/schema.json", "/snapshot.jpg", "/stream.mjpg", "/metrics", "/api/health"])
async def test_everything_needs_the_token(guarded: Rig, path: str) -> None:
    assert await status_of(guarded, path) == 401
    assert await status_of(guarded, path, headers={"Authorization": "Bearer wrong-horse-battery"}) == 401
    assert await status_of(guarded, f"{path}?token=wrong") == 401


@pytest.mark.parametrize("path", ["/ws", "/video"])
async def test_websockets_need_the_token(guarded: Rig, path: str) -> None:
    assert await socket_status(guarded, path) == 401
    assert await socket_status(guarded, path, headers={"Cookie": "hawk_token_80=guess"}) == 401
    assert await socket_status(guarded, path, headers={"Authorization": f"Bearer {TOKEN}"}) == 101


@pytest.mark.parametrize(
    "header",
    [f"Basic {TOKEN}", TOKEN, "Bearer", "Bearer ", f"Bearer {TOKEN}x", f"Bearer {TOKEN[:-1]}", "Bearer \u00e4"],
)
async def test_only_the_exact_bearer_counts(guarded: Rig, header: str) -> None:
    assert await status_of(guarded, headers={"Authorization": header}) == 401


async def test_the_page_trades_the_token_for_a_strict_cookie(guarded: Rig) -> None:
    server = await guarded.start()
    async with browser() as session:
        async with session.get(server.make_url(f"/?token={TOKEN}&view=map"), allow_redirects=False) as response:
            assert response.status == 303
            assert response.headers["Location"] == "/?view=map"
            (cookie,) = response.headers.getall("Set-Cookie")
        assert TOKEN not in cookie
        assert "HttpOnly" in cookie
        assert "SameSite=Strict" in cookie
        async with session.get(server.make_url("/api/schema.json")) as response:
            assert response.status == 200
        async with session.ws_connect(server.make_url("/ws")):
            pass
        async with session.get(server.make_url(f"/?token={TOKEN}"), allow_redirects=False) as response:
            assert response.headers["Location"] == "/", "the address is cleaned also for one who is known"


async def test_a_tool_may_bring_the_token_in_the_address(guarded: Rig) -> None:
    assert await status_of(guarded, f"/api/schema.json?token={TOKEN}") == 200


async def test_the_cookie_outlives_a_restart_of_the_server(guarded: Rig, tmp_path: Path) -> None:
    guarded.folder = tmp_path
    server = await guarded.start()
    async with browser() as session, session.get(server.make_url(f"/?token={TOKEN}")) as response:
        value = session.cookie_jar.filter_cookies(response.url).popitem()[1].value
    await server.close()
    for secret, status in ((guarded.cookie_secret, 200), (b"another" * 5, 401)):
        again = Rig(web=WebSettings(token=TOKEN), cookie_secret=secret, folder=tmp_path)
        second = await again.start()
        try:
            assert await status_of(again, headers={"Cookie": f"hawk_login_{second.port}={value}"}) == status
        finally:
            await second.close()


# -- guesses ----------------------------------------------------------------------------------------------------------


async def guess(rig: Rig, number: int) -> int:
    return await status_of(rig, headers={"Authorization": f"Bearer guess-number-{number:08d}"})


@pytest.mark.slow
@pytest.mark.fault(
    "someone guesses the token",
    "after five guesses 429 for 1, 2, 4 … 30 s; known pages and the operator in control are not held up",
)
async def test_who_guesses_the_token_has_to_wait_longer_and_longer(
    guarded: Rig, caplog: pytest.LogCaptureFixture
) -> None:
    assert [await guess(guarded, n) for n in range(FREE_GUESSES + 1)] == [401] * (FREE_GUESSES + 1)
    looked_at = []
    for number in range(240):  # a guess every half a second, for two minutes
        guarded.real.advance(0.5)
        looked_at.append(await guess(guarded, 100 + number))
    assert set(looked_at) == {401, 429}
    assert looked_at.count(401) == 7, "after 1, 3, 7, 15, 31, 61 and 91 s, or a little later"
    lines = [record for record in caplog.records if "wrong token" in record.message]
    assert len(lines) <= 3 * LINES
    assert "guess-number" not in caplog.text


async def test_the_right_token_is_looked_at_when_the_wait_is_over(guarded: Rig) -> None:
    for number in range(FREE_GUESSES + 1):
        await guess(guarded, number)
    assert await status_of(guarded, headers={"Authorization": f"Bearer {TOKEN}"}) == 429
    assert await status_of(guarded) == 401, "who brings no token guesses none"
    guarded.real.advance(FIRST_WAIT_S)
    assert await status_of(guarded, headers={"Authorization": f"Bearer {TOKEN}"}) == 200
    assert await guess(guarded, 1) == 401, "it begins again"


@pytest.mark.slow
async def test_a_page_that_is_known_and_the_operator_in_control_do_not_wait_for_a_guesser(guarded: Rig) -> None:
    server = await guarded.start()
    async with browser() as page, browser(headers={"Authorization": f"Bearer {TOKEN}"}) as tool:
        await page.get(server.make_url(f"/?token={TOKEN}"))
        async with tool.ws_connect(server.make_url("/ws")) as socket:
            await socket.receive()
            await socket.send_json({"Type": "Control", "Action": "Request"})
            await socket.receive()
        for number in range(FREE_GUESSES + 1):
            await guess(guarded, number)
        assert await guess(guarded, 1) == 429
        for one in (page, tool):
            async with one.get(server.make_url("/api/schema.json")) as response:
                assert response.status == 200


def test_guesses_are_counted_for_a_bounded_number_of_addresses() -> None:
    clock = ManualClock()
    guesses = TokenGuesses(clock)
    for number in range(3 * ADDRESS_LIMIT):
        guesses.wrong(f"10.0.{number // 256}.{number % 256}", "guess")
    assert len(guesses) == ADDRESS_LIMIT
    assert guesses.total == 3 * ADDRESS_LIMIT
    for number in range(40):
        guesses.wrong("evil", f"{number}")
    assert guesses.wait_s("evil") == LONGEST_WAIT_S
    clock.advance(FORGOTTEN_S + 1)
    assert guesses.wrong("evil", "39") == 1


@pytest.mark.parametrize(
    ("host", "network"),
    [
        ("192.168.1.7", "192.168.1.7"),
        ("::ffff:192.168.1.7", "192.168.1.7"),
        ("2001:db8:1:2:aaaa::1", "2001:db8:1:2::"),
        ("2001:db8:1:2:bbbb::2", "2001:db8:1:2::"),
        ("fe80::1%eth0", "fe80::"),
        (None, ""),
        ("", ""),
    ],
)
def test_one_guest_is_one_address(host: str | None, network: str) -> None:
    assert network_of(host) == network


# -- broken requests --------------------------------------------------------------------------------------------------


@pytest.mark.fault("a request with a Host that is no ASCII, or of HTTP/2.0", "400, 505")
@pytest.mark.parametrize(
    ("line", "host", "status"),
    [
        (b"GET / HTTP/1.1", b"127.0.0.\x831", 400),
        (b"GET / HTTP/1.1", b"127.0.0.1; script-src *", 400),
        (b"GET / HTTP/1.1", b"user@127.0.0.1", 400),
        (b"GET / HTTP/2.0", b"127.0.0.1", 505),
        (b"GET /stream.mjpg HTTP/2.0", b"127.0.0.1", 505),
    ],
)
async def test_a_broken_request_is_refused_and_is_no_fault_of_ours(
    rig: Rig, line: bytes, host: bytes, status: int
) -> None:
    server = await rig.start()
    reader, writer = await asyncio.open_connection("127.0.0.1", server.port)
    writer.write(line + b"\r\nHost: " + host + b"\r\nConnection: close\r\n\r\n")
    async with asyncio.timeout(5):
        answer = await reader.read()
    writer.close()
    assert int(answer.split()[1]) == status
    assert b"script-src *" not in answer


# -- headers ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", ["/", "/api/schema.json", "/nothing"])
async def test_headers_keep_the_browser_strict(rig: Rig, path: str) -> None:
    server = await rig.start()
    async with browser() as session, session.get(server.make_url(path)) as response:
        headers = response.headers
    policy = headers["Content-Security-Policy"]
    assert "default-src 'self'" in policy
    assert "script-src 'self';" in policy
    assert f"connect-src 'self' ws://127.0.0.1:{server.port} " in policy
    assert "unsafe" not in policy
    assert "frame-ancestors 'none'" in policy
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert headers["X-Frame-Options"] == "DENY"
    assert headers["Referrer-Policy"] == "no-referrer"
    assert headers["Cross-Origin-Resource-Policy"] == "same-origin"


async def test_the_session_cookie_is_strict(rig: Rig) -> None:
    server = await rig.start()
    async with browser() as session, session.ws_connect(server.make_url("/ws")) as socket:
        cookie = socket._response.headers["Set-Cookie"]
    assert cookie.startswith(f"hawk_session_{server.port}=")
    assert "HttpOnly" in cookie
    assert "SameSite=Strict" in cookie
