from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator
from pathlib import Path

import aiohttp
import pytest

from hawk.comm.protocol.authority import Role
from hawk.comm.protocol.command_table import COMMAND_TABLE
from hawk.lots.documents import lot_document, parts, source, survey_document
from hawk.lots.documents.lot_document import LotDocument, plan_digest
from hawk.lots.store import LotStore
from hawk.lots.survey.pictures import pictures_of
from hawk.web.access.tokens import TOKEN_FILE, remove_drone, rotate_drone
from hawk.web.v1.desk.documents import FOR_DRONES_ALONE
from hawk.web.v1.table import OPERATIONS
from tests.unit.lots.documents.drones import tile
from tests.unit.web.rig import Rig
from tests.unit.web.stand import Stand
from tests.unit.web.v1.centre import ONE, OTHER, Centre


@pytest.mark.nightly
async def test_a_document_is_stored_with_its_picture_and_answered_the_same_each_time(centre: Centre) -> None:
    for document in centre.documents():
        answers = [await centre.send(document) for _ in range(2)]
        wanted = {"survey": document.survey.id, "state": document.survey.state, "lot": document.survey.lot}
        assert answers == [(200, wanted)] * 2
        assert pictures_of(centre.store.path).read(document.survey.id) == {(0, 0): tile()}
    async with await centre.stand.tool(Role.VIEWER) as viewer:
        async with viewer.get(centre.url("/api/v1/surveys")) as answer:
            items = (await answer.json())["items"]
            assert [(each["placed"], each["drone"]) for each in items] == [("first", ONE), ("registered", ONE)]
        async with viewer.get(centre.url("/api/v1/lots")) as answer:
            assert [each["last_survey"]["drone"] for each in (await answer.json())["items"]] == [ONE]
        async with viewer.get(centre.url(f"/api/v1/lots/{document.survey.lot}/stalls?limit=1000")) as answer:
            assert {each["survey"] for each in (await answer.json())["items"]} == {document.survey.id}


@pytest.mark.slow
async def test_a_survey_of_the_day_after_tomorrow_is_refused(centre: Centre) -> None:
    first, _ = centre.documents()
    ahead = time.time() + 2 * 86_400.0
    late = first.survey.model_copy(update={"began": ahead - 60.0, "ended": ahead, "time_is_sure": True})
    status, problem = await centre.send(first.model_copy(update={"survey": late}))
    assert (status, problem["field"]) == (422, "survey.ended")
    assert "set the clock of drone and desk right" in problem["detail"]


