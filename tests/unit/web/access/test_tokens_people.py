"""People with a role for some lots: their tokens in the file, the command, and what a login of theirs opens."""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from hawk.cli import EXIT_USAGE, main
from hawk.comm.protocol.authority import Role
from hawk.lots.ingest import save
from hawk.lots.store import LotStore
from hawk.web.access.tokens import (
    LARGEST_BYTES,
    TOKEN_FILE,
    TokensError,
    read_tokens,
    remove_person,
    rotate,
    rotate_drone,
    rotate_person,
)
from hawk.web.v1.bounds import FOR_ALL_LOTS
from tests.unit.lots.repaints import by_place
from tests.unit.lots.surveys import survey
from tests.unit.web.rig import Rig, browser
from tests.unit.web.stand import Stand

NORTH = "n" * 36
SOUTH = "s" * 36


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / TOKEN_FILE


# -- the file ---------------------------------------------------------------------------------------------------------


def test_a_person_keeps_role_and_lots_beside_the_other_tokens(path: Path) -> None:
    operator, drone = rotate(path, Role.OPERATOR), rotate_drone(path, "Drone 1")
    token = rotate_person(path, "Ada", Role.VIEWER, [SOUTH, NORTH])
    tokens = read_tokens(path)
    assert token not in path.read_text()
    assert (tokens.role_of(operator), tokens.drone_of(drone)) == (Role.OPERATOR, "Drone 1")
    assert tokens.role_of(token) is None, "it is no role's for all lots"
    assert (tokens.person_of(token), tokens.people["Ada"].lots) == ("Ada", frozenset({NORTH, SOUTH}))
    assert tokens.person_of(token, Role.OPERATOR) is None
    remove_person(path, "Ada")
    tokens = read_tokens(path)
    assert tokens.person_of(token) is None
    assert tokens.is_or_was_one(token), "to send it again is no guess"
    with pytest.raises(TokensError, match=r"--name: no person is called 'Ada' .* there are none"):
        remove_person(path, "Ada")


def test_a_file_of_a_version_without_people_is_read(path: Path) -> None:
    token = rotate(path, Role.OPERATOR)
    held = json.loads(path.read_text())
    del held["people"]
    path.write_text(json.dumps(held))
    assert read_tokens(path).role_of(token) is Role.OPERATOR
    assert read_tokens(path).people == {}


@pytest.mark.parametrize("wrong", [{"lots": None}, {"lots": "all"}, {"lots": [7]}, {"role": "admin"}, {"role": None}])
def test_a_person_without_lots_or_role_opens_nothing(path: Path, wrong: dict[str, object]) -> None:
    rotate_person(path, "Ada", Role.VIEWER, [NORTH])
    held = json.loads(path.read_text())
    held["people"]["Ada"] |= wrong
    path.write_text(json.dumps(held))
    with pytest.raises(TokensError, match="is damaged"):
        read_tokens(path)


