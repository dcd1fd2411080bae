from __future__ import annotations

from collections.abc import AsyncIterator
from datetime import datetime
from pathlib import Path

import pytest

from hawk.config.sections import StoreSettings
from hawk.daemon.lots.keeper import find_stalls
from hawk.lots.store import LotStore
from hawk.store.recording_requests import RecordingRequests
from hawk.store.recordings import Recordings
from hawk.web.access.tokens import TOKEN_FILE, rotate_drone
from tests.unit.lots.documents.drones import Drone
from tests.unit.web.rig import Rig
from tests.unit.web.stand import Stand
from tests.unit.webhooks.lines import ONE, Line


@pytest.fixture
async def line(tmp_path: Path) -> AsyncIterator[Line]:
    desk, rig = tmp_path / "desk", Rig()
    centre = rig.lots = LotStore(desk / "lots.db", find_stalls)
    rig.collects, rig.folder = True, desk
    settings = StoreSettings(directory=desk)
    rig.recordings = Recordings(settings)
    moments: list[datetime] = []
    rig.due = lambda _, name, *__: moments if name == "Lot 1" else []
    rig.recording_requests = RecordingRequests(rig.recordings, settings)
    stand = Stand(rig, desk)
    (tmp_path / "token").write_text(rotate_drone(desk / TOKEN_FILE, ONE) + "\n")
    server = await rig.start()
    path = tmp_path / "drone" / "lots.db"
    drone, store = Drone.at(path), LotStore(path)
    yield Line(drone, store, centre, tmp_path, str(server.make_url("/")), rig=rig, moments=moments)
    await stand.close()
    await server.close()
    await store.close()
    await centre.close()
    drone.store.close()
