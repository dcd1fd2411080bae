"""Import of a plan over HTTP: the file, its preview, and who may take it."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

from hawk.comm.protocol.authority import Role
from hawk.lots.plan_files import values
from tests.unit.lots.plan_import.imports import drawn, geojson
from tests.unit.web.v1.plans import Answer, Plans

pytestmark = pytest.mark.slow  # each file is read by a process of its own
PLAN = geojson(drawn(40))


async def send(plans: Plans, data: bytes, path: str = "/plan/import?name=plan.geojson") -> Answer:
    async with plans.session.post(plans.address(path), data=data) as response:
        return response.status, await response.json(content_type=None)


async def send_new(plans: Plans, path: str, **how: Any) -> Answer:
    assert plans.stand.rig.server is not None
    async with plans.session.post(plans.stand.rig.server.make_url(path), **how) as response:
        return response.status, await response.json(content_type=None)


async def test_a_plan_is_previewed_taken_undone_and_done_again(plans: Plans) -> None:
    before = await plans.get()
    status, shown = await send(plans, PLAN)
    assert (status, shown["file"], shown["format"], shown["lot"]) == (200, "plan.geojson", "GeoJSON", plans.lot)
    assert (len(shown["stay"]), len(shown["begin"]), shown["left_out_count"]) == (30, 10, 0)
    assert await plans.get() == before
    edit = await plans.opened()
    done = await plans.done(f"/plan/import/{shown['token']}/take", edit=edit)
    assert (len(done["stalls"]), done["undo"]) == (40, 1)
    assert {*await plans.stalls()} == {str(number) for number in range(1, 41)}
    assert (await plans.post(f"/plan/import/{shown['token']}/take", edit=edit))[0] == 409
    assert (await plans.done("/plan/undo", edit=edit))["operation"] == "import"
    assert len(await plans.stalls()) == 30
    await plans.done("/plan/redo", edit=edit)
    assert (await plans.done("/edit/close", edit=edit))["layout"] == 2


async def test_a_new_lot_begins_with_a_plan(plans: Plans) -> None:
    far = geojson(drawn(20, north=9000.0))
    status, shown = await send_new(plans, "/api/v1/lots/import?name=north.geojson", data=far)
    assert (status, shown["lot"], len(shown["begin"])) == (200, None, 20)
    status, refusal = await send_new(plans, f"/api/v1/lots/import/{shown['token']}/take", json={})
    assert (status, refusal["field"]) == (422, "name")
    status, made = await send_new(plans, f"/api/v1/lots/import/{shown['token']}/take", json={"name": "<b>North</b>"})
    assert (status, made["stalls"], made["kind"]) == (200, 20, "import")
    async with plans.session.get(plans.address("").with_path(f"/api/v1/lots/{made['lot']}")) as response:
        assert (await response.json())["name"] == "<b>North</b>"
    async with plans.session.post(plans.change(made)) as response:
        assert response.status == 200


async def test_a_file_that_cannot_be_used_is_refused_with_field_and_remedy(plans: Plans) -> None:
    before = await plans.get()
    for data, query, field in (
        (PLAN[:-50], "", "file"),
        (b"", "", "file"),
        (PLAN, "&crs=EPSG:1", "crs"),
        (PLAN, "&replace=yes", "replace"),
        (PLAN, "&colour=red", "colour"),
        (PLAN, "&pin=1,2,52,5", "pin"),
    ):
        status, refusal = await send(plans, data, f"/plan/import?name=plan.geojson{query}")
        assert (status, refusal["field"]) == (422, field), refusal
        assert refusal["detail"]
    assert await plans.get() == before


async def test_a_file_that_is_too_large_is_refused_before_it_is_read(
    plans: Plans, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(values, "LARGEST_BYTES", 100_000)
    async with plans.session.post(plans.address("/plan/import"), data=bytes(200_000)) as response:
        found = await response.json(content_type=None)
        assert (response.status, found["detail"]) == (413, "The file is too large: 0 MB are read at most.")


async def test_one_file_is_read_at_a_time(plans: Plans) -> None:
    answers = await asyncio.gather(*(send(plans, PLAN) for _ in range(3)))
    assert sorted(status for status, _ in answers) == [200, 409, 409]
    words = next(answer["detail"] for status, answer in answers if status == 409)
    assert words == "another file is being read: send this one again in a minute"


async def test_viewers_may_not_import_and_no_lot_is_none(plans: Plans) -> None:
    viewer = await plans.stand.tool(Role.VIEWER)
    async with viewer.post(plans.address("/plan/import"), data=PLAN) as response:
        found = await response.json(content_type=None)
        assert (response.status, found["detail"]) == (403, "Lots are changed by operators: log in as operator.")
    plans.lot = "0" * 36
    assert (await send(plans, PLAN))[0] == 404
