"""OGC API Features: answers by the standard, and GDAL, which QGIS reads with, opens the collections live."""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import sys
from collections.abc import AsyncIterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
import shapely

from hawk.lots.store import LotStore
from hawk.web.v1.features import answers as shapes
from hawk.web.v1.features import reads as features
from hawk.web.v1.features.parameters import box_of, period_of
from tests.sweep import sweep
from tests.unit.lots.repaints import by_place
from tests.unit.web.rig import Rig, browser
from tests.unit.web.stand import Stand
from tests.unit.web.v1.archive import NOWHERE, Archive, Filled

ITEMS = "/features/collections/{}/items"
COUNTS = {"lots": 2, "stalls": 60, "surveys": 4}


def links_of(found: dict[str, Any]) -> dict[str, str]:
    return {each["rel"]: each["href"] for each in found["links"]}


@pytest.mark.slow
async def test_every_link_from_the_landing_page_leads_on(archive: Archive) -> None:
    landing = await archive.shown("/features", shapes.Landing)
    links = links_of(landing)
    assert str(archive.address("/features")) == links["self"]
    classes = await archive.shown(archive.path_of(links["conformance"]), shapes.Conformance)
    assert [each.rsplit("/")[-1] for each in classes["conformsTo"]] == ["core", "geojson"]
    definition = await archive.ask(archive.path_of(links["service-desc"]))
    assert (definition.status, definition.content_type) == (200, "application/vnd.oai.openapi+json")
    listed = await archive.shown(archive.path_of(links["data"]), shapes.Collections)
    assert [each["id"] for each in listed["collections"]] == ["lots", "stalls", "sections", "surveys"]
    for each in (one for one in listed["collections"] if one["id"] in COUNTS):
        (box,) = each["extent"]["spatial"]["bbox"]
        assert box == pytest.approx([5.0, 52.0, 6.0, 52.0], abs=0.002)
        assert each["extent"]["temporal"]["interval"] == [["2026-02-02T02:40:00Z", "2026-02-05T02:55:00Z"]]
        links = links_of(each)
        assert await archive.shown(archive.path_of(links["self"]), shapes.Collection) == each
        response = await archive.ask(archive.path_of(links["items"]))
        assert response.content_type == "application/geo+json"
        found = shapes.FeatureCollection.model_validate(await response.json(content_type=None))
        assert found.number_matched == COUNTS[each["id"]]
        if "alternate" in links:
            assert len((await archive.get(archive.path_of(links["alternate"])))["items"]) == found.number_matched


@pytest.mark.slow
@sweep("name", COUNTS)
async def test_parts_follow_each_other_in_both_directions(archive: Archive, name: str) -> None:
    path = f"{ITEMS.format(name)}?limit=7"
    whole = [each["id"] for each in (await archive.get(ITEMS.format(name)))["features"]]
    found: list[str] = []
    while True:
        part = await archive.shown(path, shapes.FeatureCollection)
        assert part["numberReturned"] == len(part["features"])
        assert part["numberMatched"] == COUNTS[name]
        found += [each["id"] for each in part["features"]]
        links = links_of(part)
        if "next" not in links:
            break
        path = archive.path_of(links["next"])
    assert found == whole
    assert len(set(found)) == COUNTS[name]
    back: list[str] = []
    while "prev" in links:
        part = await archive.get(archive.path_of(links["prev"]))
        back = [each["id"] for each in part["features"]] + back
        links = links_of(part)
    assert back == whole[: len(back)]
    assert len(back) == (COUNTS[name] - 1) // 7 * 7


