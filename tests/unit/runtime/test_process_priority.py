from __future__ import annotations

import os
import threading
from pathlib import Path

import pytest

from hawk.runtime.process import set_niceness, set_session_niceness


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


def test_a_session_of_our_own_is_put_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    autogroup = tmp_path / "autogroup"
    autogroup.write_text("/autogroup-7 nice 0")
    monkeypatch.setattr(os, "getsid", lambda _: os.getpid())
    set_session_niceness(-5, autogroup)
    assert autogroup.read_text() == "-5"


def test_a_session_that_others_share_is_left_as_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    autogroup = tmp_path / "autogroup"
    autogroup.write_text("/autogroup-7 nice 0")
    monkeypatch.setattr(os, "getsid", lambda _: os.getpid() + 1)
    set_session_niceness(-5, autogroup)
    assert autogroup.read_text() == "/autogroup-7 nice 0"


def test_a_kernel_without_autogroups_and_one_that_refuses_are_no_trouble(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError("Operation not permitted")

    monkeypatch.setattr(os, "getsid", lambda _: os.getpid())
    set_session_niceness(-5, tmp_path / "absent")
    assert not (tmp_path / "absent").exists()
    autogroup = tmp_path / "autogroup"
    autogroup.write_text("/autogroup-7 nice 0")
    monkeypatch.setattr(Path, "write_text", refuse)
    set_session_niceness(-5, autogroup)
