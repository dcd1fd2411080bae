"""Every recording that a flight of these tests leaves behind is decided again."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.integration.daemon_support import differing_decisions


@pytest.fixture(scope="module", autouse=True)
def recorded_decisions(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Fail a module whose recordings hold a decision that their facts do not cause again."""
    folder = tmp_path_factory.getbasetemp()
    before = set(folder.rglob("recordings/*.mcap"))
    yield
    found = [
        words for path in sorted(set(folder.rglob("recordings/*.mcap")) - before) for words in differing_decisions(path)
    ]
    assert not found, "\n".join(found)
