from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import aiohttp
import numpy as np
import pytest

from hawk.comm.protocol.authority import Role
from hawk.lots.ingest import save
from hawk.lots.store import LotStore
from hawk.lots.values import Doubtful, FinishedSurvey, PossiblePlace, Saved
from tests.sweep import sweep
from tests.unit.lots.repaints import by_place, extra, flown, repainted
from tests.unit.lots.surveys import DATUM, box, later, survey
from tests.unit.web.rig import Rig
from tests.unit.web.stand import Stand

HTML = "<b onclick='alert(1)'>North & South</b>"
NOWHERE = "0" * 36


@dataclass
class Lots:
    """The API as an operator's program sees it."""

    stand: Stand
    store: LotStore
    session: aiohttp.ClientSession

    async def add(self, given: FinishedSurvey) -> Saved:
        return await self.store.write(lambda connection: save(connection, given))

    def address(self, path: str) -> Any:
        assert self.stand.rig.server is not None
        return self.stand.rig.server.make_url(f"/api/v1{path}")

    async def get(self, path: str) -> Any:
        async with self.session.get(self.address(path)) as response:
            assert response.status == 200, await response.text()
            return await response.json()

    async def items(self, path: str = "/lots") -> list[dict[str, Any]]:
        """Return the items of a list that has one part."""
        found = await self.get(f"{path}{'&' if '?' in path else '?'}limit=1000")
        assert found["next"] is None
        return list(found["items"])

    async def post(self, path: str, **body: object) -> tuple[int, dict[str, Any]]:
        async with self.session.post(self.address(path), json=body) as response:
            return response.status, await response.json(content_type=None)

    async def names(self) -> list[str]:
        return [lot["name"] for lot in await self.items()]

    async def undecided(self) -> list[dict[str, Any]]:
        return await self.items("/surveys?placed=undecided")

    async def stalls(self, lot: str) -> dict[str, dict[str, Any]]:
        return {each["label"]: each for each in await self.items(f"/lots/{lot}/stalls")}

    async def surveys(self, lot: str | None) -> list[dict[str, Any]]:
        return await self.items(f"/lots/{lot}/surveys")

    async def done(self, path: str, **body: object) -> dict[str, Any]:
        status, answer = await self.post(path, **body)
        assert status == 200, answer
        return answer

    async def undo(self, change: dict[str, Any]) -> tuple[int, dict[str, Any]]:
        return await self.post(f"/changes/{change['seq']}/undo")

    async def everything(self) -> str:
        listed = await self.items()
        shown = []
        for lot in listed:
            path = f"/lots/{lot['id']}"
            parts = [await self.items(f"{path}/{part}") for part in ("layouts", "zones", "surveys")]
            shown += [await self.get(path) | {"revision": None}, parts, list((await self.stalls(lot["id"])).values())]
        return json.dumps([listed, await self.undecided(), shown])


@pytest.fixture
async def lots(tmp_path: Path, rig: Rig) -> AsyncIterator[Lots]:
    store = rig.lots = LotStore(tmp_path / "lots.db")
    stand, rig.folder = Stand(rig, tmp_path), tmp_path
    await rig.start()
    yield Lots(stand, store, await stand.tool(Role.OPERATOR))
    await stand.close()
    await store.close()


@pytest.mark.nightly
async def test_lots_are_listed_with_their_surveys_and_stalls(lots: Lots) -> None:
    first = await lots.add(survey())
    await lots.add(replace(later(survey(seed=1), 2), time_is_sure=False))
    (lot,) = await lots.items()
    assert (lot["id"], lot["name"], lot["stalls"], lot["survey_count"]) == (first.lot, "Lot 1", 40, 2)
    assert lot["last_survey"]["placed"] == "unregistered"
    assert lot["last_survey"]["time_is_sure"] is False
    surveys = await lots.surveys(first.lot)
    assert [each["seq"] for each in surveys] == [1, 2]
    assert surveys[0]["ended"] == "2026-02-02T02:55:00Z"
    assert (await lots.stalls(first.lot or ""))["A 1"]["state"] == survey().stalls[0].state
    assert len((await lots.get(f"/lots/{first.lot}"))["outline"][0]) == 4


