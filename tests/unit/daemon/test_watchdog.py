from __future__ import annotations

import io
import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from hawk.process import SystemdNotifier, Watchdog
from tests.manual_clock import ManualClock

HUNG = """
import ctypes, sys
from hawk.process import SystemdNotifier, Watchdog
dog = Watchdog(0.3, SystemdNotifier({}), sys.stderr)
dog.progress()
print("armed", flush=True)
ctypes.PyDLL(None).sleep(30)  # C code that keeps the GIL: no Python thread runs
"""


def test_a_process_that_hangs_in_c_with_the_gil_is_ended_with_its_stack() -> None:
    started = time.monotonic()
    result = subprocess.run([sys.executable, "-c", HUNG], capture_output=True, text=True, timeout=20)
    assert result.returncode == 1
    assert "armed" in result.stdout
    assert "Timeout (0:00:00.3" in result.stderr
    assert time.monotonic() - started < 15


def test_progress_keeps_a_process_alive() -> None:
    code = HUNG.split("ctypes.PyDLL")[0] + "import time\nfor _ in range(8): time.sleep(0.1); dog.progress()\ndog.stop()"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=20)
    assert result.returncode == 0, result.stderr


def test_ticks_re_arm_it_seldom_and_never_too_late(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = ManualClock()
    armed: list[tuple[float, float]] = []
    monkeypatch.setattr(
        "faulthandler.dump_traceback_later", lambda timeout, **_: armed.append((clock(), clock() + timeout))
    )
    dog = Watchdog(1.0, SystemdNotifier({}), io.StringIO(), monotonic=clock)
    for _ in range(200):  # ten seconds of ticks
        assert not armed or clock() < armed[-1][1], "ended although it ticked"
        dog.progress()
        # a hang that begins with this tick is ended between one and 1.2 s later
        assert 1.0 <= armed[-1][1] - clock() <= 1.2 + 1e-9
        clock.advance(0.05)
    assert len(armed) <= 60


def test_systemd_hears_ready_progress_and_stop(tmp_path: Path) -> None:
    path = tmp_path / "notify"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener:
        listener.bind(os.fspath(path))
        listener.settimeout(2)
        dog = Watchdog(5.0, SystemdNotifier({"NOTIFY_SOCKET": os.fspath(path)}), io.StringIO(), enabled=False)
        dog.ready()
        dog.progress()
        dog.stop()
        assert [listener.recv(64) for _ in range(3)] == [b"READY=1", b"WATCHDOG=1", b"STOPPING=1"]


def test_without_systemd_nothing_is_sent() -> None:
    notifier = SystemdNotifier({})
    notifier.notify("READY=1")
    notifier.close()


def test_a_socket_that_went_away_does_not_end_the_flight(tmp_path: Path) -> None:
    notifier = SystemdNotifier({"NOTIFY_SOCKET": os.fspath(tmp_path / "gone")})
    notifier.notify("WATCHDOG=1")
    notifier.close()
