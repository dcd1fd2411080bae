"""Set-up of the tests of the store's file."""

from __future__ import annotations

import pytest

from hawk.lots.storage import database
from tests.unit.conftest import MIGRATE_FILE


@pytest.fixture(autouse=True)
def stores_are_made(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make each store by all migrations, as the product does."""
    monkeypatch.setattr(database, "migrate_file", MIGRATE_FILE)
