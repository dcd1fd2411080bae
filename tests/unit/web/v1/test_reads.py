"""Reading by the API: lists in parts, single things, filters, and what is refused."""

from __future__ import annotations

import json
import shutil
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import delete

from hawk.comm.protocol.authority import Role
from hawk.lots import answers as lots
from hawk.lots.plan import answers as plans
from hawk.lots.storage.schema import LOOKS
from hawk.lots.store import LotStore
from hawk.stats import answers as uses
from hawk.stats.changes import Changed
from hawk.stats.figures import Figures
from hawk.stats.partition import Partition
from hawk.web.v1 import bodies
from hawk.web.v1.features import answers as shapes
from hawk.web.v1.table import OPERATIONS
from hawk.web.v1.unknown import NOTHING, WORDS
from tests.sweep import sweep
from tests.unit.web.rig import Rig
from tests.unit.web.stand import Stand
from tests.unit.web.v1.archive import NOWHERE, Archive, Filled

COUNTS = ("free", "taken", "unknown")


async def test_lots_are_listed_in_parts_that_follow_each_other(archive: Archive) -> None:
    whole = await archive.shown("/lots", lots.LotList)
    assert [each["id"] for each in whole["items"]] == [archive.lot, archive.far]
    assert (whole["items"][0]["stalls"], whole["items"][0]["survey_count"], whole["next"]) == (40, 3, None)
    assert await archive.items("/lots?limit=1") == whole["items"]
    response = await archive.ask("/lots?limit=1")
    assert response.links["next"]["url"] == archive.address(f"/lots?limit=1&after={archive.lot}")


async def test_all_lots_with_their_places_are_those_of_the_list_a_list_for_each_value(archive: Archive) -> None:
    listed = (await archive.shown("/lots", lots.LotList))["items"]
    found = await archive.shown("/lots/places", shapes.LotPlaces)
    newest = [each["last_survey"] or {} for each in listed]
    for key, name in {
        "ids": "id",
        "names": "name",
        "time_zones": "time_zone",
        "stalls": "stalls",
        "due": "due",
    }.items():
        assert found[key] == [each[name] for each in listed]
    assert found["survey_counts"] == [each["survey_count"] for each in listed]
    for key, name in {"surveys": "id", "drones": "drone", **{name: name for name in ("ended", *COUNTS)}}.items():
        assert found[key] == [each.get(name) for each in newest]
    assert (found["latitudes"][0], found["longitudes"][0]) == pytest.approx((52.0, 5.0), abs=1e-6)


async def test_a_lot_says_where_it_is_and_who_edits_its_plan(archive: Archive) -> None:
    shown = await archive.shown(f"/lots/{archive.lot}", lots.Lot)
    assert shown["datum"] == pytest.approx([52.0, 5.0], abs=1e-6)
    assert (shown["edit"], len(shown["outline"][0])) == (None, 4)
    await archive.done(f"/lots/{archive.lot}/edit", who="Ann")
    assert (await archive.shown(f"/lots/{archive.lot}", lots.Lot))["edit"]["who"] == "Ann"


@pytest.mark.slow
async def test_stalls_have_their_places_and_the_last_look(archive: Archive) -> None:
    stalls = (await archive.shown(f"/lots/{archive.lot}/stalls", lots.StallList))["items"]
    plan = await archive.shown(f"/lots/{archive.lot}/plan", plans.Plan)
    assert (plan["whole"], plan["datum"]) == (True, pytest.approx([52.0, 5.0], abs=1e-6))
    assert [each["id"] for each in stalls] == [each["id"] for each in plan["stalls"]]
    for stall, planned in zip(stalls, plan["stalls"], strict=True):
        assert {name: stall[name] for name in planned} == planned
        assert stall["survey"] == archive.surveys[-1]
        assert (stall["latitude"], stall["longitude"]) == pytest.approx((52.0, 5.0), abs=1e-3)
    assert await archive.items(f"/lots/{archive.lot}/stalls?limit=7") == stalls
    (alone,) = [each for each in stalls if each["label"] == "B 3"]
    found = await archive.shown(f"/stalls/{alone['id']}", lots.Stall)
    assert found == {"lot": archive.lot, "begins": 1, "ends": None, **alone}


