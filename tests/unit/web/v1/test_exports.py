"""Surveys as files over HTTP."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator, Mapping
from pathlib import Path

import aiohttp
import pytest

from hawk.comm.protocol.authority import Role
from hawk.exports.formats import FEEDS
from hawk.lots.ingest import save
from hawk.lots.store import LotStore
from hawk.lots.survey.pictures import pictures_of
from hawk.lots.values import Saved
from hawk.model.lot_map import CELL_M, TILE_CELLS
from tests.unit.exports.stored import mosaic
from tests.unit.lots.surveys import survey
from tests.unit.web.rig import Rig
from tests.unit.web.stand import Stand

TYPES = {
    "csv": "text/csv", "geojson": "application/geo+json", "gpkg": "application/geopackage+sqlite3",
    "kmz": "application/vnd.google-earth.kmz", "png": "image/png", "zip": "application/zip",
    "sections.csv": "text/csv", "sections.geojson": "application/geo+json",
}  # fmt: skip


class Viewer:
    """A program that may only read, and the ids of a survey and its lot."""

    def __init__(self, stand: Stand, session: aiohttp.ClientSession, saved: Saved) -> None:
        self._stand = stand
        self._session = session
        self.survey = saved.survey
        self.lot = saved.lot

    async def get(self, path: str) -> tuple[int, Mapping[str, str], bytes]:
        assert self._stand.rig.server is not None
        async with self._session.get(self._stand.rig.server.make_url(path)) as response:
            return response.status, response.headers, await response.read()


@pytest.fixture
async def viewer(tmp_path: Path, rig: Rig) -> AsyncIterator[Viewer]:
    store = rig.lots = LotStore(tmp_path / "lots.db")
    stand, rig.folder = Stand(rig, tmp_path), tmp_path
    await rig.start()
    saved = await store.write(lambda connection: save(connection, survey()))
    pictures_of(store.path).write(saved.survey, mosaic())
    yield Viewer(stand, await stand.tool(Role.VIEWER), saved)
    await stand.close()
    await store.close()


@pytest.mark.slow
@pytest.mark.parametrize("kind", TYPES)
async def test_viewers_get_a_survey_as_a_file(viewer: Viewer, kind: str) -> None:
    status, headers, data = await viewer.get(f"/api/v1/surveys/{viewer.survey}/files/{kind}")
    assert status == 200
    assert headers["Content-Type"].startswith(TYPES[kind])
    assert headers["Content-Disposition"] == f'attachment; filename="survey-{viewer.survey[:8]}.{kind}"'
    assert len(data) > (1000 if "sections" not in kind else 40)


@pytest.mark.slow
async def test_a_survey_that_is_not_there_and_another_kind_are_refused(viewer: Viewer) -> None:
    status, _, data = await viewer.get(f"/api/v1/surveys/{'0' * 36}/files/csv")
    assert (status, b"there is no survey" in data) == (404, True)
    status, _, data = await viewer.get(f"/api/v1/surveys/{viewer.survey}/files/exe")
    assert (status, json.loads(data)["field"], b"there are csv, geojson" in data) == (404, "kind", True)


@pytest.mark.slow
async def test_the_picture_of_a_survey_comes_in_tiles_with_their_place(viewer: Viewer, rig: Rig) -> None:
    at = f"/api/v1/surveys/{viewer.survey}/ground"
    status, _, data = await viewer.get(at)
    found = json.loads(data)
    assert status == 200
    assert sorted(map(tuple, found["tiles"])) == sorted(mosaic())
    assert found["place"] == {"north": 0.0, "east": 0.0, "turn": 0.0}
    assert (found["cells"], found["cell_m"]) == (TILE_CELLS, CELL_M)
    assert found["datum"] == pytest.approx([survey().datum.latitude, survey().datum.longitude], abs=1e-6)
    status, headers, data = await viewer.get(f"{at}/-1/2")
    assert (status, headers["Content-Type"], data) == (200, "image/jpeg", mosaic()[-1, 2].data)
    assert "max-age" in headers["Cache-Control"]
    status, _, data = await viewer.get(f"{at}/-1/3")
    assert (status, json.loads(data)["field"], b"/ground lists the tiles" in data) == (404, "row", True)
    status, headers, data = await viewer.get(f"{at}/whole")
    assert (status, headers["Content-Type"], data[8:12]) == (200, "image/webp", b"WEBP")
    assert "max-age" in headers["Cache-Control"]
    status, _, _ = await viewer.get(f"/api/v1/surveys/{'0' * 36}/ground")
    assert status == 404
    assert rig.lots is not None
    pictures_of(rig.lots.path).remove(viewer.survey)
    status, _, data = await viewer.get(at)
    assert (status, json.loads(data)["tiles"]) == (200, []), "a survey whose picture is not kept any more"
    status, _, data = await viewer.get(f"{at}/whole")
    assert (status, data) == (204, b"")


@pytest.mark.slow
async def test_a_survey_without_a_picture_or_a_stall_cannot_be_drawn(viewer: Viewer, rig: Rig) -> None:
    assert rig.lots is not None
    pictures_of(rig.lots.path).write(viewer.survey, {(0, 0): mosaic()[0, 0]})
    for file in (rig.lots.path.parent / "lots-pictures").glob("*.zip"):
        file.write_bytes(b"broken")
    status, _, data = await viewer.get(f"/api/v1/surveys/{viewer.survey}/files/png")
    assert (status, b"only the picture of that survey is lost" in data) == (409, True)
    status, _, _ = await viewer.get(f"/api/v1/surveys/{viewer.survey}/files/csv")
    assert status == 200


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("name", "content_type", "key"),
    [
        ("ngsi-ld", "application/ld+json", "ParkingSpot"),
        ("cds", "application/vnd.cds+json", "curb_space_id"),
        ("parkapi", "application/json", "parking_spots"),
    ],
)
async def test_a_lot_is_a_feed_in_the_words_of_a_receiver(
    viewer: Viewer, name: str, content_type: str, key: str
) -> None:
    status, headers, data = await viewer.get(f"/api/v1/lots/{viewer.lot}/feeds/{name}?valid_s=1e10")
    assert status == 200
    assert headers["Content-Type"].startswith(content_type)
    assert key in data.decode()
    assert ('"status":"unknown"' in data.decode()) is False
    _, _, old = await viewer.get(f"/api/v1/lots/{viewer.lot}/feeds/{name}")
    assert old != data, "the survey is older than an hour"
    _, same, _ = await viewer.get(f"/api/v1/lots/{viewer.lot}/feeds/{name}?survey={viewer.survey}")
    assert same["ETag"] != headers["ETag"]
    status, _, refusal = await viewer.get(f"/api/v1/lots/{viewer.lot}/feeds/{name}?from=2026-05-04")
    assert (status, json.loads(refusal)["field"]) == (422, "from")


@pytest.mark.slow
@pytest.mark.parametrize("valid_s", ["0", "-1", "nan", "inf", "x"])
async def test_a_time_that_is_no_time_is_refused(viewer: Viewer, valid_s: str) -> None:
    status, _, data = await viewer.get(f"/api/v1/lots/{viewer.lot}/feeds/cds?valid_s={valid_s}")
    assert (status, json.loads(data)["field"]) == (422, "valid_s")


@pytest.mark.slow
async def test_another_feed_is_refused_with_those_that_there_are(viewer: Viewer) -> None:
    status, _, data = await viewer.get(f"/api/v1/lots/{viewer.lot}/feeds/datex")
    assert (status, json.loads(data)["field"]) == (404, "feed")
    assert json.loads(data)["detail"].endswith(f"there are {', '.join(FEEDS)}")


@pytest.mark.slow
async def test_a_lot_is_aggregates_hour_by_hour(viewer: Viewer) -> None:
    status, headers, data = await viewer.get(f"/api/v1/lots/{viewer.lot}/feeds/cds-aggregates?time_zone=UTC")
    assert (status, headers["Content-Type"]) == (200, "application/vnd.cds+csv;version=1.0")
    lines = data.decode().splitlines()
    assert len(lines) == 25, "the head, and the hours of the day of the survey"
    assert sum(line.endswith(",-1") for line in lines) == 23


@pytest.mark.slow
@pytest.mark.parametrize(
    ("query", "field"), [("from=x", "from"), ("time_zone=Mars", "time_zone"), ("valid_s=9", "valid_s")]
)
async def test_a_period_that_is_none_is_refused(viewer: Viewer, query: str, field: str) -> None:
    status, _, data = await viewer.get(f"/api/v1/lots/{viewer.lot}/feeds/cds-aggregates?{query}")
    assert status == 422
    assert json.loads(data)["field"] == field
