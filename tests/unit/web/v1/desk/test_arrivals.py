"""Attacks on a desk that collects, at its front door: each is refused or changes nothing, slowed, and logged."""

from __future__ import annotations

import gzip
import json
from pathlib import Path
from typing import Any

import pytest

from hawk.comm.protocol.authority import Role
from hawk.lots.documents import parts
from hawk.lots.documents.lot_document import LotDocument
from hawk.lots.values import StoreFullError
from hawk.store.inbox import InboxFolder, InboxQuota
from hawk.web.access.tokens import TOKEN_FILE, remove_drone
from tests.unit.lots.documents.tables import tables
from tests.unit.web.v1.centre import ONE, OTHER, Centre

pytestmark = pytest.mark.slow
WORDS = ("sender", "kind", "name", "outcome", "times")
ELSEWHERE = "123e4567-e89b-42d3-a456-426614174000"


@pytest.fixture
def inbox(tmp_path: Path, rig: Any) -> Path:
    """The folder of an inbox, beside files that are nobody's."""
    path = tmp_path / "inbox"
    path.mkdir()
    rig.inbox = InboxFolder(path, InboxQuota(largest=100_000, most_bytes=250_000, most_files=4), lambda _: 10**12)
    return path


def shown(found: list[dict[str, Any]]) -> list[tuple[Any, ...]]:
    return [tuple(each[name] for name in WORDS) for each in found]


async def put(centre: Centre, path: str, data: bytes, token: str) -> tuple[int, dict[str, Any], str]:
    """Send to an address as it is written; return status, answer and the wait that it asks for."""
    path, _, query = path.partition("?")
    assert centre.stand.rig.server is not None
    url = centre.stand.rig.server.make_url("/").with_path(path, encoded=True).with_query(query)
    async with centre.tool(token) as session, session.put(url, data=data) as answer:
        return answer.status, json.loads(await answer.text()), answer.headers.get("Retry-After", "")


async def slowed(centre: Centre, path: str, data: bytes, token: str, status: int) -> int:
    """Send the same until it has to wait; return the number that was looked at, and be past the wait."""
    for number in range(10):
        found, answer, wait = await put(centre, path, data, token)
        if found == 429:
            assert "wait" in answer["detail"]
            centre.stand.rig.real.advance(float(wait))
            return number
        assert found == status
    raise AssertionError("ten of them, and no wait")


@pytest.mark.fault("a drone sends another drone's survey", "refused, slowed, and in the log of arrivals")
async def test_another_drones_survey(centre: Centre) -> None:
    first, second = centre.documents()
    assert (await centre.send(first))[0] == 200
    before = await centre.store.read(tables)
    forged = first.model_copy(update={"survey": first.survey.model_copy(update={"state": 10**6})})
    path = f"/api/v1/surveys/{first.survey.id}/document"
    looked_at = await slowed(centre, path, parts.packed(forged), centre.tokens[OTHER], 403)
    assert looked_at == 6
    assert await centre.store.read(tables) == before
    assert (await centre.send(second))[0] == 200, "the other drone waits for nothing"
    assert shown(await centre.arrivals()) == [
        (ONE, "survey", first.survey.id, "taken", 1),
        (OTHER, "survey", first.survey.id, "refused", looked_at),
        (ONE, "survey", second.survey.id, "taken", 1),
    ]
    (refused,) = await centre.arrivals(sender=OTHER, outcome="refused")
    assert refused["reason"] == "survey.id: this survey is another's: a drone sends its own surveys alone"


