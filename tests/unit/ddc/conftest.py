from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from hawk.comm.protocol.commands import Hold
from hawk.model.operation import StateName
from tests.unit.ddc.fakes import Rig


@pytest.fixture
async def fresh(tmp_path: Path) -> AsyncIterator[Rig]:
    """A rig whose clock has not moved yet."""
    made = Rig(tmp_path)
    yield made
    await made.close()


@pytest.fixture
async def rig(fresh: Rig) -> Rig:
    """A drone on the ground, found, its parameters read."""
    await fresh.run(2.0)
    return fresh


@pytest.fixture
async def flying(fresh: Rig) -> Rig:
    """A drone that holds at 30 m."""
    await fresh.enter(StateName.HOVER)
    return fresh


@pytest.fixture
async def holding(fresh: Rig) -> Rig:
    """A drone that holds where we reported it to."""
    await fresh.enter(StateName.COMPULSIVE_MOVE)
    fresh.order(Hold())
    await fresh.run(5.0)
    fresh.expect(StateName.HOVER)
    return fresh