@pytest.mark.nightly
async def test_a_name_is_text_and_html_in_it_stays_as_it_is(lots: Lots) -> None:
    first = await lots.add(survey())
    change = await lots.done(f"/lots/{first.lot}/name", name=f"  {HTML} ")
    async with lots.session.get(lots.address("/lots")) as response:
        assert response.content_type == "application/json"
        assert response.headers["X-Content-Type-Options"] == "nosniff"
    assert await lots.names() == [HTML]
    assert await lots.undo(change) == (200, {"seq": change["seq"], "kind": "name"})
    assert await lots.names() == ["Lot 1"]
    status, refusal = await lots.undo(change)
    assert (status, refusal["field"]) == (409, "seq")
    assert "was undone already" in refusal["detail"]


@pytest.mark.slow
async def test_a_time_zone_is_that_of_the_place_until_a_person_says_another_one(lots: Lots) -> None:
    lot = (await lots.add(survey())).lot

    async def shown() -> set[str]:
        clocks = [(await lots.get(f"/lots/{lot}{path}"))["clock"] for path in ("/statistics", "/statistics/surveys")]
        return {(await lots.get(f"/lots/{lot}"))["time_zone"], (await lots.items())[0]["time_zone"], *clocks}

    assert await shown() == {"Europe/Amsterdam"}
    change = await lots.done(f"/lots/{lot}/time-zone", time_zone="America/Toronto")
    assert await shown() == {"America/Toronto"}
    assert (await lots.get(f"/lots/{lot}/feeds/cds"))["time_zone"] == "America/Toronto"
    assert await lots.undo(change) == (200, {"seq": change["seq"], "kind": "time_zone"})
    assert await shown() == {"Europe/Amsterdam"}
    status, refusal = await lots.post(f"/lots/{lot}/time-zone", time_zone="Toronto")
    assert (status, refusal["field"]) == (422, "time_zone")
    assert "must be a name of the time zone database, as Europe/Amsterdam or UTC" in refusal["detail"]
    day = "from=2026-05-04&to=2026-05-04"
    assert (await lots.get(f"/lots/{lot}/surveys?{day}"))["items"] == []


@pytest.mark.slow
async def test_a_later_change_is_undone_first(lots: Lots) -> None:
    first = await lots.add(survey())
    changes = [await lots.done(f"/lots/{first.lot}/name", name=name) for name in ("North", "South")]
    status, refusal = await lots.undo(changes[0])
    assert (status, refusal["detail"].split(";")[1]) == (409, " undo the later changes first")
    assert [(await lots.undo(change))[0] for change in reversed(changes)] == [200, 200]
    assert await lots.names() == ["Lot 1"]
    assert [each["undone"] is not None for each in await lots.items("/changes")] == [True, True]


@pytest.mark.nightly
async def test_lots_beside_each_other_are_merged_and_undone(lots: Lots) -> None:
    west = await lots.add(survey())
    moved = replace(survey(), datum=replace(DATUM, longitude=5.01))
    east = await lots.add(replace(later(moved, 2), outline=box(0, 0, 20, 54, moved.datum)))
    before = await lots.everything()
    ids = {each["id"] for lot in (west, east) for each in (await lots.stalls(lot.lot or "")).values()}
    change = await lots.done(f"/lots/{west.lot}/merge", **{"with": east.lot})
    stalls = await lots.stalls(west.lot or "")
    assert {each["id"] for each in stalls.values()} == ids
    assert sorted({label.split()[0] for label in stalls}) == ["A", "B", "C", "D"]
    assert stalls["C 1"]["east"] - stalls["A 1"]["east"] == pytest.approx(686.5, abs=1.0)
    (lot,) = await lots.items()
    assert (lot["stalls"], lot["survey_count"], lot["last_survey"]["placed"]) == (80, 2, "registered")
    assert (await lots.post(f"/lots/{east.lot}/name", name="East"))[0] == 404
    assert (await lots.undo(change))[0] == 200
    assert await lots.everything() == before
    await lots.done(f"/lots/{west.lot}/merge", **{"with": east.lot})
    assert {label.split()[0] for label in await lots.stalls(west.lot or "")} == {"A", "B", "C", "D"}


