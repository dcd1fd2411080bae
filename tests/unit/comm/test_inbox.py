from __future__ import annotations

import asyncio
import threading

from hawk.comm.inbox import Inbox


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
    await asyncio.wait_for(done.wait(), 5)
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
