"""The result of a survey as files."""

from __future__ import annotations

import csv
import io
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import aiohttp
import cv2
import numpy as np
import pytest

from hawk.comm.protocol.authority import Role
from hawk.comm.protocol.heartbeat import DroneStatus, SiteStatus, VehicleStatus
from hawk.model.lot_map import TILE_CELLS, Cell, EncodedTile, OccupancyMap
from hawk.model.poses import GlobalPose
from hawk.store.recording import NoRecordingError
from hawk.web import downloads
from tests.unit.web.rig import Rig, browser
from tests.unit.web.stand import Stand
from tests.unit.web.test_api import MAP, get, get_json

PLACED = DroneStatus(site=SiteStatus(datum=(43.0, -79.0)))


async def sizes(rig: Rig) -> dict[str, dict[str, Any]]:
    status, answer = await get_json(rig, "/api/downloads.json")
    assert status == 200
    return {each["Name"]: each for each in answer["Downloads"]}


async def fetched(rig: Rig, path: str) -> bytes:
    server = rig.server or await rig.start()
    async with browser() as session, session.get(server.make_url(path)) as response:
        assert response.status == 200
        return await response.read()


def recorded(path: Path, data: bytes = b"a flight") -> Path:
    path.write_bytes(data)
    return path


async def test_exports_of_the_present_map(rig: Rig) -> None:
    rig.map.publish(MAP)
    rig.publish(DroneStatus(site=SiteStatus(datum=(43.0, -79.0))))
    status, text, headers = await get(rig, "/api/stalls.csv")
    rows = list(csv.DictReader(io.StringIO(text)))
    assert (status, [row["state"] for row in rows]) == (200, ["free", "taken"])
    assert "stalls.csv" in headers["Content-Disposition"]
    status, text, headers = await get(rig, "/api/stalls.geojson")
    assert status == 200
    assert headers["Content-Type"].startswith("application/geo+json")
    assert text.count('"Polygon"') == 2


async def test_no_export_before_the_map_has_its_place_on_earth(rig: Rig) -> None:
    rig.map.publish(MAP)
    rig.publish(DroneStatus(site=SiteStatus(datum=None)))
    for path in ("/api/stalls.csv", "/api/stalls.geojson"):
        status, text, _ = await get(rig, path)
        assert status == 409
        assert "no map yet" in text


async def test_each_file_is_listed_with_the_size_that_is_sent(rig: Rig, tmp_path: Path) -> None:
    path = recorded(tmp_path / "20260501T100000Z.mcap")
    rig.newest_recording = lambda: path
    rig.map.publish(MAP)
    rig.publish(PLACED)
    listed = await sizes(rig)
    assert list(listed) == ["stalls.csv", "stalls.geojson", "lot.jpg", "recording.mcap"]
    for name, each in listed.items():
        assert each["Reason"] == ""
        assert each["Bytes"] == len(await fetched(rig, f"/api/{name}")) > 0


async def test_a_file_that_is_not_there_is_listed_with_the_reason(rig: Rig) -> None:
    rig.publish(DroneStatus(site=SiteStatus(datum=None)))
    listed = await sizes(rig)
    assert {each["Bytes"] for each in listed.values()} == {None}
    assert "no map yet" in listed["lot.jpg"]["Reason"]
    assert listed["recording.mcap"]["Reason"] == "Nothing is recorded here."