@pytest.mark.slow
@pytest.mark.parametrize(("asked", "name", "value"), [("row=B", "row", "B"), ("state=free", "state", "free")])
async def test_stalls_are_chosen_by_row_and_state(archive: Archive, asked: str, name: str, value: str) -> None:
    path = f"/lots/{archive.lot}/stalls"
    chosen = [each for each in await archive.items(path) if each[name] == value]
    assert 0 < len(chosen) < 40
    assert await archive.items(f"{path}?{asked}&limit=3") == chosen
    assert await archive.items(f"{path}?kind=disabled") == []
    assert len(await archive.items(f"{path}?kind=")) == 40


@pytest.mark.slow
async def test_a_layout_has_its_stalls_as_they_were(archive: Archive) -> None:
    path = f"/lots/{archive.lot}"
    before = await archive.items(f"{path}/layouts/1/stalls")
    edit = (await archive.done(f"{path}/edit", who="Ann"))["edit"]
    ids = [each["id"] for each in before]
    for operation in (
        {"do": "remove", "stalls": [ids[0]]},
        {"do": "set_kind", "stalls": [ids[5]], "kind": "disabled"},
    ):
        await archive.done(f"{path}/plan", edit=edit, operation=operation)
    layouts = (await archive.shown(f"{path}/layouts", lots.LayoutList))["items"]
    assert [(each["version"], each["who"]) for each in layouts] == [(1, "hawk"), (2, "Ann")]
    assert (await archive.shown(f"{path}/layouts/1/stalls", lots.PlacedStallList))["items"] == before
    now = await archive.items(f"{path}/layouts/2/stalls?limit=5")
    assert [each["id"] for each in now] == ids[1:]
    assert [each["kind"] for each in now if each["id"] == ids[5]] == ["disabled"]
    gone = await archive.shown(f"/stalls/{ids[0]}", lots.Stall)
    assert (gone["begins"], gone["ends"]) == (1, 2)
    third = await archive.shown(f"/surveys/{archive.surveys[2]}", lots.Survey)
    counts = await archive.shown(f"{path}/statistics/surveys?survey={archive.surveys[2]}", uses.SurveysUse)
    assert third["found"] == counts["surveys"][0]["found"] == 40, "a plan that was corrected changes no flight"


async def test_zones_are_listed_with_their_ground(archive: Archive) -> None:
    path = f"/lots/{archive.lot}"
    edit = (await archive.done(f"{path}/edit", who="Ann"))["edit"]
    outline = [[-2, -2], [-2, 12], [3, 12], [3, -2]]
    operation = {"do": "draw_zone", "outline": outline, "name": "Front", "kind": "staff"}
    await archive.done(f"{path}/plan", edit=edit, operation=operation)
    (zone,) = (await archive.shown(f"{path}/zones", lots.ZoneList))["items"]
    assert (zone["name"], zone["kind"], zone["has_stalls"], zone["outline"]) == ("Front", "staff", True, outline)
    assert zone["ground"][0] == pytest.approx([52.0 - 2 / 111_270, 5.0 - 2 / 68_680], abs=1e-6)


@pytest.mark.slow
async def test_surveys_are_listed_from_either_end_and_by_time(archive: Archive) -> None:
    path = f"/lots/{archive.lot}/surveys"
    oldest = (await archive.shown(path, lots.SurveyList))["items"]
    assert [each["id"] for each in oldest] == archive.surveys
    assert await archive.items(f"{path}?order=newest&limit=1") == oldest[::-1]
    assert [each["placed"] for each in oldest] == ["first", "registered", "registered"]
    assert await archive.items(f"{path}?placed=registered") == oldest[1:]
    assert await archive.items(f"{path}?from=2026-02-03&to=2026-02-03&time_zone=UTC") == oldest[1:2]
    assert await archive.items(f"{path}?from=2026-02-03T02:55:00Z") == oldest[1:]
    assert await archive.items(f"{path}?to=2026-02-03T02:55:00Z") == oldest[:1]
    assert await archive.shown(f"/surveys/{oldest[1]['id']}", lots.Survey) == oldest[1]
    assert len(await archive.items("/surveys?limit=3")) == 4


