"""Changes by the API: each is made by an operator alone."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from hawk.comm.protocol.heartbeat import DroneStatus, VehicleStatus
from hawk.config.sections import StoreSettings
from hawk.lots import answers as lots
from hawk.lots.ingest import save
from hawk.lots.plan import answers as plans
from hawk.lots.plan_import.answers import PlanPreview
from hawk.lots.values import Doubtful, PossiblePlace
from hawk.store.recordings import Recordings
from hawk.web.v1 import bodies
from hawk.web.v1.operations import Operation
from hawk.web.v1.table import OPERATIONS
from tests.sweep import sweep
from tests.unit.lots.plan_import.imports import drawn, geojson
from tests.unit.lots.repaints import extra, flown
from tests.unit.lots.surveys import later, survey
from tests.unit.store.recorded import recorded
from tests.unit.web.rig import Rig, browser
from tests.unit.web.v1.archive import NOWHERE, Archive
from tests.unit.web.v1.recordings.test_files import FIRST, SECOND

CHANGES = [each for each in OPERATIONS if each.is_change and not each.for_drones]
CORNERS = [[51.99985, 4.9999], [51.99985, 5.001], [51.99996, 5.001], [51.99996, 4.9999]]


def path_of(operation: Operation, archive: Archive) -> str:
    ids = {"{id}": archive.surveys[0] if operation.path.startswith("/surveys") else archive.lot, "{seq}": "1"}
    ids["{preview}"] = "0" * 32
    path = operation.path.replace("{name}", FIRST)
    for name, value in ids.items():
        path = path.replace(name, value)
    return path


@pytest.fixture
async def recordings(rig: Rig, tmp_path: Path) -> Path:
    folder = tmp_path / "recordings"
    folder.mkdir()
    for name in (FIRST, SECOND):
        recorded(folder / name, "")
    rig.recordings = Recordings(StoreSettings(directory=tmp_path))
    return folder


@pytest.mark.slow
@sweep("operation", CHANGES)
async def test_a_viewer_a_stranger_and_another_origin_change_nothing(archive: Archive, operation: Operation) -> None:
    path = path_of(operation, archive)
    tag = (await archive.ask("/lots")).headers["ETag"]
    status, problem = await archive.refused(path, method="POST", body={})
    assert (status, "log in as operator" in problem["detail"]) == (403, True)
    foreign = {"operator": True, "body": {}, "Origin": "https://elsewhere.example"}
    status, problem = await archive.refused(path, method="POST", **foreign)
    assert (status, problem["detail"].split(":")[0]) == (403, "Origin")
    async with browser() as stranger, stranger.post(archive.address(path), json={}) as response:
        assert response.status == 401
    assert (await archive.ask("/lots", If_None_Match=tag)).status == 304


@pytest.mark.slow
async def test_lots_are_named_pinned_and_split_and_each_change_is_undone(archive: Archive) -> None:
    before = await archive.get("/lots")
    path = f"/lots/{archive.lot}"
    asked: list[tuple[str, Mapping[str, Any], type[lots.Shown]]] = [
        ("name", {"name": "North"}, lots.Done),
        ("pin", {"points": [{"from": [52.0, 5.0], "to": [52.00001, 5.0]}]}, lots.Pinned),
        ("split", {"name": "South", "outline": CORNERS}, lots.Done),
        ("merge", {"with": archive.far}, lots.Done),
    ]
    for kind, body, model in asked:
        if kind == "merge":
            status, problem = await archive.refused(f"{path}/{kind}", method="POST", operator=True, body=body)
            assert (status, problem["field"]) == (422, "with")
            continue
        done = await archive.done(f"{path}/{kind}", **body)
        model.model_validate(done)
        assert (done["kind"], done["lot"]) == (kind, archive.lot)
    listed = (await archive.shown("/changes", lots.ChangeList))["items"]
    assert [each["kind"] for each in listed] == ["split", "pin", "name"]
    assert await archive.items("/changes?limit=1") == listed
    for each in listed:
        lots.Undone.model_validate(await archive.done(f"/changes/{each['seq']}/undo"))
    assert await archive.get("/lots") == before
    assert all(each["undone"] for each in await archive.items("/changes"))
    status, problem = await archive.refused(f"/changes/{listed[0]['seq']}/undo", method="POST", operator=True)
    assert (status, problem["field"]) == (409, "seq")


@pytest.mark.nightly
async def test_a_survey_is_moved_and_placed(archive: Archive) -> None:
    moved = await archive.done(f"/surveys/{archive.surveys[1]}/move", lot=None, name="Alone")
    lots.Done.model_validate(moved)
    assert [each["name"] for each in await archive.items("/lots")] == ["Lot 1", "Lot 2", "Alone"]
    await archive.done(f"/changes/{moved['seq']}/undo")
    doubtful = Doubtful("Two places fit", (PossiblePlace(0.0, 0.0, 0.0, 3.0), PossiblePlace(0.0, 2.5, 0.0, 2.0)))
    given = later(survey(seed=5), 7, hours=200.0)
    saved = await archive.store.write(lambda connection: save(connection, given, lambda *_: doubtful))
    shown = await archive.shown(f"/surveys/{saved.survey}", lots.Survey)
    assert (shown["placed"], shown["doubt"]["why"], len(shown["doubt"]["places"])) == (
        "unregistered", "Two places fit", 2,
    )  # fmt: skip
    (waiting,) = (await archive.shown(f"/lots/{archive.lot}/proposals", lots.Proposals))["doubtful"]
    assert waiting["survey"] == saved.survey
    assert (await archive.done(f"/surveys/{saved.survey}/place", place=0))["kind"] == "place"
    assert (await archive.get(f"/surveys/{saved.survey}"))["placed"] == "registered"


@pytest.mark.slow
async def test_a_deleted_survey_is_listed_only_when_it_is_asked_for_and_comes_back(archive: Archive) -> None:
    before, gone = await archive.get("/surveys"), archive.surveys[1]
    deleted = await archive.done(f"/surveys/{gone}/delete")
    lots.Done.model_validate(deleted)
    assert gone not in [each["id"] for each in await archive.items("/surveys")]
    assert [each["id"] for each in await archive.items("/surveys?placed=deleted")] == [gone]
    assert (await archive.shown(f"/surveys/{gone}", lots.Survey))["placed"] == "deleted"
    assert (await archive.get("/features/collections/surveys/items"))["numberMatched"] == 3
    (listed,) = await archive.items(f"/changes?lot={archive.lot}")  # as a page that was loaded again reads it
    assert (listed["kind"], listed["surveys"], listed["undone"], listed["kept"]) == ("delete", [gone], None, None)
    await archive.done(f"/changes/{listed['seq']}/undo")
    assert await archive.get("/surveys") == before
    (listed,) = await archive.items("/changes")
    assert listed["undone"] is not None
    assert listed["kept"] == f"change: {listed['seq']} was undone already; make the change again to have it back"


@pytest.mark.slow
async def test_the_list_of_changes_says_of_each_its_lot_and_why_it_cannot_be_undone(archive: Archive) -> None:
    for name in ("North", "South"):
        await archive.done(f"/lots/{archive.lot}/name", name=name)
    await archive.done(f"/lots/{archive.far}/name", name="Far")
    listed = await archive.items(f"/changes?lot={archive.lot}")
    assert [(each["lot"], each["surveys"]) for each in listed] == [(archive.lot, [])] * 2
    assert [each["kept"] for each in listed] == [
        None, f"change: lots of {listed[1]['seq']} were changed since; undo the later changes first",
    ]  # fmt: skip
    assert [each["lot"] for each in await archive.items("/changes")] == [archive.far, archive.lot, archive.lot]
    assert await archive.items(f"/changes?lot={NOWHERE}") == []
    status, problem = await archive.refused("/changes?lot=x")
    assert (status, problem["field"]) == (422, "lot")


@pytest.mark.nightly
async def test_rows_are_numbered_as_painted_and_old_surveys_keep_the_labels_of_their_time(archive: Archive) -> None:
    """A's letter is ours: E, here B, gets it; the observations of a survey say where the stalls were then."""
    path, survey = f"/lots/{archive.lot}", archive.surveys[0]
    then = await archive.items(f"/surveys/{survey}/observations?limit=1000")
    file = await archive.get(f"{path}/surveys/{survey}/stalls")
    edit = (await archive.done(f"{path}/edit", who="Ann"))["edit"]
    for operation in (
        {"do": "rename", "row": "B", "to": "A"},
        {"do": "reverse", "row": "A"},
        {"do": "shift", "row": "A", "by": 100},
        {"do": "rename", "row": "B", "to": "Nord"},
        {"do": "swap", "rows": ["A", "Nord"]},
    ):
        await archive.done(f"{path}/plan", edit=edit, operation=operation)
    closed = await archive.done(f"{path}/edit/close", edit=edit, why="as painted")
    north = await archive.items(f"{path}/stalls?row=Nord")
    assert [(each["row"], each["is_named"]) for each in north] == [("Nord", True)] * 20
    assert {each["label"] for each in north} == {f"Nord {number}" for number in range(101, 121)}
    assert len(await archive.items(f"{path}/stalls?row=A")) == 20
    assert await archive.items(f"{path}/stalls?row=B") == []
    assert await archive.items(f"/surveys/{survey}/observations?limit=1000") == then
    assert (await archive.get(f"{path}/surveys/{survey}/stalls"))["features"] == file["features"]
    await archive.done(f"/changes/{closed['seq']}/undo")
    assert {each["label"] for each in await archive.items(f"{path}/stalls?row=B")} == {f"B {n}" for n in range(1, 21)}


