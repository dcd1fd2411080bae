"""Attacks on logging in, on the session after it, and on its end."""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import re
from pathlib import Path
from typing import Any

import aiohttp
import pytest

from hawk.comm.protocol.authority import Role
from hawk.config.sections import WebSettings
from hawk.web import door
from hawk.web.access.access import KEEPER, LOGIN_FILE, OPEN
from hawk.web.access.guesses import FIRST_WAIT_S, FREE_GUESSES
from hawk.web.access.login_page import WRONG
from hawk.web.access.logins import HOUR_S, LOGIN_LIMIT, Logins
from hawk.web.access.tokens import TOKEN_FILE, Tokens, rotate
from hawk.web.app import WebServer
from hawk.web.door import FIRST_REQUEST_S, Places
from hawk.web.sessions import LONGEST_FLIGHT_S
from hawk.web.ws import ACCESS_ENDED
from tests.manual_clock import ManualClock
from tests.unit.comm.waiting import until
from tests.unit.web.rig import PATIENCE_S, Rig, Visitor, browser
from tests.unit.web.stand import Stand


async def post(
    stand: Stand,
    session: aiohttp.ClientSession,
    token: str,
    role: str = "operator",
    path: str = "/login",
    fields: dict[str, str] | None = None,
    **headers: str,
) -> tuple[int, Any, str]:
    """Send the login form as a browser does; return status, headers and text."""
    assert stand.rig.server is not None
    url = stand.rig.server.make_url(path)
    sent = {"Origin": str(url.origin()), **headers}
    data = {"username": role, "password": token, **(fields or {})}
    async with session.post(url, data=data, headers=sent, allow_redirects=False) as response:
        return response.status, response.headers, await response.text()


def cookie_of(stand: Stand, session: aiohttp.ClientSession, purpose: str = "login") -> str:
    assert stand.rig.server is not None
    cookies = session.cookie_jar.filter_cookies(stand.rig.server.make_url("/"))
    return cookies[f"hawk_{purpose}_{stand.rig.server.port}"].value


async def status_with(stand: Stand, value: str) -> int:
    """Return the status of a request with this cookie alone."""
    assert stand.rig.server is not None
    return await stand.status(await stand.browser(headers={"Cookie": f"hawk_login_{stand.rig.server.port}={value}"}))


async def end_of(page: Visitor) -> Any:
    """Wait for the server's end of a WebSocket; return its close code."""
    async with asyncio.timeout(PATIENCE_S):
        while (message := await page.socket.receive()).type is aiohttp.WSMsgType.TEXT:
            pass
    return message.data