async def test_the_picture_shows_the_lot_and_its_stalls(rig: Rig) -> None:
    tile = np.full((TILE_CELLS, TILE_CELLS), Cell.LOT, np.uint8)
    packed = EncodedTile(1, zlib.compress(tile.tobytes()))
    rig.map.publish(OccupancyMap(tiles={(-1, 0): packed}, stalls=MAP.stalls, map_id="m1"))
    rig.publish(PLACED)
    picture = cv2.imdecode(np.frombuffer(await fetched(rig, "/api/lot.jpg"), np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    assert picture.shape == (TILE_CELLS, TILE_CELLS, 3)
    north, east = MAP.stalls[1].north, MAP.stalls[1].east
    blue, _, red = (int(value) for value in picture[round(TILE_CELLS - north * 10), round(east * 10)])
    assert blue > red + 20, "a free stall is blue"


async def test_files_are_made_once_for_a_map_and_again_for_the_next(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[str] = []
    whole = downloads._made

    def note(kind: downloads.FileKind, datum: GlobalPose, current: OccupancyMap) -> bytes:
        made.append(kind.name)
        return whole(kind, datum, current)

    monkeypatch.setattr(downloads, "_made", note)
    rig.map.publish(replace(MAP, version=1))
    rig.publish(PLACED)
    await sizes(rig)
    await sizes(rig)
    assert made == ["stalls.csv", "stalls.geojson", "lot.jpg"]
    rig.map.publish(replace(MAP, version=2))
    await get(rig, "/api/stalls.csv")
    assert made[3:] == ["stalls.csv"]


async def test_the_recording_comes_under_its_own_name(rig: Rig, tmp_path: Path) -> None:
    path = recorded(tmp_path / "20260501T100000Z.mcap")
    rig.newest_recording = lambda: path
    status, text, headers = await get(rig, "/api/recording.mcap")
    assert (status, text) == (200, "a flight")
    assert 'filename="20260501T100000Z.mcap"' in headers["Content-Disposition"]
    assert headers["Cache-Control"] == "no-store"


@pytest.mark.parametrize(
    ("asked", "sent", "status"),
    [("bytes=2-", "flight", 206), ("bytes=0-0", "a", 206), ("bytes=-3", "ght", 206), ("bytes=2-99", "flight", 206)],
)
async def test_a_broken_download_of_the_recording_goes_on(
    rig: Rig, tmp_path: Path, asked: str, sent: str, status: int
) -> None:
    path = recorded(tmp_path / "20260501T100000Z.mcap")
    rig.newest_recording = lambda: path
    found, text, headers = await get(rig, "/api/recording.mcap", headers={"Range": asked})
    assert (found, text) == (status, sent)
    assert headers["Content-Range"].endswith("/8")


@pytest.mark.parametrize("asked", ["bytes=8-", "bytes=5-2", "rows=1-2"])
async def test_a_part_that_is_not_there_is_refused(rig: Rig, tmp_path: Path, asked: str) -> None:
    path = recorded(tmp_path / "20260501T100000Z.mcap")
    rig.newest_recording = lambda: path
    status, _, headers = await get(rig, "/api/recording.mcap", headers={"Range": asked})
    assert (status, headers["Content-Range"]) == (416, "bytes */8")


async def test_arming_ends_a_download(rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = recorded(tmp_path / "20260501T100000Z.mcap", b"x" * 3 * downloads.CHUNK_BYTES)
    rig.newest_recording = lambda: path
    read = downloads._read

    def read_and_arm(path: Path, start: int, count: int) -> bytes:
        if start > 0:
            rig.status.publish(DroneStatus(vehicle=VehicleStatus(armed=True)))
        return read(path, start, count)

    monkeypatch.setattr(downloads, "_read", read_and_arm)
    with pytest.raises(aiohttp.ClientError):
        await fetched(rig, "/api/recording.mcap")


async def test_no_recording_is_sent_while_armed(rig: Rig, tmp_path: Path) -> None:
    path = recorded(tmp_path / "20260501T100000Z.mcap")
    rig.newest_recording = lambda: path
    rig.publish(DroneStatus(vehicle=VehicleStatus(armed=True)))
    status, text, _ = await get(rig, "/api/recording.mcap")
    assert status == 409
    assert "motors are off" in text
    assert "motors are off" in (await sizes(rig))["recording.mcap"]["Reason"]


async def test_the_reason_of_a_missing_recording_is_reported(rig: Rig, tmp_path: Path) -> None:
    def incomplete() -> Path:
        raise NoRecordingError("The recording is not complete yet.")

    rig.newest_recording = incomplete
    assert (await get(rig, "/api/recording.mcap"))[:2] == (409, "The recording is not complete yet.")
    rig.newest_recording = lambda: tmp_path / "gone.mcap"
    assert (await get(rig, "/api/recording.mcap"))[0] == 409


async def test_a_viewer_gets_the_map_and_no_recording(stand: Stand, tmp_path: Path) -> None:
    path = recorded(tmp_path / "20260501T100000Z.mcap")
    stand.rig.newest_recording = lambda: path
    stand.rig.map.publish(MAP)
    stand.rig.publish(PLACED)
    viewer, operator = await stand.tool(Role.VIEWER), await stand.tool(Role.OPERATOR)
    assert await stand.status(viewer, "/api/stalls.csv") == 200
    assert await stand.status(viewer, "/api/recording.mcap") == 403
    assert await stand.status(operator, "/api/recording.mcap") == 200
    assert stand.rig.server is not None
    async with viewer.get(stand.rig.server.make_url("/api/downloads.json")) as response:
        listed = {each["Name"]: each["Reason"] for each in (await response.json())["Downloads"]}
    assert listed["recording.mcap"] == downloads.FOR_OPERATORS
