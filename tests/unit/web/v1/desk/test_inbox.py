"""Pictures that a program sends to a desk: whole or not there, by a token of its own, within limits."""

from __future__ import annotations

import asyncio
import errno
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import aiohttp
import pytest

from hawk.comm.protocol.authority import Role
from hawk.store.inbox import FileWriter, InboxFolder, InboxQuota
from hawk.web.access.tokens import TOKEN_FILE, rotate_drone
from tests.unit.web.rig import Rig
from tests.unit.web.stand import Stand

QUOTA = InboxQuota(largest=100_000, most_bytes=250_000, most_files=4)
PICTURE = b"\xff\xd8" + bytes(60_000) + b"\xff\xd9"


@dataclass
class Desk:
    """A desk with an inbox, and the tokens of two programs."""

    stand: Stand
    folder: InboxFolder
    tokens: dict[str, str]

    async def put(
        self, name: str, data: Any = PICTURE, token: str | None = None, **headers: str
    ) -> tuple[int, dict[str, Any]]:
        assert self.stand.rig.server is not None
        path, _, query = name.partition("?")
        url = self.stand.rig.server.make_url("/").with_path(f"/api/v1/inbox/{path}", encoded=True).with_query(query)
        given = {"Authorization": f"Bearer {self.tokens['dock'] if token is None else token}", **headers}
        async with (
            aiohttp.ClientSession() as session,
            session.put(url, data=data, headers=given) as answer,
        ):
            return answer.status, await answer.json()

    def files(self) -> dict[str, int]:
        found = (path for path in sorted(self.folder.path.rglob("*")) if path.is_file())
        return {path.relative_to(self.folder.path).as_posix(): path.stat().st_size for path in found}


@pytest.fixture
async def desk(tmp_path: Path, rig: Rig) -> AsyncIterator[Desk]:
    path = tmp_path / "inbox"
    path.mkdir()
    rig.folder, rig.inbox = tmp_path, InboxFolder(path, QUOTA)
    stand = Stand(rig, tmp_path)
    tokens = {name: rotate_drone(tmp_path / TOKEN_FILE, name) for name in ("dock", "phone")}
    await rig.start()
    yield Desk(stand, rig.inbox, tokens)
    await stand.close()


async def test_a_file_lies_in_the_inbox_once_it_is_answered(desk: Desk) -> None:
    assert await desk.put("DJI_0001.JPG") == (200, {"name": "DJI_0001.JPG", "flight": None, "bytes": len(PICTURE)})
    status, answer = await desk.put("DJI_0001.JPG?flight=monday")
    assert (status, answer["flight"]) == (200, "monday")
    assert (await desk.put("DJI_0001.JPG?flight=monday"))[0] == 200
    status, problem = await desk.put("DJI_0001.JPG?flight=monday", b"other")
    assert (status, problem["field"]) == (409, "flight")
    assert "name the flight of this one" in problem["detail"]
    assert desk.files() == {"DJI_0001.JPG": len(PICTURE), "monday/DJI_0001.JPG": len(PICTURE)}


@pytest.mark.parametrize(
    ("name", "field"),
    [
        ("..%2Fa.jpg", "file"),
        ("%2e%2e%2f%2e%2e%2fetc%2fpasswd", "file"),
        ("a%00.jpg", "file"),
        (".hidden.jpg", "file"),
        ("done", "file"),
        ("a.jpg?flight=..", "flight"),
        ("a.jpg?flight=../..", "flight"),
        ("a.jpg?flight=failed", "flight"),
        ("a.jpg?flight=", "flight"),
    ],
)
async def test_a_name_that_leads_elsewhere_is_refused(desk: Desk, name: str, field: str) -> None:
    status, problem = await desk.put(name)
    if "%2f" in name.lower() and field == "file":
        assert status == 403, "no address of a program's token"
    else:
        assert (status, problem["field"]) == (422, field)
    assert desk.files() == {}


async def test_what_is_too_large_or_too_much_is_refused_in_words(desk: Desk) -> None:
    status, problem = await desk.put("a.jpg", bytes(100_001))
    assert (status, problem["field"]) == (413, "file")
    assert "0.0001 GB are taken at most (inbox.largest_gb)" in problem["detail"]
    for number in range(4):
        assert (await desk.put(f"{number}.jpg"))[0] == 200
    status, problem = await desk.put("more.jpg", b"1")
    assert status == 507
    assert "inbox.most_files" in problem["detail"]
    assert len(desk.files()) == 4


