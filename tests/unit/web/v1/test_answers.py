"""Answers of the API: tags, packing, deadlines, and problems of one form."""

from __future__ import annotations

import asyncio
import gzip
import re
import uuid
from pathlib import Path
from typing import Any

import aiohttp
import pytest
from aiohttp.test_utils import make_mocked_request
from sqlalchemy import text

from hawk.lots.commands import rename
from hawk.lots.storage.database import TOO_LONG, Database
from hawk.lots.store import READS, LotStore
from hawk.web.v1 import answers
from hawk.web.v1.answers import accepts_gzip, is_known
from hawk.web.v1.table import OPERATIONS
from tests.unit.web.rig import Rig, browser
from tests.unit.web.v1.archive import Archive


@pytest.mark.nightly
async def test_an_answer_that_the_client_has_is_not_sent_again(archive: Archive) -> None:
    first = await archive.ask(f"/lots/{archive.lot}/stalls")
    tag = first.headers["ETag"]
    again = await archive.ask(f"/lots/{archive.lot}/stalls", If_None_Match=f'"other", {tag}')
    assert (again.status, await again.read(), again.headers["ETag"]) == (304, b"", tag)
    assert again.headers["Cache-Control"] == first.headers["Cache-Control"] == "private, no-cache"


@pytest.mark.nightly
async def test_an_answer_is_made_once_until_the_store_changes(
    archive: Archive, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[bool] = []
    encode = answers.encoded

    def counted(answer: answers.Answer, *, packs: bool) -> tuple[bytes, bool]:
        made.append(packs)
        return encode(answer, packs=packs)

    monkeypatch.setattr(answers, "encoded", counted)
    for path in (f"/lots/{archive.lot}/stalls", f"/lots/{archive.lot}/statistics"):
        made.clear()
        first, again = await archive.ask(path), await archive.ask(path)
        assert (await first.read(), first.headers["ETag"]) == (await again.read(), again.headers["ETag"])
        assert again.headers["Content-Type"] == first.headers["Content-Type"]
        assert len(made) == 1, path
        named = await archive.ask(f"/lots/{archive.lot}/name", method="POST", operator=True, body={"name": path[-5:]})
        made.clear()
        assert named.status == 200
        assert (await archive.ask(path)).status == 200
        assert len(made) == 1, "after a change"


def test_answers_are_kept_up_to_a_size_the_last_wanted_ones_longest() -> None:
    kept = answers.KeptAnswers(most_bytes=100)
    one, two, three = (answers._Packed(200, name, body=b"x" * 40) for name in "abc")
    for each in (one, two):
        kept.put(each, packs=True)
    assert kept.get("a", packs=True) is one
    kept.put(three, packs=True)
    assert [kept.get(name, packs=True) for name in "abc"] == [one, None, three]
    assert kept.get("a", packs=False) is None, "another encoding"


@pytest.mark.nightly
async def test_what_is_not_there_is_never_said_to_be_unchanged(archive: Archive) -> None:
    tag = (await archive.ask("/lots")).headers["ETag"]
    there = (await archive.ask(f"/lots/{archive.lot}/stalls")).headers["ETag"]
    routes = [each.route for each in OPERATIONS if each.method == "GET" and "{" in each.route]
    assert len(routes) > 20
    for route in routes:
        path = re.sub(r"\{(\w+)\}", lambda part: "99" if part[1] in ("version", "seq") else str(uuid.uuid4()), route)
        plain = await archive.ask(path)
        assert plain.status >= 400, path
        for given in ("*", tag, there, f'W/"x", {tag}'):
            answer = await archive.ask(path, If_None_Match=given)
            assert answer.status == plain.status, (path, given)
    assert (await archive.ask("/lots", If_None_Match="*")).status == 304
    assert (await archive.ask("/lots?limit=1", If_None_Match=tag)).status == 200


async def test_a_change_of_the_store_makes_another_tag_also_by_another_program(archive: Archive) -> None:
    path, old = f"/lots/{archive.lot}/name", (await archive.ask("/lots")).headers["ETag"]
    assert (await archive.ask(path, method="POST", operator=True, body={"name": "North"})).status == 200
    changed = await archive.ask("/lots", If_None_Match=old)
    assert (changed.status, (await changed.json())["items"][0]["name"]) == (200, "North")
    other = Database(archive.store.path)
    with other.writing() as connection:
        rename(connection, archive.lot, "South", "operator", 1.8e9)
    other.close()
    again = await archive.ask("/lots", If_None_Match=changed.headers["ETag"])
    assert (again.status, (await again.json())["items"][0]["name"]) == (200, "South")


@pytest.mark.slow
async def test_a_long_answer_is_packed_for_those_who_unpack_it(archive: Archive) -> None:
    path = archive.address(f"/lots/{archive.lot}/stalls")
    headers = {"Authorization": archive.viewer.headers["Authorization"]}
    async with aiohttp.ClientSession(auto_decompress=False, headers=headers) as session:
        async with session.get(path, headers={"Accept-Encoding": "gzip"}) as packed:
            assert packed.headers["Content-Encoding"] == "gzip"
            data = await packed.read()
        async with session.get(path, headers={"Accept-Encoding": "identity"}) as plain:
            assert "Content-Encoding" not in plain.headers
            assert gzip.decompress(data) == await plain.read()
            assert plain.headers["Vary"] == "Accept-Encoding"
    assert len(data) * 3 < len(gzip.decompress(data))


@pytest.mark.parametrize(
    ("given", "known"),
    [("", False), ("*", True), ('W/"a"', True), ('"a"', True), ('"b", W/"a"', True), ('"b"', False), ("a", False)],
)
def test_tags_are_compared_weakly(given: str, known: bool) -> None:
    assert is_known(given, 'W/"a"') is known


@pytest.mark.parametrize(
    ("given", "accepts"),
    [
        ("", False), ("gzip", True), ("br, GZIP;q=0.5", True), ("gzip;q=0", False), ("gzip; q=0.0", False),
        ("*", True), ("identity", False),
    ],
)  # fmt: skip
def test_gzip_is_used_where_it_is_taken(given: str, accepts: bool) -> None:
    assert accepts_gzip(make_mocked_request("GET", "/", headers={"Accept-Encoding": given})) is accepts


@pytest.mark.slow
async def test_a_store_that_does_not_answer_is_given_up(archive: Archive, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(answers, "ANSWER_S", 0.05)
    release = asyncio.Event()
    loop = asyncio.get_running_loop()

    def hang(_: Any) -> None:
        asyncio.run_coroutine_threadsafe(release.wait(), loop).result()

    hanging = asyncio.gather(*(archive.store.read(hang) for _ in range(READS)))
    await asyncio.sleep(0)
    status, problem = await archive.refused("/lots")
    assert (status, problem["detail"]) == (503, answers.BUSY)
    release.set()
    await hanging
    monkeypatch.undo()
    assert (await archive.get("/lots"))["next"] is None


@pytest.mark.slow
async def test_a_read_without_end_is_ended_and_refused_in_words(
    archive: Archive, monkeypatch: pytest.MonkeyPatch
) -> None:
    endless = text("WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT count(*) FROM n")
    monkeypatch.setattr("hawk.lots.lists.lots", lambda connection, *_: connection.execute(endless).scalar())
    monkeypatch.setattr(LotStore.read, "__defaults__", (0.1,))
    status, problem = await archive.refused("/lots")
    assert (status, problem["detail"]) == (503, TOO_LONG)
    monkeypatch.undo()
    assert (await archive.get("/lots"))["next"] is None


async def test_the_door_refuses_in_the_same_form(archive: Archive) -> None:
    async with browser() as stranger:
        for method, path, status in (("GET", "/lots", 401), ("POST", "/lots", 401)):
            async with stranger.request(method, archive.address(path)) as response:
                assert (response.status, response.content_type) == (status, "application/problem+json")
                assert "log in on the page" in (await response.json(content_type=None))["detail"]
                assert response.headers["WWW-Authenticate"] == 'Bearer realm="hawk"'
    status, problem = await archive.refused("/lots", method="DELETE")
    assert (status, problem["title"]) == (405, "Method Not Allowed")
    for method in ("GET", "HEAD", "PUT", "OPTIONS"):
        response = await archive.ask(f"/lots/{archive.lot}/name", method=method)
        assert (response.status, response.headers["Allow"]) == (405, "POST")
    assert (await archive.ask("/lots", method="PUT")).headers["Allow"] == "GET,HEAD"
    status, problem = await archive.refused("/lots", method="POST", Origin="https://elsewhere.example")
    assert (status, problem["detail"].split(":")[0]) == (403, "Origin")


async def test_an_error_of_the_program_is_logged_and_answered_in_the_same_form(
    archive: Archive, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr("hawk.lots.lists.lots", broken)
    status, problem = await archive.refused("/lots")
    assert (status, problem["title"]) == (500, "Internal Server Error")
    assert "ZeroDivisionError" in caplog.text


async def test_an_error_behind_a_link_is_logged_without_its_token(
    archive: Archive, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    token = (await archive.done(f"/lots/{archive.lot}/shares", days=7))["token"]

    def broken(*_: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr("hawk.lots.lists.observations", broken)
    assert (await archive.ask(f"/shared/{token}/observations")).status == 500
    assert "/api/v1/shared/{token}/observations failed" in caplog.text
    assert token not in caplog.text


async def test_where_there_are_no_lots_the_api_says_so(rig: Rig, tmp_path: Path) -> None:
    server = await rig.start()
    async with browser() as session, session.get(server.make_url("/api/v1/lots")) as response:
        assert (response.status, response.content_type) == (404, "application/problem+json")
        assert (await response.json(content_type=None))["detail"] == "There is no store of lots here."


async def test_the_token_of_an_address_is_no_parameter_and_no_part_of_a_link(archive: Archive) -> None:
    token = archive.viewer.headers["Authorization"].removeprefix("Bearer ")
    async with browser() as session, session.get(archive.address(f"/lots?limit=1&token={token}")) as response:
        assert response.status == 200
        assert token not in response.headers["Link"]
