"""A child ends with its parent, also with one that ended before the child looked."""

from __future__ import annotations

import asyncio
import os
import select
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import hawk.cli
import hawk.daemon.start
from hawk.config.sections import Config
from hawk.daemon.options import DaemonOptions
from hawk.runtime.process import ParentGoneError, kill_with_parent, started_s, watched_parent

GONE = 99_999_999
"""Above every limit of pid_max (proc(5))."""


@pytest.fixture
def other() -> Iterator[subprocess.Popen[bytes]]:
    """A process that lasts until it is killed."""
    process = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    yield process
    process.kill()
    process.communicate()


@pytest.fixture
def as_parent(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a child of this test stand for a parent: it is no younger."""
    monkeypatch.setattr("hawk.runtime.process.started_s", lambda _: 0.0)


def open_files() -> int:
    return len(list(Path("/proc/self/fd").iterdir()))


@pytest.mark.usefixtures("as_parent")
async def test_the_end_of_the_parent_is_reported_once(other: subprocess.Popen[bytes]) -> None:
    calls: list[int] = []
    ended = asyncio.Event()

    def end() -> None:
        calls.append(other.pid)
        ended.set()

    before = open_files()
    with watched_parent(other.pid, end):
        await asyncio.sleep(0.05)
        assert not calls
        other.kill()
        async with asyncio.timeout(5.0):
            await ended.wait()
        await asyncio.sleep(0.05)  # its descriptor stays readable
    assert calls == [other.pid]
    assert open_files() == before


@pytest.mark.usefixtures("as_parent")
async def test_a_parent_that_nobody_has_waited_for_has_ended(other: subprocess.Popen[bytes]) -> None:
    other.kill()
    os.waitid(os.P_PID, other.pid, os.WEXITED | os.WNOWAIT)  # noqa: ASYNC222 - SIGKILL takes no time
    ended = asyncio.Event()
    with watched_parent(other.pid, ended.set):
        async with asyncio.timeout(5.0):
            await ended.wait()


@pytest.mark.usefixtures("as_parent")
async def test_nothing_is_reported_afterwards(other: subprocess.Popen[bytes]) -> None:
    calls: list[int] = []
    with watched_parent(other.pid, lambda: calls.append(other.pid)):
        pass
    other.kill()
    other.wait()
    await asyncio.sleep(0.05)
    assert not calls


WORK = """
import subprocess, sys
child = "import os, sys, time; from hawk.runtime.process import kill_with_parent; kill_with_parent(os.getppid()); " \
    "print(os.getpid(), flush=True); time.sleep(600)"
subprocess.run([sys.executable, "-c", child])
"""


def test_work_that_may_be_cut_off_ends_with_its_parent() -> None:
    with subprocess.Popen([sys.executable, "-c", WORK], stdout=subprocess.PIPE) as parent:
        assert parent.stdout is not None
        child = int(parent.stdout.readline())
        pidfd = os.pidfd_open(child)
        parent.kill()
        assert select.select([pidfd], [], [], 30.0)[0] == [pidfd]
        os.close(pidfd)


def test_work_whose_parent_has_ended_does_not_begin() -> None:
    with pytest.raises(ParentGoneError):
        kill_with_parent(GONE)


async def test_a_parent_that_ended_before_is_refused(other: subprocess.Popen[bytes]) -> None:
    other.kill()
    other.wait()
    with pytest.raises(ParentGoneError, match=str(other.pid)), watched_parent(other.pid, pytest.fail):
        pass


async def test_a_younger_process_with_the_parents_number_is_no_parent(other: subprocess.Popen[bytes]) -> None:
    before = open_files()
    with pytest.raises(ParentGoneError, match=str(other.pid)), watched_parent(other.pid, pytest.fail):
        pass
    assert open_files() == before


async def test_a_parent_that_ends_while_it_is_looked_at_is_refused(
    other: subprocess.Popen[bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    def vanish(_: int) -> float:
        raise FileNotFoundError("/proc/1/stat")

    monkeypatch.setattr("hawk.runtime.process.started_s", vanish)
    before = open_files()
    with pytest.raises(ParentGoneError, match=str(other.pid)), watched_parent(other.pid, pytest.fail):
        pass
    assert open_files() == before


async def test_our_own_parent_is_no_younger() -> None:
    with watched_parent(os.getppid(), pytest.fail):
        await asyncio.sleep(0)


async def test_without_a_number_nothing_is_watched() -> None:
    before = open_files()
    with watched_parent(None, pytest.fail):
        assert open_files() == before


def test_a_start_is_between_those_of_parent_and_child(other: subprocess.Popen[bytes]) -> None:
    assert 0.0 < started_s(os.getppid()) <= started_s(os.getpid()) <= started_s(other.pid)
    with pytest.raises(OSError, match=str(GONE)):
        started_s(GONE)


def test_the_daemon_gets_the_number(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    given: list[DaemonOptions] = []

    async def run_daemon(_: Config, options: DaemonOptions) -> int:
        given.append(options)
        return 0

    monkeypatch.setattr(hawk.daemon.start, "run_daemon", run_daemon)
    monkeypatch.setattr(hawk.cli, "end_within", lambda *_: None)
    monkeypatch.chdir(tmp_path)
    assert hawk.cli.main(["run", "--parent-pid=7", "--attach-sim=http://127.0.0.1:1", "--speed=2"]) == 0
    assert hawk.cli.main(["run"]) == 0
    assert [(each.parent_pid, each.attached_simulation, each.speed) for each in given] == [
        (7, "http://127.0.0.1:1", 2.0),
        (None, None, 1.0),
    ]