# -- the form ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("role", list(Role))
async def test_the_form_logs_in_with_the_token_of_its_role(stand: Stand, role: Role) -> None:
    session = await stand.browser()
    status, headers, _ = await post(stand, session, stand.tokens[role], role)
    assert (status, headers["Location"]) == (303, "/")
    cookie = headers["Set-Cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=Strict" in cookie
    assert "Path=/" in cookie
    assert stand.tokens[role] not in cookie
    page = await stand.page(session)
    assert page.welcome["Role"] == role


@pytest.mark.parametrize(
    ("role", "of", "status"),
    [
        ("operator", Role.VIEWER, 401),
        ("viewer", Role.OPERATOR, 401),
        ("pilot", Role.OPERATOR, 400),
        ("", Role.OPERATOR, 400),
        (" Operator ", Role.OPERATOR, 303),
    ],
)
async def test_a_token_opens_its_own_role_only(stand: Stand, role: str, of: Role, status: int) -> None:
    session = await stand.browser()
    assert (await post(stand, session, stand.tokens[of], role))[0] == status
    assert await stand.status(session) == (200 if status == 303 else 401)


async def test_the_page_of_one_who_is_not_logged_in_is_the_form(stand: Stand) -> None:
    assert stand.rig.server is not None
    session = await stand.browser(headers={"Accept": "text/html"})
    for path, status in (("/", 401), ("/login", 200)):
        async with session.get(stand.rig.server.make_url(path)) as response:
            text = await response.text()
            assert response.status == status
            assert 'type="password"' in text
            assert 'autocomplete="current-password"' in text
            assert 'autocomplete="username"' in text
            assert "<script" not in text
            policy = response.headers["Content-Security-Policy"]
            assert "form-action 'self'" in policy
            assert "script-src" not in policy
            assert "default-src 'none'" in policy
            assert "unsafe" not in policy
            assert response.headers["X-Frame-Options"] == "DENY"
            assert not re.search(r"(src|href)=\"(https?:)?//", text), "nothing comes from elsewhere"
    async with session.get(stand.rig.server.make_url("/login.css")) as response:
        assert response.status == 200
    await post(stand, session, stand.tokens[Role.VIEWER], "viewer")
    assert await stand.status(session, "/login") == 303, "one who is logged in goes on to the page"


def test_the_form_looks_as_the_page_does() -> None:
    import hawk.web

    folder = Path(hawk.web.__file__).parent
    variable = re.compile(r"(--[\w-]+): ([^;]+);")
    page = (folder / "page" / "src" / "styles" / "tokens.css").read_text().split('[data-theme="outdoor"]')[0]
    light, dark = (dict(variable.findall(part)) for part in page.split('[data-theme="dark"]'))
    own_light, own_dark = (
        dict(variable.findall(part))
        for part in (folder / "access" / "login" / "login.css").read_text().split("prefers-color-scheme: dark")
    )
    assert own_light.items() <= light.items()
    assert own_dark.items() <= dark.items()
    assert own_dark.keys() == {name for name in dark if name in own_light}


async def test_what_a_person_writes_into_the_form_does_not_become_part_of_the_page(stand: Stand) -> None:
    _, _, text = await post(stand, await stand.browser(), "<script>alert(1)</script>", "viewer")
    assert WRONG in text
    assert "<script" not in text
    assert 'value="viewer"' in text


@pytest.mark.parametrize(
    "body",
    [b"", b"username=operator", b"password=x", b"\xff\xfe", b"&" * 100, b"username=operator&password=" + b"x" * 9000],
)
async def test_a_form_that_is_none_is_answered(stand: Stand, body: bytes) -> None:
    assert stand.rig.server is not None
    url = stand.rig.server.make_url("/login")
    headers = {"Origin": str(url.origin()), "Content-Type": "application/x-www-form-urlencoded"}
    async with (await stand.browser()).post(url, data=body, headers=headers) as response:
        assert response.status in (400, 413)


# -- login CSRF -------------------------------------------------------------------------------------------------------


@pytest.mark.fault(
    "a page of another site sends the login form, a log-out, or a link with a token",
    "refused, the login that is there stays",
)
@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://127.0.0.1:1", "file://", "https://127.0.0.1"]
)
@pytest.mark.parametrize("path", ["/login", "/logout"])
async def test_a_page_of_another_site_logs_nobody_in_or_out(stand: Stand, origin: str, path: str) -> None:
    session = await stand.browser(Role.OPERATOR)
    before = cookie_of(stand, session)
    status, headers, _ = await post(stand, session, stand.tokens[Role.VIEWER], "viewer", path, Origin=origin)
    assert status == 403
    assert "Set-Cookie" not in headers
    assert cookie_of(stand, session) == before
    assert await stand.status(session) == 200


async def test_a_form_without_an_origin_logs_nobody_in(stand: Stand) -> None:
    assert stand.rig.server is not None
    session = await stand.browser()
    data = {"username": "viewer", "password": stand.tokens[Role.VIEWER]}
    async with session.post(stand.rig.server.make_url("/login"), data=data) as response:
        assert response.status == 403
        assert "Set-Cookie" not in response.headers