@pytest.mark.slow
async def test_observations_are_read_by_lot_survey_and_stall(archive: Archive) -> None:
    path = f"/lots/{archive.lot}/observations"
    looks = (await archive.shown(f"{path}?limit=1000", lots.ObservationList))["items"]
    assert [each["survey"] for each in looks[::40]] == archive.surveys
    assert await archive.items(f"{path}?limit=33") == looks
    newest = await archive.items(f"{path}?limit=33&order=newest")
    assert [each["survey"] for each in newest[::40]] == list(archive.surveys)[::-1]
    assert sorted(map(str, newest)) == sorted(map(str, looks))
    second = archive.surveys[1]
    of_second = [each for each in looks if each["survey"] == second]
    assert len(of_second) == 40
    assert await archive.items(f"/surveys/{second}/observations?limit=9") == of_second
    assert await archive.items(f"{path}?survey={second}&limit=9") == of_second
    stall = looks[7]["stall"]
    assert await archive.items(f"{path}?stall={stall}&limit=2") == [each for each in looks if each["stall"] == stall]
    assert await archive.items(f"{path}?from=2026-02-04&time_zone=UTC") == looks[80:]
    assert await archive.items(f"/lots/{archive.far}/observations?survey={second}") == []


@pytest.mark.nightly
@pytest.mark.parametrize("by", [None, "hour", "row", "zone", "kind"])
async def test_statistics_are_those_of_the_command(archive: Archive, by: Partition | None) -> None:
    asked = "time_zone=UTC" if by is None else f"time_zone=UTC&by={by}"
    found = await archive.shown(f"/lots/{archive.lot}/statistics?{asked}", Figures)

    def printed(connection: Any) -> Any:
        from hawk.stats.period import period_of
        from hawk.stats.queries import statistics

        return statistics(connection, archive.lot, period_of(None, None, "UTC"), by).model_dump(mode="json")

    assert found == json.loads(json.dumps(await archive.store.read(printed)))
    assert (found["surveys"], found["by"]) == (3, by)


@pytest.mark.slow
async def test_statistics_of_a_period_use_the_surveys_with_looks_of_it_alone(archive: Archive) -> None:
    """All looks of the archive are of 2 February; two of its surveys ended on the days after it."""
    looked, ended = "from=2026-02-02&to=2026-02-02&time_zone=UTC", "from=2026-02-03&to=2026-02-04&time_zone=UTC"
    found = await archive.shown(f"/lots/{archive.lot}/statistics?{looked}", Figures)
    assert (found["surveys"], found["first"][:10]) == (3, "2026-02-02")
    found = await archive.shown(f"/lots/{archive.lot}/statistics?{ended}", Figures)
    assert (found["surveys"], found["first"]) == (0, None)


async def test_looks_of_an_older_archive_are_put_in_one_piece_by_the_first_question(archive: Archive) -> None:
    def drop(connection: Any) -> None:
        connection.execute(delete(LOOKS))

    def kept(connection: Any) -> int:
        from hawk.lots.survey.observations import missing_looks

        return len(missing_looks(connection, archive.lot))

    before = await archive.get(f"/lots/{archive.lot}/statistics?time_zone=UTC")
    await archive.store.write(drop)
    assert await archive.store.read(kept) == 3
    assert await archive.get(f"/lots/{archive.lot}/statistics?time_zone=UTC") == before
    assert await archive.store.read(kept) == 0


@sweep(
    ("path", "field", "words"),
    [
        ("/lots?limit=0", "limit", "must lie between 1 and 1000"),
        ("/lots?limit=1001", "limit", "must lie between 1 and 1000"),
        ("/lots?limit=1_0", "limit", "must be a whole number: write digits alone"),
        ("/lots?limit=5&limit=6", "limit", "is there twice: write it once"),
        ("/lots?page=2", "page", "is not known here: leave it out; there is limit, after"),
        ("/lots?after=nowhere", "after", "write `next` of the part before"),
        ("/surveys?after=1.2", "after", "write `next` of the part before"),
        ("/surveys?order=up", "order", "must be 'oldest' or 'newest'"),
        ("/surveys?from=yesterday", "from", "must be a date, as 2026-05-04"),
        ("/surveys?from=2026-05-04&to=2026-05-03", "to", "is not after 2026-05-04"),
        ("/surveys?to=2026-05-03&time_zone=Mars", "time_zone", "must be a name of the time zone database"),
        ("/lots/LOT/statistics?by=colour", "by", "must be 'hour', 'row', 'zone', 'kind' or 'section'"),
        ("/lots/LOT/stalls?kind=big", "kind", "is no kind: write one of"),
        ("/lots/LOT/observations?after=7", "after", "write `next` of the part before"),
    ],
)  # fmt: skip
async def test_a_parameter_that_cannot_be_used_is_named_with_the_remedy(
    archive: Archive, path: str, field: str, words: str
) -> None:
    status, problem = await archive.refused(path.replace("LOT", archive.lot))
    assert (status, problem["field"]) == (422, field)
    assert words in problem["detail"]
    bodies.Problem.model_validate(problem)