async def test_more_features_than_an_answer_holds_are_no_error(
    archive: Archive, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(features, "MOST_FEATURES", 25)
    part = await archive.get(f"{ITEMS.format('stalls')}?limit=1000")
    assert (part["numberReturned"], part["numberMatched"]) == (25, 60)
    assert links_of(part)["next"].endswith("limit=25&offset=25")


@pytest.mark.slow
@sweep("name", COUNTS)
async def test_a_feature_is_found_by_its_id(archive: Archive, name: str) -> None:
    first = (await archive.get(f"{ITEMS.format(name)}?limit=1"))["features"][0]
    alone = await archive.shown(f"{ITEMS.format(name)}/{first['id']}", shapes.LinkedFeature)
    links = links_of({"links": alone.pop("links")})
    assert alone == first
    assert (await archive.get(archive.path_of(links["alternate"])))["id"] == first["id"]
    status, problem = await archive.refused(f"{ITEMS.format(name)}/{NOWHERE}")
    assert (status, problem["field"]) == (404, "id")


async def test_stalls_lie_where_the_plan_has_them_and_run_counter_clockwise(archive: Archive) -> None:
    listed = {each["id"]: each for each in await archive.items(f"/lots/{archive.lot}/stalls")}
    found = (await archive.get(f"{ITEMS.format('stalls')}?limit=40"))["features"]
    for feature in found:
        stall, ring = listed[feature["id"]], shapely.geometry.shape(feature["geometry"]).exterior
        assert ring.is_ccw
        assert ring.centroid.x == pytest.approx(stall["longitude"], abs=1e-7)
        assert ring.centroid.y == pytest.approx(stall["latitude"], abs=1e-7)
        shown = feature["properties"]
        for name in ("label", "kind", "state", "taken_probability", "observed"):
            assert shown[name] == stall[name]


@pytest.mark.parametrize(
    ("name", "asked", "count"),
    [
        ("lots", "bbox=4.9,51.9,5.1,52.1", 1),
        ("lots", "bbox=4.9,51.9,0,5.1,52.1,9", 1),
        ("lots", "bbox=170,-90,-170,90", 0),
        ("lots", "bbox=5.9,-90,-170,90", 1),
        ("surveys", "bbox=4.9,51.9,5.1,52.1", 3),
        ("surveys", "bbox=4.9,51.9,5.1,52.1&limit=2", 3),
        ("stalls", "bbox=5.9,51.9,6.1,52.1", 20),
        ("stalls", "bbox=-180,-90,180,90&limit=7", 60),
        ("stalls", "bbox=5.00006,51.99998,5.00008,52.00002", 1),
        ("surveys", "datetime=2026-02-03", 1),
        ("surveys", "datetime=2026-02-03T02:45:00Z", 1),
        ("surveys", "datetime=2026-02-03T00:00:00Z/..", 3),
        ("surveys", "datetime=../2026-02-03", 2),
        ("surveys", "datetime=/2026-02-03", 2),
        ("lots", "datetime=2026-02-04", 1),
        ("stalls", "datetime=2030-01-01/..", 0),
        ("stalls", "datetime=../2030-01-01&limit=50", 60),
        ("stalls", "offset=59", 60),
        ("stalls", "offset=100&limit=999999999", 60),
    ],
)
async def test_features_are_chosen_by_place_and_time(archive: Archive, name: str, asked: str, count: int) -> None:
    found = await archive.shown(f"{ITEMS.format(name)}?{asked}", shapes.FeatureCollection)
    assert found["numberMatched"] == count


@sweep(
    ("asked", "field"),
    [
        ("limit=0", "limit"), ("limit=many", "limit"), ("bbox=1,2,3", "bbox"), ("bbox=1,2,3,x", "bbox"),
        ("bbox=1,9,3,2", "bbox"), ("datetime=soon", "datetime"), ("datetime=2026-05-02/2026-05-01", "datetime"),
        ("colour=red", "colour"), ("offset=-1", "offset"), ("bbox=nan,0,1,1", "bbox"),
    ],
)  # fmt: skip
async def test_a_parameter_that_cannot_be_used_is_a_bad_request_as_the_standard_says(
    archive: Archive, asked: str, field: str
) -> None:
    status, problem = await archive.refused(f"{ITEMS.format('stalls')}?{asked}")
    assert (status, problem["field"]) == (400, field)


async def test_a_collection_that_is_not_there_is_said(archive: Archive) -> None:
    assert (await archive.refused("/features/collections/cars"))[0] == 404
    assert (await archive.refused("/features/collections/cars/items"))[0] == 404


def test_a_box_with_heights_and_a_date_are_read_as_they_are_meant() -> None:
    assert box_of("1,2,-5,3,4,5") == (1.0, 2.0, 3.0, 4.0)
    begin, end = period_of("1970-01-02")
    assert begin == 86_400.0
    assert end == pytest.approx(2 * 86_400.0, abs=0.01)
    assert period_of("1970-01-02T00:00:00+01:00/..") == (82_800.0, None)


# -- GDAL -------------------------------------------------------------------------------------------------------------

GDAL_S = 60.0
LISTED = """
layers = [str(name) for name, _ in pyogrio.list_layers(address)]
found = {}
for name in layers:
    info = pyogrio.read_info(address, layer=name)
    found[name] = [info["features"], info["geometry_type"], info["crs"] == "EPSG:4326" or "CRS84" in info["crs"]]
"""
READ = """
options = {"layer": "stalls", "PAGE_SIZE": "7"}
meta, _, shapes, columns = pyogrio.raw.read(address, **options)
named = dict(zip(meta["fields"], columns))
inside = pyogrio.raw.read(address, bbox=(5.9, 51.9, 6.1, 52.1), **options)[2]
found = {"label": list(named["label"]), "state": list(named["state"]), "shapes": len(shapes), "inside": len(inside)}
"""


@pytest.fixture
async def opened(tmp_path: Path, rig: Rig, filled: Filled) -> AsyncIterator[Archive]:
    """The store of `archive` behind a server that asks for no token."""
    store = rig.lots = LotStore(Path(shutil.copy(filled.file, tmp_path / "lots.db")), by_place)
    await rig.start()
    async with browser() as session:
        stand = cast("Stand", SimpleNamespace(rig=rig))
        yield Archive(stand, store, session, session, filled.lot, filled.far, filled.surveys)
    await store.close()


async def by_gdal(archive: Archive, work: str) -> Any:
    """Return ``found`` after some work with ``address``, done in a process of its own: GDAL waits for its answers."""
    begin = f"import json, pyogrio\naddress = 'OAPIF:{archive.address('/features')}'"
    program = await asyncio.create_subprocess_exec(
        sys.executable, "-c", f"{begin}\n{work}\nprint(json.dumps(found))", stdout=asyncio.subprocess.PIPE,
        env={name: value for name, value in os.environ.items() if not name.startswith(("GDAL_", "CPL_"))},
    )  # fmt: skip
    try:
        async with asyncio.timeout(GDAL_S):
            out, _ = await program.communicate()
    finally:
        if program.returncode is None:
            program.kill()
    assert program.returncode == 0
    return json.loads(out)


@pytest.mark.slow
async def test_gdal_lists_the_collections_and_counts_their_features(opened: Archive) -> None:
    found = await by_gdal(opened, LISTED)
    del found["sections"]  # this archive has none
    assert found == {
        "lots": [2, "MultiPolygon", True],
        "stalls": [60, "Polygon", True],
        "surveys": [4, "MultiPolygon", True],
    }


@pytest.mark.slow
async def test_gdal_reads_every_stall_of_many_parts_and_those_of_a_box(opened: Archive) -> None:
    found = await by_gdal(opened, READ)
    stalls = [each for lot in (opened.lot, opened.far) for each in await opened.items(f"/lots/{lot}/stalls")]
    assert found["label"] == [each["label"] for each in stalls]
    assert found["state"] == [each["state"] for each in stalls]
    assert (found["shapes"], found["inside"]) == (60, 20)
