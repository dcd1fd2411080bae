"""Recordings of surveys that come to a desk: asked for, by parts, whole or not there."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from aiohttp import web

from hawk.comm.protocol.authority import Role
from hawk.config.sections import StoreSettings
from hawk.store.recording_request import ASKED
from hawk.store.recording_requests import RecordingRequests
from hawk.store.recordings import Recordings
from hawk.web.access.tokens import TOKEN_FILE, remove_drone
from hawk.web.v1.desk import file_transfer
from tests.sweep import sweep
from tests.unit.store.recorded import recorded
from tests.unit.web.rig import Rig
from tests.unit.web.v1.centre import ONE, OTHER, Centre

NAME = "20260501T100000Z.mcap"


def recording_of(path: Path, journal: str) -> bytes:
    """Return a recording of a survey's journal, some kilobytes."""
    data = recorded(path, journal, range(40), "x" * 100)
    path.unlink()
    return data


def digest_of(data: bytes) -> str:
    return f"sha-256=:{base64.b64encode(hashlib.sha256(data).digest()).decode()}:"


@dataclass
class Asking:
    """A desk with the survey of a drone, and the recording of it that the drone has."""

    centre: Centre
    folder: Path
    survey: str
    data: bytes

    async def ask(self, ask: bool = True, role: Role = Role.OPERATOR) -> tuple[int, dict[str, Any]]:
        path = self.centre.url(f"/api/v1/surveys/{self.survey}/recordings/ask")
        async with await self.centre.stand.tool(role) as person, person.post(path, json={"asked": ask}) as answer:
            return answer.status, await answer.json()

    async def change(self, path: str) -> dict[str, Any]:
        """Delete the survey, or undo that, as an operator."""
        async with (
            await self.centre.stand.tool(Role.OPERATOR) as person,
            person.post(self.centre.url(f"/api/v1/{path}"), json={}) as answer,
        ):
            assert answer.status == 200
            found: dict[str, Any] = await answer.json()
            return found

    async def state(self) -> tuple[str, int, int | None]:
        path = self.centre.url(f"/api/v1/surveys/{self.survey}/recordings")
        async with await self.centre.stand.tool(Role.VIEWER) as person, person.get(path) as answer:
            found = await answer.json()
            return found["state"], found["stored"], found["bytes"]

    async def waiting(self, drone: str = ONE) -> str | None:
        """Return the header by which a drone learns what is asked for."""
        async with (
            self.centre.tool(self.centre.tokens[drone]) as session,
            session.get(self.centre.url("/api/v1/lots/documents")) as answer,
        ):
            assert answer.status == 200
            return answer.headers.get(ASKED)

    async def offer(self, *sizes: int, drone: str = ONE, name: str = NAME, **more: str) -> tuple[int, dict[str, Any]]:
        body = {"recordings": [{"name": name, "bytes": size} for size in sizes], **more}
        path = self.centre.url(f"/api/v1/surveys/{self.survey}/recordings")
        async with self.centre.tool(self.centre.tokens[drone]) as session, session.put(path, json=body) as answer:
            return answer.status, await answer.json()

    async def part(
        self, start: int, end: int, *, drone: str = ONE, name: str = NAME, size: int | None = None,
        data: bytes | None = None,
    ) -> tuple[int, dict[str, Any]]:  # fmt: skip
        whole = self.data if data is None else data
        path = self.centre.url(f"/api/v1/surveys/{self.survey}/recordings/{name}")
        headers = {
            "Content-Range": f"bytes {start}-{end - 1}/{len(whole) if size is None else size}",
            "Repr-Digest": digest_of(whole),
        }
        async with (
            self.centre.tool(self.centre.tokens[drone]) as session,
            session.put(path, data=whole[start:end], headers=headers) as answer,
        ):
            return answer.status, await answer.json()

    def files(self) -> dict[str, bytes]:
        """Return what lies in the folder of recordings, but for what is written of requests."""
        found = (path for path in self.folder.rglob("*") if path.is_file() and path.suffix != ".json")
        return {path.relative_to(self.folder).as_posix(): path.read_bytes() for path in sorted(found)}


@pytest.fixture
async def asking(tmp_path: Path, rig: Rig, centre: Centre) -> Asking:
    document = centre.documents()[0]
    await centre.send(document)
    return Asking(
        centre, tmp_path / "recordings", document.survey.id, recording_of(tmp_path / "r", document.survey.name)
    )


@pytest.fixture
def rig(tmp_path: Path) -> Rig:
    made, settings = Rig(), StoreSettings(directory=tmp_path, recordings_gb=0.1, minimum_free_mb=1)
    made.recordings = Recordings(settings)
    made.recording_requests = RecordingRequests(made.recordings, settings, lambda _: made.free)
    return made


