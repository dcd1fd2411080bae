from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from tests.unit.ddc.fakes import Rig


@pytest.fixture
async def rig(tmp_path: Path) -> AsyncIterator[Rig]:
    """A drone on the ground, found, its parameters read."""
    made = Rig(tmp_path)
    await made.run(2.0)
    yield made
    await made.close()