@pytest.mark.fault("a page of another site sends the login form, a log-out, or a link with a token")
@pytest.mark.parametrize("site", ["cross-site", "same-site"])
async def test_a_link_on_a_page_of_another_site_logs_nobody_in(stand: Stand, site: str) -> None:
    session = await stand.browser(headers={"Sec-Fetch-Site": site})
    assert await stand.status(session, f"/?token={stand.tokens[Role.VIEWER]}") == 401
    assert await stand.status(session) == 401


async def test_a_link_with_a_viewers_token_does_not_take_the_operators_role(stand: Stand) -> None:
    session = await stand.browser(Role.OPERATOR)
    before = cookie_of(stand, session)
    assert await stand.status(session, f"/?token={stand.tokens[Role.VIEWER]}") == 303
    assert cookie_of(stand, session) == before
    viewer = await stand.browser(Role.VIEWER)
    assert await stand.status(viewer, f"/?token={stand.tokens[Role.OPERATOR]}") == 303
    assert (await stand.page(viewer)).welcome["Role"] == "operator", "one's own link gives the higher role"


# -- session fixation -------------------------------------------------------------------------------------------------


@pytest.mark.fault(
    "a session cookie is planted before the login",
    "the login has another value, and does not share a session of control",
)
async def test_a_cookie_that_was_planted_before_the_login_is_not_the_session_after_it(stand: Stand) -> None:
    assert stand.rig.server is not None
    thief = await stand.browser(Role.VIEWER)
    planted = cookie_of(stand, thief)
    victim = await stand.browser(headers={"Origin": str(stand.rig.server.make_url("/").origin())})
    for value in (planted, "A" * 43):
        victim.cookie_jar.update_cookies({f"hawk_login_{stand.rig.server.port}": value}, stand.rig.server.make_url("/"))
        await post(stand, victim, stand.tokens[Role.OPERATOR])
        assert cookie_of(stand, victim) != value
        assert await status_with(stand, value) == 401, "what was planted is worth nothing now"


@pytest.mark.fault("a session cookie is planted before the login")
async def test_a_planted_session_of_control_is_not_shared_by_a_login(stand: Stand) -> None:
    assert stand.rig.server is not None
    planted = {"Cookie": f"hawk_session_{stand.rig.server.port}={'A' * 43}"}
    thief = await stand.page(await stand.tool(Role.OPERATOR, **planted))
    victim = await stand.page(session := await stand.browser(Role.OPERATOR), headers=planted)
    assert (await victim.take_control())["Accepted"]
    assert not (await thief.ask(Type="Control", Action="Release"))["Accepted"]
    assert "hawk_session" not in str(session.cookie_jar.filter_cookies(stand.rig.server.make_url("/")))


# -- open redirect, and the token in the address ----------------------------------------------------------------------


@pytest.mark.parametrize("query", ["?next=//evil.example", "?next=https://evil.example/", "?url=//evil.example&to=x"])
async def test_after_the_login_the_browser_goes_to_the_page_and_nowhere_else(stand: Stand, query: str) -> None:
    elsewhere = {"next": "https://evil.example", "redirect": "//evil.example"}
    path = f"/login{query}"
    _, headers, _ = await post(stand, await stand.browser(), stand.tokens[Role.VIEWER], "viewer", path, elsewhere)
    assert headers["Location"] == "/"


@pytest.mark.parametrize(
    "target", ["//evil.example/?token={}", "/?token={}&next=//evil.example", "/\\evil.example?token={}"]
)
async def test_an_address_with_the_token_leads_to_this_server_only(stand: Stand, target: str) -> None:
    assert stand.rig.server is not None
    reader, writer = await asyncio.open_connection("127.0.0.1", stand.rig.server.port)
    line = target.format(stand.tokens[Role.VIEWER])
    writer.write(
        f"GET {line} HTTP/1.1\r\nHost: 127.0.0.1:{stand.rig.server.port}\r\nConnection: close\r\n\r\n".encode()
    )
    async with asyncio.timeout(PATIENCE_S):
        answer = (await reader.read()).decode()
    writer.close()
    location = re.search(r"(?m)^Location: (\S*)", answer)
    assert location is None or re.fullmatch(r"/(\?next=//evil\.example|\?next=%2F%2Fevil\.example)?", location[1])