def test_a_file_that_would_be_too_large_to_be_read_is_not_written(path: Path) -> None:
    rotate(path, Role.OPERATOR)
    before = path.read_bytes()
    with pytest.raises(TokensError, match="has no room for more"):
        rotate_person(path, "Ada", Role.VIEWER, [f"{number:036}" for number in range(LARGEST_BYTES // 36)])
    assert path.read_bytes() == before


# -- the command ------------------------------------------------------------------------------------------------------


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a store of one lot, "Lot 1", and an operator's token."""

    async def fill() -> None:
        store = LotStore(tmp_path / "lots.db", by_place)
        await store.write(lambda connection: save(connection, survey(), store.register))
        await store.close()

    asyncio.run(fill())
    rotate(tmp_path / TOKEN_FILE, Role.OPERATOR)
    return tmp_path


def test_the_command_makes_lists_and_removes_a_person(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    store = ["--store", str(folder)]
    person = ["tokens", "rotate", "person", "--name", "Ada", "--role", "viewer", "--lot", "Lot 1"]
    assert main([*person, *store]) == 0
    said = capsys.readouterr()
    token = said.out.strip()
    assert "viewer for Lot 1: for nothing else" in said.err
    tokens = read_tokens(folder / TOKEN_FILE)
    assert tokens.person_of(token) == "Ada"
    (lot,) = tokens.people["Ada"].lots
    assert main(["tokens", "rotate", "person", "--name", "Ben", "--role", "operator", "--lot", lot, *store]) == 0
    rotate_drone(folder / TOKEN_FILE, "Drone 1")
    capsys.readouterr()
    assert main(["tokens", "list", *store]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.partition(", made ")[0] for line in lines] == [
        "operator", "person Ada, viewer for Lot 1", "person Ben, operator for Lot 1", "drone Drone 1"
    ]  # fmt: skip
    assert main(["tokens", "remove", "person", "--name", "Ada", *store]) == 0
    assert list(read_tokens(folder / TOKEN_FILE).people) == ["Ben"]


def test_a_new_token_for_other_lots_says_what_it_replaces(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rotate_person(folder / TOKEN_FILE, "Ada", Role.OPERATOR, [NORTH])
    person = ["tokens", "rotate", "person", "--name", "Ada", "--role", "viewer", "--lot", "Lot 1"]
    for words in (f"Before it was operator for {NORTH} (not there).", ""):
        assert main([*person, "--store", str(folder)]) == 0
        said = capsys.readouterr().err
        assert "viewer for Lot 1: for nothing else" in said
        assert [line for line in said.splitlines() if line.startswith("Before")] == ([words] if words else [])


def test_a_person_and_a_drone_have_no_name_in_common(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = folder / TOKEN_FILE
    rotate_drone(path, "Drone 1")
    rotate_person(path, "Ada", Role.VIEWER, [NORTH])
    before = path.read_bytes()
    for other, given in (
        ("drone", ["person", "--name", "Drone 1", "--role", "viewer", "--lot", "Lot 1"]),
        ("person", ["drone", "--name", "Ada"]),
    ):
        assert main(["tokens", "rotate", *given, "--store", str(folder)]) == EXIT_USAGE
        name = repr(given[2])
        assert f"--name: a {other} is called {name}: write another one" in capsys.readouterr().err
        assert path.read_bytes() == before


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (["rotate"], "tokens: say whose token: viewer, operator, person, drone"),
        (["rotate", "person", "--role", "viewer", "--lot", "Lot 1"], "--name: is missing: a person has a name"),
        (["rotate", "person", "--name", "Ada", "--lot", "Lot 1"], "--role: is missing"),
        (["rotate", "person", "--name", "Ada", "--role", "viewer"], "--lot: is missing"),
        (["rotate", "person", "--name", "Ada", "--role", "viewer", "--lot", "Lot 2"], "--lot: no lot is called"),
        (["rotate", "person", "--name", "operator", "--role", "viewer", "--lot", "Lot 1"], "send another name"),
        (["rotate", "viewer", "--lot", "Lot 1"], "--lot: only with tokens rotate person"),
        (["rotate", "drone", "--name", "Drone 1", "--role", "viewer"], "--role: only with tokens rotate person"),
        (["list", "--name", "Ada"], "tokens list: takes no more"),
    ],
)
def test_a_wrong_command_names_option_and_remedy(
    folder: Path, capsys: pytest.CaptureFixture[str], given: list[str], words: str
) -> None:
    before = (folder / TOKEN_FILE).read_bytes()
    with contextlib.suppress(SystemExit):  # of argparse
        assert main(["tokens", *given, "--store", str(folder)]) == EXIT_USAGE
    assert words in capsys.readouterr().err
    assert (folder / TOKEN_FILE).read_bytes() == before


# -- a login ----------------------------------------------------------------------------------------------------------


@pytest.fixture
async def stand(tmp_path: Path, rig: Rig) -> AsyncIterator[Stand]:
    rig.folder = tmp_path
    found = Stand(rig, tmp_path)
    await rig.start()
    yield found
    await found.close()


async def test_a_person_logs_in_by_form_link_and_header_until_the_token_is_another(
    stand: Stand, tmp_path: Path
) -> None:
    path = tmp_path / TOKEN_FILE
    token = rotate_person(path, "Ada", Role.VIEWER, [NORTH])
    await stand.look()
    assert stand.rig.server is not None
    url = stand.rig.server.make_url
    form, link = await stand.browser(), await stand.browser()
    tool = await stand.browser(headers={"Authorization": f"Bearer {token}"})
    for role, status in (("operator", 401), ("viewer", 200)):
        answer = await form.post(
            url("/login"), data={"username": role, "password": token}, headers={"Origin": str(url("/"))[:-1]}
        )
        assert answer.status == status, "a token proves its own role alone"
    await link.get(url(f"/?token={token}"))
    for session, is_login in ((form, True), (link, True), (tool, False)):
        async with session.get(url("/api/session")) as answer:
            assert await answer.json() == {"role": "viewer", "login": is_login, "person": "Ada"}
    rotate_person(path, "Ada", Role.VIEWER, [NORTH, SOUTH])
    await stand.look()
    assert [await stand.status(each) for each in (form, link, tool)] == [401, 401, 401]


async def test_a_link_gives_more_and_never_takes_lots_away(stand: Stand, tmp_path: Path) -> None:
    path = tmp_path / TOKEN_FILE
    tokens = {role: rotate_person(path, f"Ada the {role}", role, [NORTH]) for role in Role}
    await stand.look()
    assert stand.rig.server is not None
    url = stand.rig.server.make_url

    async def after(*given: str) -> tuple[str, str]:
        async with browser() as session:
            for token in given:
                await session.get(url(f"/?token={token}"))
            async with session.get(url("/api/session")) as answer:
                found = await answer.json()
                return found["role"], found["person"]

    some, every = tokens, stand.tokens
    viewer, operator = Role.VIEWER, Role.OPERATOR
    assert await after(some[viewer], every[operator]) == ("operator", "")
    assert await after(some[viewer], some[operator]) == ("operator", "Ada the operator")
    assert await after(some[operator], every[operator]) == ("operator", "")
    assert await after(some[operator], every[viewer]) == ("operator", "Ada the operator"), "who may change keeps that"
    assert await after(every[viewer], some[operator]) == ("viewer", ""), "who may see all lots keeps that"
    assert await after(every[operator], some[operator]) == ("operator", "")


@pytest.mark.fault(
    "a person with a role for some lots asks for what is no view of lots: socket, pictures, map, metrics, recordings",
    "403 before anything of it is read; no command reaches the drone",
)
async def test_a_role_for_some_lots_opens_the_page_and_nothing_of_the_drone(stand: Stand, tmp_path: Path) -> None:
    token = rotate_person(tmp_path / TOKEN_FILE, "Ada", Role.OPERATOR, [NORTH])
    await stand.look()
    assert stand.rig.server is not None
    assert stand.rig.app is not None
    session = await stand.browser(headers={"Authorization": f"Bearer {token}"})
    beside = {route.resource.canonical for route in stand.rig.app.router.routes() if route.resource is not None}
    beside = {each for each in beside if not each.startswith(("/api/v1/", "/docs"))}
    assert {"/ws", "/video", "/stream.mjpg", "/metrics"} <= beside
    opened = {"/login", "/login.css", "/logout", "/api/session", "/api/alive", "/register_service", "/shared"}
    for each in [*sorted(beside - opened - {"/{path}"}), "/static.json", "/.env", "/licences.txt"]:
        for method in ("GET", "POST"):
            async with session.request(method, stand.rig.server.make_url(each)) as answer:
                assert answer.status == 403, (method, each, await answer.text())
                assert await answer.text() == FOR_ALL_LOTS
    for path in ("/", "/ws", "/api/session"):
        upgrade = {"Upgrade": "websocket", "Connection": "Upgrade"}
        async with session.get(stand.rig.server.make_url(path), headers=upgrade) as answer:
            assert answer.status == 403, path
    assert await stand.status(session, "/") == 200
    assert len(stand.rig.side.hub) == 0