@pytest.mark.nightly
async def test_an_owners_plan_is_taken_though_hawk_has_given_its_labels_to_others(archive: Archive) -> None:
    """The owner numbers both rows from the other side; hawk's own labels are the same words, on other stalls."""
    path = f"/lots/{archive.lot}"
    stalls = await archive.items(f"{path}/stalls?limit=1000")
    words = dict(zip((each["label"] for each in stalls), (each["label"] for each in reversed(stalls)), strict=True))
    plan = await archive.get(f"{path}/plan")
    for each in plan["stalls"]:
        each["label"] = words[each["label"]]
    edit = (await archive.done(f"{path}/edit", who="Ann"))["edit"]
    answer = await archive.operator.post(archive.address(f"{path}/plan/import?name=plan.json"), data=json.dumps(plan))
    preview = PlanPreview.model_validate(await answer.json())
    assert (len(preview.stay), preview.clash_count) == (40, 0)
    await archive.done(f"{path}/plan/import/{preview.token}/take", edit=edit)
    found = {each["id"]: each["label"] for each in await archive.items(f"{path}/stalls?limit=1000")}
    assert found == {each["id"]: words[each["label"]] for each in stalls}
    await archive.done(f"{path}/plan/undo", edit=edit)
    assert await archive.items(f"{path}/stalls?limit=1000") == stalls