@pytest.mark.slow
async def test_what_is_no_document_of_that_survey_is_refused_with_its_field(centre: Centre) -> None:
    first, second = centre.documents()
    data = parts.packed(first)
    for given, field in ((data[: len(data) // 2], "document"), (b"", "document"), (b"{}", "document")):
        status, problem = await centre.put(given, first.survey.id)
        assert (status, problem["field"]) == (422, field)
    status, problem = await centre.put(data, second.survey.id)
    assert (status, problem["field"]) == (422, "survey.id")
    assert (await centre.put(data, "..%2F..%2Fetc"))[0] in (403, 404)
    async with await centre.stand.tool(Role.VIEWER) as viewer, viewer.get(centre.url("/api/v1/surveys")) as answer:
        assert (await answer.json())["items"] == []


@pytest.mark.slow
async def test_a_document_that_is_too_large_ends_while_it_comes(
    centre: Centre, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hawk.web.v1.desk.documents.LARGEST_BYTES", 100_000)
    first, _ = centre.documents()
    status, problem = await centre.put(b"\0" * 200_000, first.survey.id)
    assert status == 413
    assert "is too large" in problem["detail"]


@pytest.mark.slow
async def test_a_drones_token_opens_documents_and_lots_and_nothing_else(centre: Centre) -> None:
    (first, _), opened = centre.documents(), set()
    assert (await centre.send(first))[0] == 200
    values = {"id": first.survey.lot, "survey": first.survey.id, "version": "1", "collection": "lots", "kind": "csv"}
    values |= {"seq": "1", "number": "0", "row": "0", "column": "0", "preview": "0" * 32, "feed": "apds"}
    values |= {"name": "000001-20260504T103000Z.mcap", "token": "t" * 22, "file": "a.jpg"}
    async with centre.tool(centre.tokens[ONE]) as session:
        for each in OPERATIONS:
            if each.is_open:
                continue
            path = "/api/v1" + each.path.format(**values)
            async with session.request(each.method, centre.url(path), json={} if each.is_change else None) as answer:
                if answer.status != 403:
                    opened.add((each.method, each.path))
                else:
                    assert (await answer.json())["detail"] == FOR_DRONES_ALONE
        for path in ("/", "/api/health", "/api/settings.json", "/metrics", "/snapshot.jpg", "/stream.mjpg", "/docs/",
                     "/api/recording.mcap", "/api/report.json", "/api/session"):  # fmt: skip
            async with session.get(centre.url(path), allow_redirects=False) as answer:
                assert answer.status == 403, path
        for path in ("/logout", "/api/area-file"):
            async with session.post(centre.url(path), data=b"{}") as answer:
                assert answer.status == 403, path
    written = {("PUT", "/surveys/{id}/document"), ("PUT", "/lots/{id}/document"), ("PUT", "/inbox/{file}")}
    written |= {("PUT", "/surveys/{id}/recordings"), ("PUT", "/surveys/{id}/recordings/{name}")}
    assert written < opened
    assert opened - written == {
        (each.method, each.path) for each in OPERATIONS if each.method == "GET" and each.path.startswith("/lots")
    } - {("GET", "/lots/{id}/shares")}


@pytest.mark.slow
async def test_a_lot_goes_to_the_desk_and_back_as_one_form_of_document(centre: Centre) -> None:
    first, _ = centre.documents()
    lot = first.survey.lot
    assert lot is not None
    with centre.drone.store.reading() as connection:
        document = source.document_of_lot(connection, lot)
    assert document is not None
    url = centre.url(f"/api/v1/lots/{lot}/document")
    async with centre.tool(centre.tokens[ONE]) as session:
        for _ in range(2):
            async with session.put(url, data=parts.packed(document)) as answer:
                wanted = {"lot": lot, "state": document.state, "keeps_plan": False}
                assert (answer.status, await answer.json()) == (200, wanted)
        asked = f"{centre.url('/api/v1/lots/documents')}?after={{}}&seen={{}}"
        async with session.get(asked.format(0, "true")) as answer:
            assert answer.content_type == "application/gzip"
            back = lot_document.unpacked(await answer.read())
        assert [plan_digest(each) for each in back.lots] == [plan_digest(each) for each in document.lots]
        async with session.get(asked.format(back.state, "false")) as answer:
            after = lot_document.unpacked(await answer.read())
        assert (after.state, after.lots) == (back.state, ())
    async with centre.tool(centre.tokens[OTHER]) as session:
        for seen, count in (("true", 0), ("false", 1)):
            async with session.get(asked.format(0, seen)) as answer:
                assert len(lot_document.unpacked(await answer.read()).lots) == count


@pytest.mark.slow
async def test_a_lot_that_contradicts_itself_is_refused_with_its_field(centre: Centre) -> None:
    first, _ = centre.documents()
    lot, stall = first.lots[0], first.lots[0].stalls[0]
    wrong = {
        "survey.layout": first.model_copy(update={"survey": first.survey.model_copy(update={"layout": 99})}),
        "lots[0].stalls[0].begins": with_lot(first, stalls=(stall.model_copy(update={"begins": 77}), *lot.stalls[1:])),
        "lots[0].merged_into": with_lot(first, merged_into=lot.id),
    }
    for field, document in wrong.items():
        status, problem = await centre.send(document)
        assert (status, problem["field"]) == (422, field)
    async with centre.tool(centre.tokens[ONE]) as session:
        path = "/api/v1/lots/123e4567-e89b-42d3-a456-426614174000/document"
        other = LotDocument(format="hawk lots", version=1, state=1, lots=first.lots)
        async with session.put(centre.url(path), data=parts.packed(other)) as answer:
            assert (answer.status, (await answer.json())["field"]) == (422, "lots")


def with_lot(document: survey_document.SurveyDocument, **values: object) -> survey_document.SurveyDocument:
    """Return a document whose first lot has other values."""
    return document.model_copy(update={"lots": (document.lots[0].model_copy(update=values), *document.lots[1:])})


@pytest.mark.slow
@pytest.mark.fault("a drone's token opens the command socket", "the connection is refused: no message is read")
async def test_no_message_is_read_of_a_drones_token(centre: Centre) -> None:
    async with centre.tool(centre.tokens[ONE]) as session:
        for path in ("/ws", "/video"):
            with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
                await session.ws_connect(centre.url(path))
            assert refused.value.status == 403
        async with session.get(centre.url(f"/?token={centre.tokens[ONE]}"), allow_redirects=False) as answer:
            assert answer.status == 403
            assert "Set-Cookie" not in answer.headers
    async with aiohttp.ClientSession() as stranger:
        async with stranger.get(centre.url(f"/?token={centre.tokens[ONE]}"), allow_redirects=False) as answer:
            assert answer.status == 401
        origin = {"Origin": centre.url("/").rstrip("/")}
        for role in ("drone", "operator", "viewer"):
            form = {"username": role, "password": centre.tokens[ONE]}
            async with stranger.post(centre.url("/login"), data=form, headers=origin) as answer:
                assert answer.status in (400, 401)


@pytest.mark.slow
@pytest.mark.fault(
    "each command is sent to a desk that collects, by an operator in control", "refused: no drone is here"
)
async def test_no_command_is_done_at_a_desk_that_collects(centre: Centre) -> None:
    page = await centre.stand.page(await centre.stand.browser(Role.OPERATOR))
    await page.take_control()
    rows = [row for row in COMMAND_TABLE.values() if not row.answered_by_web_server]
    assert {"Arm", "Takeoff", "Kill", "Set Failsafes", "Set Fence"} <= {row.example.type for row in rows}
    for row in rows:
        centre.stand.rig.real.advance(1.0)
        answer = await page.ask(**row.example.model_dump(mode="json", by_alias=True))
        assert not answer["Accepted"]
        assert "There is no drone here" in answer["Reason"]


@pytest.mark.nightly
async def test_a_person_sends_no_document_and_a_drone_none_to_another_program(centre: Centre) -> None:
    first, _ = centre.documents()
    for role in Role:
        status, problem = await centre.send(first, centre.stand.tokens[role])
        assert status == 403
        assert "is for drones and programs" in problem["detail"]
    status, problem = await centre.put(parts.packed(first), first.survey.id, **{"X-Forwarded-For": "192.0.2.1"})
    assert status == 403
    assert "HTTPS" in problem["detail"]


@pytest.mark.nightly
async def test_a_stranger_and_another_origin_send_no_document(centre: Centre) -> None:
    first, _ = centre.documents()
    data = parts.packed(first)
    status, problem = await centre.put(data, first.survey.id, Origin="https://elsewhere.example")
    assert (status, problem["detail"].split(":")[0]) == (403, "Origin")
    url = centre.url(f"/api/v1/surveys/{first.survey.id}/document")
    async with aiohttp.ClientSession() as stranger, stranger.put(url, data=data) as answer:
        assert answer.status == 401


async def test_a_program_that_does_not_collect_takes_no_document(tmp_path: Path, rig: Rig) -> None:
    rig.folder, rig.lots = tmp_path, LotStore(tmp_path / "lots.db")
    stand = Stand(rig, tmp_path)
    token = rotate_drone(tmp_path / TOKEN_FILE, ONE)
    server = await rig.start()
    url = server.make_url("/api/v1/surveys/123e4567-e89b-42d3-a456-426614174000/document")
    headers = {"Authorization": f"Bearer {token}"}
    async with aiohttp.ClientSession(headers=headers) as session, session.put(url, data=b"") as answer:
        assert answer.status == 409
        assert "hawk-drone desk --collect" in (await answer.json())["detail"]
    await stand.close()


@pytest.mark.nightly
async def test_a_token_that_was_removed_or_replaced_opens_nothing(centre: Centre) -> None:
    first, second = centre.documents()
    assert (await centre.send(first))[0] == 200
    remove_drone(centre.folder / TOKEN_FILE, OTHER)
    new = rotate_drone(centre.folder / TOKEN_FILE, ONE)
    await centre.stand.look()
    assert (await centre.send(second))[0] == 401
    assert (await centre.send(second, centre.tokens[OTHER]))[0] == 401
    assert (await centre.send(second, new))[0] == 200, "another token of the same drone writes its surveys on"
    assert (await centre.send(first, new))[0] == 200


@pytest.mark.nightly
async def test_a_drone_sends_one_document_at_a_time(centre: Centre) -> None:
    first, second = centre.documents()
    begun, goes_on = asyncio.Event(), asyncio.Event()

    async def slowly() -> AsyncIterator[bytes]:
        data = parts.packed(first)
        yield data[:100]
        begun.set()
        await goes_on.wait()
        yield data[100:]

    async with centre.tool(centre.tokens[ONE]) as session:
        url = centre.url(f"/api/v1/surveys/{first.survey.id}/document")
        sending = asyncio.create_task(_status(session, url, slowly()))
        await begun.wait()
        while (found := await centre.send(second))[0] == 200:  # noqa: ASYNC110 - until the first one is being read
            await asyncio.sleep(0)
        assert found[0] == 503
        goes_on.set()
        assert await sending == 200
    assert (await centre.send(second))[0] == 200


async def _status(session: aiohttp.ClientSession, url: str, data: AsyncIterator[bytes]) -> int:
    async with session.put(url, data=data) as answer:
        return answer.status
