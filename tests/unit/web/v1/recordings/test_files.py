"""The recordings on the disk, by their addresses."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import aiohttp
import pytest

from hawk.comm.protocol.authority import Role
from hawk.comm.protocol.heartbeat import DroneStatus, VehicleStatus
from hawk.config.sections import StoreSettings
from hawk.lots.ingest import save
from hawk.lots.store import LotStore
from hawk.lots.time_zone import zone_of_lot
from hawk.store.recordings import Recordings, Stored
from tests.unit.lots.surveys import survey
from tests.unit.store.recorded import recorded
from tests.unit.web.rig import Rig
from tests.unit.web.stand import Stand

FIRST, SECOND = "20260501T100000Z.mcap", "20260502T100000Z-2.mcap"


class Folder:
    """Two recordings, and the API as an operator's and a viewer's program see it."""

    def __init__(
        self, stand: Stand, path: Path, operator: aiohttp.ClientSession, viewer: aiohttp.ClientSession
    ) -> None:
        self.stand, self.path, self.operator, self.viewer = stand, path, operator, viewer

    async def ask(
        self, method: str, path: str, body: dict[str, object] | None = None, *, viewer: bool = False
    ) -> tuple[int, dict[str, Any] | str]:
        assert self.stand.rig.server is not None
        session = self.viewer if viewer else self.operator
        async with session.request(method, self.stand.rig.server.make_url(path), json=body) as response:
            text = await response.text(errors="replace")
            return response.status, json.loads(text) if response.content_type.endswith("json") else text

    async def rows(self, *, viewer: bool = False) -> list[dict[str, Any]]:
        status, answer = await self.ask("GET", "/api/v1/recordings", viewer=viewer)
        assert status == 200
        assert isinstance(answer, dict)
        assert answer["next"] is None
        return list(answer["items"])

    async def refused(self, method: str, path: str, body: dict[str, object] | None = None) -> tuple[int, str, str]:
        status, answer = await self.ask(method, f"/api/v1/recordings{path}", body)
        assert isinstance(answer, dict)
        return status, answer["field"], answer["detail"]

    def fly(self) -> None:
        self.stand.rig.publish(DroneStatus(vehicle=VehicleStatus(armed=True)))


@pytest.fixture
async def folder(tmp_path: Path, rig: Rig) -> AsyncIterator[Folder]:
    path = tmp_path / "recordings"
    path.mkdir()
    recorded(path / FIRST, "000001-day")
    recorded(path / SECOND, "")
    rig.recordings = Recordings(StoreSettings(directory=tmp_path))
    store = rig.lots = LotStore(tmp_path / "lots.db")
    stand, rig.folder = Stand(rig, tmp_path), tmp_path
    await rig.start()
    yield Folder(stand, path, await stand.tool(Role.OPERATOR), await stand.tool(Role.VIEWER))
    await stand.close()
    await store.close()


async def test_everybody_sees_recordings_with_size_lot_length_and_mark(folder: Folder) -> None:
    store = folder.stand.rig.lots
    assert store is not None
    saved = await store.write(lambda connection: save(connection, replace(survey(), name="000001-day")))
    zone = await store.read(lambda connection: zone_of_lot(connection, str(saved.lot)))
    first, second = await folder.rows(viewer=True)
    assert first == {
        "name": FIRST,
        "bytes": (folder.path / FIRST).stat().st_size,
        "began": "2026-05-01T10:00:00Z",
        "seconds": 75.0,
        "survey": "000001-day",
        "lot": {"id": saved.lot, "name": "Lot 1", "time_zone": zone, "survey": saved.survey},
        "drone": None,
        "keep": False,
        "keep_end": None,
        "under_way": False,
    }
    assert (second["name"], second["survey"], second["lot"]) == (SECOND, None, None)


async def test_the_day_is_that_of_the_surveys_and_the_end_that_of_the_limits(folder: Folder) -> None:
    """The computer's clock names the file and decides how long it is kept; a simulation draws another day."""
    recorded(folder.path / FIRST, "", zero_utc="2024-01-02T10:00:00+00:00")
    settings = StoreSettings(directory=folder.path.parent, recordings_days=30)
    folders = Recordings(settings)
    one = folders.listed()[0]
    assert folders.contents(FIRST).began == datetime(2024, 1, 2, 10, 0, 10, tzinfo=UTC).timestamp()
    assert folders.ends(one) == datetime(2026, 5, 31, 10, tzinfo=UTC).timestamp()
    folders.keep(FIRST, is_kept=True)
    assert folders.ends(folders.listed()[0]) is None


