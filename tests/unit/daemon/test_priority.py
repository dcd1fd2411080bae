from __future__ import annotations

import os
import threading

import pytest

from hawk.priority import set_niceness


def test_only_the_calling_thread_yields() -> None:
    found: list[int] = []

    def work() -> None:
        set_niceness(15)
        found.append(os.getpriority(os.PRIO_PROCESS, threading.get_native_id()))

    before = os.getpriority(os.PRIO_PROCESS, 0)
    worker = threading.Thread(target=work)
    worker.start()
    worker.join()
    assert found == [15]
    assert os.getpriority(os.PRIO_PROCESS, threading.get_native_id()) == before


def test_without_the_right_to_go_first_the_daemon_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: int) -> None:
        raise PermissionError("Operation not permitted")

    monkeypatch.setattr(os, "setpriority", refuse)
    set_niceness(-5)
