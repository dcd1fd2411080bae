from __future__ import annotations

from collections.abc import AsyncIterator
from functools import partial
from pathlib import Path
from typing import Any

import aiohttp
import pytest

from hawk.comm.protocol.authority import Role
from hawk.lots.ingest import save
from hawk.lots.store import LotStore
from hawk.model.lot_map import StallState
from hawk.web.access.guesses import FREE_GUESSES
from tests.unit.stats.test_panel import later, register, seen
from tests.unit.web.rig import Rig
from tests.unit.web.stand import Stand

NOWHERE = "0" * 36
FLOWN = (seen({}), later(seen({1: StallState.TAKEN, 2: StallState.TAKEN}), 1))


class Archive:
    """The addresses as somebody's program sees them."""

    def __init__(self, stand: Stand, store: LotStore) -> None:
        self.stand = stand
        self.store = store
        self.lot = ""
        self.surveys: list[str] = []

    async def fill(self) -> None:
        for one in FLOWN:
            saved = await self.store.write(partial(save, survey=one, register=register))
            assert saved.lot is not None
            self.lot = saved.lot
            self.surveys.append(saved.survey)

    def address(self, path: str) -> Any:
        assert self.stand.rig.server is not None
        return self.stand.rig.server.make_url(path)

    async def get(self, session: aiohttp.ClientSession, path: str) -> tuple[int, Any]:
        async with session.get(self.address(path)) as response:
            is_json = "json" in response.headers["Content-Type"]
            return response.status, (await response.json(content_type=None) if is_json else await response.read())

    async def post(self, session: aiohttp.ClientSession, path: str, **body: object) -> tuple[int, Any]:
        async with session.post(self.address(path), json=body) as response:
            is_json = "json" in response.headers["Content-Type"]
            return response.status, (await response.json() if is_json else await response.text())


@pytest.fixture
async def archive(tmp_path: Path, rig: Rig) -> AsyncIterator[Archive]:
    store = rig.lots = LotStore(tmp_path / "lots.db")
    stand, rig.folder = Stand(rig, tmp_path), tmp_path
    await rig.start()
    made = Archive(stand, store)
    await made.fill()
    yield made
    await stand.close()
    await store.close()


SURVEYS, FIGURES, STALLS = "statistics/surveys", "statistics?by=row", "statistics/stalls"
ASK = "statistics/ask?weekday=mon-sun&row=A&kind=normal"
BETWEEN, LOOKS = "statistics/between?before={before}&after={survey}", "observations?stall={stall}&order=newest"
READS = (SURVEYS, FIGURES, STALLS, ASK, "surveys/{survey}/stalls", LOOKS, BETWEEN)


async def read_all(archive: Archive, session: aiohttp.ClientSession, place: str) -> dict[str, Any]:
    _, heat = await archive.get(session, f"{place}/{STALLS}")
    names = {"survey": archive.surveys[1], "before": archive.surveys[0], "stall": heat["ids"][0]}
    found = {}
    for path in READS:
        status, found[path] = await archive.get(session, f"{place}/{path.format(**names)}")
        assert status == 200, (path, found[path])
    return found


@pytest.mark.slow
async def test_a_viewer_reads_the_lot_over_its_surveys(archive: Archive) -> None:
    session = await archive.stand.tool(Role.VIEWER)
    found = await read_all(archive, session, f"/api/v1/lots/{archive.lot}")
    assert [each["taken"] for each in found[SURVEYS]["surveys"]] == [2, 0]
    assert found[FIGURES]["whole"]["capacity"] == 20
    assert found[ASK]["occupancy"] == found[FIGURES]["whole"]["occupancy"]
    assert (found[ASK]["asked"]["rows"], found[ASK]["clock"]) == (["A"], "Europe/Amsterdam")
    between = found[BETWEEN]
    assert [(each["label"], each["after"]) for each in between["stalls"]] == [("A 1", "taken"), ("A 2", "taken")]
    assert (between["came"]["value"], between["left"]["value"], between["compared"]) == (2, 0, 20)
    assert found[LOOKS]["items"][0]["state"] == "taken"


