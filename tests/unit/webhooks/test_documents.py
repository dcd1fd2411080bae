from __future__ import annotations

import asyncio
import time
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from aiohttp import web
from aiohttp.test_utils import TestServer
from pydantic import ValidationError
from sqlalchemy import Connection, func, select

from hawk.config.sections import CollectSettings
from hawk.lots import commands, outbox
from hawk.lots.documents import parts
from hawk.lots.documents.lot_document import LotDue
from hawk.lots.plan import edits
from hawk.lots.storage.schema import DELIVERY, DOCUMENT, SURVEY
from hawk.lots.survey.pictures import pictures_of
from hawk.model.lot_map import EncodedTile
from hawk.web.access.tokens import TOKEN_FILE, rotate_drone
from tests.unit.comm.waiting import until
from tests.unit.lots.documents.drones import days, tile
from tests.unit.lots.documents.tables import tables
from tests.unit.lots.surveys import later, survey
from tests.unit.webhooks.lines import ONE, Line, running


@pytest.mark.slow
async def test_everything_comes_to_the_desk_once_with_pictures_and_what_changes_later(line: Line) -> None:
    first = line.drone.add(survey())
    pictures_of(line.store.path).write(first.survey, {(0, 0): EncodedTile(1, tile())})
    async with running(line.sender()):
        await line.is_received()
        for _ in days(line.drone):
            await line.is_received()
        documents = await line.centre.read(lambda c: c.execute(select(DOCUMENT.c.state)).all())
        assert len(documents) == len(line.drone.documents())
    theirs = line.drone.do(tables)
    found = await line.centre.read(tables)
    for name in ("lot", "layout", "section", "observation", "section_look", "looks"):
        assert found[name] == theirs[name], name
    assert pictures_of(line.centre.path).read(first.survey) == {(0, 0): tile()}
    assert line.said == []


@pytest.mark.nightly
async def test_the_newest_survey_is_sent_first_and_then_the_oldest(line: Line) -> None:
    stored = [line.drone.add(later(survey(seed=n), n + 1, 24.0 * n)).survey for n in range(4)]
    async with running(line.sender()):
        await line.is_received()
    assert await line.surveys() == [stored[3], *stored[:3]]


@pytest.mark.slow
@pytest.mark.fault(
    "the program is killed after the desk has taken a survey, before that is noted",
    "the survey is sent again, and the desk answers the same: nothing is doubled",
)
async def test_what_was_not_noted_is_sent_again_and_doubles_nothing(
    line: Line, monkeypatch: pytest.MonkeyPatch
) -> None:
    line.drone.add(survey())
    note, killed = outbox.note_states_sent, 0

    def fail_at_first(*given: Any) -> None:
        nonlocal killed
        killed += 1
        if killed <= 2:
            raise KeyError("killed")
        note(*given)

    monkeypatch.setattr(outbox, "note_states_sent", fail_at_first)
    async with running(line.sender()):
        await until(lambda: killed >= 2, 20)
        before = await line.centre.read(tables)
        await line.is_received()
    assert await line.centre.read(tables) == before
    assert len(await line.surveys()) == 1


@pytest.mark.slow
async def test_a_desk_that_is_away_gets_everything_when_it_is_back_and_the_operator_hears_once(line: Line) -> None:
    for number in range(3):
        line.drone.add(later(survey(seed=number), number + 1, 24.0 * number))
    away = TestServer(web.Application())
    await away.start_server()
    url = str(away.make_url("/"))
    await away.close()
    async with running(line.sender(url)):
        await until(lambda: bool(line.said), 20)
    assert [text for text, _ in line.said] == [f"The desk {url.split('/')[2]} takes no survey; it is tried on."]
    tried = await line.store.read(lambda c: c.execute(select(func.count()).select_from(DELIVERY)).scalar_one())
    assert tried == 0, "a link that is away counts against no survey"
    async with running(line.sender()):
        await line.is_received()
    assert len(await line.surveys()) == 3


@pytest.mark.parametrize("status", [429, 503, 507])
async def test_a_desk_that_takes_nothing_now_counts_against_no_survey(line: Line, status: int) -> None:
    line.drone.add(survey())
    asked = 0

    async def full(_: web.Request) -> web.Response:
        nonlocal asked
        asked += 1
        return web.Response(status=status)

    desk = web.Application()
    desk.router.add_route("*", "/{path:.*}", full)
    server = TestServer(desk)
    await server.start_server()
    async with running(line.sender(str(server.make_url("/")))):
        await until(lambda: asked > 2, 20)
    await server.close()
    tried = await line.store.read(lambda c: c.execute(select(func.count()).select_from(DELIVERY)).scalar_one())
    assert tried == 0


