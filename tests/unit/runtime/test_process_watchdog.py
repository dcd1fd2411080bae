from __future__ import annotations

import contextlib
import io
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from hawk.runtime.process import DUMP_S, END_S, GROUND_S, PACE, SYSTEMD_S, SystemdNotifier, Watchdog
from tests.manual_clock import ManualClock
from tests.unit.daemon.full_pipe import full_pipe

HUNG = """
import ctypes, sys
from hawk.runtime.process import SystemdNotifier, Watchdog
dog = Watchdog(0.3, SystemdNotifier({}), sys.stderr)
dog.progress(may_fly=True)
print("armed", flush=True)
ctypes.PyDLL(None).sleep(30)  # C code that keeps the GIL: no Python thread runs
"""


@pytest.mark.slow
def test_a_process_that_hangs_in_c_with_the_gil_is_ended_with_its_stack() -> None:
    started = time.monotonic()
    result = subprocess.run([sys.executable, "-c", HUNG], capture_output=True, text=True, timeout=20)
    assert result.returncode == 1
    assert "armed" in result.stdout
    assert "Timeout (0:00:00.3" in result.stderr
    assert time.monotonic() - started < 15


@pytest.mark.slow
@pytest.mark.fault(
    "the loop hangs and nobody reads standard error",
    "the kernel ends the process by SIGALRM within 1.7 s of the last progress; the failsafe and the restart act",
)
def test_a_process_that_hangs_is_ended_when_nobody_takes_its_dump() -> None:
    with full_pipe() as stderr:
        result = subprocess.run([sys.executable, "-c", HUNG], stdout=subprocess.PIPE, stderr=stderr, timeout=20)
    assert result.returncode == -signal.SIGALRM
    assert result.stdout == b"armed\n"


FLOODED = """
import asyncio, ctypes, logging, os, sys
from hawk.runtime.process import SystemdNotifier, Ticker, Watchdog
from hawk.runtime.program_log import ProgramLog

async def main():
    log = ProgramLog("debug")
    dog = Watchdog(0.5, SystemdNotifier({}), sys.stderr)
    enough = asyncio.Event()
    ticks = 0
    def tick():
        nonlocal ticks
        ticks += 1
        for _ in range(50):
            logging.getLogger("flood").warning("a line of %s", "words " * 20)
        dog.progress(may_fly=True)
        if ticks == 100:
            enough.set()
    ticker = Ticker(0.01, tick, lambda _: None)
    ticker.start()
    await enough.wait()
    os.write(1, b"ticked on, %d lines dropped" % log.dropped)
    ctypes.PyDLL(None).sleep(30)

asyncio.run(main())
"""


@pytest.mark.slow
@pytest.mark.fault(
    "standard error or the journal is not read",
    "the ticks go on; log lines are dropped and counted; the end takes 1 s at most for them",
)
def test_a_log_that_nobody_reads_stops_neither_the_ticks_nor_the_end_of_a_process_that_hangs() -> None:
    with full_pipe() as stderr:
        result = subprocess.run([sys.executable, "-c", FLOODED], stdout=subprocess.PIPE, stderr=stderr, timeout=30)
    assert result.stdout.startswith(b"ticked on, ")
    assert int(result.stdout.split()[2]) > 0
    assert result.returncode == -signal.SIGALRM


@pytest.mark.slow
def test_progress_keeps_a_process_alive() -> None:
    ticks = "import time\nfor _ in range(8): time.sleep(0.1); dog.progress(may_fly=True)\ndog.stop()"
    code = HUNG.split("ctypes.PyDLL")[0] + ticks
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=20)
    assert result.returncode == 0, result.stderr


@pytest.mark.slow
@pytest.mark.fault(
    "a part hangs in the orderly end",
    "the process is ended within 15.5 s, so that MAVSDK's heartbeats stop",
)
def test_an_orderly_end_that_hangs_is_ended_too() -> None:
    code = HUNG.replace(
        'print("armed", flush=True)', "import hawk.runtime.process; hawk.runtime.process.END_S = 0.3; dog.stop()"
    )
    with full_pipe() as stderr:
        result = subprocess.run([sys.executable, "-c", code], stderr=stderr, timeout=20, check=False)
    assert result.returncode == -signal.SIGALRM