async def test_a_recording_comes_by_parts_when_it_is_asked_for(asking: Asking) -> None:
    assert await asking.state() == ("none", 0, None)
    assert await asking.waiting() is None
    status, answer = await asking.ask()
    assert (status, answer["state"], answer["drone"]) == (200, "asked", ONE)
    assert (await asking.waiting(), await asking.waiting(OTHER)) == (asking.survey, None)
    size = len(asking.data)
    assert (await asking.offer(size))[1]["recordings"] == [{"name": NAME, "stored": 0, "bytes": size}]
    assert (await asking.part(0, 1000))[1]["stored"] == 1000
    assert await asking.state() == ("coming", 1000, size)
    assert (await asking.part(0, 1000))[1]["stored"] == 1000, "a part that comes twice changes nothing"
    assert (await asking.offer(size))[1]["recordings"][0]["stored"] == 1000
    assert (await asking.part(1000, size))[0] == 200
    assert await asking.state() == ("here", size, size)
    assert asking.files() == {NAME: asking.data}
    assert await asking.waiting() is None
    async with await asking.centre.stand.tool(Role.VIEWER) as person:
        rows = await (await person.get(asking.centre.url("/api/v1/recordings"))).json()
    (row,) = rows["items"]
    assert (row["name"], row["drone"], row["lot"]["survey"]) == (NAME, ONE, asking.survey)
    arrival = (await asking.centre.arrivals())[-1]
    assert (arrival["kind"], arrival["name"], arrival["outcome"]) == ("recording", asking.survey, "taken")


async def test_one_that_is_asked_for_by_nobody_changes_nothing(asking: Asking) -> None:
    size = len(asking.data)
    assert (await asking.ask(role=Role.VIEWER))[0] == 403
    for status, problem in (await asking.offer(size), await asking.part(0, size)):
        assert (status, problem["field"]) == (409, "id")
        assert "nobody asks for its recordings" in problem["detail"]
    await asking.ask()
    await asking.offer(size)
    await asking.part(0, 1000)
    assert (await asking.ask(ask=False))[1]["state"] == "none"
    assert asking.files() == {}
    assert (await asking.part(1000, size))[0] == 409
    assert asking.files() == {}


@pytest.fixture
async def begun(asking: Asking) -> Asking:
    """The first part of the recording is here."""
    await asking.ask()
    await asking.offer(len(asking.data))
    await asking.part(0, 1000)
    return asking


@sweep(
    ("given", "status", "field"),
    [
        ({"drone": OTHER, "start": 1000, "end": 2000}, 403, "id"),
        ({"name": "20260501T100001Z.mcap", "start": 0, "end": 2000}, 409, "name"),
        ({"name": "..%2F..%2Flots.db", "start": 0, "end": 2000}, 403, ""),
        ({"name": "20260501.mcap", "start": 0, "end": 2000}, 403, ""),
        ({"start": 500, "end": 2000}, 409, "Content-Range"),
        ({"start": 1500, "end": 2000}, 409, "Content-Range"),
        ({"start": 1000, "end": 2000, "size": 10**15}, 422, "Content-Range"),
        ({"start": 1000, "end": 2000, "size": 1500}, 422, "Content-Range"),
        ({"start": 1000, "end": 2000, "data": b"y" * 5000}, 422, "Content-Range"),
    ],
)
async def test_a_part_that_does_not_fit_is_refused_in_words(
    begun: Asking, given: dict[str, Any], status: int, field: str
) -> None:
    before = begun.files()
    found, problem = await begun.part(**given)
    assert (found, problem["field"]) == (status, field)
    assert problem["detail"]
    assert begun.files() == before
    assert list(before.values()) == [begun.data[:1000]]


async def test_the_token_that_was_removed_midway_sends_no_more(asking: Asking) -> None:
    await asking.ask()
    await asking.offer(len(asking.data))
    await asking.part(0, 1000)
    remove_drone(asking.centre.folder / TOKEN_FILE, ONE)
    await asking.centre.stand.look()
    assert (await asking.part(1000, 2000))[0] == 401
    assert list(asking.files().values()) == [asking.data[:1000]]


