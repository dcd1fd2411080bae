from __future__ import annotations

import asyncio
import shutil
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from hawk.comm.protocol.authority import Role
from hawk.daemon.desk import refuse
from hawk.daemon.lots.keeper import find_stalls
from hawk.lots.store import LotStore
from hawk.model.day_plan import DayPlan, Forecast
from hawk.web.access.tokens import TOKEN_FILE, rotate_drone
from hawk.web.services import OperatorSide
from tests.unit.lots.documents.drones import Drone
from tests.unit.lots.plan.plans import drawn_lot
from tests.unit.lots.repaints import by_place
from tests.unit.lots.surveys import later, survey
from tests.unit.web.rig import Rig
from tests.unit.web.stand import Stand
from tests.unit.web.v1.archive import Archive, Filled, fill
from tests.unit.web.v1.centre import ONE, OTHER, Centre
from tests.unit.web.v1.plans import Plans


@pytest.fixture(scope="session")
def filled(tmp_path_factory: pytest.TempPathFactory) -> Filled:
    """Three surveys of a lot of 40 stalls, and one survey of a lot that is far away; no test changes the file."""
    file = tmp_path_factory.mktemp("archive") / "lots.db"

    async def made() -> Filled:
        store = LotStore(file, by_place)
        found = await fill(store)
        await store.close()
        return Filled(file, *found)

    return asyncio.run(made())


async def nothing_due(_: Forecast | None, __: int) -> DayPlan:
    return DayPlan()


@pytest.fixture
async def archive(tmp_path: Path, rig: Rig, filled: Filled) -> AsyncIterator[Archive]:
    """A copy of `filled` behind a server."""
    store = rig.lots = LotStore(Path(shutil.copy(filled.file, tmp_path / "lots.db")), by_place)
    stand, rig.folder = Stand(rig, tmp_path), tmp_path
    rig.day_plan = nothing_due
    await rig.start()
    viewer, operator = await stand.tool(Role.VIEWER), await stand.tool(Role.OPERATOR)
    yield Archive(stand, store, viewer, operator, filled.lot, filled.far, filled.surveys)
    await stand.close()
    await store.close()


@pytest.fixture
async def plans(tmp_path: Path, rig: Rig) -> AsyncIterator[Plans]:
    """A drawn lot of 30 stalls behind a server."""
    store = rig.lots = LotStore(tmp_path / "lots.db")
    stand, rig.folder = Stand(rig, tmp_path), tmp_path
    await rig.start()
    lot = await store.write(lambda connection: drawn_lot(connection, 30))
    yield Plans(stand, store, await stand.tool(Role.OPERATOR), lot)
    await stand.close()
    await store.close()


@pytest.fixture(scope="session")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two surveys of a lot in the store of a drone; no test changes the file."""
    file = tmp_path_factory.mktemp("flown") / "lots.db"
    drone = Drone.at(file)
    drone.add(survey())
    drone.add(later(survey(seed=2), 2))
    drone.store.close()
    return file


@pytest.fixture
async def centre(tmp_path: Path, rig: Rig, flown: Path) -> AsyncIterator[Centre]:
    store = rig.lots = LotStore(tmp_path / "centre" / "lots.db", find_stalls)
    rig.collects, rig.folder = True, tmp_path
    rig.side = OperatorSide.create(rig.clock, rig.operator, refuse)
    stand = Stand(rig, tmp_path)
    tokens = {name: rotate_drone(tmp_path / TOKEN_FILE, name) for name in (ONE, OTHER)}
    await rig.start()
    (tmp_path / "drone").mkdir()
    drone = Drone.at(Path(shutil.copy(flown, tmp_path / "drone" / "lots.db")))
    yield Centre(stand, store, tmp_path, tokens, drone)
    drone.store.close()
    await stand.close()
    await store.close()