@pytest.mark.slow
async def test_a_question_that_cannot_be_used_names_its_field(archive: Archive) -> None:
    session, place = await archive.stand.tool(Role.VIEWER), f"/api/v1/lots/{archive.lot}"
    for path, status, field in (
        ("statistics?by=colour", 422, "by"), ("statistics/surveys?from=yesterday", 422, "from"),
        ("statistics/ask?weekday=workday", 422, "weekday"), ("statistics/ask?hour=7-25", 422, "hour"),
        ("statistics/ask?row=A&row=Z", 422, "row"), ("statistics/ask?zone=North", 422, "zone"),
        ("statistics/ask?kind=taxi", 422, "kind"), ("statistics/ask?hour=7&hour=8", 422, "hour"),
        ("statistics/stalls?time_zone=Nowhere", 422, "time_zone"), ("statistics/between?before=x", 422, "before"),
        (f"statistics/between?before={NOWHERE}&after={NOWHERE}", 422, "before"),
        (f"observations?stall={NOWHERE}", 404, "stall"), (f"surveys/{NOWHERE}/stalls", 404, "survey"),
    ):  # fmt: skip
        found = await archive.get(session, f"{place}/{path}")
        assert (found[0], found[1]["field"]) == (status, field), (path, found)
    assert (await archive.get(session, f"/api/v1/lots/{NOWHERE}/{SURVEYS}"))[0] == 404


@pytest.mark.slow
async def test_a_survey_is_deleted_by_an_operator_alone_and_comes_back(archive: Archive) -> None:
    operator, viewer = await archive.stand.tool(Role.OPERATOR), await archive.stand.tool(Role.VIEWER)
    path = f"/api/v1/surveys/{archive.surveys[1]}/delete"
    assert (await archive.post(viewer, path))[0] == 403
    status, done = await archive.post(operator, path)
    assert status == 200
    _, left = await archive.get(operator, f"/api/v1/lots/{archive.lot}/{SURVEYS}")
    assert [each["id"] for each in left["surveys"]] == [archive.surveys[0]]
    assert (await archive.post(operator, path))[0] == 409
    assert (await archive.post(operator, f"/api/v1/changes/{done['seq']}/undo"))[0] == 200
    assert (await archive.post(operator, f"/api/v1/surveys/{NOWHERE}/delete"))[0] == 404


@pytest.mark.nightly
async def test_a_link_opens_its_lot_to_one_without_a_login_and_nothing_else(archive: Archive) -> None:
    operator, nobody = await archive.stand.tool(Role.OPERATOR), await archive.stand.browser()
    status, made = await archive.post(operator, f"/api/v1/lots/{archive.lot}/shares", days=7)
    assert status == 200
    found = await read_all(archive, nobody, f"/api/v1/shared/{made['token']}")
    assert found[SURVEYS]["lot"] == archive.lot
    for path in ("/api/v1/lots", f"/api/v1/lots/{archive.lot}/{SURVEYS}", "/api/v1/recordings", "/archive",
                 f"/api/v1/lots/{archive.lot}/shares", f"/api/v1/lots/{archive.lot}",
                 f"/api/v1/surveys/{archive.surveys[0]}/files/csv",
        f"/api/v1/surveys/{archive.surveys[0]}/files/png"):  # fmt: skip
        assert (await archive.get(nobody, path))[0] == 401, path
    assert (await archive.get(nobody, f"/api/v1/shared/{made['token']}/recordings"))[0] == 404
    assert (await archive.post(nobody, f"/api/v1/shared/{made['token']}/{SURVEYS}"))[0] == 401


@pytest.mark.nightly
async def test_a_link_that_was_taken_back_or_has_ended_opens_nothing(archive: Archive) -> None:
    operator, nobody = await archive.stand.tool(Role.OPERATOR), await archive.stand.browser()
    _, one = await archive.post(operator, f"/api/v1/lots/{archive.lot}/shares", days=7)
    _, other = await archive.post(operator, f"/api/v1/lots/{archive.lot}/shares", days=1)
    assert (await archive.post(operator, f"/api/v1/shares/{one['id']}/take-back"))[0] == 200
    archive.stand.rig.wall.advance(86_401)
    for made in (one, other):
        status, found = await archive.get(nobody, f"/api/v1/shared/{made['token']}/{SURVEYS}")
        assert (status, found["field"]) == (404, "token")
    _, listed = await archive.get(operator, f"/api/v1/lots/{archive.lot}/shares")
    assert [each["open"] for each in listed["shares"]] == [False, False]
    assert made["token"] not in str(listed)


