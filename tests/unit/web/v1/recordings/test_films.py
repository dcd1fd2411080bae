"""Recordings as films, by their addresses."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import aiohttp
import pytest

from hawk.comm.protocol.authority import Role
from hawk.comm.protocol.heartbeat import DroneStatus, VehicleStatus
from hawk.config.sections import StoreSettings
from hawk.formats import box
from hawk.replay.film import Film, PackedFilm
from hawk.store.recordings import OneRecording, Recordings
from hawk.web.v1.recordings.films import KEPT, Films, read_on_ground
from hawk.web.v1.refusals import RefusedError
from tests.unit.replay.recordings import flight, jpeg, tick, write
from tests.unit.web.rig import Rig
from tests.unit.web.stand import Stand

NAME, OTHER = "20260504T103000Z.mcap", "20260505T103000Z.mcap"
FLYING = (409, "recordings", "a recording is shown once the motors are off")


class Shown:
    """Two recordings, and the API as a viewer's program sees it."""

    def __init__(self, stand: Stand, folder: Path, viewer: aiohttp.ClientSession) -> None:
        self.stand, self.folder, self.viewer = stand, folder, viewer

    async def ask(self, path: str) -> tuple[int, bytes]:
        assert self.stand.rig.server is not None
        async with self.viewer.get(self.stand.rig.server.make_url(f"/api/v1/recordings{path}")) as response:
            return response.status, await response.read()

    async def refused(self, path: str) -> tuple[int, str, str]:
        status, body = await self.ask(path)
        answer = json.loads(body)
        return status, answer["field"], answer["detail"]


@pytest.fixture
async def shown(tmp_path: Path, rig: Rig) -> AsyncIterator[Shown]:
    folder = tmp_path / "recordings"
    folder.mkdir()
    write(folder / NAME, flight(3, 2))
    (folder / OTHER).write_bytes(b"no recording")
    rig.recordings = Recordings(StoreSettings(directory=tmp_path))
    stand, rig.folder = Stand(rig, tmp_path), tmp_path
    await rig.start()
    yield Shown(stand, folder, await stand.tool(Role.VIEWER))
    await stand.close()


@pytest.mark.slow
async def test_a_recording_is_a_film_with_its_pictures_and_maps(shown: Shown) -> None:
    status, body = await shown.ask(f"/{NAME}/film")
    film = json.loads(body)
    assert (status, film["name"], film["program"]) == (200, NAME, "hawk-drone 0.2.9, network 0123abcd")
    assert (film["pictures"], len(film["maps"]), len(film["track"])) == ([1.5, 2.5, 3.5], 3, 1)
    assert await shown.ask(f"/{NAME}/film/pictures/2") == (200, jpeg())
    assert len(json.loads((await shown.ask(f"/{NAME}/film/maps/1"))[1])["features"]) == 2
    for wrong in ("pictures/3", "maps/3", "maps/12345678"):
        status, field, words = await shown.refused(f"/{NAME}/film/{wrong}")
        assert (status, field) == (404, "number"), wrong
        assert "the recording has none of this number" in words
    assert (await shown.ask("/20260506T103000Z.mcap/film"))[0] == 404
    status, field, words = await shown.refused(f"/{OTHER}/film")
    assert (status, field) == (409, "name")
    assert "name a recording of STORE/recordings" in words


async def test_in_flight_nothing_is_read(shown: Shown) -> None:
    shown.stand.rig.publish(DroneStatus(vehicle=VehicleStatus(armed=True)))
    for path in ("film", "film/pictures/0", "film/maps/0"):
        assert await shown.refused(f"/{NAME}/{path}") == FLYING


def packed(name: str) -> PackedFilm:
    values: dict[str, Any] = {each: [] for each in Film.model_fields}
    film = Film(**{**values, "name": name, "program": "", "began": None, "seconds": 1.0, "problem": "", "datum": None})
    return PackedFilm.of(film, [], [])


async def test_arming_ends_what_is_being_read(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    ended: list[bool] = []

    async def never(*_: object) -> bytes:
        try:
            await asyncio.Event().wait()
        finally:
            ended.append(True)
        return b""

    monkeypatch.setattr(box, "read_apart", never)
    on_ground = iter([True, True, False])
    with pytest.raises(RefusedError, match="once the motors are off"):
        await read_on_ground(lambda: next(on_ground), tmp_path / "a", tmp_path / "b")
    assert ended == [True]


async def test_a_film_is_read_once_and_only_some_are_kept() -> None:
    read: list[str] = []

    async def reading(path: Path, _: Path) -> PackedFilm:
        read.append(path.name)
        return packed(path.name)

    films = Films(reading)
    keys = [(Path(name), 1, 1) for name in ("a", "b", "c")]
    await asyncio.gather(films.of(keys[0]), films.of(keys[0]))
    assert read == ["a"], "two that ask at once wait for one reading"
    for key in keys:
        await films.of(key)
    assert KEPT == 2
    await films.of(keys[2])
    await films.of(keys[0])
    assert read == ["a", "b", "c", "a"]
    await films.of((Path("a"), 2, 1))
    assert read[-1] == "a", "a file that has changed is read again"
    await films.close()


async def test_a_reading_that_failed_is_tried_again() -> None:
    tries: list[Path] = []

    async def reading(path: Path, _: Path) -> PackedFilm:
        tries.append(path)
        raise box.RefusedError("recording", "is damaged")

    films, key = Films(reading), (Path("a"), 1, 1)
    for _ in range(2):
        with pytest.raises(box.RefusedError):
            await films.of(key)
    assert len(tries) == 2
    await films.close()


@pytest.mark.slow
@pytest.mark.nightly
async def test_the_loop_goes_on_while_a_long_recording_is_read(tmp_path: Path) -> None:
    """Half a minute of ticks and thousands of values: a thread of this process would hold the loop for long."""
    path = write(tmp_path / "long.mcap", [*flight(2), *(tick(20.0 + 0.05 * k) for k in range(20_000))])
    late: list[float] = []

    async def sample() -> None:
        while True:
            began = time.perf_counter()
            await asyncio.sleep(0.01)
            late.append(time.perf_counter() - began - 0.01)

    sampling = asyncio.create_task(sample())
    film = await read_on_ground(lambda: True, path, tmp_path / "beside")
    sampling.cancel()
    assert json.loads(film.text)["seconds"] > 900
    late.sort()
    assert late[int(0.9 * len(late))] < 0.05, "seconds"


async def test_a_single_file_of_any_name_is_shown_and_not_changed(tmp_path: Path, rig: Rig) -> None:
    path = write(tmp_path / "monday morning.mcap", flight(1))
    rig.recordings = OneRecording(path)
    stand = Stand(rig, tmp_path)
    await rig.start()
    assert rig.server is not None
    session = await stand.tool(Role.OPERATOR)
    address = rig.server.make_url("/api/v1/recordings")
    async with session.get(address) as response:
        [row] = (await response.json())["items"]
    assert (row["name"], row["bytes"], row["lot"]) == ("20260504T000000Z.mcap", path.stat().st_size, None)
    for change, body in (("keep", {"keep": True}), ("delete", {})):
        async with session.post(address / row["name"] / change, json=body) as response:
            assert response.status == 409
            assert "is shown alone" in (await response.json(content_type=None))["detail"]
    async with session.get(address / row["name"]) as response:
        assert await response.read() == path.read_bytes()
    assert path.exists()
    await stand.close()