async def test_an_empty_file_is_refused(desk: Desk) -> None:
    status, problem = await desk.put("DJI_0001.JPG", b"")
    assert (status, problem["field"]) == (422, "file")
    assert "is empty: send it again" in problem["detail"]
    assert desk.files() == {}


async def test_a_file_without_its_size_is_refused(desk: Desk) -> None:
    async def parts() -> AsyncIterator[bytes]:
        yield PICTURE

    status, problem = await desk.put("a.jpg", parts())
    assert status == 411
    assert "Content-Length" in problem["detail"]
    assert desk.files() == {}


async def test_a_connection_that_is_cut_leaves_nothing(desk: Desk) -> None:
    assert desk.stand.rig.server is not None
    reader, writer = await asyncio.open_connection("127.0.0.1", desk.stand.rig.server.port)
    head = (
        f"PUT /api/v1/inbox/a.jpg HTTP/1.1\r\nHost: 127.0.0.1:{desk.stand.rig.server.port}\r\n"
        f"Authorization: Bearer {desk.tokens['dock']}\r\nContent-Length: 60000\r\n\r\n"
    )
    writer.write(head.encode() + bytes(30_000))
    await writer.drain()
    async with asyncio.timeout(10.0):
        while not desk.files():  # noqa: ASYNC110 - until it is begun
            await asyncio.sleep(0.01)
        assert list(desk.files()) != ["a.jpg"], "under another name until it is whole"
        writer.close()
        while desk.files():  # noqa: ASYNC110
            await asyncio.sleep(0.01)
    del reader
    assert (await desk.put("a.jpg"))[0] == 200, "the program may send again at once"


async def test_a_disk_that_fills_while_a_file_comes_is_a_problem_in_words(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(_: FileWriter, __: bytes) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(FileWriter, "write", full)
    status, problem = await desk.put("a.jpg")
    assert status == 507
    assert "The disk of the inbox is full" in problem["detail"]
    assert desk.files() == {}


async def test_a_program_sends_one_file_at_a_time(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    goes_on = asyncio.Event()

    async def slowly() -> AsyncIterator[bytes]:
        yield PICTURE[:10]
        await goes_on.wait()
        yield PICTURE[10:]

    first = asyncio.create_task(desk.put("a.jpg", slowly(), **{"Content-Length": str(len(PICTURE))}))
    while not desk.files():  # noqa: ASYNC110 - until it is begun
        await asyncio.sleep(0.01)
    assert (await desk.put("b.jpg"))[0] == 503
    assert (await desk.put("b.jpg", token=desk.tokens["phone"]))[0] == 200
    goes_on.set()
    assert (await first)[0] == 200
    assert set(desk.files()) == {"a.jpg", "b.jpg"}


@pytest.mark.fault("a stranger or a person sends pictures into the inbox", "refused: a program has a token of its own")
async def test_who_has_no_token_of_a_program_writes_nothing(desk: Desk) -> None:
    assert (await desk.put("a.jpg", token="a-guess-of-a-token"))[0] == 401
    for role in Role:
        status, problem = await desk.put("a.jpg", token=desk.stand.tokens[role])
        assert status == 403
        assert "drones and programs" in problem["detail"]
    status, problem = await desk.put("a.jpg", **{"X-Forwarded-For": "192.0.2.1"})
    assert status == 403
    assert "HTTPS" in problem["detail"]
    assert (await desk.put("a.jpg", Origin="https://elsewhere.example"))[0] == 403
    assert desk.files() == {}


async def test_without_an_inbox_the_setting_is_named(tmp_path: Path, rig: Rig) -> None:
    rig.folder = tmp_path
    stand = Stand(rig, tmp_path)
    tokens = {"dock": rotate_drone(tmp_path / TOKEN_FILE, "dock")}
    await rig.start()
    status, problem = await Desk(stand, InboxFolder(tmp_path, QUOTA), tokens).put("a.jpg")
    assert status == 409
    assert "inbox.folder" in problem["detail"]
    await stand.close()