@pytest.mark.slow
async def test_a_desk_that_slows_a_drone_after_refusals_is_there(line: Line) -> None:
    for number in range(8):
        line.drone.add(later(survey(seed=number), number + 1, 24.0 * number))
    statuses: list[int] = []

    async def refuse(_: web.Request) -> web.Response:
        statuses.append(422 if len(statuses) % 2 else 429)
        return web.Response(status=statuses[-1])

    desk = web.Application()
    desk.router.add_route("PUT", "/{path:.*}", refuse)
    server = TestServer(desk)
    await server.start_server()
    async with running(line.sender(str(server.make_url("/")))):
        await until(lambda: len(statuses) > 14, 20)
    await server.close()
    assert statuses.count(422) >= 7
    assert line.said == []


@pytest.mark.slow
async def test_a_survey_that_the_desk_refuses_holds_up_no_other_one(line: Line) -> None:
    stored = [line.drone.add(later(survey(seed=n), n + 1, 24.0 * n)).survey for n in range(3)]
    theirs = parts.packed(line.drone.document(stored[1]))
    await line.centre.collect(theirs, stored[1], "Drone 2")
    async with running(line.sender()):
        async with asyncio.timeout(10):
            while len(await line.surveys()) < 3:  # noqa: ASYNC110 - another thread writes it
                await asyncio.sleep(0.01)
        await asyncio.sleep(0)
    writers = await line.centre.read(lambda c: [row.writer for row in c.execute(select(DOCUMENT))])
    assert sorted(writers) == ["Drone 1", "Drone 1", "Drone 2"]
    assert await line.waiting() >= 1


@pytest.mark.slow
@pytest.mark.fault(
    "a survey waits for the desk while the motors are on", "nothing is sent, unless collect.kbit_s allows"
)
async def test_nothing_is_sent_while_the_motors_are_on(line: Line) -> None:
    line.drone.add(survey())
    line.is_flown = True
    async with running(line.sender()):
        await asyncio.sleep(0.3)
        assert not line.centre.is_open
        line.is_flown = False
        await line.is_received()
    assert len(await line.surveys()) == 1


@pytest.mark.slow
async def test_in_flight_no_more_is_sent_than_the_setting_allows(line: Line) -> None:
    stored = line.drone.add(survey())
    line.is_flown = True
    size, kbit_s = len(parts.packed(line.drone.document(stored.survey))), 100
    began = time.monotonic()
    async with running(line.sender(kbit_s=kbit_s)):
        await line.is_received()
    assert time.monotonic() - began > 0.8 * size * 8 / (kbit_s * 1000)


@pytest.mark.slow
async def test_a_wrong_token_and_a_missing_file_are_said_with_the_remedy(line: Line) -> None:
    line.drone.add(survey())
    (line.folder / "token").write_text("guess")
    async with running(line.sender()):
        await until(lambda: bool(line.said), 20)
    assert line.said[0][1] == (
        "The desk does not know the token of collect.token_file: make a new one there for this drone."
    )
    line.said.clear()
    (line.folder / "token").unlink()
    async with running(line.sender()):
        await until(lambda: bool(line.said), 20)
    assert "write the token that the desk gave into it" in line.said[0][1]
    assert await line.surveys() == []


@pytest.mark.slow
async def test_with_a_new_token_all_is_sent_again_to_a_desk_that_lost_its_store(line: Line) -> None:
    line.drone.add(survey())
    times = select(func.count()).select_from(DELIVERY).where(DELIVERY.c.sent.is_not(None))
    async with running(line.sender()):
        await line.is_received()
    before = await line.store.read(lambda c: c.execute(times).scalar_one())
    async with running(line.sender()):
        await line.is_received()
    assert await line.store.read(lambda c: c.execute(times).scalar_one()) == before, "by the same token nothing"
    (line.folder / "token").write_text(rotate_drone(line.folder / "desk" / TOKEN_FILE, ONE))
    async with running(line.sender()), asyncio.timeout(15):
        while await line.store.read(lambda c: c.execute(times).scalar_one()) < 2 * before:  # noqa: ASYNC110
            await asyncio.sleep(0.01)


