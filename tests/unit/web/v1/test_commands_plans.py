"""Plans over HTTP: edits, operations, and who may do them."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from typing import Any

import pytest

from hawk.comm.protocol.authority import Role
from hawk.lots.ingest import save
from tests.unit.lots.plan.plans import drawn_lot
from tests.unit.lots.surveys import DATUM, box, later, survey
from tests.unit.web.v1.plans import Plans

HTML = "<b onclick='alert(1)'>Ann & Bob</b>"
NOWHERE = "0" * 36


@pytest.mark.nightly
async def test_a_plan_is_corrected_undone_done_again_and_closed(plans: Plans) -> None:
    edit = await plans.opened()
    first = (await plans.stalls())["A 1"]
    assert (first["kind"], first["is_confirmed"], first["state"]) == ("", False, None)
    kind = {"do": "set_kind", "stalls": [first["id"]], "kind": "disabled"}
    done = await plans.done("/plan", edit=edit, operation=kind)
    assert [(each["label"], each["kind"]) for each in done["stalls"]] == [("A 1", "disabled")]
    assert (done["undo"], done["redo"]) == (1, 0)
    assert (await plans.done("/plan/undo", edit=edit))["stalls"][0]["kind"] == ""
    assert (await plans.done("/plan/redo", edit=edit))["stalls"][0]["kind"] == "disabled"
    status, plan = await plans.get(f"/plan?since={done['revision'] - 1}")
    assert (status, [each["label"] for each in plan["stalls"]], plan["edit"]["who"]) == (200, ["A 1"], "Ann")
    closed = await plans.done("/edit/close", edit=edit, why="repainted")
    _, layouts = await plans.get("/layouts")
    assert [(each["version"], each["who"], each["why"]) for each in layouts["items"]][1] == (2, "Ann", "repainted")
    _, lot = await plans.get()
    assert (lot["edit"], lot["revision"], lot["zones"]) == (None, done["revision"] + 2, [])
    assert (await plans.get("/plan?layout=1"))[1]["stalls"][0]["kind"] == ""
    async with plans.session.post(plans.change(closed)) as response:
        assert (response.status, await response.json()) == (200, {"seq": closed["seq"], "kind": "plan"})
    assert (await plans.stalls())["A 1"]["kind"] == ""


@pytest.mark.fault("a person's name holds HTML", "it is text, in the answers and for the second person")
async def test_a_person_who_edits_is_named_to_the_second_one_as_text(plans: Plans) -> None:
    await plans.opened(HTML)
    status, refusal = await plans.post("/edit", who="Bob")
    assert (status, refusal["field"], refusal["who"]) == (409, "edit", HTML)
    assert refusal["detail"].startswith(f"{HTML} edits this plan since {refusal['since']}: wait until it is closed")
    assert (await plans.done("/edit", who="Bob", take_over=True))["who"] == "Bob"


@pytest.mark.slow
@pytest.mark.fault(
    "two persons correct one plan at once",
    "one edits; the other one sees who and since when, and nothing of theirs is written",
)
async def test_of_two_persons_at_once_one_edits(plans: Plans) -> None:
    answers = await asyncio.gather(*(plans.post("/edit", who=f"Person {number}") for number in range(8)))
    assert sorted(status for status, _ in answers) == [200, *[409] * 7]
    edit = next(answer["edit"] for status, answer in answers if status == 200)
    removed = {"do": "remove", "row": "A"}
    edits = (NOWHERE, edit, NOWHERE)
    tried = await asyncio.gather(*(plans.post("/plan", edit=each, operation=removed) for each in edits))
    assert sorted(status for status, _ in tried) == [200, 409, 409]
    assert len(await plans.stalls()) == 20


@pytest.mark.slow
async def test_merge_split_and_undo_wait_until_an_edit_is_closed(plans: Plans) -> None:
    other = await plans.store.write(lambda connection: drawn_lot(connection, 10))
    edit = await plans.opened()
    corners = [list(corner) for corner in box(-30, -5, 16.5, 70).polygons[0]]
    for lot, path, body in (
        (plans.lot, "/merge", {"with": other}),
        (other, "/merge", {"with": plans.lot}),
        (plans.lot, "/split", {"name": "x", "outline": corners}),
    ):
        at = Plans(plans.stand, plans.store, plans.session, lot)
        status, refusal = await at.post(path, **body)
        assert (status, refusal["who"]) == (409, "Ann")
        assert refusal["detail"].endswith("close the edit first")
    await plans.done("/edit/close", edit=edit)
    assert (await plans.post("/split", name="x", outline=corners))[0] == 200


@pytest.mark.nightly
async def test_an_area_without_stalls_goes_with_its_ground_into_another_lot(plans: Plans) -> None:
    edit = await plans.opened()
    for north, east in ((-18.0, 2.5), (0.0, 2.5)):
        area = [[north - 3, east - 1], [north - 3, east + 1], [north + 3, east + 1], [north + 3, east - 1]]
        await plans.done("/plan", edit=edit, operation={"do": "forbid", "outline": area, "name": f"{north:.0f}"})
    await plans.done("/edit/close", edit=edit)
    before = (await plans.get())[1]["zones"]
    corners = [list(corner) for corner in box(-30, -5, 16.5, 70).polygons[0]]
    split = await plans.done("/split", name="South", outline=corners)
    assert [each["name"] for each in (await plans.get())[1]["zones"]] == ["0"]
    async with plans.session.get(plans.address("").with_path("/api/v1/lots")) as response:
        (south,) = [each["id"] for each in (await response.json())["items"] if each["name"] == "South"]
    made = Plans(plans.stand, plans.store, plans.session, south)
    assert [each["name"] for each in (await made.get())[1]["zones"]] == ["-18"]
    merged = await plans.done("/merge", **{"with": south})
    zones = (await plans.get())[1]["zones"]
    assert {each["name"] for each in zones} == {"0", "-18"}
    status, plan = await plans.get("/plan?since=2")
    assert (status, plan["whole"]) == (200, True)
    for change in (merged, split):
        async with plans.session.post(plans.change(change)) as response:
            assert response.status == 200, await response.text()
    assert (await plans.get())[1]["zones"] == before


@pytest.mark.slow
async def test_the_areas_of_a_merged_lot_are_in_the_frame_of_the_kept_one(plans: Plans) -> None:
    first = await plans.store.write(lambda connection: save(connection, survey()))
    moved = replace(DATUM, longitude=5.01)
    east = replace(later(survey(), 2), datum=moved, outline=box(0, 0, 20, 54, moved))
    second = await plans.store.write(lambda connection: save(connection, east))
    assert first.lot is not None
    assert second.lot is not None
    other = Plans(plans.stand, plans.store, plans.session, second.lot)
    edit = await other.opened()
    area = [[30.0, 0.0], [30.0, 5.0], [35.0, 5.0]]
    await other.done("/plan", edit=edit, operation={"do": "forbid", "outline": area})
    await other.done("/edit/close", edit=edit)
    kept = Plans(plans.stand, plans.store, plans.session, first.lot)
    await kept.done("/merge", **{"with": second.lot})
    (zone,) = (await kept.get())[1]["zones"]
    assert [corner[1] for corner in zone["outline"]] == pytest.approx([686.5, 691.5, 691.5], abs=1.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("path", "body", "status", "field"),
    [
        ("/edit", {}, 422, "who"),
        ("/plan", {}, 422, "edit"),
        ("/plan", {"edit": NOWHERE, "operation": {"do": "remove", "row": "A"}}, 409, "edit"),
        ("/plan/undo", {"edit": "EDIT"}, 409, "edit"),
        ("/plan/redo", {"edit": "EDIT"}, 409, "edit"),
        ("/plan", {"edit": "EDIT", "operation": {"do": "remove", "row": "Q"}}, 422, "row"),
        ("/plan", {"edit": "EDIT", "operation": {"do": "remove", "row": "A"}, "x": 1}, 422, "x"),
        ("/edit/close", {"edit": "EDIT", "why": 7}, 422, "why"),
    ],
)  # fmt: skip
async def test_a_request_that_cannot_be_used_is_named_with_its_remedy(
    plans: Plans, path: str, body: dict[str, Any], status: int, field: str
) -> None:
    edit = await plans.opened()
    before = await plans.get()
    named = {key: edit if value == "EDIT" else value for key, value in body.items()}
    found, refusal = await plans.post(path, **named)
    assert (found, refusal["field"]) == (status, field)
    assert (await plans.get()) == before


async def test_a_number_in_the_address_that_is_none_and_a_lot_that_is_none_are_refused(plans: Plans) -> None:
    for query in ("since=-1", "since=x", "layout=1.5", "layout=" + "9" * 30, "since=%D9%A1"):
        status, refusal = await plans.get(f"/plan?{query}")
        assert (status, refusal["field"]) == (422, query.partition("=")[0])
        assert refusal["detail"] == "must be a whole number: write digits alone"
    assert (await plans.get("/plan?layout=9"))[0] == 404
    plans.lot = NOWHERE
    assert (await plans.get())[0] == 404
    assert (await plans.post("/edit", who="Ann"))[0] == 404


async def test_a_number_that_is_none_in_the_body_is_refused(plans: Plans) -> None:
    edit = await plans.opened()
    body = f'{{"edit": "{edit}", "operation": {{"do": "move", "row": "A", "north": NaN, "east": 0}}}}'
    async with plans.session.post(plans.address("/plan"), data=body) as response:
        found = await response.json(content_type=None)
        assert (response.status, found["field"]) == (422, "operation.north")
        assert found["detail"] == "must be a finite number"


async def test_a_viewer_reads_the_plan_and_corrects_nothing(plans: Plans) -> None:
    viewer = await plans.stand.tool(Role.VIEWER)
    reader = Plans(plans.stand, plans.store, viewer, plans.lot)
    assert (await reader.get())[0] == 200
    for path in ("/edit", "/edit/close", "/plan", "/plan/undo", "/plan/redo"):
        async with viewer.post(plans.address(path), json={"who": "x"}) as response:
            assert response.status == 403