@pytest.mark.nightly
async def test_two_lots_of_one_ground_are_merged_without_a_guess(lots: Lots) -> None:
    first = await lots.add(survey())
    asked = await lots.add(replace(later(survey(seed=1), 2), outline=box(60, 0, 20, 50)))
    again = await lots.done(f"/surveys/{asked.survey}/move", lot=None, name="The same")
    await lots.done(f"/lots/{first.lot}/merge", **{"with": again["lot"]})
    second = await lots.add(later(survey(seed=2), 3))
    assert second.lot == first.lot
    before = await lots.stalls(first.lot or "")
    new = await lots.done(f"/surveys/{second.survey}/move", lot=None, name="Twin")
    change = await lots.done(f"/lots/{first.lot}/merge", **{"with": new["lot"]})
    after = await lots.stalls(first.lot or "")
    assert after.keys() == before.keys()
    surveys = await lots.surveys(first.lot)
    assert [each["placed"] for each in surveys] == ["first", "registered", "unregistered"]
    assert (await lots.undo(change))[0] == 200
    assert len(await lots.stalls(new["lot"])) == 40


@pytest.mark.nightly
async def test_a_lot_is_split_by_an_outline_and_undone(lots: Lots) -> None:
    first = await lots.add(survey(stalls=60))
    before = await lots.everything()
    old = await lots.stalls(first.lot or "")
    part = [list(corner) for corner in box(-30, -5, 16.5, 70).polygons[0]]
    change = await lots.done(f"/lots/{first.lot}/split", outline=part, name="Back row")
    (made,) = [lot for lot in await lots.items() if lot["name"] == "Back row"]
    kept, gone = await lots.stalls(first.lot or ""), await lots.stalls(made["id"])
    assert ({label[0] for label in kept}, {label[0] for label in gone}) == ({"A", "B"}, {"C"})
    assert {label: each["id"] for label, each in (kept | gone).items()} == {
        label: each["id"] for label, each in old.items()
    }
    assert gone["C 1"]["state"] == old["C 1"]["state"]
    assert (await lots.undo(change))[0] == 200
    assert await lots.everything() == before


@pytest.mark.nightly
async def test_a_split_is_not_undone_while_surveys_are_in_the_lot_that_it_made(lots: Lots) -> None:
    first = await lots.add(survey(stalls=60))
    part = [list(corner) for corner in box(-30, -5, 16.5, 70).polygons[0]]
    change = await lots.done(f"/lots/{first.lot}/split", outline=part, name="Back row")
    back = await lots.add(replace(later(survey(), 2), outline=box(-28, -5, 14, 70)))
    assert back.lot_name == "Back row"
    before = await lots.everything()
    status, refusal = await lots.undo(change)
    assert (status, refusal["field"]) == (409, "seq")
    assert "move them to another lot first" in refusal["detail"]
    assert await lots.everything() == before


@pytest.mark.nightly
async def test_which_lot_is_it_is_answered_by_a_move_and_undone(lots: Lots) -> None:
    first = await lots.add(survey())
    asked = await lots.add(replace(later(survey(seed=1), 2), outline=box(60, 0, 20, 50)))
    (waiting,) = await lots.undecided()
    assert (waiting["id"], waiting["candidates"]) == (asked.survey, [first.lot])
    before = await lots.everything()
    known = await lots.done(f"/surveys/{asked.survey}/move", lot=first.lot)
    assert await lots.undecided() == []
    assert (await lots.items())[0]["survey_count"] == 2
    assert (await lots.undo(known))[0] == 200
    new = await lots.done(f"/surveys/{asked.survey}/move", lot=None)
    assert await lots.names() == ["Lot 1", "Lot 2"]
    assert len(await lots.stalls(new["lot"])) == 40
    assert (await lots.undo(new))[0] == 200
    assert await lots.everything() == before


@pytest.mark.slow
async def test_a_person_chooses_where_a_survey_lies_and_undoes_it(lots: Lots) -> None:
    first = await lots.add(survey())
    places = (PossiblePlace(0.0, 0.0, 0.0, 20.0), PossiblePlace(0.0, 2.5, 0.0, 19.5))

    def doubtful(known: object, found: object) -> Doubtful:
        return Doubtful("two places fit alike", places)

    second = await lots.store.write(lambda connection: save(connection, later(survey(seed=1), 2), doubtful))
    before = await lots.everything()
    waiting = (await lots.surveys(first.lot))[1]
    assert (waiting["placed"], waiting["place"]) == ("unregistered", None)
    assert waiting["doubt"]["why"] == "two places fit alike"
    assert [round(place["east"], 6) for place in waiting["doubt"]["places"]] == [0.0, 2.5]
    status, refusal = await lots.post(f"/surveys/{second.survey}/place", place=2)
    assert (status, refusal["field"]) == (422, "place")
    assert refusal["detail"] == "must be the number of one of the places: 0 to 1"
    done = await lots.done(f"/surveys/{second.survey}/place", place=1)
    chosen = (await lots.surveys(first.lot))[1]
    assert (chosen["placed"], chosen["doubt"]["chosen"]) == ("registered", 1)
    compared = await lots.get(f"/lots/{first.lot}/comparison")
    assert compared["survey"] == second.survey
    assert {each["label"] for each in compared["missed"]} == {"A 1", "B 1"}
    assert [each["id"] for each in compared["found"]] == [20, 40]
    stalls = await lots.stalls(first.lot or "")
    assert stalls["A 2"]["state"] == survey(seed=1).stalls[0].state
    status, refusal = await lots.post(f"/surveys/{second.survey}/place", place=0)
    assert (status, refusal["field"], refusal["detail"]) == (409, "id", "waits for no place; reload the list")
    assert (await lots.undo(done))[0] == 200
    assert await lots.everything() == before
    assert (await lots.undo(done))[0] == 409


