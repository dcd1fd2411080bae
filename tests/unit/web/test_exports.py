"""Surveys as files over HTTP."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping
from pathlib import Path

import aiohttp
import pytest

from hawk.comm.protocol.authority import Role
from hawk.lots.pictures import pictures_of
from hawk.lots.saving import save
from hawk.lots.store import LotStore
from hawk.web.exports import KINDS
from tests.unit.exports.stored import mosaic
from tests.unit.lots.surveys import survey
from tests.unit.web.rig import Rig
from tests.unit.web.stand import Stand

TYPES = {
    "csv": "text/csv", "geojson": "application/geo+json", "gpkg": "application/geopackage+sqlite3",
    "kmz": "application/vnd.google-earth.kmz", "png": "image/png", "zip": "application/zip",
}  # fmt: skip


class Viewer:
    """A program that may only read, and the id of a survey."""

    def __init__(self, stand: Stand, session: aiohttp.ClientSession, survey_id: str) -> None:
        self._stand = stand
        self._session = session
        self.survey = survey_id

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
    yield Viewer(stand, await stand.tool(Role.VIEWER), saved.survey)
    await stand.close()
    await store.close()


@pytest.mark.parametrize("kind", KINDS.split("|"))
async def test_viewers_get_a_survey_as_a_file(viewer: Viewer, kind: str) -> None:
    status, headers, data = await viewer.get(f"/api/surveys/{viewer.survey}.{kind}")
    assert status == 200
    assert headers["Content-Type"].startswith(TYPES[kind])
    assert headers["Content-Disposition"] == f'attachment; filename="survey-{viewer.survey[:8]}.{kind}"'
    assert len(data) > 1000


async def test_a_survey_that_is_not_there_and_another_kind_are_refused(viewer: Viewer) -> None:
    status, _, data = await viewer.get(f"/api/surveys/{'0' * 36}.csv")
    assert (status, b"there is no survey" in data) == (404, True)
    status, _, _ = await viewer.get(f"/api/surveys/{viewer.survey}.exe")
    assert status == 404


async def test_a_survey_without_a_picture_or_a_stall_cannot_be_drawn(viewer: Viewer, rig: Rig) -> None:
    assert rig.lots is not None
    pictures_of(rig.lots.path).write(viewer.survey, {(0, 0): mosaic()[0, 0]})
    for file in (rig.lots.path.parent / "lots-pictures").glob("*.zip"):
        file.write_bytes(b"broken")
    status, _, data = await viewer.get(f"/api/surveys/{viewer.survey}.png")
    assert (status, b"only the picture of that survey is lost" in data) == (409, True)
    status, _, _ = await viewer.get(f"/api/surveys/{viewer.survey}.csv")
    assert status == 200