async def test_without_room_nothing_is_taken_and_the_desk_says_why(asking: Asking, rig: Rig) -> None:
    await asking.ask()
    for size, free in ((10**15, 10**12), (len(asking.data), 1000)):
        rig.free = free
        status, problem = await asking.offer(size)
        assert status == 507
        assert ("store.recordings_gb" if size == 10**15 else "disk is full") in problem["detail"]
    async with await asking.centre.stand.tool(Role.OPERATOR) as person:
        path = asking.centre.url(f"/api/v1/surveys/{asking.survey}/recordings")
        assert "disk is full" in (await (await person.get(path)).json())["problem"]
    rig.free = 10**12
    assert (await asking.offer(len(asking.data)))[0] == 200
    rig.free = 1000
    assert (await asking.part(0, 1000))[0] == 507
    assert asking.files() == {}


async def test_what_is_not_what_it_says_it_is_goes_and_another_file_begins_at_its_start(asking: Asking) -> None:
    size = len(asking.data)
    await asking.ask()
    await asking.offer(size)
    await asking.part(0, 1000)
    other = bytes([asking.data[0] ^ 1]) + asking.data[1:]
    assert (await asking.part(1000, size, data=other))[0] == 409, "of another file than before"
    assert (await asking.part(0, size, data=other))[0] == 422, "no recording"
    assert asking.files() == {}
    strange = recording_of(asking.folder.parent / "r", "000009-another-day")
    await asking.offer(len(strange))
    status, problem = await asking.part(0, len(strange), data=strange)
    assert (status, problem["field"]) == (422, "name")
    assert "of another survey" in problem["detail"]
    assert asking.files() == {}
    await asking.offer(size)
    assert (await asking.part(0, size))[0] == 200
    assert asking.files() == {NAME: asking.data}


@pytest.mark.parametrize("answer", ["never", "gone"])
async def test_a_drone_that_gives_none_says_so_and_may_be_asked_again(asking: Asking, answer: str) -> None:
    await asking.ask()
    assert (await asking.offer(answer=answer))[0] == 200
    assert await asking.state() == (answer, 0, None)
    assert await asking.waiting() is None
    assert (await asking.ask())[1]["state"] == "asked"


async def test_only_a_survey_that_a_drone_sent_can_be_asked_for(asking: Asking) -> None:
    await asking.centre.store.read(lambda _: None)
    asking.survey = "00000000-0000-4000-8000-000000000000"
    assert (await asking.ask())[0] == 404
    assert json.dumps(await asking.waiting()) == "null"


async def test_a_deleted_survey_ends_its_request_until_that_is_undone(asking: Asking) -> None:
    size = len(asking.data)
    await asking.ask()
    await asking.offer(size)
    await asking.part(0, 1000)
    deleted = await asking.change(f"surveys/{asking.survey}/delete")
    status, problem = await asking.part(1000, size)
    assert (status, problem["field"]) == (409, "id")
    assert "deleted at the desk, and nobody asks for its recordings" in problem["detail"]
    assert (asking.files(), await asking.state(), await asking.waiting()) == ({}, ("none", 0, None), None)
    status, problem = await asking.ask()
    assert (status, "was deleted: undo that" in problem["detail"]) == (409, True)
    await asking.change(f"changes/{deleted['seq']}/undo")
    assert await asking.waiting() is None
    assert (await asking.ask())[1]["state"] == "asked"
    await asking.change(f"surveys/{asking.survey}/delete")
    assert await asking.waiting() is None
    assert (await asking.offer(size))[0] == 409


async def test_a_survey_that_is_deleted_while_the_last_part_comes_gets_no_recording(
    asking: Asking, monkeypatch: pytest.MonkeyPatch
) -> None:
    size = len(asking.data)
    await asking.ask()
    await asking.offer(size)

    async def receive(request: web.Request, write: Callable[[bytes], Awaitable[object]]) -> None:
        await file_transfer.receive(request, write)
        await asking.change(f"surveys/{asking.survey}/delete")

    monkeypatch.setattr("hawk.web.v1.recordings.requests.receive", receive)
    assert (await asking.part(0, size))[0] == 409
    assert asking.files() == {}


async def test_an_offer_that_names_one_recording_twice_is_refused(asking: Asking) -> None:
    await asking.ask()
    status, problem = await asking.offer(100, len(asking.data))
    assert (status, problem["field"]) == (422, "recordings")
    assert f"has {NAME} twice: offer each recording once" in problem["detail"]
    assert await asking.state() == ("asked", 0, None)


async def test_a_recording_of_the_name_of_another_gets_another_name(asking: Asking) -> None:
    size = len(asking.data)
    asking.folder.mkdir()
    (asking.folder / NAME).write_bytes(b"another drone's")
    await asking.ask()
    await asking.offer(size)
    await asking.part(0, size)
    assert asking.files() == {NAME: b"another drone's", "20260501T100000Z-2.mcap": asking.data}