@pytest.mark.slow
async def test_proposals_are_taken_over_or_dropped(archive: Archive) -> None:
    for number in (5, 6):
        given = extra(replace(flown(number), stalls=flown(number).stalls[:40]))
        await archive.store.write(lambda connection, given=given: save(connection, given, archive.store.register))  # type: ignore[misc]
    path = f"/lots/{archive.lot}"
    (proposed,) = (await archive.shown(f"{path}/proposals", lots.Proposals))["surveys"]
    assert len(proposed["begin"]) == 1
    done = await archive.done(f"{path}/drop", survey=proposed["survey"], begin="all")
    await archive.done(f"/changes/{done['seq']}/undo")
    begin = [each["id"] for each in proposed["begin"]]
    await archive.done(f"{path}/take-over", survey=proposed["survey"], begin=begin, why="painted")
    layouts = await archive.items(f"{path}/layouts")
    assert [each["why"] for each in layouts][1:] == ["painted"]
    assert len(await archive.items(f"{path}/stalls")) == 41


@pytest.mark.slow
async def test_a_plan_is_edited_undone_done_again_and_closed(archive: Archive) -> None:
    path = f"/lots/{archive.lot}"
    opened = await archive.done(f"{path}/edit", who="Ann")
    plans.Opened.model_validate(opened)
    edit = opened["edit"]
    status, problem = await archive.refused(f"{path}/edit", method="POST", operator=True, body={"who": "Bob"})
    assert (status, problem["who"], problem["since"]) == (409, "Ann", opened["since"])
    bodies.Problem.model_validate(problem)
    operation = {"do": "set_kind", "row": "A", "kind": "staff"}
    done = await archive.done(f"{path}/plan", edit=edit, operation=operation)
    plans.Edited.model_validate(done)
    assert (len(done["stalls"]), done["undo"]) == (20, 1)
    assert len(await archive.items(f"{path}/stalls?kind=staff")) == 20
    for step, count in (("undo", 0), ("redo", 20)):
        plans.Stepped.model_validate(await archive.done(f"{path}/plan/{step}", edit=edit))
        assert len(await archive.items(f"{path}/stalls?kind=staff")) == count
    closed = await archive.done(f"{path}/edit/close", edit=edit, why="signs")
    plans.Closed.model_validate(closed)
    assert closed["layout"] == 2
    await archive.done(f"/changes/{closed['seq']}/undo")
    assert await archive.items(f"{path}/stalls?kind=staff") == []


