from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from hawk.comm.protocol.commands import Hold
from hawk.model.operation import StateName
from tests.unit.ddc.fakes import Rig

HERE = Path(__file__).parent
FLOWN = {"fresh", "rig", "flying", "holding"}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leave what flies the whole manager to `make test`: `make check` decides from facts, far quicker."""
    for item in items:
        if HERE in item.path.parents and FLOWN & set(getattr(item, "fixturenames", ())):
            item.add_marker(pytest.mark.slow)


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
