"""Requests under way: each ends, in time, with words."""

from __future__ import annotations

import asyncio

import pytest

from hawk.ddc import acts
from hawk.ddc.acts import Ask, CutMotors, ReadParameter, Request, SetMode, SetParameters, StoreHeights, UploadFence
from hawk.ddc.facts import Answer
from hawk.ddc.requests import Requests
from hawk.model.limits import Fence, HeightParameters
from hawk.model.vehicle import CopterMode
from tests.manual_clock import ManualClock


async def never() -> None:
    await asyncio.get_running_loop().create_future()


async def test_one_that_nobody_answers_fails_with_words(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(acts, "_REQUEST_S", 0.01)
    ended: list[tuple[str, str]] = []
    requests = Requests(ManualClock(5.0), lambda name, failure: ended.append((name, failure)))
    requests.start(Ask(SetMode(CopterMode.RTL), 5.0), never)
    assert requests.answers() == (Answer("mode RTL", 5.0, "pending"),)
    await requests.finish()
    await asyncio.sleep(0)
    assert requests.answers() == (Answer("mode RTL", 5.0, "failed", "no answer within 0.01 s"),)
    assert ended == [("mode RTL", "no answer within 0.01 s")]
    assert not requests.is_busy


@pytest.mark.parametrize(
    ("request_", "limit_s"),
    [
        (SetMode(CopterMode.RTL), 4.0),
        (CutMotors(), 4.0),
        (ReadParameter("RTL_ALT"), 6.0),
        (StoreHeights(HeightParameters()), 5.0),
        (UploadFence(Fence((), (), 1.0, 1.0)), 45.0),
        (SetParameters((("FS_GCS_ENABLE", 1.0), ("FENCE_ENABLE", 1.0))), 24.0),
        (SetParameters(()), 12.0),
    ],
    ids=lambda value: type(value).__name__,
)
def test_every_request_has_a_limit(request_: Request, limit_s: float) -> None:
    assert Ask(request_, 0.0).limit_s == limit_s
