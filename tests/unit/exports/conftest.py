from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.unit.exports.stored import Stored


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> Stored:
    """The closed store that each test gets a copy of: a survey with its plan takes a fifth of a second."""
    found = Stored(tmp_path_factory.mktemp("stored"))
    found.store.close()
    return found


@pytest.fixture
def stored(made: Stored, tmp_path: Path) -> Iterator[Stored]:
    own = made.copied(tmp_path)
    yield own
    own.store.close()
