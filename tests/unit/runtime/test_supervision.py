"""Long-running tasks that end, and the exit of a program that hangs."""

from __future__ import annotations

import asyncio
import subprocess
import sys
import textwrap

import pytest

from hawk.runtime.supervision import Supervisor, leave_at_once, until_first_ends
from tests.manual_clock import ManualClock


class Work:
    """Ends as asked, then runs on; counts its beginnings."""

    def __init__(self, *ends: BaseException | None) -> None:
        self._ends = list(ends)
        self.begun = 0
        self.runs = asyncio.Event()

    async def __call__(self) -> None:
        self.begun += 1
        if not self._ends:
            self.runs.set()
            await asyncio.Event().wait()
        end = self._ends.pop(0)
        if end is not None:
            raise end


async def test_a_cancelled_task_ends_at_once_and_does_not_begin_again() -> None:
    reported: list[str] = []
    supervisor, work = Supervisor(lambda name, _: reported.append(name), 60.0), Work()
    task = supervisor.start("link", work)
    await work.runs.wait()
    task.cancel()
    for _ in range(5):
        await asyncio.sleep(0)
    assert task.cancelled()
    assert (work.begun, reported) == (1, [])


async def test_a_task_that_ended_waits_a_second_before_it_begins_again(monkeypatch: pytest.MonkeyPatch) -> None:
    pauses: list[float] = []

    async def sleep(seconds: float) -> None:
        pauses.append(seconds)

    monkeypatch.setattr("hawk.runtime.supervision.asyncio.sleep", sleep)
    supervisor, work = Supervisor(), Work(None)
    task = supervisor.start("link", work)
    async with asyncio.timeout(5.0):
        await work.runs.wait()
    task.cancel()
    await asyncio.gather(task, return_exceptions=True)
    assert pauses == [1.0]


@pytest.mark.fault(
    "the link task, or another long-running task, ends",
    'reported, part "tasks" unhealthy for 30 s, started again after 1 s',
)
@pytest.mark.parametrize(
    ("end", "words"),
    [
        (ValueError("broken"), "ValueError: broken"),
        (None, "it returned"),
        (asyncio.CancelledError(), "something in it was cancelled"),
    ],
    ids=["error", "return", "cancelled inside"],
)
async def test_a_task_that_ends_is_reported_and_started_again(end: BaseException | None, words: str) -> None:
    reported: list[tuple[str, str]] = []
    clock = ManualClock(0.0)
    supervisor = Supervisor(lambda name, reason: reported.append((name, reason)), 0.0, clock)
    work = Work(end, end)
    supervisor.start("link", work)
    async with asyncio.timeout(5.0):
        await work.runs.wait()
    assert work.begun == 3
    assert reported == [("link", words)] * 2
    assert supervisor.health.reason == f"link ended: {words}"
    clock.advance(31.0)
    assert supervisor.health.is_healthy
    await supervisor.close()


async def test_a_report_that_fails_does_not_cost_the_task() -> None:
    def fail(_name: str, _words: str) -> None:
        raise ValueError("nobody listens")

    supervisor, work = Supervisor(fail, 0.0), Work(ValueError("broken"))
    supervisor.start("link", work)
    async with asyncio.timeout(5.0):
        await work.runs.wait()
    await supervisor.close()


async def test_closed_or_cancelled_it_ends_for_good() -> None:
    reported: list[str] = []
    supervisor = Supervisor(lambda name, _: reported.append(name), 0.0)
    works = [Work(), Work()]
    tasks = [supervisor.start(f"task {number}", work) for number, work in enumerate(works)]
    for work in works:
        await work.runs.wait()
    tasks[0].cancel()
    await asyncio.gather(tasks[0], return_exceptions=True)
    await supervisor.close()
    assert all(task.cancelled() for task in tasks)
    assert [work.begun for work in works] == [1, 1]
    assert reported == []


async def test_of_two_the_first_to_end_ends_the_other() -> None:
    other = asyncio.Event()

    async def runs_on() -> None:
        try:
            await asyncio.Event().wait()
        finally:
            other.set()

    async def fails() -> None:
        raise ValueError("broken")

    with pytest.raises(ValueError, match="broken"):
        await until_first_ends(runs_on(), fails())
    assert other.is_set()


async def test_cancelled_it_ends_all_and_raises_nothing_of_theirs() -> None:
    ended: list[str] = []

    async def runs_on(name: str) -> None:
        try:
            await asyncio.Event().wait()
        finally:
            ended.append(name)

    both = asyncio.ensure_future(until_first_ends(runs_on("one"), runs_on("two")))
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    both.cancel()
    with pytest.raises(asyncio.CancelledError):
        await both
    assert sorted(ended) == ["one", "two"]


async def test_when_one_returns_nothing_is_raised() -> None:
    async def returns() -> None:
        """End at once."""

    async with asyncio.timeout(5.0):
        await until_first_ends(asyncio.sleep(60.0), returns())


async def test_an_end_is_shown_for_thirty_seconds_and_not_longer() -> None:
    clock = ManualClock(0.0)
    supervisor, work = Supervisor(pause_s=0.0, monotonic=clock), Work(None)
    assert supervisor.health.is_healthy
    supervisor.start("link", work)
    async with asyncio.timeout(5.0):
        await work.runs.wait()
    clock.advance(30.0)
    assert supervisor.health.reason == "link ended: it returned"
    clock.advance(0.01)
    assert supervisor.health.reason == ""
    await supervisor.close()


def test_leaving_writes_its_words_and_ends_with_the_status(caplog: pytest.LogCaptureFixture) -> None:
    left: list[int] = []
    leave_at_once("two calls hang", leave=left.append)
    assert left == [70], "EX_SOFTWARE"
    assert "two calls hang" in caplog.text


@pytest.mark.slow
@pytest.mark.fault(
    "stderr blocked, a thread and an exit handler hang when the program ends for hanging calls",
    "the process ends all the same, 0.2 s later at most",
)
def test_leaving_waits_for_no_thread_no_exit_handler_and_no_log() -> None:
    program = textwrap.dedent("""
        import atexit, logging, os, threading, time
        from hawk.runtime.supervision import leave_at_once
        read, write = os.pipe()
        os.dup2(write, 2)
        os.set_blocking(2, False)
        try:
            while True:
                os.write(2, b"x" * 4096)
        except BlockingIOError:
            os.set_blocking(2, True)  # stderr takes nothing any more
        atexit.register(time.sleep, 60)
        threading.Thread(target=time.sleep, args=(60,)).start()
        leave_at_once("hangs")
    """)
    ended = subprocess.run([sys.executable, "-c", program], timeout=30.0, check=False)
    assert ended.returncode == 70