@pytest.mark.fault(
    "documents of last month are sent again, also by a token that was removed",
    "nothing changes by what is older or known, a removed token is refused; all is in the log of arrivals",
)
async def test_documents_of_last_month(centre: Centre) -> None:
    first, _ = centre.documents()
    newer = first.model_copy(update={"survey": first.survey.model_copy(update={"state": first.survey.state + 5})})
    lots = LotDocument(format="hawk lots", version=1, state=first.lots[0].state, lots=first.lots)
    lot_path = f"/api/v1/lots/{first.lots[0].id}/document"
    assert (await centre.send(newer))[0] == 200
    before = await centre.store.read(tables)
    for replayed in (first, newer):
        assert await centre.send(replayed) == (
            200, {"survey": first.survey.id, "state": newer.survey.state, "lot": first.survey.lot},
        )  # fmt: skip
    assert (await put(centre, lot_path, parts.packed(lots), centre.tokens[ONE]))[0] == 200
    remove_drone(centre.folder / TOKEN_FILE, ONE)
    await centre.stand.look()
    assert (await centre.send(first))[0] == 401
    assert await centre.store.read(tables) == before
    assert shown(await centre.arrivals()) == [
        (ONE, "survey", first.survey.id, "taken", 1),
        (ONE, "survey", first.survey.id, "older", 1),
        (ONE, "survey", first.survey.id, "known", 1),
        (ONE, "lot", first.lots[0].id, "known", 1),
        ("", "survey", first.survey.id, "refused", 1),
    ]


@pytest.mark.fault("a drone sends a bomb: some kilobytes that unpack to gigabytes", "refused, slowed, and logged")
@pytest.mark.parametrize("bomb", ["bytes", "values"])
async def test_a_bomb(centre: Centre, bomb: str) -> None:
    first, _ = centre.documents()
    if bomb == "bytes":
        data, words = gzip.compress(bytes(100_000_000), 1), "document: is too large: it unpacks to more than 96 MB"
    else:
        begin = b'{"format":"hawk survey","version":1,"survey":['
        data, words = gzip.compress(begin + b"[1]," * 2_000_000 + b"1]}", 1), "document: is too large: 3,000,000 values"
    assert len(data) < 1_000_000
    path = f"/api/v1/surveys/{first.survey.id}/document"
    looked_at = await slowed(centre, path, data, centre.tokens[ONE], 422)
    assert shown(found := await centre.arrivals()) == [(ONE, "survey", first.survey.id, "refused", looked_at)]
    assert found[0]["reason"].startswith(words)
    assert (await centre.send(first))[0] == 200


@pytest.mark.fault("a name with ../ comes to a desk", "refused, slowed, and logged; no file lies anywhere")
async def test_a_name_with_dots(inbox: Path, centre: Centre) -> None:
    first, _ = centre.documents()
    named = json.loads(first.model_dump_json())
    named["survey"]["name"] = "../../etc"
    asked = {
        "/api/v1/inbox/..%2F..%2Fetc%2Fpasswd": (403, "other", "PUT /api/v1/inbox/..%2F..%2Fetc%2Fpasswd"),
        "/api/v1/inbox/a.jpg?flight=../..": (422, "file", "../../a.jpg"),
        f"/api/v1/surveys/{first.survey.id}/document": (422, "survey", first.survey.id),
        "/api/v1/surveys/..%2F..%2Fetc/document": (403, "other", "PUT /api/v1/surveys/..%2F..%2Fetc/document"),
        "/api/v1/inbox/..": (422, "file", ".."),
    }
    before = {path for path in centre.folder.rglob("*") if path.is_file()}
    for path, (status, _, _) in asked.items():
        found, problem, _ = await put(centre, path, gzip.compress(json.dumps(named).encode()), centre.tokens[ONE])
        assert (path, found) == (path, status), problem
    assert await slowed(centre, "/api/v1/inbox/a.jpg?flight=..", b"1", centre.tokens[ONE], 422) == 1
    logged = await centre.arrivals()
    assert [(each["kind"], each["name"], each["outcome"]) for each in logged[:5]] == [
        (kind, name, "refused") for _, kind, name in asked.values()
    ]
    assert "survey.name: must be a name without / and .." in logged[2]["reason"]
    made = {path for path in centre.folder.rglob("*") if path.is_file()} - before
    assert {path.name for path in made} <= {"lots.db", "lots.db-wal", "lots.db-shm"}
    assert not [path for path in made if inbox in path.parents]


