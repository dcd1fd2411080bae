from __future__ import annotations

import asyncio
import threading

import pytest

from hawk.comm.threads import Inbox, LatestSender, Workers
from tests.unit.comm.waiting import until

WAIT_S = 5.0


async def test_items_of_another_thread_come_in_order_on_the_loop() -> None:
    got: list[tuple[int, int]] = []
    done = asyncio.Event()

    def handle(item: int) -> None:
        got.append((item, threading.get_ident()))
        if item == 99:
            done.set()

    inbox: Inbox[int] = Inbox(asyncio.get_running_loop(), handle)

    def put_all() -> None:
        for index in range(100):
            inbox.put(index)

    thread = threading.Thread(target=put_all)
    thread.start()
    async with asyncio.timeout(5):
        await done.wait()
    thread.join()
    assert [item for item, _ in got] == list(range(100))
    assert {ident for _, ident in got} == {threading.get_ident()}


async def test_one_wake_up_serves_many() -> None:
    got: list[int] = []
    inbox: Inbox[int] = Inbox(asyncio.get_running_loop(), got.append)
    for index in range(50):
        inbox.put(index)
    await asyncio.sleep(0)
    assert got == list(range(50))


async def test_when_the_loop_does_not_come_the_oldest_are_dropped_and_counted() -> None:
    got: list[int] = []
    inbox: Inbox[int] = Inbox(asyncio.get_running_loop(), got.append, size=3)
    for index in range(5):
        inbox.put(index)
    await asyncio.sleep(0)
    assert got == [2, 3, 4]
    assert inbox.dropped == 2


async def test_a_bad_item_does_not_stop_the_others() -> None:
    got: list[int] = []

    def handle(item: int) -> None:
        if item == 1:
            raise ValueError("bad item")
        got.append(item)

    inbox: Inbox[int] = Inbox(asyncio.get_running_loop(), handle)
    for index in range(3):
        inbox.put(index)
    await asyncio.sleep(0)
    assert got == [0, 2]


async def test_a_closed_inbox_takes_nothing() -> None:
    got: list[int] = []
    inbox: Inbox[int] = Inbox(asyncio.get_running_loop(), got.append)
    inbox.put(1)
    inbox.close()
    inbox.put(2)
    await asyncio.sleep(0)
    assert got == []


def test_a_loop_that_has_ended_is_no_trouble_to_the_thread() -> None:
    loop = asyncio.new_event_loop()
    inbox: Inbox[int] = Inbox(loop, lambda _: None)
    loop.close()
    inbox.put(1)
    inbox.put(2)


def test_what_is_put_is_sent_once() -> None:
    sent: list[int] = []
    one = threading.Event()

    def send(item: int) -> None:
        sent.append(item)
        one.set()

    sender: LatestSender[int] = LatestSender("test-sender", send)
    sender.put(1)
    assert one.wait(WAIT_S)
    sender.close()
    assert sent == [1]


def test_a_slow_wire_gets_the_newest_and_never_an_older_one() -> None:
    sent: list[int] = []
    busy, free, done = threading.Event(), threading.Event(), threading.Event()

    def send(item: int) -> None:
        sent.append(item)
        busy.set()
        free.wait(WAIT_S)
        if item == 9:
            done.set()

    sender: LatestSender[int] = LatestSender("test-sender", send)
    sender.put(0)
    assert busy.wait(WAIT_S)
    for item in range(1, 10):
        sender.put(item)
    free.set()
    assert done.wait(WAIT_S)
    sender.close()
    assert sent == [0, 9]


def test_what_was_cleared_is_not_sent() -> None:
    sent: list[int] = []
    busy, free = threading.Event(), threading.Event()

    def send(item: int) -> None:
        sent.append(item)
        busy.set()
        free.wait(WAIT_S)

    sender: LatestSender[int] = LatestSender("test-sender", send)
    sender.put(0)
    assert busy.wait(WAIT_S)
    sender.put(1)
    sender.clear()
    free.set()
    sender.close()
    assert sent == [0]


def test_a_failure_does_not_end_the_thread() -> None:
    done = threading.Event()

    def send(item: int) -> None:
        if item == 0:
            failed.set()
            raise OSError("the wire is cut")
        done.set()

    failed = threading.Event()
    sender: LatestSender[int] = LatestSender("test-sender", send)
    sender.put(0)
    assert failed.wait(WAIT_S)
    sender.put(1)
    assert done.wait(WAIT_S)
    sender.close()


class Piece:
    """Work that notes its thread and ends when it may."""

    def __init__(self, may_end: bool = True) -> None:
        self.may_end = threading.Event()
        self.thread: threading.Thread | None = None
        if may_end:
            self.may_end.set()

    def __call__(self) -> None:
        self.thread = threading.current_thread()
        assert self.may_end.wait(WAIT_S)

    async def begun(self) -> threading.Thread:
        await until(lambda: self.thread is not None)
        assert self.thread is not None
        return self.thread


async def test_an_idle_thread_is_used_again_and_no_new_one_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    workers = Workers("test")
    first = Piece()
    workers.begin(first)
    thread = await first.begun()
    await until(lambda: bool(workers._idle))
    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, "start", lambda _: pytest.fail("a thread is started"))
        second = Piece()
        workers.begin(second)
    assert await second.begun() is thread
    assert thread.name == "test"
    assert thread.daemon, "it does not hold the exit"


async def test_work_does_not_wait_behind_other_work_that_hangs() -> None:
    workers = Workers("test")
    hanging = [Piece(may_end=False) for _ in range(3)]
    for each in hanging:
        workers.begin(each)
    free = Piece()
    workers.begin(free)
    threads = {await each.begun() for each in (*hanging, free)}
    assert len(threads) == 4
    for each in hanging:
        each.may_end.set()
    await until(lambda: len(workers._idle) == 4)


async def test_a_thread_that_has_nothing_to_do_ends_and_later_work_is_done() -> None:
    workers = Workers("test", idle_s=0.01)
    first = Piece()
    workers.begin(first)
    thread = await first.begun()
    await until(lambda: not thread.is_alive())
    assert not workers._idle
    later = Piece()
    workers.begin(later)
    assert await later.begun() is not thread
