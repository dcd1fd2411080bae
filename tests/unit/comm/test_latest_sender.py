from __future__ import annotations

import threading

from hawk.comm.latest_sender import LatestSender

WAIT_S = 5.0


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