async def test_a_doubt_without_a_place_says_what_to_do(lots: Lots) -> None:
    await lots.add(survey())
    given = later(survey(seed=1), 2)
    second = await lots.store.write(lambda c: save(c, given, lambda known, found: Doubtful("too few stalls")))
    status, refusal = await lots.post(f"/surveys/{second.survey}/place", place=0)
    assert (status, refusal["field"]) == (422, "place")
    assert refusal["detail"] == "cannot be chosen, there is none: too few stalls. Fly the lot again"


LOT, SURVEY = "LOT", "SURVEY"
NO_LOT, NO_SURVEY = "GET /api/v1/lots lists them", "GET /api/v1/surveys lists them"
WRONG: list[tuple[str, dict[str, object], int, str, str]] = [
    (f"/lots/{LOT}/name", {}, 422, "name", "is missing: write it"),
    (f"/lots/{LOT}/name", {"name": 7}, 422, "name", "must be text"),
    (f"/lots/{LOT}/name", {"name": "  \n "}, 422, "name", "is empty: write one or more letters"),
    (f"/lots/{LOT}/name", {"name": "x" * 81}, 422, "name", "must have 80 or fewer characters"),
    (f"/lots/{LOT}/name", {"name": "a\u202eb"}, 422, "name", "cannot be shown"),
    (f"/lots/{LOT}/name", {"name": "a\0b"}, 422, "name", "cannot be shown"),
    (f"/lots/{NOWHERE}/name", {"name": "x"}, 404, "id", NO_LOT),
    (f"/lots/{LOT}/merge", {"with": LOT}, 422, "with", "is the lot itself"),
    (f"/lots/{LOT}/merge", {"with": NOWHERE}, 404, "with", "reload the list"),
    (f"/lots/{LOT}/merge", {}, 422, "with", "is missing: write it"),
    (f"/lots/{LOT}/merge", {"with": "\ud800"}, 422, "body", "holds half a character"),
    (f"/lots/{LOT}/merge", {"with": "another"}, 422, "with", "must be an id, 36 characters, as the lists have it"),
    (f"/lots/{LOT}/split", {"name": "x"}, 422, "outline", "is missing"),
    (f"/lots/{LOT}/split", {"name": "x", "outline": [[52, 5]]}, 422, "outline", "must be a list of 3 or more, not 1"),
    (f"/lots/{LOT}/split", {"name": "x", "outline": [[52, 5]] * 501}, 422, "outline", "must be a list of 500 or fewer"),
    (f"/lots/{LOT}/split", {"name": "x", "outline": [[52, 5], [52, 6], [52, "5"]]}, 422, "outline[2][1]", "a number"),
    (f"/lots/{LOT}/split", {"name": "x", "outline": [[52, 5], [52, True], [52, 5]]}, 422, "outline[1][1]", "a number"),
    (f"/lots/{LOT}/split", {"name": "x", "outline": [[500, 5], [52, 6], [52, 5]]}, 422, "outline[0][0]", "90 or less"),
    (f"/lots/{LOT}/split", {"name": "x", "outline": [[50, 1], [50, 2], [51, 1]]}, 422, "outline", "holds no stall"),
    (f"/lots/{LOT}/split", {"name": "x", "outline": [[51.9, 4.9], [51.9, 5.1], [52.1, 5]]}, 422, "outline", "every"),
    (f"/lots/{LOT}/split", {"outline": [[50, 1], [50, 2], [51, 1]]}, 422, "name", "is missing"),
    (f"/surveys/{SURVEY}/move", {}, 422, "lot", "is missing"),
    (f"/surveys/{SURVEY}/move", {"lot": LOT}, 422, "lot", "has this survey already"),
    (f"/surveys/{SURVEY}/move", {"lot": 12}, 422, "lot", "must be text"),
    (f"/surveys/{SURVEY}/move", {"lot": NOWHERE}, 404, "lot", "reload the list"),
    (f"/surveys/{NOWHERE}/move", {"lot": LOT}, 404, "id", NO_SURVEY),
    (f"/surveys/{SURVEY}/place", {"place": 0}, 409, "id", "waits for no place"),
    (f"/surveys/{NOWHERE}/place", {"place": 0}, 404, "id", NO_SURVEY),
    ("/changes/99/undo", {}, 404, "seq", "there is no change with this number"),
]  # fmt: skip