@pytest.mark.slow
@sweep(
    ("path", "body", "field", "words"),
    [
        ("/lots/LOT/name", {}, "name", "is missing: write it"),
        ("/lots/LOT/name", {"name": 3}, "name", "must be text"),
        ("/lots/LOT/name", {"name": " "}, "name", "is empty: write one or more letters"),
        ("/lots/LOT/name", {"name": "\ud800"}, "body", "holds half a character"),
        ("/lots/LOT/name", {"name": "N", "colour": "red"}, "colour", "is not known here: leave it out; there is name"),
        ("/lots/LOT/name", [1], "body", "must be a JSON object"),
        ("/lots/LOT/split", {"name": "S", "outline": CORNERS[:2]}, "outline", "must be a list of 3 or more, not 2"),
        ("/lots/LOT/split", {"name": "S", "outline": [[91, 0], *CORNERS]}, "outline[0][0]", "must be 90 or less"),
        ("/lots/LOT/pin", {"points": [{"from": [1, 2]}]}, "points[0].to", "is missing: write it"),
        ("/lots/LOT/pin?force=1", {"points": []}, "force", "there is no parameter"),
        ("/surveys/SURVEY/place", {"place": -1}, "place", "must lie between 0 and 1000"),
        ("/lots/LOT/plan", {"edit": NOWHERE, "operation": {"do": "fly"}}, "operation.do", "must be 'add_stall'"),
        ("/lots/LOT/plan", {"edit": NOWHERE, "operation": {"do": "move", "row": "B", "north": 0}}, "operation.east",
         "is missing: write it"),
        ("/lots/LOT/plan", {"edit": NOWHERE, "operation": {"do": "remove"}}, "operation.stalls", "names no stalls"),
    ],
)  # fmt: skip
async def test_a_body_that_cannot_be_used_is_refused_with_the_field_and_changes_nothing(
    archive: Archive, path: str, body: object, field: str, words: str
) -> None:
    tag = (await archive.ask("/lots")).headers["ETag"]
    path = path.replace("LOT", archive.lot).replace("SURVEY", archive.surveys[0])
    status, problem = await archive.refused(path, method="POST", operator=True, body=body)
    assert (status, problem["field"]) == (422, field), problem
    assert words in problem["detail"]
    assert (await archive.ask("/lots", If_None_Match=tag)).status == 304


ENGLISH = ("Input should", "should have", "String should", "List should", "Value error", "Field required", "permitted")


@pytest.mark.slow
async def test_every_body_is_refused_in_plain_words_with_the_field_and_changes_nothing(archive: Archive) -> None:
    tag = (await archive.ask("/lots")).headers["ETag"]
    tried = 0
    for operation in CHANGES:
        fields = {} if operation.body is None else operation.body.model_fields
        keys = {field.alias or name for name, field in fields.items()}
        needs = any(field.is_required() for field in fields.values())
        for body in ({"x-ray": 1}, *([{}] if needs else []), *({key: {"odd": 1}} for key in keys)):
            if operation.takes_file:
                continue
            path = path_of(operation, archive)
            status, problem = await archive.refused(path, method="POST", operator=True, body=body)
            assert status == 422, (operation.name, body, problem)
            assert problem["field"].replace("[", ".").split(".")[0] in keys | {"x-ray"}, (operation.name, body, problem)
            assert problem["detail"], operation.name
            assert not any(words in problem["detail"] for words in ENGLISH), problem
            tried += 1
    assert tried > 40
    assert (await archive.ask("/lots", If_None_Match=tag)).status == 304


