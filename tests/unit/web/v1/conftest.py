from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from hawk.comm.protocol.authority import Role
from hawk.lots.store import LotStore
from tests.unit.lots.repaints import by_place
from tests.unit.web.rig import Rig
from tests.unit.web.stand import Stand
from tests.unit.web.v1.archive import Archive, fill


@pytest.fixture
async def archive(tmp_path: Path, rig: Rig) -> AsyncIterator[Archive]:
    """Three surveys of a lot of 40 stalls, and one survey of a lot that is far away."""
    store = rig.lots = LotStore(tmp_path / "lots.db", by_place)
    stand, rig.folder = Stand(rig, tmp_path), tmp_path
    await rig.start()
    lot, far, surveys = await fill(store)
    viewer, operator = await stand.tool(Role.VIEWER), await stand.tool(Role.OPERATOR)
    yield Archive(stand, store, viewer, operator, lot, far, surveys)
    await stand.close()
    await store.close()