@sweep(
    "path",
    [
        "/lots/ID", "/lots/ID/layouts", "/lots/ID/layouts/1/stalls", "/lots/ID/stalls", "/stalls/ID", "/lots/ID/zones",
        "/lots/ID/surveys", "/surveys/ID", "/surveys/ID/observations", "/lots/ID/observations", "/lots/ID/statistics",
        "/lots/LOT/layouts/9/stalls", "/lots/LOT/observations?survey=ID", "/lots/LOT/observations?stall=ID",
        "/nothing", "/lots/1",
    ],
)  # fmt: skip
async def test_what_is_not_there_is_said(archive: Archive, path: str) -> None:
    status, problem = await archive.refused(path.replace("ID", NOWHERE).replace("LOT", archive.lot))
    assert (status, problem["title"]) == (404, "Not Found")


async def test_surveys_stalls_and_changes_are_counted_over_a_period(archive: Archive) -> None:
    path = f"/lots/{archive.lot}"
    listed = await archive.shown(f"{path}/statistics/surveys", uses.SurveysUse)
    assert [each["id"] for each in listed["surveys"]] == [*reversed(archive.surveys)]
    assert {each["blurred"] for each in listed["surveys"]} == {None}
    stalls = await archive.shown(f"{path}/statistics/stalls", uses.StallsUse)
    assert (len(stalls["ids"]), stalls["surveys_in_period"]) == (40, 3)
    before, after = archive.surveys[:2]
    changed = await archive.shown(f"{path}/statistics/between?before={before}&after={after}", Changed)
    assert changed["compared"] + changed["unknown"] == 40
    found = await archive.shown(f"{path}/surveys/{after}/stalls", shapes.SurveyStalls)
    assert (found["hawk"]["survey_id"], len(found["features"])) == (after, 41)
    drawn = await archive.shown(f"{path}/surveys/{after}/map", shapes.SurveyMap)
    of_stalls = found["features"][1:]  # behind the lot
    assert drawn["ids"] == [each["id"] for each in of_stalls]
    for name, key in (("labels", "ref"), ("states", "state"), ("taken", "taken_probability")):
        assert drawn[name] == [each["properties"][key] for each in of_stalls]
    corners = np.array(drawn["corners"]).reshape(-1, 4, 2) * 1e-8 + drawn["origin"]
    assert np.abs(corners - [each["geometry"]["coordinates"][0][:4] for each in of_stalls]).max() < 2e-8
    status, problem = await archive.refused(f"/lots/{archive.far}/surveys/{after}/stalls")
    assert status == 404
    assert problem["field"] == "survey"
    assert problem["detail"].endswith("of this lot with this id; GET /api/v1/lots/{id}/surveys lists them")


@pytest.mark.slow
@sweep(
    ("method", "path", "field", "words"),
    [
        ("GET", "/lots/ID", "id", "there is no lot with this id; GET /api/v1/lots lists them"),
        ("GET", "/lots/ID/statistics", "id", "there is no lot with this id; GET /api/v1/lots lists them"),
        ("POST", "/lots/ID/name", "id", "there is no lot with this id; GET /api/v1/lots lists them"),
        ("GET", "/lots/ID/shares", "id", "there is no lot with this id; GET /api/v1/lots lists them"),
        ("GET", "/surveys/ID/observations", "id", "there is no survey with this id; GET /api/v1/surveys lists them"),
        ("POST", "/surveys/ID/delete", "id", "there is no survey with this id; GET /api/v1/surveys lists them"),
        ("GET", "/lots/LOT/surveys/ID/stalls", "survey", "no survey of this lot with this id; GET /api/v1/lots/{id}/s"),
        ("GET", "/stalls/ID", "id", "there is no stall with this id; GET /api/v1/lots/{id}/stalls lists those of"),
        ("GET", "/lots/LOT/layouts/9/stalls", "version", "there is no layout with this number; GET /api/v1/lots/{id}/"),
        ("POST", "/changes/99/undo", "seq", "there is no change with this number; GET /api/v1/changes lists them"),
        ("POST", "/shares/ID/take-back", "id", "there is no link with this id; GET /api/v1/lots/{id}/shares lists"),
        ("GET", "/features/collections/lots/items/ID", "id", "there is no feature with this id; GET /api/v1/features/"),
    ],
)
@sweep("given", [NOWHERE, "nix"])
async def test_an_id_that_is_not_there_is_named_with_the_list_of_those_that_are(
    archive: Archive, method: str, path: str, field: str, words: str, given: str
) -> None:
    body = {"name": "North"} if path.endswith("name") else {}
    if given == "nix":
        path = path.replace("/9/", "/nix/").replace("/99/", "/nix/")
    asked = path.replace("ID", given).replace("LOT", archive.lot)
    status, problem = await archive.refused(
        asked, method=method, operator=True, body=body if method == "POST" else None
    )
    assert (status, problem["field"]) == (404, field), problem
    assert words in problem["detail"]
    bodies.Problem.model_validate(problem)


