"""Requests under way: each ends, in time, with words."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any, Literal

import pytest

from hawk.ddc import acts
from hawk.ddc.acts import (
    Ask,
    CompareFence,
    CutMotors,
    PutBack,
    ReadParameter,
    Request,
    SendMode,
    SetArmed,
    SetMode,
    SetParameters,
    SetReturnAltitude,
    StoreFence,
    StoreHeights,
    UploadFence,
)
from hawk.ddc.facts import Answer
from hawk.ddc.requests.requests import Requests
from hawk.model.plans import Fence, HeightParameters
from hawk.model.vehicle import CopterMode
from tests.manual_clock import ManualClock


async def never() -> None:
    await asyncio.get_running_loop().create_future()


@pytest.mark.fault("a request is never answered", "it fails within its limit (4 to 45 s) with words")
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


class Rig:
    """Requests on a clock that is moved by hand, and what was reported of those that ended."""

    def __init__(self) -> None:
        self.clock = ManualClock(5.0)
        self.ended: list[tuple[str, str]] = []
        self.requests = Requests(self.clock, lambda name, failure: self.ended.append((name, failure)))
        self.begun = 0

    def ask(self, at: float, answer: Callable[[], Coroutine[Any, Any, Any]] = never) -> None:
        def call() -> Coroutine[Any, Any, Any]:
            self.begun += 1
            return answer()

        self.requests.start(Ask(SetMode(CopterMode.RTL), at), call)

    async def end(self) -> None:
        await self.requests.finish()
        await asyncio.sleep(0)


async def seven() -> int:
    return 7


async def words() -> str:
    return "words"


async def refused() -> None:
    raise ValueError("not now")


async def broken() -> None:
    raise ValueError


async def late() -> None:
    raise TimeoutError("MAVSDK was late")


async def test_a_request_is_begun_once_also_after_it_ended() -> None:
    rig = Rig()
    rig.ask(5.0)
    rig.ask(5.0)
    assert rig.begun == 1
    rig.ask(5.5, seven)
    assert rig.begun == 2
    await asyncio.sleep(0.01)
    assert [answer.status for answer in rig.requests.answers()] == ["pending", "done"]
    rig.ask(5.5, seven)
    assert rig.begun == 2, "it has its answer"
    assert rig.requests.is_busy
    await rig.requests.close()
    assert not rig.requests.is_busy


@pytest.mark.parametrize(
    ("answer", "status", "reason", "value"),
    [
        (seven, "done", "", 7.0),
        (words, "done", "", None),
        (refused, "failed", "not now", None),
        (broken, "failed", "ValueError", None),
        (late, "failed", "MAVSDK was late", None),
    ],
)
async def test_how_it_ends_is_a_fact_and_reported_once(
    answer: Callable[[], Coroutine[Any, Any, Any]], status: Literal["done", "failed"], reason: str, value: float | None
) -> None:
    rig = Rig()
    rig.ask(5.0, answer)
    await rig.end()
    assert rig.requests.answers() == (Answer("mode RTL", 5.0, status, reason, value),)
    assert rig.ended == [("mode RTL", reason)]


async def test_an_answer_is_kept_for_half_a_minute() -> None:
    rig = Rig()
    rig.clock.advance(100.0)
    rig.ask(105.0, seven)
    await rig.end()
    rig.clock.advance(30.0)
    assert len(rig.requests.answers()) == 1
    rig.ask(135.0, seven)
    await rig.end()
    rig.clock.advance(0.1)
    assert [answer.asked for answer in rig.requests.answers()] == [135.0]


async def test_the_end_cancels_what_is_under_way_and_reports_nothing_of_it() -> None:
    rig = Rig()
    rig.ask(5.0)
    await asyncio.sleep(0)
    rig.ask(6.0)  # cancelled before it begins
    await rig.requests.close()
    await asyncio.sleep(0)
    assert set(rig.requests.answers()) == {
        Answer("mode RTL", 5.0, "failed", "cancelled"),
        Answer("mode RTL", 6.0, "failed", "cancelled"),
    }
    assert rig.ended == []
    await rig.requests.close()


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
        (SetReturnAltitude(15.0), 12.0),
        (PutBack("FENCE_ENABLE", 1.0), 12.0),
        (CompareFence(Fence((), (), 1.0, 1.0)), 28.0),
        (StoreFence(None), 5.0),
    ],
    ids=lambda value: type(value).__name__,
)
def test_every_request_has_a_limit(request_: Request, limit_s: float) -> None:
    assert Ask(request_, 0.0).limit_s == limit_s


@pytest.mark.parametrize(
    ("request_", "name"),
    [
        (SetArmed(True), "arm"),
        (SetArmed(False), "disarm"),
        (SetMode(CopterMode.RTL), "mode RTL"),
        (SendMode(CopterMode.RTL), "send RTL"),
        (ReadParameter("RTL_ALT"), "read RTL_ALT"),
        (PutBack("RTL_ALT", 1.0), "put back RTL_ALT"),
        (CutMotors(), "kill"),
    ],
)
def test_the_name_distinguishes_requests_of_one_moment(request_: Request, name: str) -> None:
    assert Ask(request_, 0.0).name == name