@pytest.mark.slow
async def test_a_document_that_cannot_be_made_is_said_and_holds_up_no_other_one(line: Line) -> None:
    stored = [line.drone.add(later(survey(seed=n), n + 1, 24.0 * n)).survey for n in range(2)]
    damage = SURVEY.update().where(SURVEY.c.id == stored[0]).values(latitude=400.0)
    line.drone.do(lambda connection: connection.execute(damage).close())
    async with running(line.sender()):
        async with asyncio.timeout(10):
            while await line.surveys() != [stored[1]]:  # noqa: ASYNC110 - another thread writes it
                await asyncio.sleep(0.01)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"url": "https://desk.example/"}, "token_file is missing"),
        ({"url": "http://desk.example/", "token_file": "/t"}, "must begin with https://"),
        ({"url": "http://127.0.0.1.example/", "token_file": "/t"}, "must begin with https://"),
        ({"kbit_s": -1}, "greater than or equal to 0"),
    ],
)
def test_settings_that_cannot_be_used_are_refused(given: dict[str, Any], words: str) -> None:
    with pytest.raises(ValidationError, match=words):
        CollectSettings.model_validate(given)


def test_a_desk_on_this_computer_may_be_without_tls(tmp_path: Path) -> None:
    for host in ("localhost:3000", "127.0.0.1:3000"):
        assert CollectSettings.model_validate({"url": f"http://{host}/", "token_file": str(tmp_path)}).url is not None


async def test_a_plan_corrected_at_the_desk_is_on_the_drone_after_some_looks(line: Line) -> None:
    lot = line.drone.add(survey()).lot
    async with running(line.sender()):
        await line.is_received()
        await line.centre.write(lambda c: commands.rename(c, str(lot), "North", "operator", time.time()))
        async with asyncio.timeout(15):
            while await line.names() != ["North"]:  # noqa: ASYNC110 - another thread writes it
                await asyncio.sleep(0.01)
        await line.is_received()
    assert line.said == []


async def test_what_is_due_at_the_desk_is_known_here_also_without_a_link_after_a_start(line: Line) -> None:
    lot, moment = str(line.drone.add(survey()).lot), datetime.fromtimestamp(int(time.time()) + 3600, UTC)
    line.moments.append(moment)
    taken: list[Sequence[LotDue]] = []
    async with running(line.sender(take_due=taken.append)):
        await until(lambda: bool(taken) and bool(taken[-1]))
    assert taken[0] == ()  # of the store, before the desk was asked
    assert [(each.lot, each.moments) for each in taken[-1]] == [(lot, (moment.timestamp(),))]
    assert taken[-1][0].last == await line.centre.read(lambda c: c.execute(select(SURVEY.c.ended)).scalar_one())
    again: list[Sequence[LotDue]] = []
    line.is_flown = True  # it asks no desk
    async with running(line.sender(kbit_s=1000, take_due=again.append)):
        await until(lambda: bool(again))
    assert again == [taken[-1]]


@pytest.mark.fault("a lot changes at the desk while the motors are on", "it is asked for after the landing")
async def test_no_lot_is_asked_for_while_the_motors_are_on(line: Line) -> None:
    lot = line.drone.add(survey()).lot
    async with running(line.sender()):
        await line.is_received()
    line.is_flown = True
    await line.centre.write(lambda c: commands.rename(c, str(lot), "North", "operator", time.time()))
    async with running(line.sender(kbit_s=1000)):
        await asyncio.sleep(0.5)
        assert await line.names() == ["Lot 1"]
        line.is_flown = False
        async with asyncio.timeout(15):
            while await line.names() != ["North"]:  # noqa: ASYNC110 - another thread writes it
                await asyncio.sleep(0.01)


async def test_a_plan_changed_at_both_ends_is_the_desks_and_the_operator_hears_it(line: Line) -> None:
    lot = line.drone.add(survey()).lot
    assert lot is not None
    async with running(line.sender()):
        await line.is_received()
    await line.centre.write(lambda c: edited(c, lot, {"do": "rename", "row": "A", "to": "X"}))
    line.drone.edit(lot, {"do": "remove", "row": "B"})
    async with running(line.sender()):
        await until(lambda: bool(line.said), 20)
    assert line.said == [("The plan of Lot 1 is the desk's now; some of your changes are not in it.", "")]


def edited(connection: Connection, lot: str, operation: dict[str, Any]) -> None:
    """Edit a plan as a person at the desk does."""
    opened = edits.open_edit(connection, lot, {"who": "Bob"}, time.time())
    edits.do(connection, lot, {"edit": opened.edit, "operation": operation}, time.time())
    edits.close(connection, lot, {"edit": opened.edit}, time.time())