def test_ticks_re_arm_it_seldom_and_never_too_late(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = ManualClock()
    armed: list[tuple[float, float]] = []
    alarms: list[float] = []
    monkeypatch.setattr(
        "faulthandler.dump_traceback_later", lambda timeout, **_: armed.append((clock(), clock() + timeout))
    )
    monkeypatch.setattr("signal.setitimer", lambda _, seconds: alarms.append(clock() + seconds))
    dog = Watchdog(1.0, SystemdNotifier({}), io.StringIO(), monotonic=clock)
    for _ in range(200):  # ten seconds of ticks
        assert not armed or clock() < armed[-1][1], "ended although it ticked"
        dog.progress(may_fly=True)
        # a hang that begins with this tick is ended between one and 1.2 s later, without its dump by 1.7 s
        assert 1.0 <= armed[-1][1] - clock() <= 1.2 + 1e-9
        assert alarms[-1] == pytest.approx(armed[-1][1] + DUMP_S)
        clock.advance(0.05)
    assert len(armed) <= 60


def test_the_orderly_end_has_its_own_time_and_a_watchdog_that_is_off_arms_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    armed: list[float] = []
    monkeypatch.setattr("hawk.runtime.process.end_within", lambda seconds, _stream: armed.append(seconds))
    dog = Watchdog(1.0, SystemdNotifier({}), io.StringIO(), monotonic=ManualClock())
    dog.stop()
    assert armed == [END_S]
    off = Watchdog(1.0, SystemdNotifier({}), io.StringIO(), enabled=False, monotonic=ManualClock())
    off.progress(may_fly=True)
    off.stop()
    assert armed == [END_S]


def test_progress_is_passed_on_again_after_a_fifth_of_the_timeout(monkeypatch: pytest.MonkeyPatch) -> None:
    armed: list[float] = []
    monkeypatch.setattr("hawk.runtime.process.end_within", lambda seconds, _stream: armed.append(seconds))
    clock = ManualClock()
    dog = Watchdog(1.0, SystemdNotifier({}), io.StringIO(), monotonic=clock)
    for step, times in ((0.0, 1), (0.19, 1), (0.01, 2), (0.19, 2), (0.02, 3)):
        clock.advance(step)
        dog.progress(may_fly=True)
        assert len(armed) == times
    assert armed == [pytest.approx(1.2)] * 3


@pytest.mark.fault(
    "a busy computer lets the program wait for seconds while the drone stands on the ground",
    "it is ended after 10 s at the earliest; a drone that may fly has the short time again at once",
)
def test_a_drone_on_the_ground_gives_it_longer_and_one_that_may_fly_takes_that_back_at_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    armed: list[float] = []
    monkeypatch.setattr("hawk.runtime.process.end_within", lambda seconds, _stream: armed.append(seconds))
    clock = ManualClock()
    dog = Watchdog(1.0, SystemdNotifier({}), io.StringIO(), monotonic=clock)
    dog.progress(may_fly=False)
    clock.advance(GROUND_S * PACE - 0.01)
    dog.progress(may_fly=False)
    assert armed == [pytest.approx(1.2 * GROUND_S)], "passed on again after a fifth of it"
    dog.progress(may_fly=True)
    assert armed[1:] == [pytest.approx(1.2)], "not after the rest of the fifth"
    clock.advance(0.1)
    dog.progress(may_fly=False)
    assert armed[2:] == [pytest.approx(1.2 * GROUND_S)]


def test_a_longer_time_than_that_of_the_ground_is_kept_there(monkeypatch: pytest.MonkeyPatch) -> None:
    armed: list[float] = []
    monkeypatch.setattr("hawk.runtime.process.end_within", lambda seconds, _stream: armed.append(seconds))
    Watchdog(20.0, SystemdNotifier({}), io.StringIO(), monotonic=ManualClock()).progress(may_fly=False)
    assert armed == [pytest.approx(24.0)]


def test_systemd_waits_as_long_and_has_its_own_time_again_when_the_drone_may_fly(tmp_path: Path) -> None:
    path = tmp_path / "notify"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener:
        listener.bind(os.fspath(path))
        listener.settimeout(2)
        notifier = SystemdNotifier({"NOTIFY_SOCKET": os.fspath(path), "WATCHDOG_USEC": "3000000"})
        dog = Watchdog(1.0, notifier, io.StringIO(), enabled=False, monotonic=ManualClock())
        for may_fly in (True, False, True):
            dog.progress(may_fly=may_fly)
        dog.stop()
        heard = [listener.recv(64) for _ in range(6)]
    longer = b"WATCHDOG_USEC=%d" % round((1.2 * GROUND_S + SYSTEMD_S) * 1e6)
    each = b"WATCHDOG=1"
    assert heard == [each, longer, each, b"WATCHDOG_USEC=3000000", each, b"STOPPING=1"]


@pytest.mark.slow
def test_it_ends_a_process_whose_parent_had_left_the_alarm_ignored_and_blocked() -> None:
    code = "import signal\nsignal.signal(14, signal.SIG_IGN)\nsignal.pthread_sigmask(signal.SIG_BLOCK, [14])\n" + HUNG
    with full_pipe() as stderr:
        result = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=stderr, timeout=20)
    assert result.returncode == -signal.SIGALRM


def test_systemd_hears_ready_progress_and_stop(tmp_path: Path) -> None:
    path = tmp_path / "notify"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener:
        listener.bind(os.fspath(path))
        listener.settimeout(2)
        dog = Watchdog(5.0, SystemdNotifier({"NOTIFY_SOCKET": os.fspath(path)}), io.StringIO(), enabled=False)
        dog.ready()
        dog.progress(may_fly=True)
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


def test_a_socket_that_nobody_reads_does_not_hold_the_loop_up(tmp_path: Path) -> None:
    path = os.fspath(tmp_path / "notify")
    with (
        socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener,
        socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as other,
    ):
        listener.bind(path)
        other.setblocking(False)
        with contextlib.suppress(BlockingIOError):
            while True:
                other.sendto(b"WATCHDOG=1", path)
        notifier = SystemdNotifier({"NOTIFY_SOCKET": path})
        sending = threading.Thread(target=notifier.notify, args=("WATCHDOG=1",), daemon=True)
        sending.start()
        sending.join(5.0)
        assert not sending.is_alive()
        notifier.close()


def test_an_abstract_socket_is_addressed_by_a_zero_byte() -> None:
    name = f"hawk-test-{os.getpid()}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener:
        listener.bind(f"\0{name}")
        listener.settimeout(2)
        notifier = SystemdNotifier({"NOTIFY_SOCKET": f"@{name}"})
        notifier.notify("READY=1")
        assert listener.recv(64) == b"READY=1"
        notifier.close()
        notifier.notify("WATCHDOG=1")
        notifier.close()
        listener.settimeout(0.01)
        with pytest.raises(TimeoutError):
            listener.recv(64)