@pytest.mark.fault("a drone sends a plan for another's lot", "it waits for a person, changes nothing, and is logged")
async def test_a_plan_for_anothers_lot(centre: Centre) -> None:
    first, _ = centre.documents()
    assert (await centre.send(first))[0] == 200
    before = await centre.store.read(tables)
    lot = first.lots[0].model_copy(update={"name": "Mine now", "state": 10**6, "stalls": first.lots[0].stalls[1:]})
    lots = LotDocument(format="hawk lots", version=1, state=10**6, lots=(lot,))
    path = f"/api/v1/lots/{lot.id}/document"
    for _ in range(2):
        status, answer, _ = await put(centre, path, parts.packed(lots), centre.tokens[OTHER])
        assert (status, answer["keeps_plan"]) == (200, True)
    after = await centre.store.read(tables)
    assert {**after, "lot_document": []} == {**before, "lot_document": []}
    assert shown(await centre.arrivals(lot=lot.id)) == [
        (ONE, "survey", first.survey.id, "taken", 1),
        (OTHER, "lot", lot.id, "waits", 1),
        (OTHER, "lot", lot.id, "known", 1),
    ]
    wrong = f"/api/v1/lots/{ELSEWHERE}/document"
    assert await slowed(centre, wrong, parts.packed(lots), centre.tokens[OTHER], 422) == 6
    assert (await centre.arrivals(outcome="refused"))[0]["lot"] == ELSEWHERE


@pytest.mark.fault("a token is guessed at a desk", "refused, slowed, and logged without a name and the guess")
async def test_a_guessed_token(centre: Centre) -> None:
    first, _ = centre.documents()
    found = [(await centre.send(first, f"guess-number-{number}"))[0] for number in range(8)]
    assert found == [401] * 6 + [429] * 2
    centre.stand.rig.real.advance(1.0)
    assert (await centre.send(first, "guess-number-9"))[0] == 401
    assert (await centre.send(first))[0] == 429, "the address waits, whatever it sends"
    centre.stand.rig.real.advance(2.0)
    assert (await centre.send(first))[0] == 200
    logged, taken = await centre.arrivals()
    assert (logged["sender"], logged["outcome"], logged["times"]) == ("", "refused", 9), "those that waited are counted"
    assert logged["reason"] == "A token that is not known here, or was removed, from 127.0.0.1."
    assert (taken["sender"], taken["outcome"]) == (ONE, "taken")


@pytest.mark.fault("a drone's token asks for what is not for drones, without end", "refused; the log is not filled")
async def test_requests_without_end_do_not_fill_the_log(centre: Centre) -> None:
    async with centre.tool(centre.tokens[ONE]) as session:
        for number in range(40):
            async with session.get(centre.url(f"/api/v1/surveys?limit={number}")) as answer:
                assert answer.status == 403
    assert shown(await centre.arrivals()) == [(ONE, "other", "GET /api/v1/surveys", "refused", 6)]


async def test_arrivals_are_for_operators(centre: Centre) -> None:
    for token, status in ((centre.stand.tokens[Role.VIEWER], 403), (centre.tokens[ONE], 403), ("none", 401)):
        async with centre.tool(token) as session, session.get(centre.url("/api/v1/documents")) as answer:
            assert answer.status == status
    async with await centre.stand.tool(Role.OPERATOR) as operator:
        for query, field in (("outcome=gone", "outcome"), ("lot=x", "lot"), ("after=x", "after")):
            async with operator.get(centre.url(f"/api/v1/documents?{query}")) as answer:
                assert (answer.status, (await answer.json())["field"]) == (422, field)


async def test_what_a_full_disk_or_a_closed_store_does_not_log_is_refused_all_the_same(
    centre: Centre, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    async def full(*_: object) -> None:
        raise StoreFullError("lots.db cannot grow: the disk is full")

    monkeypatch.setattr(centre.store, "note", full)
    first, _ = centre.documents()
    assert (await centre.put(b"no document", first.survey.id))[0] == 422
    assert "what came from Drone 1 is not in the log of arrivals: lots.db cannot grow" in caplog.text