async def test_the_token_leaves_the_address_at_once(stand: Stand) -> None:
    assert stand.rig.server is not None
    token = stand.tokens[Role.OPERATOR]
    session = await stand.browser()
    async with session.get(stand.rig.server.make_url(f"/?token={token}&view=map"), allow_redirects=False) as response:
        assert response.status == 303, "a browser keeps the address of the answer in its history, not this one"
        assert response.headers["Location"] == "/?view=map"
        assert response.headers["Referrer-Policy"] == "no-referrer"
        assert response.headers["Cache-Control"] == "no-store"
        assert token not in str(response.headers)
    async with session.get(stand.rig.server.make_url("/")) as response:
        assert response.headers["Referrer-Policy"] == "no-referrer"
    assert token not in stand.rig.folder.joinpath(TOKEN_FILE).read_text() if stand.rig.folder else False


# -- guessing ---------------------------------------------------------------------------------------------------------


async def test_form_header_and_address_are_slowed_together(stand: Stand, caplog: pytest.LogCaptureFixture) -> None:
    session = await stand.browser()
    wrong = "guess-number-0000000"
    for number in range(FREE_GUESSES + 1):
        status, _, _ = await post(stand, session, f"{wrong}{number}")
        assert status == 401, number
    right = stand.tokens[Role.OPERATOR]
    status, headers, text = await post(stand, session, right)
    assert (status, headers["Retry-After"]) == (429, "1")
    assert "Too many wrong tokens" in text
    assert await stand.status(await stand.tool(Role.OPERATOR)) == 429
    assert await stand.status(session, f"/?token={right}") == 429
    stand.rig.real.advance(FIRST_WAIT_S)
    assert (await post(stand, session, right))[0] == 303
    assert wrong not in caplog.text
    assert "wrong token from 127.0.0.1" in caplog.text


async def test_a_guesser_slows_its_own_address_only(stand: Stand) -> None:
    assert stand.rig.server is not None
    guesser = await stand.browser(connector=aiohttp.TCPConnector(local_addr=("127.0.0.2", 0)))
    for number in range(FREE_GUESSES + 1):
        await post(stand, guesser, f"guess {number}")
    assert (await post(stand, guesser, "guess"))[0] == 429
    assert (await post(stand, await stand.browser(), stand.tokens[Role.OPERATOR]))[0] == 303


@pytest.mark.slow
async def test_every_token_is_compared_in_constant_time(stand: Stand, monkeypatch: pytest.MonkeyPatch) -> None:
    compared: list[tuple[bytes, bytes]] = []
    same = hmac.compare_digest

    def watched(given: bytes, wanted: bytes) -> bool:
        compared.append((given, wanted))
        return same(given, wanted)

    monkeypatch.setattr("hawk.web.access.tokens.hmac.compare_digest", watched)
    counts = set()
    for token in ("", "x", stand.tokens[Role.VIEWER], stand.tokens[Role.OPERATOR], "\ud800", "ä" * 500):
        compared.clear()
        assert stand.rig.app is not None
        stand.rig.app[KEEPER]._book.tokens.role_of(token)
        counts.add(len(compared))
        assert {len(each) for pair in compared for each in pair} == {32}, "hashes are compared, never the token itself"
    assert counts == {2}, "the number of comparisons does not depend on which one is right"


# -- the end of a session ---------------------------------------------------------------------------------------------