@sweep(
    ("path", "field"),
    [
        ("/features/collections/cars", "collection"), ("/features/collections/cars/items/1", "collection"),
        ("/shared/!/statistics", "token"), ("/recordings/a.mcap/keep", "name"),
        ("/lots/import/x/take", "preview"), ("/lots/LOT/plan/import/x/take", "preview"),
    ],
)  # fmt: skip
async def test_a_value_of_a_path_that_has_not_its_form_is_named(archive: Archive, path: str, field: str) -> None:
    status, problem = await archive.refused(path.replace("LOT", archive.lot), operator=True)
    assert (status, problem["field"]) == (404, field)


async def test_another_method_of_an_address_stays_refused_as_such(archive: Archive) -> None:
    assert (await archive.refused("/lots/import"))[0] == 405


@sweep("method", ["GET", "POST"])
async def test_another_address_is_refused_with_the_list_of_all(archive: Archive, method: str) -> None:
    status, problem = await archive.refused("/nothing", method=method, operator=True)
    assert (status, problem["field"], problem["detail"]) == (404, "", NOTHING)


def test_every_field_of_a_path_has_words() -> None:
    found = {each.path.partition(f"/{{{field}}}")[0] for each in OPERATIONS for field in each.fields}
    assert found == {*WORDS}


async def test_surveys_that_are_due_are_asked_of_the_settings(archive: Archive) -> None:
    """Nothing is due without settings; a lot that is not there is named."""
    assert (await archive.shown(f"/lots/{archive.lot}/due?days=30", bodies.DueList))["items"] == []
    status, problem = await archive.refused(f"/lots/{'0' * 8 + '-0000-4000-8000-' + '0' * 12}/due")
    assert (status, problem["field"]) == (404, "id")


async def test_a_list_of_lots_says_when_the_next_survey_of_each_is_due(
    tmp_path: Path, rig: Rig, filled: Filled
) -> None:
    """The moment is asked for with the time of the newest survey, and again once a minute: no change of the store says
    that it has come.
    """
    asked: list[tuple[str, float | None]] = []

    def due(lot: str, name: str, last: float | None, now: float, days: int) -> list[datetime]:
        asked.append((lot, last))
        return [datetime.fromtimestamp(now + 3600, UTC)] if (lot, days) == (filled.lot, 7) else []

    rig.due, rig.lots = due, LotStore(Path(shutil.copy(filled.file, tmp_path / "lots.db")))
    stand, rig.folder = Stand(rig, tmp_path), tmp_path
    await rig.start()
    async with await stand.tool(Role.VIEWER) as viewer:
        assert rig.server is not None
        address = str(rig.server.make_url("/api/v1/lots"))
        async with viewer.get(address) as answer:
            items, tag = (await answer.json())["items"], answer.headers["ETag"]
        assert [each["due"] for each in items] == ["2027-01-15T09:00:00Z", None]
        newest = datetime.fromisoformat(items[0]["last_survey"]["ended"]).timestamp()
        lot, last = asked[0]
        assert lot == filled.lot
        assert last == pytest.approx(newest)
        for passed, wanted in ((30.0, 304), (30.0, 200)):
            rig.wall.advance(passed)
            async with viewer.get(address, headers={"If-None-Match": tag}) as answer:
                assert answer.status == wanted
        async with viewer.get(f"{address}/{filled.lot}") as answer:
            assert (await answer.json())["due"] == "2027-01-15T09:01:00Z"
    await stand.close()
    await rig.lots.close()
