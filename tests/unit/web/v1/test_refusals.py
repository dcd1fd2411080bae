"""Reasons why requests are refused."""

from __future__ import annotations

import pytest

from hawk.lots.values import BeingEditedError, LotInputError, LotStoreError, NotFoundError, StoreFullError
from hawk.store.recordings import NotThatRecordingError
from hawk.web.v1.refusals import RefusedError, refusal_of


@pytest.mark.parametrize(
    ("error", "status", "content"),
    [
        (LotInputError("name", "is empty"), 422, {"field": "name", "reason": "is empty"}),
        (NotFoundError("lot: there is none"), 404, {"field": "lot", "reason": "there is none"}),
        (LotStoreError("/var/lots.db: is full"), 409, {"field": "", "reason": "/var/lots.db: is full"}),
        (StoreFullError("/var/lots.db: is full"), 507, {"field": "", "reason": "/var/lots.db: is full"}),
        (
            BeingEditedError("Ann", 1.8e9, "Ann edits"), 409,
            {"field": "edit", "reason": "Ann edits", "who": "Ann", "since": "2027-01-15T08:00:00Z"},
        ),
        (NotThatRecordingError("a.mcap: is kept"), 409, {"field": "a.mcap", "reason": "is kept"}),
        (
            NotThatRecordingError("a.mcap: there is no recording of this name"), 404,
            {"field": "a.mcap", "reason": "there is no recording of this name"},
        ),
        (OSError(28, "No space left"), 409, {"field": "recordings", "reason": "No space left: look at the disk"}),
        (RefusedError(418, "pot", "holds tea"), 418, {"field": "pot", "reason": "holds tea"}),
    ],
)  # fmt: skip
def test_an_error_has_its_status_field_and_reason(error: Exception, status: int, content: dict[str, str]) -> None:
    refusal = refusal_of(error)
    assert (refusal.status, {"field": refusal.field, "reason": refusal.reason, **refusal.more}) == (status, content)
