from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import pytest

from hawk.comm.protocol.authority import Role
from hawk.ddc.fence.geojson import editable_area
from hawk.formats.area_file import LARGEST_BYTES
from hawk.web import area_file
from tests.unit.formats.test_area_file import (
    HOLE,
    POINT,
    RING,
    ZONE_DATA,
    collection,
    feature,
    kml,
    kml_polygon,
    packed,
    placemark,
    polygon,
    positions,
)
from tests.unit.web.rig import Rig, browser
from tests.unit.web.stand import Stand

QGIS = json.dumps(collection(POINT, feature({"type": "MultiPolygon", "coordinates": [[positions(), positions(HOLE)]]})))
FILES = {
    "QGIS": QGIS.encode("utf-8-sig"),
    "KML": kml(placemark(kml_polygon()), placemark(kml_polygon(HOLE), ZONE_DATA)).encode(),
    "KMZ": packed(kml(placemark(kml_polygon(RING, [HOLE])))),
}


async def sent(rig: Rig, data: Any, query: str = "kind=fence", **options: Any) -> tuple[int, str]:
    rig.read_area = editable_area
    server = rig.server or await rig.start()
    address = server.make_url(f"/api/area-file?{query}")
    async with browser() as session, session.post(address, data=data, **options) as response:
        return response.status, await response.text()


@pytest.mark.fault(
    "the same file on the page and on the command line",
    "one reader, the same result and the same words",
)
@pytest.mark.parametrize("kind", ["fence", "outline"])
@pytest.mark.parametrize("name", FILES)
async def test_a_file_comes_back_as_one_polygon_for_the_editor(rig: Rig, name: str, kind: str) -> None:
    status, text = await sent(rig, FILES[name], f"kind={kind}")
    assert status == 200
    rings = json.loads(text)["geometry"]["coordinates"]
    assert [{tuple(place) for place in ring} for ring in rings] == [
        {(longitude, latitude) for latitude, longitude in ring} for ring in (RING, HOLE)
    ]
    assert rings[0][0] == rings[0][-1]


async def test_a_ceiling_is_kept(rig: Rig) -> None:
    _, text = await sent(rig, json.dumps(feature(polygon(), ceiling_m=45)))
    assert json.loads(text)["properties"]["ceiling_m"] == 45
    _, text = await sent(rig, json.dumps(polygon()))
    assert json.loads(text)["properties"]["ceiling_m"] is None


@pytest.mark.fault("the same file on the page and on the command line")
@pytest.mark.parametrize(
    ("data", "query", "status", "words"),
    [
        (json.dumps(collection(POINT)), "kind=fence", 422, "The file must hold exactly one Polygon"),
        (
            json.dumps(collection(feature(polygon()), feature(polygon(positions(HOLE))))),
            "kind=outline",
            422,
            "2 polygons",
        ),
        (b"\x89PNG", "kind=fence", 422, "The file cannot be read"),
        (b"", "kind=outline", 422, "The file cannot be read"),
        (json.dumps(polygon()), "kind=lot", 400, "kind: must be fence or outline"),
        (io.BytesIO(b" " * (LARGEST_BYTES + 1)), "kind=fence", 413, ""),
    ],
)
async def test_a_file_that_holds_none_is_refused_with_the_words_of_the_command_line(
    rig: Rig, data: Any, query: str, status: int, words: str
) -> None:
    found = await sent(rig, data, query)
    assert found[0] == status
    assert words in found[1]


async def test_a_client_that_accepts_json_gets_the_sentences_of_the_refusal(rig: Rig) -> None:
    status, text = await sent(rig, b"", "kind=outline", headers={"Accept": "application/json"})
    answer = json.loads(text)
    assert status == 422
    assert answer["Reason"].startswith("The file cannot be read: neither GeoJSON nor KML (")
    assert [each["Code"] for each in answer["Sentences"]] == [
        "the-file-fault",
        "cannot-be-read-neither-geojson-nor-kml-error",
    ]


async def test_a_file_that_does_not_come_is_given_up(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(area_file, "READ_S", 0.05)

    async def slow() -> Any:
        yield b"{"
        await rig.never.wait()

    assert (await sent(rig, slow()))[0] == 408


async def test_it_is_for_those_with_a_login_and_for_this_server_s_page(rig: Rig, tmp_path: Path) -> None:
    rig.folder = tmp_path
    rig.read_area = editable_area
    stand = Stand(rig, tmp_path)
    server = await rig.start()
    address = server.make_url("/api/area-file")
    try:
        async with (await stand.browser()).post(address, data=QGIS) as response:
            assert response.status == 401
        viewer = await stand.tool(Role.VIEWER)
        async with viewer.post(address, data=QGIS) as response:
            assert response.status == 200
        async with viewer.post(address, data=QGIS, headers={"Origin": "http://evil.example"}) as response:
            assert response.status == 403
    finally:
        await stand.close()


async def test_a_server_without_a_reader_says_so(rig: Rig) -> None:
    server = await rig.start()
    async with browser() as session, session.post(server.make_url("/api/area-file"), data=QGIS) as response:
        assert (response.status, await response.text()) == (422, "The file cannot be read here.")