@pytest.fixture
async def first(lots: Lots) -> Saved:
    """The survey of the one lot."""
    return await lots.add(survey())


@pytest.mark.slow
@sweep(("path", "body", "status", "field", "reason"), WRONG)
async def test_a_value_that_cannot_be_used_is_named_with_its_remedy_and_changes_nothing(
    lots: Lots, first: Saved, path: str, body: dict[str, object], status: int, field: str, reason: str
) -> None:
    before = await lots.everything()
    named = {"LOT": first.lot, "SURVEY": first.survey}
    asked = {key: named.get(value, value) if isinstance(value, str) else value for key, value in body.items()}
    for word, value in named.items():
        path = path.replace(word, str(value))
    found, refusal = await lots.post(path, **asked)
    assert (found, refusal["field"]) == (status, field)
    assert reason in refusal["detail"]
    assert await lots.everything() == before


@pytest.mark.slow
@pytest.mark.fault("a survey holds numbers that are none")
@sweep(
    ("body", "reason"),
    [
        (b"{", "is no JSON"),
        (b"[1]", "must be a JSON object"),
        (b"\xff", "is no JSON"),
        (b"[" * 50_000, "is no JSON"),
        (b'{"name": "x", "outline": [[52, 5], [52, NaN], [52, 5]]}', "must be a finite number"),
    ],
)  # fmt: skip
async def test_a_body_that_is_no_object_of_numbers_is_refused(
    lots: Lots, first: Saved, body: bytes, reason: str
) -> None:
    async with lots.session.post(lots.address(f"/lots/{first.lot}/split"), data=body) as response:
        assert response.status == 422
        assert reason in (await response.json(content_type=None))["detail"]


@pytest.mark.slow
async def test_a_viewer_reads_and_changes_nothing(lots: Lots) -> None:
    first = await lots.add(survey())
    viewer = await lots.stand.tool(Role.VIEWER)
    assert await lots.stand.status(viewer, "/api/v1/lots") == 200
    for path in (
        f"/lots/{first.lot}/name",
        f"/surveys/{first.survey}/move",
        f"/surveys/{first.survey}/place",
        "/changes/1/undo",
    ):
        async with viewer.post(lots.address(path), json={"name": "x"}) as response:
            found = await response.json(content_type=None)
            assert (response.status, found["detail"]) == (403, "Lots are changed by operators: log in as operator.")
    assert await lots.names() == ["Lot 1"]


@pytest.mark.fault("the store of lots is damaged while a daemon runs")
async def test_a_damaged_store_is_an_answer_with_the_remedy(tmp_path: Path, lots: Lots) -> None:
    (tmp_path / "lots.db").write_bytes(b"x" * 300)
    async with lots.session.get(lots.address("/lots")) as response:
        assert response.status == 409
        assert "hawk-drone restore FILE" in (await response.json(content_type=None))["detail"]


async def test_a_server_without_a_store_says_so(rig: Rig) -> None:
    server = await rig.start()
    async with aiohttp.ClientSession() as session, session.get(server.make_url("/api/v1/lots")) as response:
        found = await response.json(content_type=None)
        assert (response.status, found["detail"]) == (404, "There is no store of lots here.")


@pytest.mark.slow
async def test_twenty_readers_at_once_are_answered(lots: Lots) -> None:
    await lots.add(survey())
    assert await asyncio.gather(*(lots.names() for _ in range(20))) == [["Lot 1"]] * 20


