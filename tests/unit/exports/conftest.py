from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.unit.exports.stored import Stored


@pytest.fixture
def stored(tmp_path: Path) -> Iterator[Stored]:
    made = Stored(tmp_path)
    yield made
    made.store.close()