@pytest.mark.fault(
    "a cookie is sent again after log-out, or after a new token of its role",
    "401; its WebSockets and streams are closed, commands that arrive meanwhile are not taken",
)
async def test_a_cookie_is_worth_nothing_after_the_log_out_and_its_connections_end(stand: Stand) -> None:
    assert stand.rig.server is not None
    session = await stand.browser(Role.OPERATOR)
    kept = cookie_of(stand, session)
    page = await stand.page(session)
    video = await session.ws_connect(stand.rig.server.make_url("/video"))
    other = await stand.page(other_session := await stand.browser(Role.OPERATOR))
    origin = str(stand.rig.server.make_url("/").origin())
    async with session.post(stand.rig.server.make_url("/logout"), headers={"Origin": origin}) as response:
        assert response.status == 200, "the login page"
    assert await end_of(page) == ACCESS_ENDED
    assert (await video.receive()).data == ACCESS_ENDED
    assert await status_with(stand, kept) == 401
    assert (await other.ask(Type="Heartbeat"))["Accepted"]
    assert await stand.status(other_session) == 200
    assert stand.rig.folder is not None
    assert len(re.findall('"key"', (stand.rig.folder / LOGIN_FILE).read_text())) == 1, "it is not in the file either"


@pytest.mark.slow
async def test_the_stream_of_one_who_logged_out_ends(stand: Stand) -> None:
    assert stand.rig.server is not None
    assert stand.rig.app is not None
    session = await stand.browser(Role.VIEWER)
    stream = await session.get(stand.rig.server.make_url("/stream.mjpg"))
    async with session.post(stand.rig.server.make_url("/logout")):
        pass
    with contextlib.suppress(aiohttp.ClientError):
        async with asyncio.timeout(PATIENCE_S):
            await stream.read()
    assert len(stand.rig.app[OPEN]) == 0


@pytest.mark.fault("the one in control logs out", "control is given back at once")
async def test_log_out_gives_control_back(stand: Stand) -> None:
    assert stand.rig.server is not None
    session = await stand.browser(Role.OPERATOR)
    page = await stand.page(session)
    assert (await page.take_control())["Accepted"]
    async with session.post(stand.rig.server.make_url("/logout")):
        pass
    assert stand.rig.side.desk.controller() is None
    assert stand.rig.side.desk.given_back_by() == "Operator 1"


@pytest.mark.slow
@pytest.mark.fault("a cookie is sent again after log-out, or after a new token of its role")
@pytest.mark.parametrize("role", list(Role))
async def test_a_new_token_ends_what_the_old_one_began_and_nothing_else(stand: Stand, role: Role) -> None:
    """The command writes the file; the running server notices it by itself."""
    assert stand.rig.folder is not None
    other_role = next(each for each in Role if each is not role)
    session, tool, other = await stand.browser(role), await stand.tool(role), await stand.browser(other_role)
    kept, pages = cookie_of(stand, session), [await stand.page(session), await stand.page(tool)]
    other_page = await stand.page(other)
    new = rotate(stand.rig.folder / TOKEN_FILE, role)
    async with asyncio.timeout(PATIENCE_S):
        assert [await end_of(page) for page in pages] == [ACCESS_ENDED, ACCESS_ENDED]
    assert await status_with(stand, kept) == 401
    assert await stand.status(tool) == 401
    assert (await other_page.ask(Type="Heartbeat"))["Accepted"]
    assert await stand.status(await stand.browser(headers={"Authorization": f"Bearer {new}"})) == 200


@pytest.mark.fault("a cookie is sent again after log-out, or after a new token of its role")
async def test_a_command_that_comes_after_the_end_of_its_access_is_not_taken(stand: Stand) -> None:
    """It may arrive while the connection is being closed."""
    assert stand.rig.app is not None
    page = await stand.page(await stand.browser(Role.OPERATOR))
    assert (await page.take_control())["Accepted"]
    book = stand.rig.app[KEEPER]._book
    for login in tuple(book.logins._logins.values()):
        book.logins.end(login)
    await page.send(Type="Hold")
    await end_of(page)
    assert stand.rig.manager.urgent == []