@pytest.mark.nightly
async def test_what_a_survey_proposes_is_taken_over_and_undone(lots: Lots) -> None:
    first = await lots.add(flown(1))
    second = await lots.store.write(lambda c: save(c, repainted(2), by_place))
    before = await lots.everything()
    (shown,) = (await lots.get(f"/lots/{first.lot}/proposals"))["surveys"]
    assert (shown["survey"], len(shown["begin"]), len(shown["end"])) == (second.survey, 18, 20)
    assert shown["begin"][0]["corners"][0] == pytest.approx([52.0, 5.0], abs=1e-3)
    done = await lots.done(f"/lots/{first.lot}/take-over", survey=second.survey, begin="all", end="all")
    assert len(await lots.stalls(str(first.lot))) == 58
    assert (await lots.get(f"/lots/{first.lot}/proposals"))["surveys"] == []
    assert (await lots.undo(done))[0] == 200
    assert await lots.everything() == before


@pytest.mark.slow
async def test_a_dropped_proposal_is_gone(lots: Lots) -> None:
    first = await lots.add(flown(1))
    second = await lots.store.write(lambda c: save(c, extra(flown(2)), by_place))
    await lots.done(f"/lots/{first.lot}/drop", survey=second.survey, begin=[90])
    assert (await lots.get(f"/lots/{first.lot}/proposals"))["surveys"] == []
    status, refusal = await lots.post(f"/lots/{first.lot}/drop", survey=second.survey, begin=[90])
    assert (status, refusal["field"]) == (422, "survey")


@pytest.mark.slow
async def test_nothing_is_taken_over_or_pinned_while_a_person_edits(lots: Lots) -> None:
    first = await lots.add(flown(1))
    second = await lots.store.write(lambda c: save(c, extra(flown(2)), by_place))
    await lots.done(f"/lots/{first.lot}/edit", who="Ann")
    for path, body in (("take-over", {"survey": second.survey, "begin": "all"}), ("pin", {"points": []})):
        status, refusal = await lots.post(f"/lots/{first.lot}/{path}", **body)
        assert (status, refusal["who"]) == (409, "Ann")


@pytest.mark.nightly
async def test_a_lot_is_pinned_and_all_that_is_shown_of_it_follows(lots: Lots) -> None:
    first = await lots.add(flown(1))
    before = await lots.everything()
    point = {"from": [52.0, 5.0], "to": [52.00002, 5.0]}
    done = await lots.done(f"/lots/{first.lot}/pin", points=[point])
    assert (done["kind"], done["turn"], done["residual"]) == ("pin", 0.0, 0.0)
    assert done["north"] == pytest.approx(2.2, abs=0.1)
    shown = await lots.get(f"/lots/{first.lot}")
    assert shown["datum_is_pinned"]
    assert shown["datum"] == done["datum"] == pytest.approx([52.00002, 5.0], abs=1e-8)
    assert (await lots.undo(done))[0] == 200
    assert await lots.everything() == before
    status, refusal = await lots.post(f"/lots/{first.lot}/pin", points=[point | {"to": [52.1, 5.0]}])
    assert (status, refusal["field"]) == (422, "points[0].to")


@pytest.mark.slow
async def test_the_places_of_a_survey_in_doubt_are_shown_with_the_stalls_at_each(lots: Lots) -> None:
    first = await lots.add(flown(1))
    places = (PossiblePlace(0.0, 0.0, 0.0, 20.0), PossiblePlace(0.0, 2.5, 0.0, 19.5))
    second = await lots.store.write(
        lambda c: save(c, flown(2), lambda known, found: Doubtful("two places fit alike", places))
    )
    (waiting,) = (await lots.get(f"/lots/{first.lot}/proposals"))["doubtful"]
    assert (waiting["survey"], waiting["places"], waiting["why"]) == (second.survey, 2, "two places fit alike")
    shown = await lots.get(f"/surveys/{second.survey}/places")
    assert (shown["lot"], len(shown["known"])) == (first.lot, 60)
    here, there = (np.array(place["stalls"]) for place in shown["places"])
    assert there[:, :2] - here[:, :2] == pytest.approx(np.tile([0.0, 2.5], (60, 1)), abs=0.01)
    await lots.done(f"/surveys/{second.survey}/place", place=0)
    assert (await lots.get(f"/lots/{first.lot}/proposals"))["doubtful"] == []


@pytest.mark.slow
async def test_a_survey_without_doubt_has_no_places(lots: Lots) -> None:
    first = await lots.add(flown(1))
    async with lots.session.get(lots.address(f"/surveys/{first.survey}/places")) as response:
        assert response.status == 404
