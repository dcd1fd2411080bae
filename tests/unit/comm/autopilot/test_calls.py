"""Calls that may hang: each on its own thread, with a deadline, counted."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import AsyncIterator

import pytest

from hawk.comm.autopilot.calls import Calls
from hawk.comm.autopilot.vehicle import AutopilotError
from hawk.ddc.acts import Ask, SetMode
from hawk.model.vehicle import CopterMode
from tests.manual_clock import ManualClock
from tests.unit.comm.waiting import until


class Rig:
    """Calls with a short deadline, and one that hangs until it is let go."""

    def __init__(self) -> None:
        self.clock = ManualClock(0.0)
        self.calls = Calls("test", 0.01, self.clock)
        self.let_go = threading.Event()
        self.reported: list[str] = []
        self.calls.on_overdue = self.reported.append

    def hang(self) -> str:
        self.let_go.wait(30.0)
        return "late"

    async def let_one_hang(self, name: str = "arm") -> None:
        with pytest.raises(AutopilotError, match=f"{name}: MAVSDK did not return within 0.01 s"):
            await self.calls.run(name, self.hang)


@pytest.fixture
async def rig() -> AsyncIterator[Rig]:
    made = Rig()
    yield made
    made.let_go.set()
    assert await made.calls.finish(10.0)


async def test_a_call_gives_its_result_or_its_own_error(rig: Rig) -> None:
    assert await rig.calls.run("add", lambda a, b: a + b, 1, 2, deadline_s=10.0) == 3
    with pytest.raises(ZeroDivisionError):
        await rig.calls.run("divide", lambda: 1 / 0, deadline_s=10.0)
    assert rig.calls.health.is_healthy
    assert rig.reported == []


@pytest.mark.fault(
    "a call into MAVSDK never returns",
    'it fails after 3 s with words, later calls go out, part "requests" is unhealthy',
)
async def test_the_first_that_passes_its_deadline_fails_with_words_and_is_unhealthy(rig: Rig) -> None:
    await rig.let_one_hang()
    assert rig.reported == ["arm"]
    assert rig.calls.overdue == 1
    assert "MAVSDK does not return: arm." in rig.calls.health.reason


@pytest.mark.fault("a call into MAVSDK never returns")
async def test_later_calls_do_not_wait_behind_it(rig: Rig) -> None:
    for _ in range(5):
        await rig.let_one_hang()
    assert await rig.calls.run("read", lambda: 7, deadline_s=10.0) == 7
    assert rig.calls.overdue == 5


async def test_one_that_comes_back_late_counts_for_a_minute(rig: Rig) -> None:
    await rig.let_one_hang()
    rig.let_go.set()
    await until(lambda: "returned late" in rig.calls.health.reason)
    assert rig.calls.overdue == 1
    rig.clock.advance(61.0)
    assert rig.calls.overdue == 0
    assert rig.calls.health.is_healthy


async def test_when_too_many_hang_no_other_is_begun_but_the_urgent(rig: Rig) -> None:
    for _ in range(15):
        await rig.let_one_hang()
    assert await rig.calls.run("read", lambda: 7, deadline_s=10.0) == 7
    await rig.let_one_hang()
    with pytest.raises(AutopilotError, match="read: not begun, 16 calls hang"):
        await rig.calls.run("read", lambda: 7)
    assert await rig.calls.run("kill", lambda: 8, deadline_s=10.0, urgent=True) == 8


async def test_a_caller_that_went_away_does_not_hide_a_hanging_call(rig: Rig) -> None:
    waiting = asyncio.create_task(rig.calls.run("arm", rig.hang))
    await asyncio.sleep(0)
    waiting.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await waiting
    await until(lambda: rig.reported == ["arm"])
    assert rig.calls.overdue == 1


async def test_the_end_waits_for_calls_under_way_but_not_for_ever(rig: Rig) -> None:
    assert await rig.calls.finish(0.0)
    await rig.let_one_hang()
    assert not await rig.calls.finish(0.01)
    rig.let_go.set()
    assert await rig.calls.finish(10.0)


async def test_a_call_of_another_thread_is_counted(rig: Rig) -> None:
    rig.calls.note_overdue("target")
    assert rig.reported == ["target"]
    assert "target" in rig.calls.health.reason


async def test_a_minute_after_it_came_back_a_late_call_counts_no_more(rig: Rig) -> None:
    await rig.let_one_hang()
    rig.let_go.set()
    await until(lambda: "returned late" in rig.calls.health.reason)
    rig.clock.advance(60.0)
    assert rig.calls.overdue == 1
    rig.clock.advance(0.1)
    assert rig.calls.overdue == 0


async def test_each_late_call_counts_from_its_own_return(rig: Rig) -> None:
    rig.clock.advance(100.0)
    await rig.let_one_hang()
    rig.let_go.set()
    await until(lambda: "returned late" in rig.calls.health.reason)
    rig.clock.advance(50.0)
    rig.let_go.clear()
    await rig.let_one_hang()
    rig.let_go.set()
    await until(lambda: "returned late" in rig.calls.health.reason)
    assert rig.calls.overdue == 2
    rig.clock.advance(11.0)
    assert rig.calls.overdue == 1


def test_a_call_may_take_longer_than_mavsdk_waits_and_ends_before_its_request_does() -> None:
    assert 2.0 < Calls("test").deadline_s < Ask(SetMode(CopterMode.RTL), 0.0).limit_s


async def test_hanging_calls_are_named_once_each(rig: Rig) -> None:
    for name in ("mode", "arm", "arm"):
        await rig.let_one_hang(name)
    assert rig.calls.health.reason == "MAVSDK does not return: arm, mode. Restart the program on the ground."


async def test_a_call_is_under_way_until_it_returns(rig: Rig) -> None:
    first = asyncio.create_task(rig.calls.run("one", rig.hang, deadline_s=10.0))
    assert await rig.calls.run("two", lambda: 2, deadline_s=10.0) == 2
    assert not await rig.calls.finish(0.0), "the first is under way"
    rig.let_go.set()
    assert await first == "late"
    assert await rig.calls.finish(0.0)


@pytest.mark.slow
def test_a_call_that_returns_after_the_loop_ended_is_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    raised: list[object] = []
    monkeypatch.setattr(threading, "excepthook", raised.append)
    let_go = threading.Event()

    async def leave() -> None:
        calls = Calls("left", 0.01)
        with pytest.raises(AutopilotError):
            await calls.run("arm", let_go.wait, 30.0)

    asyncio.run(leave())
    (thread,) = (each for each in threading.enumerate() if each.name == "left")
    let_go.set()
    thread.join(2.0)
    assert raised == []


async def test_a_hanging_call_does_not_keep_the_process(rig: Rig) -> None:
    await rig.let_one_hang()
    hanging = [thread for thread in threading.enumerate() if thread.name == "test"]
    assert hanging
    assert all(thread.daemon for thread in hanging)