@pytest.mark.nightly
async def test_tokens_that_are_made_while_it_runs_open_to_all_are_asked_for_from_then_on(
    rig: Rig, tmp_path: Path
) -> None:
    rig.folder = tmp_path
    server = await rig.start()
    async with browser() as session:
        page = Visitor(await session.ws_connect(server.make_url("/ws")))
        rotate(tmp_path / TOKEN_FILE, Role.OPERATOR)
        assert await end_of(page) == ACCESS_ENDED
        async with session.get(server.make_url("/api/session")) as response:
            assert response.status == 401


@pytest.mark.fault(
    "the token file is damaged or removed while the daemon runs",
    "the tokens before it stay valid; it is reported",
)
async def test_a_damaged_or_missing_token_file_leaves_the_tokens_as_they_are(
    stand: Stand, caplog: pytest.LogCaptureFixture
) -> None:
    assert stand.rig.folder is not None
    path = stand.rig.folder / TOKEN_FILE
    session = await stand.browser(Role.OPERATOR)
    path.write_text("{")
    await stand.look()
    assert "damaged" in caplog.text
    path.unlink()
    await stand.look()
    assert "is gone" in caplog.text
    assert await stand.status(session) == 200
    assert await stand.status(await stand.browser()) == 401


# -- limits of time ---------------------------------------------------------------------------------------------------


async def test_a_session_ends_when_nobody_uses_it(stand: Stand) -> None:
    session, idle = await stand.browser(Role.VIEWER), await stand.browser(Role.VIEWER)
    page = await stand.page(session)
    for _ in range(3):
        stand.rig.real.advance(5 * HOUR_S)
        await stand.look()
    assert (await page.ask(Type="Heartbeat"))["Accepted"], "an open page is in use"
    assert await stand.status(session) == 200
    assert await stand.status(idle) == 401


@pytest.mark.fault("a login reaches its time limit while it has control")
async def test_an_expired_sessions_websocket_is_closed(stand: Stand) -> None:
    session = await stand.browser(Role.OPERATOR)
    page = await stand.page(session)
    stand.rig.real.advance(168 * HOUR_S + 1)
    await stand.look()
    assert await end_of(page) == ACCESS_ENDED
    assert await stand.status(session) == 401


@pytest.mark.fault(
    "a login reaches its time limit while it has control",
    "it ends when control is given back, not before; any other one is closed",
)
async def test_the_one_in_control_is_not_logged_out_by_time_but_when_it_gives_control_back(stand: Stand) -> None:
    session = await stand.browser(Role.OPERATOR)
    page = await stand.page(session)
    assert (await page.take_control())["Accepted"]
    stand.rig.real.advance(400 * HOUR_S)
    await stand.look()
    assert await stand.status(session) == 200
    assert (await page.ask(Type="Hold"))["Accepted"]
    assert (await page.ask(Type="Control", Action="Release"))["Accepted"]
    await stand.look()
    assert await end_of(page) == ACCESS_ENDED


async def test_a_lost_operators_login_is_kept_for_the_length_of_a_flight_only(stand: Stand) -> None:
    lost, replaced = await stand.browser(Role.OPERATOR), await stand.browser(Role.OPERATOR)
    page = await stand.page(lost)
    assert (await page.take_control())["Accepted"]
    await page.socket.close()
    await stand.rig.nobody_connected()
    stand.rig.real.advance(400 * HOUR_S)
    stand.rig.clock.advance(LONGEST_FLIGHT_S)
    assert await stand.status(lost) == 200, "it finds its drone again"
    assert await stand.status(replaced) == 401
    stand.rig.clock.advance(1.0)
    assert await stand.status(lost) == 401


# -- the table --------------------------------------------------------------------------------------------------------