async def test_a_file_with_a_name_of_its_own_and_one_that_went_meanwhile_leave_the_list_whole(
    folder: Folder, monkeypatch: pytest.MonkeyPatch
) -> None:
    (folder.path / "monday morning.mcap").touch()
    listed = Recordings.listed
    gone = Stored("20260509T100000Z.mcap", 5, None, is_kept=False)
    monkeypatch.setattr(Recordings, "listed", lambda recordings: [*listed(recordings), gone])
    assert [row["name"] for row in await folder.rows()] == [FIRST, SECOND]


async def test_an_operator_marks_and_deletes(folder: Folder) -> None:
    marked = await folder.ask("POST", f"/api/v1/recordings/{FIRST}/keep", {"keep": True})
    assert marked == (200, {"name": FIRST, "keep": True})
    assert [row["keep"] for row in await folder.rows()] == [True, False]
    refusal = await folder.refused("POST", f"/{FIRST}/delete")
    assert refusal == (409, "name", 'is marked "keep": take the mark away first')
    await folder.ask("POST", f"/api/v1/recordings/{FIRST}/keep", {"keep": False})
    assert (await folder.ask("POST", f"/api/v1/recordings/{FIRST}/delete"))[0] == 200
    assert [row["name"] for row in await folder.rows()] == [SECOND]
    assert (await folder.ask("POST", f"/api/v1/recordings/{FIRST}/delete"))[0] == 404


async def test_a_viewer_changes_and_downloads_nothing(folder: Folder) -> None:
    for method, path in (("POST", "/keep"), ("POST", "/delete"), ("GET", "")):
        status, text = await folder.ask(method, f"/api/v1/recordings/{FIRST}{path}", viewer=True)
        assert status == 403
        assert "log in as operator" in str(text)
    assert (folder.path / FIRST).exists()


async def test_a_recording_is_downloaded_by_its_name(folder: Folder) -> None:
    status, text = await folder.ask("GET", f"/api/v1/recordings/{SECOND}")
    assert status == 200
    assert "MCAP0" in str(text)
    assert (await folder.ask("GET", "/api/v1/recordings/20260509T100000Z.mcap"))[0] == 404


async def test_nothing_is_deleted_or_sent_in_flight(folder: Folder) -> None:
    folder.fly()
    for method, path in (("POST", "/delete"), ("GET", "")):
        refusal = await folder.refused(method, f"/{FIRST}{path}")
        assert refusal == (409, "recordings", "wait until the motors are off")
    assert len(await folder.rows()) == 2


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ({}, "is missing: write it"),
        ({"keep": "yes"}, "must be true or false"),
        ({"keep": None}, "must be true or false"),
    ],
)
async def test_a_mark_that_is_no_truth_value_is_refused(body: dict[str, object], words: str, folder: Folder) -> None:
    assert await folder.refused("POST", f"/{FIRST}/keep", body) == (422, "keep", words)


async def test_where_nothing_is_recorded_the_list_says_so(rig: Rig, tmp_path: Path) -> None:
    stand = Stand(rig, tmp_path)
    await rig.start()
    session = await stand.tool(Role.OPERATOR)
    assert rig.server is not None
    async with session.get(rig.server.make_url("/api/v1/recordings")) as response:
        assert response.status == 409
        assert (await response.json(content_type=None))["detail"] == "nothing is recorded here"
    await stand.close()