async def test_recordings_are_listed_kept_and_deleted(rig: Rig, recordings: Path, archive: Archive) -> None:
    whole = await archive.shown("/recordings", bodies.RecordingList)
    assert [each["name"] for each in whole["items"]] == [FIRST, SECOND]
    assert await archive.items("/recordings?limit=1") == whole["items"]
    tag = (await archive.ask("/recordings")).headers["ETag"]
    assert (await archive.ask("/recordings", If_None_Match=tag)).status == 304
    bodies.Kept.model_validate(await archive.done(f"/recordings/{FIRST}/keep", keep=True))
    assert (await archive.ask("/recordings", If_None_Match=tag)).status == 200
    status, problem = await archive.refused(f"/recordings/{FIRST}/delete", method="POST", operator=True)
    assert (status, problem["field"]) == (409, "name")
    rig.publish(DroneStatus(vehicle=VehicleStatus(armed=True)))
    status, problem = await archive.refused(f"/recordings/{SECOND}/delete", method="POST", operator=True)
    assert (status, problem["detail"]) == (409, "wait until the motors are off")
    rig.publish(DroneStatus(vehicle=VehicleStatus(armed=False)))
    bodies.Deleted.model_validate(await archive.done(f"/recordings/{SECOND}/delete"))
    assert not (recordings / SECOND).exists()
    status, problem = await archive.refused(f"/recordings?after={SECOND}")
    assert (status, problem["field"]) == (422, "after")
    status, _ = await archive.refused(f"/recordings/{SECOND}/keep", method="POST", operator=True, body={"keep": True})
    assert status == 404


async def test_links_are_listed_made_and_taken_back(rig: Rig, archive: Archive) -> None:
    path = f"/lots/{archive.lot}/shares"
    made = await archive.done(path, days=7)
    lots.SharedLink.model_validate(made)
    (listed,) = (await archive.shown(path, lots.SharedLinks))["shares"]
    assert (listed["id"], listed["open"], made["token"] in str(listed)) == (made["id"], True, False)
    tag = (await archive.ask(path)).headers["ETag"]
    assert (await archive.ask(path, If_None_Match=tag)).status == 304
    rig.wall.advance(8 * 86_400)
    response = await archive.ask(path, If_None_Match=tag)
    assert (response.status, (await response.json())["shares"][0]["open"]) == (200, False)
    other = await archive.done(path, days=1)
    lots.TakenBack.model_validate(await archive.done(f"/shares/{other['id']}/take-back"))
    assert [each["open"] for each in (await archive.get(path))["shares"]] == [False, False]
    for days in (0, 367, "seven"):
        status, problem = await archive.refused(path, method="POST", operator=True, body={"days": days})
        assert (status, problem["field"]) == (422, "days")


@pytest.mark.slow  # the file is read by a process of its own
async def test_a_plan_is_imported_and_makes_a_lot(archive: Archive) -> None:
    path = f"/lots/{archive.lot}/plan/import"
    shown = await sent(archive, f"{path}?name=plan.geojson", geojson(drawn(40)))
    PlanPreview.model_validate(shown)
    assert (shown["lot"], shown["file"], shown["format"]) == (archive.lot, "plan.geojson", "GeoJSON")
    edit = (await archive.done(f"/lots/{archive.lot}/edit", who="Ann"))["edit"]
    taken = await archive.done(f"{path}/{shown['token']}/take", edit=edit, uncertain=True)
    plans.Edited.model_validate(taken)
    assert (len(taken["stalls"]), taken["undo"]) == (len(shown["begin"]) + len(shown["stay"]), 1)
    away = geojson(drawn(10, north=5000.0))
    other = await sent(archive, "/lots/import", away)
    assert other["lot"] is None
    begun = await archive.done(f"/lots/import/{other['token']}/take", name="East")
    lots.Begun.model_validate(begun)
    assert [each["name"] for each in await archive.items("/lots")][2:] == ["East"]


async def test_a_file_that_is_no_plan_is_refused_with_the_remedy(archive: Archive) -> None:
    for given in ("replace=perhaps", "colour=red", "pin=1,2"):
        path = f"/lots/{archive.lot}/plan/import?{given}"
        status, problem = await archive.refused(path, method="POST", operator=True, body={})
        assert (status, problem["field"]) == (422, given.partition("=")[0])


async def sent(archive: Archive, path: str, data: bytes) -> Any:
    async with archive.operator.post(archive.address(path), data=data) as response:
        assert response.status == 200, await response.text()
        return await response.json()


async def test_where_nothing_is_recorded_the_list_says_so(archive: Archive) -> None:
    status, problem = await archive.refused("/recordings")
    assert (status, problem["detail"]) == (409, "nothing is recorded here")