def table(folder: Path, clock: ManualClock) -> tuple[Logins, Tokens]:
    from hawk.web.access.tokens import read_tokens

    for role in Role:
        rotate(folder / TOKEN_FILE, role)
    return Logins(WebSettings(), clock, b"s" * 32), read_tokens(folder / TOKEN_FILE)


def test_logins_outlive_a_restart_with_their_ages(tmp_path: Path) -> None:
    clock = ManualClock(1000.0)
    logins, tokens = table(tmp_path, clock)
    value = logins.begin(Role.VIEWER, tokens.proof(Role.VIEWER) or "")
    clock.advance(5 * HOUR_S)
    text = logins.to_json(wall=1.8e9)
    assert value not in text, "the file does not log anybody in"
    for away_h, is_known in ((0.0, True), (6.9, True), (7.1, False), (-1000.0, True)):
        again = Logins(WebSettings(), ManualClock(3.0), b"s" * 32)
        again.restore(text, wall=1.8e9 + away_h * HOUR_S)
        assert (again.find(value, tokens) is not None) == is_known, away_h


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"written": 1, "logins": [{}]}', '{"written": "x", "logins": []}'])
def test_a_damaged_table_is_left_alone(tmp_path: Path, text: str) -> None:
    logins, _ = table(tmp_path, ManualClock())
    with pytest.raises(ValueError, match=r"damaged|could not|Expecting"):
        logins.restore(text, wall=1.8e9)
    assert len(logins) == 0


async def test_a_damaged_table_costs_a_login_and_not_the_start(
    rig: Rig, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    rig.folder = tmp_path
    (tmp_path / LOGIN_FILE).write_bytes(b"\xff\x00")
    await rig.start()
    assert "log in again" in caplog.text


def test_a_crowd_of_viewers_ends_no_operators_login(tmp_path: Path) -> None:
    clock = ManualClock(1000.0)
    logins, tokens = table(tmp_path, clock)
    operator = logins.begin(Role.OPERATOR, tokens.proof(Role.OPERATOR) or "")
    first = logins.begin(Role.VIEWER, tokens.proof(Role.VIEWER) or "")
    for _ in range(LOGIN_LIMIT):
        clock.advance(1.0)
        logins.begin(Role.VIEWER, tokens.proof(Role.VIEWER) or "")
    assert len(logins) == LOGIN_LIMIT + 1
    assert logins.find(operator, tokens) is not None
    assert logins.find(first, tokens) is None


# -- the door ---------------------------------------------------------------------------------------------------------


@pytest.mark.fault(
    "login forms that are never finished",
    "they count among the connections that wait, and end after 10 s",
)
async def test_forms_that_are_never_finished_take_no_place_from_the_pages(rig: Rig, tmp_path: Path) -> None:
    rig.folder, rig.web = tmp_path, WebSettings(port=0, maximum_clients=3)
    token = rotate(tmp_path / TOKEN_FILE, Role.OPERATOR)
    server = WebServer(rig.services(), rig.page)
    await server.start()
    server.door.places = Places(waiting=12, waiting_of_one=6, answered=4)
    head = f"POST /login HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nOrigin: http://127.0.0.1:{server.port}\r\n"
    slow = [await asyncio.open_connection("127.0.0.1", server.port) for _ in range(10)]
    try:
        for _, writer in slow:
            writer.write(f"{head}Content-Length: 100\r\n\r\nusername=".encode())
        await until(lambda: server.door.waiting == 6)
        assert server.door.answered == 0
        known = browser(headers={"Authorization": f"Bearer {token}"})
        async with known as session, session.get(f"{server.url}api/session") as response:
            assert response.status == 200
        rig.real.advance(FIRST_REQUEST_S + 1)
        server.door.sweep()
        await until(lambda: server.door.waiting == 0)
    finally:
        for _, writer in slow:
            writer.close()
        await server.close()
    assert door.IDLE_S > FIRST_REQUEST_S