@pytest.mark.slow
async def test_links_are_made_and_taken_back_by_operators(archive: Archive) -> None:
    viewer, operator = await archive.stand.tool(Role.VIEWER), await archive.stand.tool(Role.OPERATOR)
    assert (await archive.post(viewer, f"/api/v1/lots/{archive.lot}/shares", days=7))[0] == 403
    assert (await archive.post(viewer, f"/api/v1/shares/{NOWHERE}/take-back"))[0] == 403
    status, found = await archive.post(operator, f"/api/v1/lots/{archive.lot}/shares", days="for ever")
    assert (status, found["field"]) == (422, "days")


@pytest.mark.slow
async def test_guesses_of_links_are_slowed_and_logged(archive: Archive, caplog: pytest.LogCaptureFixture) -> None:
    operator, nobody = await archive.stand.tool(Role.OPERATOR), await archive.stand.browser()
    _, made = await archive.post(operator, f"/api/v1/lots/{archive.lot}/shares", days=7)
    statuses = [
        (await archive.get(nobody, f"/api/v1/shared/guess-{k:06d}/{SURVEYS}"))[0] for k in range(FREE_GUESSES + 2)
    ]
    assert statuses == [404] * (FREE_GUESSES + 1) + [429]
    assert (await archive.get(nobody, f"/api/v1/shared/{made['token']}/{SURVEYS}"))[0] == 429
    assert any("wrong link to a lot from 127.0.0.1" in line for line in caplog.messages)
    assert "guess-000001" not in caplog.text
    archive.stand.rig.real.advance(3600)
    assert (await archive.get(nobody, f"/api/v1/shared/{made['token']}/{SURVEYS}"))[0] == 200


@pytest.mark.nightly
async def test_a_link_that_was_one_is_no_guess_and_links_hold_up_no_token(archive: Archive) -> None:
    operator, nobody = await archive.stand.tool(Role.OPERATOR), await archive.stand.browser()
    made = [(await archive.post(operator, f"/api/v1/lots/{archive.lot}/shares", days=days))[1] for days in (1, 7, 7)]
    await archive.post(operator, f"/api/v1/shares/{made[1]['id']}/take-back")
    archive.stand.rig.wall.advance(86_401)
    for each in made[:2]:  # one that has ended, one that was taken back
        for _ in range(FREE_GUESSES + 2):
            assert (await archive.get(nobody, f"/api/v1/shared/{each['token']}/{SURVEYS}"))[0] == 404
    right = f"/api/v1/shared/{made[2]['token']}/{SURVEYS}"
    assert (await archive.get(nobody, right))[0] == 200
    for number in range(FREE_GUESSES + 1):
        await archive.get(nobody, f"/api/v1/shared/guess-{number:06d}/{SURVEYS}")
    assert (await archive.get(nobody, right))[0] == 429, "guesses of links are slowed"
    assert (await archive.get(operator, "/api/v1/lots"))[0] == 200, "and no token"
    archive.stand.rig.real.advance(3600)
    for number in range(FREE_GUESSES + 1):
        guesser = await archive.stand.browser(headers={"Authorization": f"Bearer guess-{number}"})
        assert (await archive.get(guesser, "/api/v1/lots"))[0] == 401
    assert (await archive.get(operator, "/api/v1/lots"))[0] == 429
    assert (await archive.get(nobody, right))[0] == 200, "guesses of tokens are slowed, and no link"


@pytest.mark.nightly
async def test_one_wrong_link_that_is_read_again_is_one_guess(archive: Archive) -> None:
    nobody = await archive.stand.browser()
    for _ in range(FREE_GUESSES + 2):
        assert (await archive.get(nobody, f"/api/v1/shared/of-an-erased-lot/{SURVEYS}"))[0] == 404
