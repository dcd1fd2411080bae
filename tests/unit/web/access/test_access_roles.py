"""A viewer sees everything and commands nothing, whatever it sends and whatever it pretends to be."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path

import aiohttp
import pytest

from hawk.comm.protocol.authority import VIEWERS_COMMAND_NOTHING, Role, role_refusal
from hawk.comm.protocol.command_table import COMMAND_TABLE, sender_of
from hawk.config.sections import WebSettings
from hawk.web.access.guesses import FREE_GUESSES, GUESSES
from hawk.web.access.tokens import TOKEN_FILE, rotate
from hawk.web.app import WebServer
from hawk.web.door import Places
from hawk.web.services import KEPT_PLACES
from tests.unit.web.rig import Rig, Visitor, browser
from tests.unit.web.stand import Stand

CONTROL = ["Request", "Release", "Ask", "Withdraw", "Give", "Keep"]
VIEWER_MAY = {"Heartbeat", "Map Resync"}
COMMANDS = [
    *(json.loads(row.example.model_dump_json(by_alias=True, exclude={"id"}))
      for kind, row in COMMAND_TABLE.items() if kind not in VIEWER_MAY and kind != "Control"),
    *({"Type": "Control", "Action": action} for action in CONTROL),
]  # fmt: skip


def refusal(kind: str, role: Role) -> str:
    return role_refusal(sender_of(kind), role)


# -- every command ----------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.fault(
    "a viewer sends each command, while control is free, held or lost",
    "refused with the reason; nothing reaches the states",
)
@pytest.mark.parametrize("held", ["free", "held", "lost"])
async def test_every_command_of_a_viewer_is_refused_with_the_reason(stand: Stand, held: str) -> None:
    operator = await stand.page(await stand.browser(Role.OPERATOR))
    viewers = [await stand.page(await stand.browser(Role.VIEWER)), await stand.page(await stand.tool(Role.VIEWER))]
    if held != "free":
        assert (await operator.take_control())["Accepted"]
    if held == "lost":
        stand.rig.clock.advance(10.1)
    for viewer in viewers:
        for command in COMMANDS:
            answer = await viewer.ask(**command)
            assert (answer["Accepted"], answer["Reason"]) == (False, VIEWERS_COMMAND_NOTHING), command
            await asyncio.sleep(0.01)  # slower than the flood limit
    assert stand.rig.manager.urgent == [], "nothing reached the manager past the queue"
    assert stand.rig.side.socket.receive() == [], "nor through it"


@pytest.mark.fault("a viewer sends each command, while control is free, held or lost")
async def test_every_type_of_command_is_among_those_tried() -> None:
    from hawk.comm.protocol.commands import schema

    kinds = {
        found["const"]
        for model in schema()["toDrone"]["$defs"].values()
        if (found := model.get("properties", {}).get("Type"))
    }
    assert kinds == {command["Type"] for command in COMMANDS} | VIEWER_MAY
    assert all(not refusal(kind, Role.OPERATOR) for kind in kinds)
    assert all(refusal(kind, Role.VIEWER) for kind in kinds - VIEWER_MAY)
    assert refusal("Something New", Role.VIEWER), "a command that nobody listed is refused as well"


async def test_a_viewer_knows_its_role_and_sees_everything(stand: Stand) -> None:
    viewer = await stand.page(session := await stand.browser(Role.VIEWER))
    operator = await stand.page(await stand.browser(Role.OPERATOR))
    assert (viewer.welcome["Role"], viewer.welcome["Login"]) == ("viewer", True)
    assert (operator.welcome["Role"], operator.welcome["Login"]) == ("operator", True)
    assert viewer.welcome["Session"].startswith("Viewer ")
    stand.rig.publish()
    assert (await viewer.next("Heartbeat"))["In Control"] is False
    assert (await viewer.ask(Type="Heartbeat"))["Accepted"]
    assert (await viewer.ask(Type="Map Resync"))["Accepted"]
    assert stand.rig.server is not None
    for path in ("/", "/api/health", "/api/report.json", "/metrics", "/api/session"):
        async with session.get(stand.rig.server.make_url(path)) as response:
            assert response.status in (200, 503), path
    async with session.get(stand.rig.server.make_url("/api/session")) as response:
        assert await response.json() == {"role": "viewer", "login": True, "person": ""}


async def test_without_tokens_there_is_one_role_and_no_login(rig: Rig) -> None:
    await rig.start()
    assert rig.server is not None
    async with browser() as session, session.get(rig.server.make_url("/api/session")) as response:
        assert await response.json() == {"role": "operator", "login": False, "person": ""}
    async with browser() as session:
        page = Visitor(await session.ws_connect(rig.server.make_url("/ws")))
        assert (await page.next("Welcome"))["Login"] is False
        assert (await page.take_control())["Accepted"], "nothing is to be set up on loopback"


# -- pretending -------------------------------------------------------------------------------------------------------


@pytest.mark.fault(
    "a viewer sends the session cookie of the operator in control",
    "it commands nothing, keeps no lease alive, gets no kept place",
)
async def test_a_viewer_with_the_operators_session_cookie_commands_nothing_and_keeps_nothing_alive(
    stand: Stand,
) -> None:
    """The cookie of a tool's session is not its login: with another role's login it is worth nothing."""
    assert stand.rig.server is not None
    operator = await stand.page(tool := await stand.tool(Role.OPERATOR))
    assert (await operator.take_control())["Accepted"]
    cookies = tool.cookie_jar.filter_cookies(stand.rig.server.make_url("/"))
    (stolen,) = (f"{name}={morsel.value}" for name, morsel in cookies.items())
    assert "hawk_session" in stolen
    thieves = [
        await stand.page(await stand.tool(Role.VIEWER, Cookie=stolen)),
        await stand.page(await stand.browser(Role.VIEWER), headers={"Cookie": stolen}),
    ]
    stand.rig.clock.advance(9.0)
    for thief in thieves:
        for command in ({"Type": "Land"}, {"Type": "Hold"}, {"Type": "Control", "Action": "Release"}):
            assert (await thief.ask(**command))["Reason"] == VIEWERS_COMMAND_NOTHING
        assert (await thief.ask(Type="Heartbeat"))["Accepted"]
        stand.rig.publish_status()
        assert (await thief.next("Heartbeat"))["In Control"] is False
    stand.rig.clock.advance(1.1)
    assert stand.rig.side.desk.controller_is_lost(), "a viewer's sign of life is not the operator's"
    assert stand.rig.manager.urgent == []


@pytest.mark.nightly
@pytest.mark.parametrize(
    "cookie", ["hawk_login_{port}", "hawk_session_{port}", "hawk_token_{port}", "__Host-hawk_login"]
)
@pytest.mark.parametrize("value", ["operator", "A" * 43, '{{"role":"operator"}}', "", "%00"])
async def test_a_made_up_cookie_opens_nothing(stand: Stand, cookie: str, value: str) -> None:
    assert stand.rig.server is not None
    header = f"{cookie.format(port=stand.rig.server.port)}={value}"
    session = await stand.browser(headers={"Cookie": header})
    async with session.get(stand.rig.server.make_url("/api/session")) as response:
        assert response.status == 401
    with pytest.raises(aiohttp.WSServerHandshakeError):
        await session.ws_connect(stand.rig.server.make_url("/ws"))


@pytest.mark.fault("a viewer sends the session cookie of the operator in control")
async def test_a_viewer_gets_no_place_that_is_kept_for_the_operator_in_control(rig: Rig, tmp_path: Path) -> None:
    stand = Stand(rig, tmp_path)
    rig.folder, rig.web = tmp_path, WebSettings(maximum_clients=1)
    server = await rig.start()
    tool = await stand.tool(Role.OPERATOR)
    operator = await stand.page(tool)
    assert (await operator.take_control())["Accepted"]
    (stolen,) = (f"{n}={morsel.value}" for n, morsel in tool.cookie_jar.filter_cookies(server.make_url("/")).items())
    with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
        await stand.page(await stand.tool(Role.VIEWER, Cookie=stolen))
    assert refused.value.status == 503
    await stand.page(await stand.tool(Role.OPERATOR, Cookie=stolen))
    await stand.close()


@pytest.mark.fault("viewers take every place that they can get", "four places are left to operators")
async def test_viewers_leave_places_to_operators(rig: Rig, tmp_path: Path) -> None:
    stand = Stand(rig, tmp_path)
    rig.folder, rig.web = tmp_path, WebSettings(maximum_clients=6)
    await rig.start()
    viewer = await stand.browser(Role.VIEWER)
    for _ in range(6 - KEPT_PLACES):
        await stand.page(viewer)
    with pytest.raises(aiohttp.WSServerHandshakeError):
        await stand.page(viewer)
    for _ in range(KEPT_PLACES):
        await stand.page(await stand.browser(Role.OPERATOR))
    await stand.close()


async def test_a_viewer_with_the_cookie_of_control_is_not_answered_when_too_much_is_asked(
    rig: Rig, tmp_path: Path
) -> None:
    rig.folder, rig.web = tmp_path, WebSettings(port=0)
    tokens = {role: rotate(tmp_path / TOKEN_FILE, role) for role in Role}
    server = WebServer(rig.services(), rig.page)
    await server.start()

    async def status(role: Role, cookie: str) -> int:
        headers = {"Authorization": f"Bearer {tokens[role]}", "Cookie": cookie}
        async with browser(headers=headers) as tool, tool.get(f"{server.url}api/session") as response:
            return response.status

    try:
        async with browser(headers={"Authorization": f"Bearer {tokens[Role.OPERATOR]}"}) as tool:
            operator = Visitor(await tool.ws_connect(f"{server.url}ws"))
            assert (await operator.take_control())["Accepted"]
            stolen = operator.socket._response.headers["Set-Cookie"].partition(";")[0]
            server.door.places = Places(waiting=12, waiting_of_one=6, answered=1)
            assert [await status(role, stolen) for role in (Role.VIEWER, Role.OPERATOR)] == [503, 200]
            await operator.socket.close()
    finally:
        await server.close()


# -- what was a token is no guess --------------------------------------------------------------------------------------


async def test_former_tokens_those_of_another_role_and_old_cookies_are_no_guesses(stand: Stand, tmp_path: Path) -> None:
    old, viewer = stand.tokens[Role.OPERATOR], await stand.browser(Role.VIEWER)
    programs = [await stand.tool(Role.OPERATOR)]
    for _ in range(FREE_GUESSES + 2):  # as many former tokens, each by a program of its own
        stand.tokens[Role.OPERATOR] = rotate(tmp_path / TOKEN_FILE, Role.OPERATOR)
        programs.append(await stand.tool(Role.OPERATOR))
    await stand.look()
    right = programs.pop()
    for program in programs:
        assert [await stand.status(program) for _ in range(2)] == [401, 401]
    stand.tokens[Role.VIEWER] = rotate(tmp_path / TOKEN_FILE, Role.VIEWER)
    await stand.look()
    for _ in range(FREE_GUESSES + 2):
        assert await stand.status(viewer) == 401, "its cookie has ended"
    assert stand.rig.app is not None
    guesses = stand.rig.app[GUESSES]
    assert (guesses.total, len(guesses)) == (0, 0)
    assert await stand.status(right) == 200
    assert old not in (tmp_path / TOKEN_FILE).read_text()
    for number in range(FREE_GUESSES + 1):
        await stand.status(await stand.browser(headers={"Authorization": f"Bearer guess {number}"}))
    assert await stand.status(right) == 429, "true guesses are slowed"
