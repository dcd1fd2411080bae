"""The link of a fault goes before the daemons: by its session, or by its thread where no session has a niceness."""

from __future__ import annotations

import os
import threading
from pathlib import Path

import pytest

from hawk.runtime.process import SIMULATOR_NICENESS
from proving.faults.run import in_time


def _niceness() -> int:
    return os.getpriority(os.PRIO_PROCESS, threading.get_native_id())


def test_the_session_goes_first_and_gets_its_niceness_back(tmp_path: Path) -> None:
    autogroup = tmp_path / "autogroup"
    autogroup.write_text("/autogroup-7 nice 3\n")
    with in_time(autogroup):
        assert autogroup.read_text() == str(SIMULATOR_NICENESS)
    assert autogroup.read_text() == "3"


@pytest.mark.parametrize("text", ["", None], ids=["the root group", "no autogroups"])
def test_where_no_session_has_a_niceness_the_thread_goes_first(
    tmp_path: Path, text: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    autogroup = tmp_path / "autogroup"
    if text is not None:
        autogroup.write_text(text)
    asked: list[int] = []
    monkeypatch.setattr("proving.faults.run.set_niceness", asked.append)
    before = _niceness()
    with in_time(autogroup):
        pass
    assert asked == [SIMULATOR_NICENESS, before]
    assert (autogroup.read_text() if autogroup.exists() else None) == text


def test_without_the_right_to_go_first_the_faults_are_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError("Operation not permitted")

    autogroup = tmp_path / "autogroup"
    autogroup.write_text("/autogroup-7 nice 0\n")
    monkeypatch.setattr(os, "setpriority", refuse)
    monkeypatch.setattr(Path, "write_text", refuse)
    with in_time(autogroup):
        pass
